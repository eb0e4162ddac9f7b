from __future__ import annotations

import itertools
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import colonysim
import colonysim.view
from colonysim.cli import app
from colonysim.errors import TraceError
from colonysim.view import marks, write_page
from colonysim.view.content import gather
from colonysim.view.packing import Block, unpack
from colonysim.view.page import LIVE, MODULES, STILL

ASSETS = Path(colonysim.view.__file__).parent / "assets"


def test_what_was_packed_comes_back() -> None:
    block = Block()
    block.head = {"name": "</script> \u2028 \N{SNOWMAN}"}
    columns = {
        "tiny": [-128, 0, 127], "short": [-129, 128], "long": [-70_000, 2**31 - 1], "none": [],
        "years": [0, 2**31, 10**12, 2**53], "minus": [-(2**53), 2**53],
    }  # fmt: skip
    for name, values in columns.items():
        block.ints(name, values)
    times = np.arange(0, 3_000_000, 700)
    block.ints("times", times, steps=True)
    slow = 4 * 10**12 + np.arange(0, 3 * 10**12, 7 * 10**9)
    block.ints("slow", slow, steps=True)
    block.ints("small steps to large sums", np.arange(300) * 10**7, steps=True)
    block.reals("values", [0.1, np.nan, 1e30])
    packed = block.compressed()
    head, back = unpack(packed)
    assert head == block.head
    assert {name: back[name].tolist() for name in columns} == columns
    assert back["times"].tolist() == times.tolist()
    assert np.array_equal(back["slow"], slow)
    assert np.array_equal(back["small steps to large sums"], np.arange(300) * 10**7)
    assert np.array_equal(back["values"], np.float32([0.1, np.nan, 1e30]), equal_nan=True)
    assert len(packed) < len(times), "steady times are a byte each at most"
    for values, steps in (([2**53 + 1], False), ([-(2**53) - 1], True), ([-(2**53), 2**53], True)):
        with pytest.raises(TraceError, match="from -2"):
            block.ints("too much", values, steps=steps)


def test_pheromones_begin_an_episode_as_the_last_one_left_them_and_time_wore_them(hard: colonysim.Run) -> None:
    head, columns = unpack(gather(hard, [2, 3]).compressed())
    index = hard.scenario.topology.index
    first = columns["starts.first"]
    for episode, (begin, end) in zip((2, 3), itertools.pairwise(first), strict=True):
        found = {}
        for slot, value in zip(columns["starts.slot"][begin:end], columns["starts.value"][begin:end], strict=True):
            field, place, key = (int(columns[f"slots.{name}"][slot]) for name in ("field", "place", "key"))
            found[head["fields"][field], place, key] = float(value)
        for name, left in (("D", 1.0), ("E", 0.5)):  # D outlives an episode, half of E does
            for node, value in hard.field(name, episode - 1).items():
                assert found[name, index[node], -1] == pytest.approx(left * value, rel=1e-5)
        for (box, hole), value in hard.field("B", episode - 1).items():
            assert found["B", box, index[hole]] == pytest.approx(value, rel=1e-5)


def test_every_row_of_the_chosen_episodes_is_there(hard: colonysim.Run) -> None:
    _, columns = unpack(gather(hard, [2]).compressed())
    events = list(hard.events(2))
    assert len(columns["events.time"]) == len(events)
    ids = hard.scenario.topology.ids
    assert [ids[node] for node in columns["events.node"] if node >= 0] == [e.node for e in events if e.node >= 0]
    assert columns["events.time"].tolist() == [round(event.time * 1000) for event in events]
    decided = [row for row in hard.table("decisions").to_pylist() if row["episode"] == 2]
    assert columns["decisions.count"].tolist() == [len(row["targets"]) for row in decided]
    chances = [chance for row in decided for chance in row["probabilities"]]
    assert columns["decisions.chances"] / 10_000 == pytest.approx(chances, abs=6e-5)


def test_a_page_is_one_file_with_nothing_to_fetch(hard: colonysim.Run, tmp_path: Path) -> None:
    page = write_page(hard, tmp_path / "page.html")
    assert [path.name for path in tmp_path.iterdir()] == ["page.html"]
    assert sorted((*MODULES, *STILL, *LIVE)) == sorted(path.stem for path in ASSETS.glob("*.js"))
    text = page.read_text()
    assert not re.search(r"""(src|href)\s*=|url\(|@import|\bfetch\(|XMLHttpRequest|WebSocket|innerHTML""", text)
    assert "default-src 'none'" in text and "unsafe" not in text.split("</head>")[0]
    assert write_page(hard, tmp_path / "again.html").read_bytes() == page.read_bytes()


def test_the_command_writes_beside_the_run_and_says_what_is_wrong(hard: colonysim.Run, tmp_path: Path) -> None:
    run = CliRunner()
    out = tmp_path / "page.html"
    done = run.invoke(app, ["view", str(hard.path), "--no-open", "-o", str(out), "--episodes", "1,3"])
    assert done.exit_code == 0 and done.stdout.strip() == str(out) and out.stat().st_size > 50_000
    done = run.invoke(app, ["view", str(hard.path), "--no-open"])
    assert hard.path is not None and (hard.path / "view.html").is_file()
    wrong = run.invoke(app, ["view", str(hard.path), "--no-open", "--episodes", "9"])
    assert wrong.exit_code == 2 and "it has 1 to 3" in wrong.output
    with pytest.raises(TraceError, match="kept no trace"):
        write_page(colonysim.run("sanity", episodes=1, trace=False), out)


def test_runs_with_little_in_them_have_pages_too(tmp_path: Path) -> None:
    document = {
        "name": "line", "nodes": [[5, 0, 0, 0], [3, 1, 0, 0]], "edges": {"radius": 1.5}, "agents": [5], "goal": 3,
    }  # fmt: skip
    bare = colonysim.scenario_from_document(document)
    run = colonysim.run(bare, policy="random", episodes=1, out=tmp_path / "bare", record="deposits,frames")
    head, columns = unpack(gather(run).compressed())
    assert head["fields"] == [] and head["holes"] == [] and "bodies" not in head
    assert len(columns["decisions.time"]) == len(columns["deposits.time"]) == len(columns["boxes.node"]) == 0
    assert columns["nodes.id"].tolist() == [5, 3] and columns["events.now_at"][-2] == 1
    write_page(run)


def test_a_policy_that_is_not_installed_here_leaves_its_marks_as_they_were(hard: colonysim.Run) -> None:
    assert hard.path is not None
    foreign = colonysim.Run(hard.path, hard.manifest | {"policy": "elsewhere:Policy"})
    head, columns = unpack(gather(foreign, [2]).compressed())
    slots = [columns[f"slots.{name}"] for name in ("field", "place", "key")]
    exploration = head["fields"].index("E")
    at = {
        int(slots[1][slot]): float(value)
        for slot, value in zip(columns["starts.slot"], columns["starts.value"], strict=True)
        if slots[0][slot] == exploration
    }
    index = hard.scenario.topology.index
    assert at == pytest.approx({index[node]: value for node, value in hard.field("E", 1).items()}, rel=1e-5)


def test_slots_are_the_different_rows_in_order() -> None:
    draws = np.random.default_rng(3)
    for shape in ((0, 3), (1, 3), (5000, 3)):
        rows = draws.integers(-1, 12, shape)
        slots, which = marks._distinct(rows)
        assert slots.tolist() == np.unique(rows, axis=0).tolist() and (slots[which] == rows).all()


def test_each_agent_has_the_radius_of_its_group(tmp_path: Path) -> None:
    document = {
        "topology": {"kind": "line", "nodes": 9}, "goal": 8, "detection_radius": 2.0,
        "groups": [{"name": "far", "agents": [0, 1], "detection_radius": 6.5}, {"name": "near", "agents": [4]}],
    }  # fmt: skip
    run = colonysim.run(colonysim.scenario_from_document(document), episodes=1, out=tmp_path / "run")
    head, _ = unpack(gather(run).compressed())
    assert head["radius"] == 2.0 and head["radii"] == [6.5, 6.5, 2.0]
