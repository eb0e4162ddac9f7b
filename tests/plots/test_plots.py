from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import warnings
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from drawn_labels import check_labels
from tampering import _with_poses

import colonysim
import colonysim.plots
import colonysim.view
from colonysim.errors import ColonysimError, ColonysimWarning, MissingExtraError
from colonysim.installing import install_command
from colonysim.pheromones.field import Write
from colonysim.plots import draw, draw_training, is_training
from colonysim.policies.uniform import Uniform
from colonysim.trace.schema import Event

MAPS = ("sanity", "easy", "medium", "hard")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, colonysim.Run]:
    folder = tmp_path_factory.mktemp("runs")
    return {name: colonysim.run(name, seed=1, episodes=2, out=folder / name) for name in MAPS}


def test_everything_can_be_drawn_from_the_directory_alone(runs: dict[str, colonysim.Run], tmp_path: Path) -> None:
    assert runs["sanity"].path is not None
    run = colonysim.Run.open(runs["sanity"].path)
    images = draw(run, out=tmp_path, episodes=[2])
    names = {image.name for image in images}
    assert names == {
        "D.png", "E.png", "H-hole3.png", "H-hole7.png", "B-box0.png", "B-box1.png", "map.png", "trajectories.png",
        "episodes.png", "waiting.png", "workload.png", "fates.png",
    }  # fmt: skip
    assert all(image.read_bytes().startswith(b"\x89PNG") for image in images)
    assert {image.name for image in tmp_path.iterdir()} == names


def test_a_choice_of_hole_box_episodes_and_format(runs: dict[str, colonysim.Run], tmp_path: Path) -> None:
    images = draw(runs["hard"], what=["H", "B"], hole=29, box=3, episodes=[2], out=tmp_path, kind="svg")
    assert [image.name for image in images] == ["H-hole29.svg", "B-box3.svg"]
    assert "hole at node 29" in images[0].read_text() or images[0].stat().st_size > 10_000
    again = draw(runs["hard"], what=["map"], out=tmp_path / "a")[0].read_bytes()
    assert draw(runs["hard"], what=["map"], out=tmp_path / "b")[0].read_bytes() == again


@pytest.mark.parametrize("style", ["screen", "paper"])
@pytest.mark.parametrize("name", MAPS)
def test_no_two_labels_overlap_in_any_plot(
    runs: dict[str, colonysim.Run], name: str, style: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    figures: dict[str, Any] = {}
    monkeypatch.setattr(colonysim.plots.images, "save", lambda figure, path, *_: figures.__setitem__(path.stem, figure))
    run = runs[name]
    draw(run, out=tmp_path, style=style)
    kinds = {stem.split("-")[0] for stem in figures}
    assert kinds == {*colonysim.plots.KINDS} - ({"H"} if not run.scenario.holes else set())
    for stem, figure in figures.items():
        check_labels(figure, stem, monkeypatch)


@pytest.mark.parametrize("name", MAPS)
def test_a_map_names_every_node_and_says_what_its_axes_are(runs: dict[str, colonysim.Run], name: str) -> None:
    from colonysim.plots.maps import map_figure

    for axes in map_figure(runs[name], 2).axes:
        assert axes.get_xlabel() and axes.get_ylabel() and axes.get_title()
        assert len([text for text in axes.texts if text.get_text()]) >= len(runs[name].scenario.topology)


def test_mistakes_are_told_before_anything_is_drawn(runs: dict[str, colonysim.Run], tmp_path: Path) -> None:
    run = runs["sanity"]
    out = tmp_path / "plots"
    for words, said in [
        ({"what": ["D", "mpa"]}, "did you mean 'map'"),
        ({"episodes": [7]}, "it has 1 to 2"),
        ({"hole": 4}, "no hole at node 4; there are: 3, 7"),
        ({"box": 2}, "the boxes are 0 to 1"),
        ({"style": "print"}, "no style 'print'; there are: screen, paper"),
        ({"width": "3in"}, "only with the style paper"),
        ({"style": "paper", "width": "3 inch"}, "width: '3 inch', expected 2 to 40 inches, such as 3.4in, 86mm"),
        ({"style": "paper", "width": "10mm"}, "expected 2 to 40 inches"),
        ({"style": "paper", "width": 1.0}, "width: 1.0, expected a number from 2 to 40"),
    ]:
        with pytest.raises(ColonysimError, match=said):
            draw(run, out=out, **words)  # type: ignore[arg-type]
    assert not out.exists()
    with pytest.raises(ColonysimError, match="kept no trace"):
        draw(colonysim.run("sanity", episodes=1, trace=False))


class _Scent:
    """A field of somebody else: by node, by node and hole, or by box."""

    def __init__(self, name: str, by_box: bool, key: int) -> None:
        self.name, self.by_box, self._key = name, by_box, key

    def at(self, node: int, key: int = -1) -> float:
        return 0.0

    def keys(self, node: int) -> tuple[int, ...]:
        return ()

    def deposit(self, visit: Any) -> tuple[()]:
        return ()

    def end_episode(self) -> None:
        pass

    def frame(self) -> list[Any]:
        return [Write(0, self._key, 1.5), Write(1, self._key, 1e6)]

    def load(self, frame: Any) -> None:
        pass


class _Scented(Uniform):
    def fields(self, world: Any) -> dict[str, Any]:
        kinds = (("scent", False, -1), ("../up", False, 0), ("load", True, -1))
        return {name: _Scent(name, by_box, key) for name, by_box, key in kinds}


def test_what_a_run_has_is_drawn_and_fields_of_others_too(tmp_path: Path) -> None:
    others = {"map.png", "trajectories.png", "episodes.png", "waiting.png", "workload.png", "fates.png"}
    markless = colonysim.run("sanity", policy="random", episodes=1, out=tmp_path / "markless")
    assert {image.name for image in draw(markless)} == others
    with pytest.raises(ColonysimError, match="cannot draw 'D'"):
        draw(markless, what=["D"])
    scented = colonysim.run("sanity", policy=_Scented, episodes=1, out=tmp_path / "scented")
    told = {name: field["by_box"] for name, field in scented.manifest["fields"].items()}
    assert told == {"scent": False, "../up": False, "load": True}
    drawn = {"scent.png", "..%2Fup-hole3.png", "load-box0.png", "load-box1.png"}
    with pytest.warns(ColonysimWarning, match=r"left out: \.\.%2Fup-hole7: no value in this episode"):
        assert {image.name for image in draw(scented)} == others | drawn
    assert not list(tmp_path.glob("*.png"))
    colonysim.view.write_page(scented, tmp_path / "view.html")


def test_a_training_whose_files_are_wrong_is_told_by_field(tmp_path: Path) -> None:
    test = {"episodes": 20, "success": 0.5, "reward": -3.0, "by_kind": {"flat": 0.5}}
    card = {"how": {"peak_episode": 20, "seed": 1, "config": {"name": "paper", "test_block": 20}}}
    point = {"n": 1, "chance": 0.5, "success": 0.4, "success_low": 0.1, "success_high": 0.9}
    judged = {"n": 1, "brier": 0.1, "curve": [point]}
    begun: dict[str, Any] = {"phase": "imitation", "decisions": 500, "tested": None}
    of_policy = {"phase": "ppo", "decisions": 1000, "tested": {"success": 0.9, "seconds": 31.5}}
    results: dict[str, Any] = {"split": "s", "pushes": judged, "ways": judged}
    tries: list[tuple[dict[str, Any], str]] = [
        ({"history.json": [test]}, ""), ({"history.json": [test], "push.json": card}, ""),
        ({"history.json": {}}, "a list"), ({"history.json": [7]}, "0.episodes"),
        ({"history.json": [{**test, "success": None}]}, r"history\.json: 0\.success"),
        ({"history.json": [{**test, "by_kind": []}]}, "by_kind"),
        ({"history.json": [{**test, "reward": 1e300}]}, "reward"),
        ({"history.json": [test], "push.json": {"how": []}}, r"push\.json: how\.peak_episode"),
        ({"history.json": [begun, of_policy]}, ""), ({"history.json": [begun]}, "no test of this training"),
        ({"history.json": [{**of_policy, "decisions": "x"}]}, r"0\.decisions: expected a number"),
        ({"history.json": [of_policy, {**of_policy, "tested": []}]}, r"1\.tested\.success: expected a number"),
        ({"history.json": [{**of_policy, "tested": {"success": 1.0, "seconds": 1e300}}]}, r"tested\.seconds: expected"),
        ({"ways.jsonl": 0, "way.json": {"results": results}}, ""),
        ({"ways.jsonl": 0, "way.json": []}, r"results\.split"),
        ({"ways.jsonl": 0, "way.json": {"results": results | {"ways": {"curve": [{}]}}}}, r"ways\.curve\.0\.chance"),
        ({"ways.jsonl": 0}, "not fitted yet"), ({"history.json": []}, "no test"),
    ]  # fmt: skip
    for number, (files, said) in enumerate(tries):
        folder = tmp_path / str(number)
        folder.mkdir()
        for name, content in files.items():
            (folder / name).write_text(json.dumps(content))
        assert is_training(folder)
        if not said:
            assert draw_training(folder)[0].stat().st_size > 1000
            continue
        with pytest.raises(ColonysimError, match=said):
            draw_training(folder)
    os.mkfifo(tmp_path / "0/push.json")
    with pytest.raises(ColonysimError, match=r"push\.json: is a pipe"):
        draw_training(tmp_path / "0")


def test_without_matplotlib_the_command_to_install_it_is_named(
    runs: dict[str, colonysim.Run], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingExtraError, match=re.escape(install_command("plot"))):
        draw(runs["sanity"])


def test_the_package_of_plots_imports_no_matplotlib() -> None:
    program = "import sys, colonysim.plots; assert not {'matplotlib', 'numpy', 'pyarrow'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", program], check=True)


def test_events_tell_where_everything_went() -> None:
    from colonysim.trace.replay import blocked_edges, follow

    scenario = colonysim.load_scenario("sanity")
    events = [
        Event(1, 1.0, "end", 0, "take", 0, 1, 0, 3, "arrived", now_at=1),
        Event(1, 2.0, "end", 0, "push", 1, 3, 0, 3, "arrived", now_at=1),
        Event(1, 3.0, "end", 0, "travel", 1, 3, status="arrived", now_at=3),
        Event(1, 4.0, "end", 0, "push", 3, 4, 1, 7, "failed", now_at=3),
    ]
    ways = follow(scenario, events)
    assert ways.agents[0] == [0, 1, 3]
    assert ways.boxes == {0: [1, 3], 1: [2]}
    before = blocked_edges(scenario, {0: 1, 1: 2})
    after = blocked_edges(scenario, {0: 3, 1: 2})
    assert (1, 3) in before and (1, 3) not in after
    assert (3, 4) in before and (3, 4) not in after and (4, 7) in after


def test_running_intervals_are_students() -> None:
    from colonysim.plots.results import running_interval

    assert running_interval([3.0]) == [(3.0, 3.0, 3.0)]
    mean, low, high = running_interval([1.0, 2.0, 3.0, 4.0, 5.0])[2]
    assert mean == 3.0 and low == pytest.approx(3 - 1.9632, abs=1e-3) and high == pytest.approx(3 + 1.9632, abs=1e-3)
    assert len(running_interval(list(range(30)))) == 30


def test_what_agents_do_fills_the_episode(runs: dict[str, colonysim.Run]) -> None:
    from colonysim.plots.waiting import spans

    run = runs["hard"]
    result = run.episodes[0]
    found = spans(run.events(1))
    for agent in range(4):
        mine = sorted((span for span in found if span.agent == agent), key=lambda span: span.begin)
        assert mine[0].begin == 0.0 and mine[-1].end == result.sim_seconds
        assert all(before.end == pytest.approx(after.begin) for before, after in pairwise(mine))
    # The one that is there last leaves with the episode's end.
    assert sum(span.state == "left at the goal" for span in found) == 3


def test_a_wait_is_told_from_what_ends_it() -> None:
    from colonysim.plots.waiting import spans

    events = [
        Event(1, 1.0, "wait", 0, "wait", 3, 4),
        Event(1, 2.0, "wait", 0, "wait", 3, -1),
        Event(1, 5.0, "end", 0, "push", 3, 4, 0, 4, "failed", began=2.5, now_at=3),
        Event(1, 5.0, "spent", 0, node=3, began=5.0),
        Event(1, 6.0, "episode"),
    ]
    assert spans(events) == [
        (0, 1.0, 2.0, "waits for a taken node"), (0, 2.0, 2.5, "waits"), (0, 2.5, 5.0, "pushes"),
        (0, 5.0, 6.0, "stands still for good"),
    ]  # fmt: skip


def test_gini_coefficients() -> None:
    from colonysim.plots.workload import gini

    assert gini([3, 3, 3]) == gini([]) == gini([0, 0]) == 0.0
    assert gini([0, 0, 0, 8]) == 0.75
    assert gini([1, 2, 3, 4]) == gini([4, 2, 1, 3]) == pytest.approx(0.25)


def test_boxes_are_counted_where_they_end(runs: dict[str, colonysim.Run]) -> None:
    from colonysim.plots.fates import fates_figure
    from colonysim.trace.replay import follow

    run = runs["hard"]
    axes = fates_figure(run).axes[0]
    told = {(round(text.get_position()[1]), round(text.get_position()[0])): int(text.get_text()) for text in axes.texts}
    assert sum(told.values()) == len(run.episodes) * len(run.scenario.boxes)
    holes = [run.scenario.topology.ids[hole.node] for hole in run.scenario.holes]
    for box in range(4):
        for column, hole in enumerate(holes):
            ended = sum(follow(run.scenario, run.events(e)).boxes[box][-1] == hole for e in (1, 2))
            assert told.get((box, column), 0) == ended


def test_values_as_large_as_there_are(tmp_path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    colonysim.run("sanity", seed=1, episodes=2, out=tmp_path / "run")
    _with_poses(tmp_path / "bodies")
    for run, name, column, what in (("run", "frames", "value", "DEHB"), ("bodies", "poses", "x", ["trajectories"])):
        part = min((tmp_path / run / name).glob("*.parquet"))
        table = pq.read_table(part)
        values = [(-1) ** i * 1.7e308 if i % 3 else value for i, value in enumerate(table[column].to_pylist())]
        at = table.column_names.index(column)
        pq.write_table(table.set_column(at, column, pa.array(values)), part, store_schema=False)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert draw(colonysim.Run.open(tmp_path / run), what=tuple(what), out=tmp_path)


@pytest.fixture(scope="module")
def mixed(tmp_path_factory: pytest.TempPathFactory) -> colonysim.Run:
    groups = [{"name": "quick ones", "agents": [0, 1], "speed": 3}, {"name": "slow/late", "agents": [6, 12, 18]}]
    place = {"topology": {"kind": "grid", "columns": 6, "rows": 4}, "goal": 23, "groups": groups}
    scenario = colonysim.scenario_from_document(place)
    return colonysim.run(scenario, seed=1, episodes=3, out=tmp_path_factory.mktemp("mixed") / "run")


def test_each_group_has_images_of_its_own(mixed: colonysim.Run, tmp_path: Path) -> None:
    images = draw(mixed, what=["map", "episodes", "waiting", "workload"], by_group=True, out=tmp_path)
    parts = ("quick%20ones", "slow%2Flate")
    kinds = ("episodes", "waiting", "workload")
    assert {image.name for image in images} == {"map.png", *(f"{kind}-{part}.png" for kind in kinds for part in parts)}
    assert len({image.read_bytes() for image in images}) == 7


def test_a_group_is_drawn_by_its_own_agents(mixed: colonysim.Run) -> None:
    from colonysim.plots.results import results_figure
    from colonysim.plots.waiting import waiting_figure
    from colonysim.plots.workload import workload_figure

    for group in mixed.scenario.groups:
        own = [result for result in mixed.groups if result.group == group.name]
        above, below = results_figure(mixed, group).axes
        dots = [next(line for line in axes.lines if line.get_label() == "episode") for axes in (above, below)]
        assert list(dots[0].get_ydata()) == [result.steps for result in own]
        assert list(dots[1].get_ydata()) == [result.success for result in own]
        steps = [event for event in mixed.events() if event.kind == "end" and event.agent in group.agents]
        bars = workload_figure(mixed, group).axes[0].patches
        assert sum(bar.get_height() for bar in bars) == pytest.approx(len(steps) / 3)
        assert {round(bar.get_x() + bar.get_width() / 2) for bar in bars} == {*group.agents}
        assert waiting_figure(mixed, 3, group).axes[0].get_ylim() == (0, len(group.agents))
        assert f"group {group.name}" in waiting_figure(mixed, 3, group).get_suptitle()


def test_what_cannot_be_drawn_by_group_is_said(
    mixed: colonysim.Run, runs: dict[str, colonysim.Run], tmp_path: Path
) -> None:
    with pytest.raises(ColonysimError, match="has no groups of agents"):
        draw(runs["sanity"], by_group=True, out=tmp_path)
    with pytest.raises(ColonysimError, match="by group: map, D are not of agents, expected some of episodes, waiting"):
        draw(mixed, what=["map", "D"], by_group=True, out=tmp_path)
    assert not list(tmp_path.iterdir())
