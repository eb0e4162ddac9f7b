"""Strides against the long way round, and compiled against plain Python: the same traces, bit for bit."""

from __future__ import annotations

import sys
from importlib.machinery import EXTENSION_SUFFIXES

import pytest
from plain_python import PACKAGE, compiled_and_plain

import colonysim
from colonysim.scenario.invent import invent
from colonysim.simulation import episode
from colonysim.simulation.strides import Strides
from colonysim.testing.worlds import random_scenario

VARIANTS = [
    {},
    {"distance_rule": "literal", "exploration_evaporation": None, "epsilon": 0.9, "epsilon_floor": 0.5},
    {"unvisited": "zero", "beta": 0.5, "deposit_at_start": True, "hole_evaporation": 0.0},
    {"hole_rule": "min", "box_credit": "enter", "stack_credit": "top", "exploration_on_wait": True, "box_cap": None},
    {"ask_to_clear": False, "errands": False, "step_past": False, "patience": 1.0, "overfill": True,
     "candidates_centre": "agent"},
]  # fmt: skip

PROGRAM = """
import colonysim
from colonysim.simulation import strides
from colonysim.testing.worlds import random_scenario
print(strides.__file__)
for seed in range(200):
    scenario = random_scenario(seed, max_nodes=40, max_agents=8)
    print(seed, colonysim.run(scenario, episodes=2, seed=seed, trace=False).trace_sha256)
print(colonysim.run("hard", episodes=4, seed=3, trace=False).trace_sha256)
"""


def varied(seed: int):
    """A random world with parameters of its own, small or not so small."""
    scenario = random_scenario(seed, max_nodes=12 + 28 * (seed % 2), max_agents=8)
    scenario.parameters.update(VARIANTS[seed % len(VARIANTS)])
    return scenario


def test_200_random_worlds_with_strides_and_without(monkeypatch):
    with_strides = [colonysim.run(varied(seed), seed=seed, trace=False).trace_sha256 for seed in range(200)]
    monkeypatch.setattr(episode, "strides_of", lambda *_: None)
    assert [colonysim.run(varied(seed), seed=seed, trace=False).trace_sha256 for seed in range(200)] == with_strides


def test_measured_durations_of_travels_and_pushes_count_either_way(monkeypatch):
    document = invent("grid", columns=10, rows=10, holes=2, spare=2, agents=3, seed=4)
    place = colonysim.scenario_from_document(document).topology
    edges = [(place.ids[i], place.ids[j]) for i, near in enumerate(place.neighbours) for j in near]
    timing = {
        "travels": [[i, j, 2.0 + (3 * i + j) % 7] for i, j in edges],
        "pushes": [[i, j, 5.0 + (5 * i + j) % 11] for i, j in edges],
    }
    scenario = colonysim.scenario_from_document({**document, "timing": timing})
    assert scenario.timing.travels and scenario.timing.pushes
    short = colonysim.run(scenario, episodes=3, seed=2, trace=False)
    monkeypatch.setattr(episode, "strides_of", lambda *_: None)
    assert colonysim.run(scenario, episodes=3, seed=2, trace=False).trace_sha256 == short.trace_sha256


def test_without_a_sink_the_same_happens_either_way(monkeypatch):
    events = [list(colonysim.simulate(varied(seed), episodes=2, seed=seed)) for seed in range(20)]
    monkeypatch.setattr(episode, "strides_of", lambda *_: None)
    for seed, before in enumerate(events):
        again = list(colonysim.simulate(varied(seed), episodes=2, seed=seed))
        assert [e for e in again if e.kind != "episode"] == [e for e in before if e.kind != "episode"]


def test_the_preset_colony_takes_strides_too_by_whatever_name(monkeypatch):
    made, original = [], episode.strides_of
    monkeypatch.setattr(episode, "strides_of", lambda *args: made.append(original(*args)) or made[-1])
    by_name = colonysim.run("hard", policy="colony", episodes=2, seed=1, trace=False).trace_sha256
    assert all(made)
    monkeypatch.setattr(episode, "strides_of", lambda *_: None)
    assert colonysim.run("hard", policy="colony", episodes=2, seed=1, trace=False).trace_sha256 == by_name


@pytest.fixture
def taken(monkeypatch):
    """The agents of the decisions that were taken the long way round."""
    agents = []

    class Counted(episode.Episode):
        def _decide(self, agent):
            agents.append(agent)
            return super()._decide(agent)

    monkeypatch.setattr(colonysim.simulation, "Episode", Counted)
    return agents


def test_strides_are_what_a_large_map_consists_of(taken):
    document = {"name": "grid", "topology": {"kind": "grid", "columns": 12, "rows": 12}, "agents": [0, 7], "goal": 143}
    run = colonysim.run(colonysim.scenario_from_document(document), episodes=3, seed=1, trace=False)
    assert len(taken) < 0.05 * run.manifest["rows"]["decisions"]


def test_among_boxes_too_nothing_is_decided_the_long_way(taken):
    document = invent("grid", columns=12, rows=12, holes=4, spare=8, agents=6, seed=2)
    run = colonysim.run(colonysim.scenario_from_document(document), episodes=3, seed=1, trace=False)
    assert taken == [] and run.manifest["rows"]["decisions"] > 100


def test_a_crowd_that_waits_and_wakes_is_the_same_either_way(monkeypatch):
    document = invent("grid", columns=14, rows=14, holes=3, spare=7, agents=60, crowded=True, seed=5)
    scenario = colonysim.scenario_from_document({**document, "max_steps": 12})
    short = colonysim.run(scenario, episodes=2, seed=3, trace=False)
    monkeypatch.setattr(episode, "strides_of", lambda *_: None)
    assert colonysim.run(scenario, episodes=2, seed=3, trace=False).trace_sha256 == short.trace_sha256


@pytest.mark.parametrize("seed", range(6))
def test_a_listener_hears_every_event_and_changes_nothing(seed, tmp_path):
    scenario, heard = varied(seed), []
    alone = colonysim.run(scenario, seed=seed, out=tmp_path / "alone")
    watched = colonysim.run(scenario, seed=seed, out=tmp_path / "watched", on_event=lambda e, _: heard.append(e))
    assert alone.trace_sha256 == watched.trace_sha256
    assert list(alone.events()) == list(watched.events()) == heard
    kinds = {"goal", "wait"}
    some = list(colonysim.simulate(scenario, seed=seed, kinds=kinds))
    assert some == [event for event in heard if event.kind in kinds]


OTHERS = [("mock", "colony"), ("nodeworld", "paper"), ("nodeworld", "oracle"), ("nodeworld", "random")]


@pytest.mark.parametrize(("backend", "policy"), OTHERS)
def test_no_strides_where_they_would_not_do_as_the_policy_or_the_backend_says(backend, policy, monkeypatch):
    made, original = [], episode.strides_of
    monkeypatch.setattr(episode, "strides_of", lambda *args: made.append(original(*args)))
    colonysim.run("easy", backend=backend, policy=policy, episodes=1, trace=False)
    assert made == [None]


def test_a_policy_of_ones_own_is_asked_every_time():
    from colonysim.policies.stigmergy import Stigmergy

    asked = []

    class Own(Stigmergy):
        def decide(self, view, memory, random):
            asked.append(view.agent)
            return super().decide(view, memory, random)

    scenario = colonysim.load_scenario("easy")
    run = colonysim.run(scenario, policy=Own(scenario), episodes=1, seed=1, trace=False)
    assert len(asked) >= run.manifest["rows"]["decisions"]


def compiled() -> bool:
    return not str(sys.modules[Strides.__module__].__file__).endswith(".py")


@pytest.mark.skipif(not compiled(), reason="colonysim was installed where there is no C compiler")
def test_compiled_and_plain_python_on_200_random_worlds(tmp_path):
    hashes, again = compiled_and_plain(PROGRAM, tmp_path)
    assert hashes == again


@pytest.mark.skipif(not compiled(), reason="colonysim was installed where there is no C compiler")
def test_what_is_compiled_is_as_new_as_its_source():
    for built in PACKAGE.rglob(f"*{EXTENSION_SUFFIXES[0]}"):
        stem = built.with_name(built.name.split(".")[0])
        for source in (stem.with_suffix(suffix) for suffix in (".py", ".pyx", ".pxd")):
            newer = source.exists() and source.stat().st_mtime > built.stat().st_mtime
            assert not newer, f"{source.name} has changed since it was compiled: pip install -e . again"
