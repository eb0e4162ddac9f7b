"""A page has a size, known before it is made; and times of years and large numbers go onto it as they are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from chromium import errors, show
from test_page import ask, press, text
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.cli.watch import Board
from colonysim.errors import TraceError
from colonysim.trace.reader import Run
from colonysim.view import extent, write_page
from colonysim.view.content import gather
from colonysim.view.packing import unpack


def test_a_run_of_some_episodes_reads_the_rows_of_those(hard: colonysim.Run) -> None:
    part = hard.only([1, 3])
    for table in ("events", "decisions", "deposits", "frames"):
        whole = hard.table(table)
        counts = hard.rows_by_episode(table)
        assert sum(counts.values()) == whole.num_rows
        assert part.table(table).num_rows == counts[1] + counts[3]
        assert set(part.table(table)["episode"].to_pylist()) == {1, 3}
    assert len(part.episodes) == 3 and list(part.events(2)) == [] and part.frames(3) == hard.frames(3)


def test_the_page_of_a_long_run_shows_the_last_episodes_that_fit_and_says_so(
    browser: Any, hard: colonysim.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    write_page(hard, tmp_path / "all.html", tell=said.append)
    assert said == []
    sizes = extent._sizes(hard)
    monkeypatch.setattr(extent, "USUAL", extent._size(sizes, [2, 3]) + 1.0)
    page = write_page(hard, tmp_path / "page.html", tell=said.append)
    assert len(said) == 1 and "of all 3 episodes" in said[0] and "the last 2, 2 to 3" in said[0]
    show(browser, page)
    assert "2 of 3 episodes" in text(browser, "#what") and errors(browser) == []
    assert ask(browser, "return page.run.episodes.map((each) => each[0])") == [2, 3]
    # The values that an episode began with are those of the whole page.
    _, whole = unpack(gather(hard).compressed())
    assert ask(browser, "return page.run.starts.value.length") == len(whole["starts.value"])
    # Whoever asks for more gets it, and is told that it is large.
    said.clear()
    write_page(hard, tmp_path / "page.html", [1, 2, 3], tell=said.append)
    assert len(said) == 1 and "the page will take about" in said[0]
    monkeypatch.setattr(extent, "USUAL", 1.0)
    write_page(hard, tmp_path / "page.html", tell=said.append)
    assert "the last, 3." in said[1] and "the page will take" in said[-1]


def test_a_page_that_is_too_large_is_refused_before_anything_is_read(
    hard: colonysim.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes = extent._sizes(hard)
    monkeypatch.setattr(extent, "USUAL", 1.0)
    monkeypatch.setattr(extent, "MOST", max(extent._size(sizes, [number]) for number in sizes) + 1.0)
    command = ["view", str(hard.path), "--no-open", "--episodes", "1-3", "-o", str(tmp_path / "p.html")]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 2 and "a page of these 3 episodes would take" in done.output
    assert "choose fewer with --episodes" in done.output and list(tmp_path.iterdir()) == []
    monkeypatch.setattr(extent, "MOST", 1.0)
    with pytest.raises(TraceError, match=r"episode 3 alone would take .* --record less"):
        write_page(hard, tmp_path / "p.html")


def test_of_an_episode_that_is_too_large_the_motion_is_left_and_the_rest_named(
    hard: colonysim.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes = extent._sizes(hard)[3]
    bare = sizes["events"] + sizes["decisions"]
    for usual, lacking in ((bare + 1.0, ["pheromones"]), (bare - 1.0, ["pheromones", "decisions"])):
        monkeypatch.setattr(extent, "USUAL", usual)
        said: list[str] = []
        shown = extent.choose_extent(hard, None, said.append)
        assert shown.episodes == [3] and "the last, 3." in said[0]
        named = [what for what in ("pheromones", "decisions") if any(f"with its {what}" in each for each in said)]
        assert named == lacking
        _, page = unpack(gather(hard, shown.episodes, without=shown.without).compressed())
        assert len(page["events.time"]) > 0 and len(page["deposits.time"]) == len(page["starts.value"]) == 0
        assert (len(page["decisions.time"]) == 0) == ("decisions" in lacking)
        # Whoever asks for the episode gets all of it, and is told that it is large.
        said.clear()
        assert extent.choose_extent(hard, [3], said.append) == extent.Extent([3])
        assert len(said) == 1 and "the page will take about" in said[0]


@pytest.mark.parametrize(
    ("record", "lacking", "named"),
    [
        ("events,frames", ("pheromones", "decisions"), "no deposits: it was recorded with --record events,frames"),
        ("decisions,deposits,last-frames", ("pheromones",), "no frames of episode 1: it was recorded with"),
        ("decisions,deposits,frames", (), ""),
    ],
)
def test_what_was_not_recorded_is_named_and_not_shown(
    record: str, lacking: tuple[str, ...], named: str, tmp_path: Path
) -> None:
    run = colonysim.run("hard", seed=10, episodes=2, out=tmp_path / "run", record=record)
    command = ["view", str(run.path), "--no-open", "-o", str(tmp_path / "p.html")]
    done = CliRunner().invoke(app, command)
    assert done.exit_code == 0, done.output
    said = [each for each in ("pheromones", "decisions") if f"shows no {each}: this run has no" in done.output]
    assert said == list(lacking)
    assert named in done.output
    head, page = unpack(gather(run).compressed())
    assert (head["fields"] == []) == ("pheromones" in lacking) and len(page["events.time"]) > 0
    # Its first episode began with none, and every deposit since is there.
    if "last-frames" in record:
        assert unpack(gather(run, [1]).compressed())[0]["fields"] != []


def test_only_the_episodes_and_columns_that_are_shown_are_read(
    hard: colonysim.Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    from colonysim.trace import stored

    read: list[tuple[str, int]] = []
    original = stored._check_columns

    def watched(path: Path, rows: Any, schema: Any) -> None:
        read.append((path.parent.name, rows.num_rows))
        assert path.parent.name != "deposits" or "agent" not in schema.names
        original(path, rows, schema)

    monkeypatch.setattr(stored, "_check_columns", watched)
    again = Run.open(str(hard.path))
    gather(again, [2], without=("deposits", "frames"))
    assert {table for table, _ in read} == {"episodes", "events", "decisions"}
    read.clear()
    gather(again, [2])
    assert {table for table, _ in read} == {"events", "decisions", "deposits", "frames"}


def test_reading_says_how_far_it_is(hard: colonysim.Run, tmp_path: Path) -> None:
    told: list[float] = []
    write_page(hard, tmp_path / "p.html", progress=told.append)
    assert told == sorted(told) and len(told) >= 4 and 0.0 < told[0] <= told[-1] <= 1.0


def test_the_size_is_about_what_was_expected(hard: colonysim.Run, tmp_path: Path) -> None:
    bare = len(write_page(hard.only([]), tmp_path / "bare.html", [1]).read_bytes())
    whole = len(write_page(hard, tmp_path / "whole.html").read_bytes()) - bare
    assert 0.5 * whole < extent._size(sizes := extent._sizes(hard), sizes) < 3.0 * whole


def test_large_numbers_of_nodes_and_times_of_months(browser: Any, large: Path, tmp_path: Path) -> None:
    run = colonysim.run(large, episodes=2, out=tmp_path / "run")
    assert run.episodes[0].sim_seconds > 2**31 / 1000
    page = write_page(run, tmp_path / "page.html")
    show(browser, page)
    last = run.scenario.topology.ids[-1]
    assert last == 10**15
    assert ask(browser, "return Math.max(...page.run.nodes.id)") == last
    press(browser, "\ue010")  # End
    assert ask(browser, "return page.replay.duration") == round(1000 * run.episodes[0].sim_seconds)
    assert "episode ends: goal" in text(browser, "#caption")
    press(browser, "\ue012")  # one event back
    assert str(last) in text(browser, "#events")
    speed = float(ask(browser, "return document.getElementById('speed').value"))
    assert run.episodes[0].sim_seconds / speed < 60
    middle = ask(browser, "page.seek(page.replay.duration / 3); return [...page.replay.agentX]")
    assert any(x % 1 for x in middle)
    assert errors(browser) == []


@pytest.mark.parametrize("command", [["plot"], ["export"], ["report"], ["video"]])
def test_the_other_readers_take_them_too(command: list[str], large: Path, tmp_path: Path) -> None:
    if command == ["video"]:
        pytest.importorskip("av", reason="PyAV is not installed")
    colonysim.run(large, episodes=2, out=tmp_path / "run")
    more = {
        "plot": ["-o", str(tmp_path / "plots")], "export": ["-o", str(tmp_path / "rows.csv")], "report": [],
        "video": [str(tmp_path / "film.gif"), "--seconds", "1"],
    }[command[0]]  # fmt: skip
    done = CliRunner().invoke(app, [*command, str(tmp_path / "run"), *more])
    assert done.exit_code == 0, (done.output, done.exception)
    if command == ["export"]:
        assert str(10**15) in (tmp_path / "rows.csv").read_text()


def test_they_are_watched_on_the_terminal_too(large: Path, tmp_path: Path) -> None:
    run = colonysim.run(large, episodes=1, out=tmp_path / "run")
    board = Board(run.scenario)
    for event in Run.open(tmp_path / "run").events(1):
        board.take(event)
    assert "◆" in board.draw(80, 20).plain


def test_marks_that_fade_or_spread_are_announced(tmp_path: Path) -> None:
    said: list[str] = []
    options = ({"hole_half_life": None, "hole_diffusion": 0.0}, {"hole_half_life": 30.0}, {"hole_diffusion": 0.5})
    for i, option in enumerate(options):
        scenario = colonysim.load_scenario("sanity", None, {f"policy.{name}": value for name, value in option.items()})
        run = colonysim.run(scenario, seed=1, episodes=1, out=tmp_path / str(i))
        write_page(run, tmp_path / "page.html", tell=said.append)
        assert len(said) == i
    assert all("marks fade with time or spread in this run" in each for each in said)
