"""Counts, seeds and other numbers of every public function: NumPy's are welcome, what is none is refused by name."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import colonysim
from colonysim.arguments import MAX_SEED, as_seed, as_span, plain, real, shown, whole, wholes
from colonysim.bench import measure
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.plots import draw
from colonysim.scenario.invent import invent
from colonysim.sweep import Store, plan_sweep, run_planned, run_sweep
from colonysim.sweep.comparing import compare
from colonysim.sweep.tables import read_table, summary
from colonysim.sweep.tuning import tune
from colonysim.testing import check_backend, check_policy, random_scenario
from colonysim.trace.export import export
from colonysim.trace.failures import attempts
from colonysim.trace.manifest import begin_manifest
from colonysim.video import write_video
from colonysim.view import write_page
from colonysim.view.live import Live

NO_COUNT = [2.5, 3.0, math.nan, np.float64(3), None, "3", True, np.True_, 0, -1, 10**30, 10**5000, [1], np.arange(2)]
NO_SEED = [1.5, "a", None, False, -1, MAX_SEED + 1, 10**5000, np.float32(1), (1,)]
SWEEP = "scenarios: [sanity]\nepisodes: 1\nseeds: {count: 2}\n"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return colonysim.run("sanity", episodes=2, seed=1, out=tmp_path_factory.mktemp("runs") / "run")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def each(call, name, bad):
    """Calls once with each value that is none; every refusal is one line that begins with the name."""
    for value in bad:
        with pytest.raises(ColonysimError) as refused:
            call(value)
        message = str(refused.value)
        assert message.startswith(f"{name}: ") and "\n" not in message and len(message) < 200, message


def no_default(values):
    """Without None, which stands for "not given" where there is a default."""
    return [value for value in values if value is not None]


def test_whole_numbers():
    for value in (3, np.int64(3), np.uint8(3), np.array(3)):
        assert type(whole("n", value)) is int and whole("n", value) == 3
    each(lambda value: whole("n", value), "n", NO_COUNT)
    each(as_seed, "seed", NO_SEED)
    assert as_seed(np.uint64(MAX_SEED)) == MAX_SEED and as_seed(0) == 0
    assert wholes("episodes", np.array([1, 3])) == (1, 3) == wholes("episodes", {1: 0, 3: 0})
    each(lambda value: wholes("episodes", value), "episodes", [3, "12", [], [1.0], None, [0], np.array(3)])
    assert as_span("episodes", (np.int64(1), 2)) == (1, 2)
    each(lambda value: as_span("episodes", value), "episodes", [(2, 1), (1,), (1, 2, 3), "12", (0, 2), 5])


def test_numbers():
    for value in (2, 2.0, np.float32(2), np.int64(2), np.array(2.0)):
        assert type(real("x", value, 0, 9)) is float
    each(lambda value: real("x", value, 0, 9), "x", [math.nan, math.inf, -1, 10, None, "2", True, 10**400, [2.0]])
    assert plain(np.array([[1, 2], [3, 4]])) == [[1, 2], [3, 4]]
    assert [type(plain(value)) for value in (np.bool_(1), np.float32(1), np.str_("a"), "a", None)] == [
        bool, float, str, str, type(None),
    ]  # fmt: skip
    assert len(shown("x" * 1000)) == 60 and "int" in shown(10**5000)


def test_a_run_takes_numbers_of_numpy_and_its_manifest_holds_plain_ones(folder):
    settings = {"policy.beta": np.float64(2), "detection_radius": np.int32(3), "agents": np.array([4]),
                "policy.overfill": np.bool_(1), "max_steps": np.array(20)}  # fmt: skip
    ours = colonysim.run("sanity", overrides=settings, seed=np.int64(7), episodes=np.uint16(2), out="ours")
    same = {"policy.beta": 2.0, "detection_radius": 3, "agents": [4], "policy.overfill": True, "max_steps": 20}
    theirs = colonysim.run("sanity", overrides=same, seed=7, episodes=2, trace=False)
    assert ours.trace_sha256 == theirs.trace_sha256 and ours.scenario.digest == theirs.scenario.digest
    manifest = json.loads((folder / "ours" / "manifest.json").read_text())
    assert manifest["options"]["overrides"] == same and (manifest["seed"], manifest["episodes"]) == (7, 2)
    again = colonysim.scenario_from_document({"topology": {"kind": "line", "nodes": np.int64(5)}, "goal": np.int8(4),
                                              "agents": np.arange(2)})  # fmt: skip
    assert json.dumps(dict(again.document)) and again.agents == (0, 1)
    assert list(colonysim.simulate(again, seed=np.int64(1), episodes=np.int64(1)))


def test_options_of_a_backend_stand_in_the_manifest_whatever_they_are():
    options = {"a": np.int64(1), "b": object(), "c": {2, 1}, "d": np.arange(2), "e": np.float32(0.5)}
    manifest = begin_manifest("x", backend="b", policy="p", mode="m", episodes=1, seed=1, options=options)
    kept = json.loads(json.dumps(manifest["options"]))
    assert kept.pop("b").startswith("<object object") and kept == {"a": 1, "c": [1, 2], "d": [0, 1], "e": 0.5}


def test_runs_refuse_what_is_no_count_and_no_seed_and_make_nothing(folder):
    scenario = colonysim.load_scenario("sanity")
    each(lambda value: colonysim.run("sanity", episodes=value), "episodes", no_default(NO_COUNT))
    each(lambda value: colonysim.run("sanity", seed=value), "seed", NO_SEED)
    each(lambda value: list(colonysim.simulate(scenario, episodes=value)), "episodes", no_default(NO_COUNT))
    each(lambda value: list(colonysim.simulate(scenario, seed=value)), "seed", NO_SEED)
    for mode in ("", "fast", 3):
        with pytest.raises(ColonysimError, match="no mode"):
            colonysim.run(scenario, mode=mode)
    with pytest.raises(ColonysimError, match="no events of kind 'episdoe'; did you mean 'episode'"):
        list(colonysim.simulate(scenario, kinds=["episdoe"]))
    for settings in ({"episodes": 2.0}, {"max_steps": np.True_}, {"agents": np.array([0.5])}, {"goal": np.float64(1)}):
        with pytest.raises(ScenarioError, match=next(iter(settings))):
            colonysim.run("sanity", overrides=settings)
    assert not list(folder.iterdir())


def test_readers_of_a_run(run, folder):
    each(lambda value: list(run.events(value)), "episode", no_default(NO_COUNT))
    each(lambda value: run.field("D", value), "episode", no_default(NO_COUNT))
    each(lambda value: run.frames(value), "episode", no_default(NO_COUNT))
    assert list(run.events(np.int64(2))) and run.field("D", np.int8(1))
    with pytest.raises(ColonysimError, match="no episode 9"):
        list(run.events(9))
    wrong = [3, "12", [], [2.5], [None], [0], [True]]
    each(lambda value: draw(run, episodes=value), "episodes", wrong)
    each(lambda value: write_page(run, folder / "x.html", value), "episodes", wrong)
    each(lambda value: export(run, "events", "csv", None, value), "episodes", wrong)
    each(lambda value: attempts(run, value), "episodes", wrong)
    each(lambda value: draw(run, hole=value), "hole", [2.5, "3", -1, True])
    each(lambda value: draw(run, box=value), "box", [2.5, "3", -1, True])
    each(lambda value: draw(run, dpi=value), "dpi", [0, -1, math.nan, math.inf, "high"])
    each(lambda value: write_video(run, "x.gif", episode=value), "episode", no_default(NO_COUNT))
    each(lambda value: write_video(run, "x.gif", fps=value), "fps", NO_COUNT)
    each(lambda value: write_video(run, "x.gif", seconds=value), "seconds", [math.inf, math.nan, -1, "20", None, True])
    each(lambda value: write_video(run, "x.gif", size=value), "size", [300, "300x200", (300.0, 200), (True, 200)])
    each(Live, "port", [-1, 65536, 2.5, "80", None])
    for kind in ("jpg", None):
        with pytest.raises(ColonysimError, match="no format"):
            draw(run, what="map", kind=kind, out=folder)
        with pytest.raises(ColonysimError, match="no format"):
            export(run, "events", kind, folder / "x", None)
    with pytest.raises(ColonysimError, match="no episode 7 in this run"):
        export(run, "events", "csv", None, [1, 7])
    assert not [path for path in folder.rglob("*") if path.is_file()]
    assert [path.name for path in draw(run, what="map", episodes=np.array([1]), out=folder)] == ["map.png"]


def test_sweeps_tunings_and_their_tables(folder):
    (folder / "s.yaml").write_text(SWEEP)
    each(lambda value: run_sweep("s.yaml", "out", workers=value), "workers", no_default(NO_COUNT))
    betas = [np.float64(2), np.int64(3)]
    planned = plan_sweep({"scenarios": ["sanity"], "episodes": 1, "grid": {"policy.beta": betas}})
    with pytest.raises(ColonysimError, match="no engine 'rai'; did you mean 'ray'"):
        run_sweep("s.yaml", "out", engine="rai")
    with pytest.raises(ColonysimError, match="no measure 'step'; did you mean 'steps'"):
        tune("s.yaml", "out", measure="step")
    spans = [(2, 1), (0, 1), (1.0, 2), "12", 5]
    each(lambda value: tune("s.yaml", "out", episodes=value), "episodes", spans)
    each(lambda value: compare(["out"], episodes=value), "episodes", spans)
    wrong = {"episodes": [2.0, True, "2", 0, -1, 10**12], "seeds": [[1.5], [True], ["1"], [-1], [10**18]]}
    for field, bad in wrong.items():
        for value in bad:
            with pytest.raises(ScenarioError, match=rf"^sweep: {field}"):
                plan_sweep({"scenarios": ["sanity"], field: value})
    assert not (folder / "out").exists()
    with Store("out", write=True) as store:
        each(lambda value: run_planned(planned, store, workers=value), "workers", no_default(NO_COUNT))
        run_planned(planned, store, workers=np.int64(1))
    trials, episodes = read_table("out", "trials"), read_table("out", "episodes")
    assert trials["policy.beta"].to_pylist() == [2.0, 3.0]
    each(lambda value: summary(trials, episodes, None, value), "episodes", spans)


def test_checkers_worlds_and_the_bench():
    from colonysim.backends.mock import Mock
    from colonysim.policies.uniform import Uniform

    counts = no_default(value for value in NO_COUNT if not (isinstance(value, int) and value == 0) or value is True)
    each(lambda value: check_policy(Uniform, worlds=value), "worlds", counts)
    each(lambda value: check_policy(Uniform, runs=value), "runs", counts)
    each(lambda value: check_policy(Uniform, episodes=value), "episodes", NO_COUNT)
    each(lambda value: check_policy(Uniform, seed=value), "seed", NO_SEED)
    each(lambda value: check_backend(Mock, episodes=value), "episodes", [*NO_COUNT, 1])
    each(lambda value: check_backend(Mock, seed=value), "seed", NO_SEED)
    each(random_scenario, "seed", NO_SEED)
    each(lambda value: random_scenario(1, max_nodes=value), "max_nodes", [*NO_COUNT, 3])
    assert random_scenario(np.int64(3)).digest == random_scenario(3).digest
    each(lambda value: measure("hard", value), "rounds", NO_COUNT)
    for name in ("columns", "rows", "agents"):
        each(lambda value, name=name: invent("grid", **{name: value}), name, NO_COUNT)
    each(lambda value: invent("rooms", size=value), "size", no_default([*NO_COUNT, 1]))
    each(lambda value: invent("grid", seed=value), "seed", NO_SEED)
    assert invent("grid", columns=np.int64(4), seed=np.int64(2)) == invent("grid", columns=4, seed=2)


def test_the_push(folder, some_engine):
    from colonysim.cli.pushes import PushRecorder
    from colonysim.push.executors import make_executor
    from colonysim.push.training.evaluation import evaluate_push

    each(lambda value: evaluate_push("scripted", episodes=value), "episodes", NO_COUNT)
    each(lambda value: evaluate_push("scripted", seed=value), "seed", NO_SEED)
    each(lambda value: evaluate_push("scripted", tries=value), "tries", NO_COUNT)
    each(
        lambda value: PushRecorder(folder / "run", "scripted", engine=some_engine, episodes=value, seed=1),
        "episodes", NO_COUNT,
    )  # fmt: skip
    for settings in ({"model": "push"}, {"ticks": 3}, {"chooser": "push-in"}, {"gate": lambda state: 1.0}):
        with pytest.raises(ColonysimError, match="'scripted'"):
            make_executor("scripted", **settings)
    with pytest.raises(ColonysimError, match="'staged' asks no gate"):
        make_executor("staged", gate=lambda state: 1.0)
    assert not list(folder.iterdir())


def test_trainings(folder):
    pytest.importorskip("torch")
    pytest.importorskip("sklearn")
    from colonysim.push.training.calibration import train_way_chance
    from colonysim.push.training.forest import train_feasibility
    from colonysim.push.training.trainer import train_push

    each(lambda value: train_push("improved", folder / "out", value), "seed", NO_SEED)
    each(lambda value: train_feasibility(folder / "out", value), "seed", NO_SEED)
    each(lambda value: train_feasibility(folder / "out", 1, states=value), "states", NO_COUNT)
    each(lambda value: train_way_chance(folder / "out", value), "seed", NO_SEED)
    each(lambda value: train_way_chance(folder / "out", 1, ways=value), "ways", NO_COUNT)
    assert not list(folder.iterdir())


def test_a_span_of_time_is_no_number():
    for value in (
        np.timedelta64(5),
        np.timedelta64(5, "ns"),
        np.timedelta64(5, "s"),
        np.datetime64("2026-01-01", "ns"),
    ):
        assert plain(value) is value
        each(lambda value: real("pace", value, 0.0, 1e30), "pace", [value])
