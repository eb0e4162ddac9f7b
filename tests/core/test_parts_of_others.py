"""Parts of others against our own, and compiled against plain Python: the same traces, bit for bit."""

from __future__ import annotations

from importlib.machinery import EXTENSION_SUFFIXES

import pytest
from plain_python import PACKAGE, compiled_and_plain
from small_worlds import Wrapped

import colonysim
from colonysim.backends.nodeworld import NodeWorld
from colonysim.policies.presets import Colony
from colonysim.policies.stigmergy import Stigmergy
from colonysim.scenario.invent import invent
from colonysim.simulation import episode
from colonysim.simulation.foreign import ForeignPolicy, checked_policy
from colonysim.testing.worlds import random_scenario
from colonysim.trace.rows import Rows
from colonysim.world.state import World

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
from colonysim.simulation import episode
from colonysim.testing.worlds import random_scenario
print(episode.__file__)
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


class WrappedFields(Stigmergy):
    """The policy as it is, with fields that are called by their protocol."""

    def fields(self, world):
        return {name: Wrapped(field) for name, field in super().fields(world).items()}


def same_hash(scenario, seed, **parts):
    return colonysim.run(scenario, seed=seed, trace=False, **parts).trace_sha256


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_a_part_of_another_changes_nothing_but_who_answers(mode):
    for seed in range(0, 100, 1 + (mode == "synchronous")):
        scenario = varied(seed)
        ours = same_hash(scenario, seed, mode=mode)
        assert same_hash(scenario, seed, mode=mode, policy=Wrapped(Stigmergy(scenario))) == ours
        assert same_hash(scenario, seed, mode=mode, policy=WrappedFields(scenario)) == ours
        assert same_hash(scenario, seed, mode=mode, backend=Wrapped(NodeWorld())) == ours


def test_measured_durations_of_travels_and_pushes_count_either_way():
    document = invent("grid", columns=10, rows=10, holes=2, spare=2, agents=3, seed=4)
    place = colonysim.scenario_from_document(document).topology
    edges = [(place.ids[i], place.ids[j]) for i, near in enumerate(place.neighbours) for j in near]
    timing = {
        "travels": [[i, j, 2.0 + (3 * i + j) % 7] for i, j in edges],
        "pushes": [[i, j, 5.0 + (5 * i + j) % 11] for i, j in edges],
    }
    scenario = colonysim.scenario_from_document({**document, "timing": timing})
    assert scenario.timing.travels and scenario.timing.pushes
    assert same_hash(scenario, 2, backend=Wrapped(NodeWorld())) == same_hash(scenario, 2)


def test_a_crowd_that_waits_and_wakes_is_the_same_either_way():
    document = invent("grid", columns=14, rows=14, holes=3, spare=7, agents=60, crowded=True, seed=5)
    scenario = colonysim.scenario_from_document({**document, "max_steps": 12})
    assert same_hash(scenario, 3, policy=Wrapped(Stigmergy(scenario))) == same_hash(scenario, 3)


def test_only_what_replaces_a_method_of_ours_is_looked_at():
    class Renamed(Colony):
        name = "another"

    class Bolder(Colony):
        def decide(self, view, memory, random):
            return super().decide(view, memory, random)

    scenario = colonysim.load_scenario("easy")
    world, rows = World(scenario), Rows(scenario, None, False)
    kept = Renamed(scenario)
    assert checked_policy(kept, world, rows) is kept
    assert isinstance(checked_policy(Bolder(scenario), world, rows), ForeignPolicy)


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


def test_a_policy_of_ones_own_is_asked_every_time():
    asked = []

    class Own(Stigmergy):
        def decide(self, view, memory, random):
            asked.append(view.agent)
            return super().decide(view, memory, random)

    scenario = colonysim.load_scenario("easy")
    run = colonysim.run(scenario, policy=Own(scenario), episodes=1, seed=1, trace=False)
    assert len(asked) >= run.manifest["rows"]["decisions"]


def compiled() -> bool:
    return not str(episode.__file__).endswith(".py")


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
