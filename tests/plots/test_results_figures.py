"""Figures of sweeps and of several runs, and figures for papers: what is drawn, not its pixels."""

from __future__ import annotations

import json
import math
import re
import shutil
import warnings
from pathlib import Path
from statistics import fmean
from typing import Any

import pytest

pytest.importorskip("matplotlib")

from drawn_labels import check_labels
from matplotlib.colors import to_hex
from typer.testing import CliRunner

import colonysim
import colonysim.plots
from colonysim.cli import app
from colonysim.errors import ColonysimError, ColonysimWarning
from colonysim.intervals import of_mean
from colonysim.plots import draw, draw_results
from colonysim.plots.arrangement import arranged, labels, short
from colonysim.plots.paper import AGENTS, BOX, GOAL, HOLE, pens
from colonysim.sweep import run_sweep
from colonysim.sweep.comparing import compare, pooled
from colonysim.sweep.played import Played, read_source

FILE = """
scenarios: [sanity]
policies: [paper, colony]
grid: {policy.beta: [8, 1, 2], policy.epsilon: [0.2, 0.6]}
seeds: {count: 3}
episodes: 3
"""


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return swept(tmp_path_factory.mktemp("swept"), FILE)


def swept(folder: Path, text: str) -> Path:
    (folder / "file.yaml").write_text(text)
    run_sweep(folder / "file.yaml", folder / "out", workers=2)
    return folder / "out"


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What is drawn instead of being written."""
    found: dict[str, Any] = {}
    monkeypatch.setattr(colonysim.plots.images, "save", lambda figure, path, *_: found.__setitem__(path.stem, figure))
    return found


def means_of(played: list[Played], measure: str, **about: Any) -> list[float]:
    chosen = [each for each in played if all(each.about[n.replace("_", ".")] == v for n, v in about.items())]
    return [fmean(episode[measure] for episode in each.episodes) for each in chosen]


def test_means_along_the_number_with_most_values_and_a_line_for_all_else(
    sweep: Path, figures: dict[str, Any], tmp_path: Path
) -> None:
    draw_results(sweep, what=["means"], out=tmp_path)
    success, steps = figures["means"].axes
    assert steps.get_xlabel() == "policy.beta" and (success.get_ylabel(), steps.get_ylabel()) == ("success", "steps")
    assert len(steps.containers) == 4 and [t.get_text() for t in figures["means"].legends[0].get_texts()] == [
        "paper, 0.2", "paper, 0.6", "colony, 0.2", "colony, 0.6",
    ]  # fmt: skip
    played = list(read_source(sweep).played)
    line, _, (bars,) = steps.containers[3]
    assert list(line.get_xdata()) == [1, 2, 8]
    for beta, mean, bar in zip((1, 2, 8), line.get_ydata(), bars.get_segments(), strict=True):
        values = means_of(played, "steps", policy="colony", policy_beta=beta, policy_epsilon=0.6)
        assert mean == pytest.approx(fmean(values)) and len(values) == 3
        assert bar[:, 1] == pytest.approx(of_mean(values))
    assert len({(to_hex(c[0].get_color()), c[0].get_marker()) for c in steps.containers}) == 4


def test_columns_and_episodes_that_are_asked_for(sweep: Path, figures: dict[str, Any], tmp_path: Path) -> None:
    with pytest.warns(ColonysimWarning, match="averaged over: policy.epsilon"):
        draw_results(
            sweep, what=["means"], x="policy", by="policy.beta", y="steps", episodes=(2, 3), out=tmp_path
        )  # fmt: skip
    (axes,) = figures["means"].axes
    assert [t.get_text() for t in axes.get_xticklabels()] == ["paper", "colony"] and len(axes.containers) == 3
    line = axes.containers[0][0]
    assert line.get_linestyle() == "None"  # nothing lies between two policies
    values = [
        fmean(e["steps"] for e in each.episodes if e["episode"] >= 2) for each in read_source(sweep).played
        if each.about["policy.beta"] == 1 and each.about["policy"] == "colony"
    ]  # fmt: skip
    assert len(values) == 6 and line.get_ydata()[1] == pytest.approx(fmean(values))


def test_a_map_of_colours_by_two_numbers(sweep: Path, figures: dict[str, Any], tmp_path: Path) -> None:
    draw_results(sweep, what=["heatmap"], by=["policy", "policy.epsilon"], y="steps", out=tmp_path)
    paper, colony, _ = figures["heatmap"].axes
    assert (paper.get_title(), colony.get_title()) == ("paper", "colony")
    shown = colony.images[0].get_array()
    assert shown.shape == (2, 3)
    played = list(read_source(sweep).played)
    for row, epsilon in enumerate((0.2, 0.6)):
        for column, beta in enumerate((1, 2, 8)):
            values = means_of(played, "steps", policy="colony", policy_beta=beta, policy_epsilon=epsilon)
            assert shown[row, column] == pytest.approx(fmean(values))
    assert [t.get_text() for t in colony.get_xticklabels()] == ["1", "2", "8"]


def test_curves_are_means_over_seeds_with_their_interval(
    sweep: Path, figures: dict[str, Any], tmp_path: Path
) -> None:
    with pytest.warns(ColonysimWarning, match="averaged over"):
        draw_results(sweep, what=["curves"], x="policy", by=[], out=tmp_path)
    _, steps = figures["curves"].axes
    line = steps.lines[-1]
    values = [
        [run.episodes[i]["steps"] for run in read_source(sweep).played if run.about["policy"] == "colony"]
        for i in range(3)
    ]  # fmt: skip
    assert line.get_label() == "colony" and list(line.get_ydata()) == pytest.approx([fmean(v) for v in values])
    band = steps.collections[-1].get_paths()[0].vertices[:, 1]
    assert {round(y, 6) for y in band} >= {round(y, 6) for v in values for y in of_mean(v, 400) or ()}
    draw_results(sweep, what=["curves"], out=tmp_path)
    assert len(figures["curves"].axes) == 8  # a row for each policy and epsilon, a column for each measure


def test_differences_are_those_of_compare(sweep: Path, figures: dict[str, Any], tmp_path: Path) -> None:
    draw_results(sweep, what=["differences"], y="steps", out=tmp_path)
    (axes,) = figures["differences"].axes
    found = [each for each in compare([sweep], by="policy") if each.measure == "steps"]
    (total,) = [each for each in pooled(found) if each.measure == "steps"]
    assert [t.get_text() for t in axes.get_yticklabels()] == [
        "8, 0.2", "8, 0.6", "1, 0.2", "1, 0.6", "2, 0.2", "2, 0.6", "over all",
    ]  # fmt: skip
    assert axes.get_xlabel() == "steps, policy colony less paper"
    means = [container[0].get_xdata()[0] for container in axes.containers]
    assert means == pytest.approx([*(each.difference for each in found), total.difference])
    seeds = [list(line.get_xdata()) for line in axes.lines if line.get_marker() == "."]
    assert seeds == [pytest.approx(list(each.by_seed.values())) for each in found]


def test_runs_that_differ_in_their_seed_only_are_one_curve(figures: dict[str, Any], tmp_path: Path) -> None:
    runs = [colonysim.run("sanity", seed=seed, episodes=4, out=tmp_path / f"run{seed}") for seed in (1, 2, 3)]
    paths = [run.path for run in runs if run.path]
    with pytest.warns(ColonysimWarning, match="means, differences: the runs differ in nothing but their seeds"):
        draw_results(paths, out=tmp_path)
    assert [*figures] == ["curves"]
    _, steps = figures["curves"].axes
    assert list(steps.lines[-1].get_ydata()) == [fmean(run.episodes[i].steps for run in runs) for i in range(4)]
    assert len(steps.lines) == 4 and len(steps.collections) == 1
    figures.clear()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ColonysimWarning)
        draw_results([paths[0], paths[0]], out=tmp_path)
    _, steps = figures["curves"].axes
    assert len(steps.lines) == 1 and not steps.collections  # the same run twice is one, and of one there is no interval
    other = colonysim.run("sanity", policy="paper", seed=2, episodes=4, out=tmp_path / "other")
    assert other.path is not None
    with pytest.warns(ColonysimWarning, match="heatmap"):
        draw_results([*paths, other.path], y="steps", out=tmp_path)
    assert [*figures] == ["curves", "means", "differences"]
    (axes,) = figures["differences"].axes
    with pytest.warns(ColonysimWarning, match="means: the runs differ in nothing but their seeds, policy"):
        draw_results([*paths, other.path], by="policy", out=tmp_path)
    assert axes.containers[0][0].get_xdata()[0] == pytest.approx(
        fmean(e.steps for e in other.episodes) - fmean(e.steps for e in runs[1].episodes)
    )


def test_trials_that_are_missing_are_told_and_the_others_drawn(
    figures: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[1] / "sweep")
    (tmp_path / "file.yaml").write_text("scenarios: [sanity]\ngrid: {max_steps: [9, 30]}\nseeds: [1]\nepisodes: 1\n")
    run_sweep(tmp_path / "file.yaml", tmp_path / "out", workers=1)
    import pyarrow as pa
    import pyarrow.parquet as pq

    trials, episodes = (pq.read_table(tmp_path / f"out/{name}.parquet") for name in ("trials", "episodes"))
    rows = trials.to_pylist()
    rows[1] |= {"status": "failed", "episodes": 0, "success": None, "steps": None}
    pq.write_table(pa.Table.from_pylist(rows, schema=trials.schema), tmp_path / "out/trials.parquet")
    pq.write_table(episodes.slice(0, 1), tmp_path / "out/episodes.parquet")
    with pytest.warns(ColonysimWarning, match="1 of 2 trials: 1 failed"):
        draw_results(tmp_path / "out", what=["means"], x="max_steps", out=tmp_path)
    line, caps, _ = figures["means"].axes[0].containers[0]
    assert list(line.get_xdata()) == [9] and all(cap.get_ydata()[0] == line.get_ydata()[0] for cap in caps)
    rows[0] |= {"status": "pending", "episodes": 0, "success": None, "steps": None}
    pq.write_table(pa.Table.from_pylist(rows, schema=trials.schema), tmp_path / "out/trials.parquet")
    pq.write_table(episodes.slice(0, 0), tmp_path / "out/episodes.parquet")
    answer = CliRunner().invoke(app, ["plot", str(tmp_path / "out")])
    assert answer.exit_code == 2 and "nothing to draw yet" in answer.stderr


def test_what_cannot_be_drawn_is_one_message(sweep: Path, tmp_path: Path) -> None:
    colonysim.run("sanity", seed=1, episodes=1, out=tmp_path / "run")
    run = str(tmp_path / "run")
    for words, said in [
        ([str(sweep), "--x", "policy.bta"], "no column 'policy.bta' to plot by; did you mean 'policy.beta'"),
        ([str(sweep), "--by", "polcy"], "did you mean 'policy'"),
        ([str(sweep), "--x", "policy", "--by", "policy"], "not both"),
        ([str(sweep), "-w", "map"], "cannot draw 'map' of a sweep or several runs"),
        ([str(sweep), "--hole", "3"], "--hole: only of one run"),
        ([str(sweep), "--episodes", "9-12"], "no run or trial has finished these episodes"),
        ([str(sweep), "-w", "curves", "--episodes", "2"], "nothing to draw: curves: no run has two episodes"),
        ([run, "--x", "policy"], "--x: only of a sweep or of several runs"),
        ([run, "--width", "3in"], "width: only with the style paper"),
        ([run, str(tmp_path / "nowhere")], "nowhere"),
        ([str(sweep), "-o", str(sweep / "trials.parquet")], "is part of the sweep"),
    ]:
        answer = CliRunner().invoke(app, ["plot", *words])
        assert answer.exit_code == 2 and said in answer.stderr, (words, answer.output)
        assert "Traceback" not in answer.output
    manifest = json.loads((tmp_path / "run/manifest.json").read_text())
    shutil.copytree(tmp_path / "run", tmp_path / "pushes")
    pushes = {"robot_size": [1, 1], "pushes": [], "executor": "rl"}
    (tmp_path / "pushes/manifest.json").write_text(json.dumps({**manifest, "evaluation": pushes}))
    answer = CliRunner().invoke(app, ["plot", run, str(tmp_path / "pushes")])
    assert answer.exit_code == 2 and "pushes: " in answer.stderr
    damaged = tmp_path / "damaged"
    shutil.copytree(sweep, damaged)
    (damaged / "episodes.parquet").write_bytes((sweep / "episodes.parquet").read_bytes()[:-9])
    answer = CliRunner().invoke(app, ["plot", str(damaged)])
    assert answer.exit_code == 2 and "episodes.parquet: cannot be read" in answer.stderr


@pytest.mark.parametrize("style", ["screen", "paper"])
@pytest.mark.parametrize("count", [2, 30])
def test_labels_of_long_names_and_many_settings_do_not_overlap(
    style: Any, count: int, figures: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    played = [
        Played(
            {"source": "x", "scenario": f"a-very-long-name-of-a-scenario-in-a-file-number-{i}", "policy": policy,
             "a.very.long.name.of.a.parameter": 10.0 ** (j - 3)}, seed,
            [
                {"episode": e, "steps": 10 + i + e + seed, "success": (i + seed) % 3 / 2, "sim_seconds": 1.0}
                for e in (1, 2)
            ],
        )
        for i in range(count) for policy in ("colony", "mine:AnotherPolicyOfMine") for j in range(3) for seed in (1, 2)
    ]  # fmt: skip
    source = read_source.__globals__["Source"](tmp_path, played, "")
    monkeypatch.setattr("colonysim.sweep.played.read_source", lambda *_, **__: source)
    monkeypatch.setattr("colonysim.sweep.comparing.read_source", lambda *_, **__: source)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", ColonysimWarning)
        draw_results(tmp_path, x="scenario", by=["policy"], out=tmp_path, style=style)
        draw_results(tmp_path, x="a.very.long.name.of.a.parameter", what=["means", "curves"], out=tmp_path, style=style)
        for name, figure in figures.items():
            check_labels(figure, name, monkeypatch)
    assert {*figures} == {"means", "curves", "differences"}


def test_many_things_are_told_apart() -> None:
    for palette in (AGENTS, ("#0072B2", "#D55E00")):
        assert len({(pen.color, pen.dash, pen.mark) for pen in pens(60, palette)}) == 60
    assert len({pen.color for pen in pens(4, AGENTS)}) == 4
    assert len({(pen.color, pen.dash) for pen in pens(42)}) == 42
    assert {BOX, GOAL, HOLE}.isdisjoint(AGENTS)
    found = labels([("a" * 40 + "x" + "b" * 40,), ("a" * 40 + "y" + "b" * 40,)])
    assert len({*found}) == 2 and all(len(each) < 40 for each in found)
    assert short("x\x1b[2J") == r"x\x1b[2J"


def test_numbers_that_were_drawn_together_are_no_lines() -> None:
    played = [
        Played({"source": "x", "beta": 0.5 + i, "gamma": float(i * i % 11), "policy": policy}, 1, [])
        for i in range(10) for policy in ("a", "b")
    ]  # fmt: skip
    chosen = arranged(played, None, None)
    assert (chosen.x, chosen.by, chosen.averaged, chosen.numeric) == ("beta", ("policy",), ("gamma",), True)
    mixed = [Played({"source": "x", "beta": value}, 1, []) for value in (None, "2", "1")]
    assert not arranged(mixed, None, None).numeric
    texts = [Played({"source": "x", "beta": value}, 1, []) for value in ("10", "2", "1")]
    assert arranged(texts, None, None).numeric and list(arranged(texts, None, None).along(texts)) == [1.0, 2.0, 10.0]


@pytest.mark.parametrize("kind", ["pdf", "svg", "png"])
def test_a_figure_for_a_paper(sweep: Path, kind: Any, tmp_path: Path) -> None:
    run = colonysim.run("sanity", seed=1, episodes=2, out=tmp_path / "run")
    for make in (
        lambda out: draw(run, what=["D", "workload"], out=out, kind=kind, style="paper", width="86mm"),
        lambda out: draw_results(sweep, what=["means"], out=out, kind=kind, style="paper", width="86mm"),
    ):
        for one, two in zip(make(tmp_path / "a"), make(tmp_path / "b"), strict=True):
            content = one.read_bytes()
            assert content == two.read_bytes() and not re.search(rb"CreationDate|<dc:date>|tIME", content)
            if kind == "pdf":
                assert b"/CIDFontType2" in content and b"/Type3" not in content
                box = re.search(rb"/MediaBox \[ 0 0 ([0-9.]+) ([0-9.]+) \]", content)
                assert box and float(box[1]) == pytest.approx(86 / 25.4 * 72, abs=0.01)
            elif kind == "svg":
                assert b"<text " in content and (one.stem != "means" or b"policy.beta" in content)


@pytest.mark.parametrize(
    ("width", "inches"), [(None, 3.4), ("3.4in", 3.4), ("8.6 cm", 8.6 / 2.54), ("246pt", 3.4039), (7, 7)]
)
def test_widths_and_titles(sweep: Path, width: Any, inches: float, figures: dict[str, Any], tmp_path: Path) -> None:
    draw_results(sweep, what=["means", "differences"], out=tmp_path, style="paper", width=width)
    for figure in figures.values():
        assert figure.get_size_inches()[0] == pytest.approx(inches, abs=1e-3) and figure.get_suptitle() == ""
        assert all(text.get_fontsize() <= 8 for axes in figure.axes for text in axes.get_xticklabels())
    draw_results(sweep, what=["means"], out=tmp_path)
    assert figures["means"].get_suptitle().startswith("Success and steps")


def outlines(axes: Any) -> set[str]:
    """Colours of the outlines around nodes."""
    return {
        to_hex(color).upper() for marks in axes.collections for color in marks.get_edgecolors()
        if marks.get_facecolors().size == 0
    }  # fmt: skip


def test_goal_holes_and_boxes_are_on_every_panel_of_a_map(figures: dict[str, Any], tmp_path: Path) -> None:
    run = colonysim.run("hard", seed=1, episodes=3, out=tmp_path / "run")
    draw(run, out=tmp_path)
    maps = [figure for name, figure in figures.items() if name[0] in "DEHB" or name == "trajectories"]
    assert len(maps) == 10
    for figure in maps:
        for axes in (axes for axes in figure.axes if axes.get_title()):
            assert {GOAL, HOLE.upper(), BOX} <= outlines(axes)
    lines = [line for line in figures["trajectories"].axes[0].lines if line.get_linewidth() == 1.3]
    assert {line.get_color() for line in lines} == {*AGENTS}
    # Boxes are where the events say that the episode left them.
    boxes = [marks for marks in figures["D"].axes[2].collections if outlined(marks) == BOX]
    at = {tuple(point) for marks in boxes for point in marks.get_offsets()}
    from colonysim.trace.replay import follow

    ends = follow(run.scenario, run.events(3)).boxes_at_end().values()
    assert at == {run.scenario.topology.graph.nodes[node]["pos"] for node in ends}


def outlined(marks: Any) -> str:
    edges = marks.get_edgecolors()
    return to_hex(edges[0]).upper() if len(edges) and not marks.get_facecolors().size else ""


def test_no_figure_is_empty(figures: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "bare.yaml").write_text(
        "name: bare\nnodes: [[0, 0, 0, 1], [1, 1, 0, 1], [2, 2, 0, 1]]\nedges: [[0, 1], [1, 2]]\nagents: [0]\ngoal: 2\n"
    )
    run = colonysim.run(tmp_path / "bare.yaml", seed=1, episodes=2, out=tmp_path / "run")
    with pytest.warns(ColonysimWarning, match="left out: fates: the scenario has no boxes"):
        draw(run, out=tmp_path)
    assert {"map", "trajectories", "episodes", "waiting", "workload"} <= {*figures} and "fates" not in figures
    assert len(figures["waiting"].axes) == 1  # one agent alone waits for nobody
    with pytest.raises(ColonysimError, match="nothing to draw: fates: the scenario has no boxes"):
        draw(run, what="fates", out=tmp_path)
    assert math.isfinite(figures["waiting"].axes[0].get_ylim()[1])
