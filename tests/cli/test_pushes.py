"""`evaluate push`, `train` and what `plot` makes of their directories."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from colonysim.cli import app
from colonysim.physics import default_engine, engine_trouble, engine_version
from colonysim.push.foresight import Features
from colonysim.push.way import load_way_chance
from colonysim.trace.reader import Run

if trouble := engine_trouble(default_engine()):
    pytest.skip(trouble, allow_module_level=True)

TINY = [
    "actions=80", "explore=30", "update_from=24", "batch=16", "buffer=200", "train_block=1", "test_block=1",
    "candidates=1", "learner.target_every=50", "hidden=[16, 16]", "kinds=[[flat, 1]]",
    "starts=[{name: fine, share: 1, guards: true}]",
]  # fmt: skip
TINY_TRAINING = [word for setting in TINY for word in ("--set", setting)]


def colonysim(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    out = tmp_path_factory.mktemp("pushes") / "run"
    return out, colonysim("evaluate", "push", "--push", "rl", "-n", 2, "--seed", 4, "--json", "-q", "--out", out)


def test_json_holds_the_figures_of_each_terrain_with_or_without_a_record(
    recorded: tuple[Path, Result], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    plain = colonysim("evaluate", "push", "--push", "rl", "-n", 2, "--seed", 4, "--json", "-q")
    found = json.loads(plain.stdout)
    assert list(found) == ["flat", "slope", "hole"]
    for values in found.values():
        assert list(values) == ["episodes", "success", "success_low", "success_high", "reward_mean", "reward_sd"]
        assert values["episodes"] == 2 and values["success_low"] <= values["success"] <= values["success_high"]
    assert not list(tmp_path.iterdir())
    assert recorded[1].stdout == plain.stdout


def test_the_record_tells_what_was_evaluated_and_where_everything_was(recorded: tuple[Path, Result]) -> None:
    run = Run.open(recorded[0])
    assert run.status == "finished" and run.verify()
    evaluation = run.manifest["evaluation"]
    assert evaluation["executor"] == "rl" and evaluation["results"] == json.loads(recorded[1].stdout)
    assert len(evaluation["model_sha256"]) == len(evaluation["starts_sha256"]) == 64
    pushes = evaluation["pushes"]
    assert [push["episode"] for push in pushes] == [1, 2, 3, 4, 5, 6]
    assert [push["terrain"] for push in pushes] == ["flat", "flat", "slope", "slope", "hole", "hole"]
    assert [(len(push["pits"]), len(push["ramps"])) for push in pushes] == [(0, 0)] * 2 + [(0, 1)] * 2 + [(1, 0)] * 2
    assert [result.episode for result in run.episodes] == [1, 2, 3, 4, 5, 6]
    assert [event.episode for event in run.events()] == [1, 2, 3, 4, 5, 6]
    poses = run.table("poses").to_pylist()
    for push, result in zip(pushes, run.episodes, strict=True):
        for body, number in (("agent", push["robot"]), ("box", push["box"])):
            way = [row for row in poses if row["episode"] == push["episode"] and row["body"] == body]
            assert [way[0]["x"], way[0]["y"]] == pytest.approx(number[:2], abs=0.02)
            assert way[-1]["time"] == pytest.approx(result.sim_seconds)
            gaps = [later["time"] - row["time"] for row, later in pairwise(way)]
            assert all(gap == pytest.approx(0.1) for gap in gaps[:-1]) and 0 < gaps[-1] < 0.1001
    choosers = set(run.table("controls")["chooser"].to_pylist())
    assert "network" in choosers


def test_a_record_is_drawn_from_its_directory_alone(recorded: tuple[Path, Result], tmp_path: Path) -> None:
    drawn = colonysim("plot", recorded[0], "--out", tmp_path / "all")
    assert drawn.exit_code == 0, drawn.output
    names = {"trajectories.png", "samples-flat.png", "samples-slope.png", "samples-hole.png"}
    assert {path.name for path in (tmp_path / "all").iterdir()} == names
    some = colonysim("plot", recorded[0], "--out", tmp_path / "some", "--episodes", "5", "-w", "samples", "-f", "svg")
    assert some.exit_code == 0 and [path.name for path in (tmp_path / "some").iterdir()] == ["samples-hole.svg"]
    for words, said in [
        (("--episodes", "7"), "it has 1 to 6"),
        (("-w", "trajectoris"), "did you mean 'trajectories'?"),
        (("--box", "0"), "neither hole, box nor group"),
    ]:
        mistake = colonysim("plot", recorded[0], *words)
        assert mistake.exit_code == 2 and said in mistake.stderr


def test_the_engine_can_be_chosen_and_stands_in_the_manifest(engine: str, tmp_path: Path) -> None:
    words = ("evaluate", "push", "--push", "scripted", "-n", 1, "-q", "--engine", engine, "--out", tmp_path / "run")
    done = colonysim(*words)
    assert done.exit_code == 0 and f"push scripted · {engine}" in done.stdout, done.output
    manifest = Run.open(tmp_path / "run").manifest
    assert manifest["backend"] == manifest["engine"]["name"] == engine
    assert manifest["engine"]["version"] == engine_version(engine)


def test_a_colony_cannot_start_from_single_pushes(recorded: tuple[Path, Result], tmp_path: Path) -> None:
    refused = colonysim("run", "sanity", "--from", recorded[0], "--out", tmp_path / "run")
    assert refused.exit_code == 2 and f"{recorded[0]}: this run left no pheromones" in refused.stderr
    assert not (tmp_path / "run").exists()


def test_nothing_is_overwritten(recorded: tuple[Path, Result]) -> None:
    again = colonysim("evaluate", "push", "--push", "scripted", "-n", 1, "--out", recorded[0])
    assert again.exit_code == 2 and "not empty" in again.stderr


def test_an_interrupted_training_goes_on_and_its_curve_can_be_drawn(tmp_path: Path) -> None:
    pytest.importorskip("torch")
    command = [sys.executable, "-m", "colonysim", "train", "push", "--out", "mine", *TINY_TRAINING]
    process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stderr is not None
    while "episodes: success" not in (line := process.stderr.readline()):
        assert line, "the training ended early"
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 130 and not stdout, stderr
    assert "--resume" in stderr and "Traceback" not in stderr
    folder = tmp_path / "mine"
    assert not (folder / "push.npz").exists()
    refused = colonysim("train", "push", "--out", folder, *TINY_TRAINING)
    assert refused.exit_code == 2 and "holds a training already" in refused.stderr
    before = len(json.loads((folder / "history.json").read_text()))
    assert colonysim("plot", folder, "--out", tmp_path / "early").exit_code == 0

    resumed = colonysim("train", "push", "--out", folder, "--resume", *TINY_TRAINING)
    assert resumed.exit_code == 0, resumed.output
    assert "success" in resumed.stderr and "success" not in resumed.stdout
    card = json.loads((folder / "push.json").read_text())
    assert card["how"]["config"]["actions"] == 80 and card["how"]["config"]["hidden"] == [16, 16]
    history = json.loads((folder / "history.json").read_text())
    assert len(history) > before >= 1 and history[-1]["actions"] >= 80
    assert (tmp_path / "early/learning.png").read_bytes().startswith(b"\x89PNG")
    assert colonysim("plot", folder, "-w", "D").exit_code == 2


def test_the_classifier_is_trained_from_the_command_line(tmp_path: Path) -> None:
    pytest.importorskip("sklearn")
    done = colonysim("train", "feasibility", "--states", 200, "--out", tmp_path, "-q")
    assert done.exit_code == 0, done.output
    card = json.loads((tmp_path / "feasibility.json").read_text())
    assert card["results"]["states"] >= 200 and card["results"]["episodes"] > 1


def test_the_chance_of_a_way_is_fitted_and_its_calibration_drawn_from_the_command_line(tmp_path: Path) -> None:
    pytest.importorskip("sklearn")
    done = colonysim("train", "way", "--ways", 20, "--seed", 90, "--out", tmp_path, "-q")
    assert done.exit_code == 0, done.output
    results = json.loads((tmp_path / "way.json").read_text())["results"]
    assert results["ways"]["n"] == 20 and results["pushes"]["n"] >= 20
    assert set(results["pushes"]["accepts"]) == {"way", "geometry", "forest"}
    assert 0.0 < load_way_chance(tmp_path / "way.json")(Features(0.5, 0.5, 0, 0, 0, 0, 0, 1, 0, 0)) < 1.0
    assert colonysim("plot", tmp_path).exit_code == 0
    assert (tmp_path / "plots/calibration.png").read_bytes().startswith(b"\x89PNG")
    (tmp_path / "way.json").unlink()
    undrawn = colonysim("plot", tmp_path)
    assert undrawn.exit_code == 2 and "not fitted yet" in undrawn.stderr
    other = colonysim("train", "way", "--ways", 20, "--seed", 91, "--out", tmp_path, "-q")
    assert other.exit_code == 2 and "seed, engine and network" in other.stderr


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("acions=3", "did you mean 'actions'?"),
        ("learner.los=squared", "did you mean 'loss'?"),
        ("learner=3", "learner.loss"),
        ("learner.loss=squard", "'squared' or 'huber'"),
        ("actions=many", "valid integer"),
        ("actions.more=3", "no parts"),
        ("actions=null", "would never end"),
        ("train_block=0", "at least 1"),
        ("update_every=0", "at least 1"),
        ("actions", "KEY=VALUE"),
    ],
)
def test_a_wrong_parameter_is_told_before_anything_is_written(setting: str, said: str, tmp_path: Path) -> None:
    pytest.importorskip("torch")
    result = colonysim("train", "push", "--out", tmp_path / "mine", "--set", setting)
    assert result.exit_code == 2 and said in result.stderr and "Traceback" not in result.output
    assert not (tmp_path / "mine").exists()
