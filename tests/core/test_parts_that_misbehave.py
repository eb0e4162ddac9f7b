"""What parts of third parties may not do: each was accepted, or ended in a traceback, once."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import colonysim
from colonysim.backends.nodeworld import NodeWorld
from colonysim.backends.physics import Physics
from colonysim.backends.protocol import Done
from colonysim.errors import ColonysimError, PluginError
from colonysim.policies import Choice
from colonysim.policies.presets import Colony
from colonysim.scenario.loading import load_scenario, scenario_from_document
from colonysim.simulation import simulate
from colonysim.world.intents import Outcome, Push, Travel, Wait


def line(nodes: int, **more: object) -> dict[str, object]:
    return {
        "topology": {"kind": "line", "nodes": nodes}, "goal": nodes - 1, "agents": [0], "episodes": 1, "max_steps": 30,
        **more,
    }  # fmt: skip


class Watching(NodeWorld):
    """A node world that keeps hold of its world."""

    name = "watching"

    def reset(self, world, streams):
        self.world = world
        super().reset(world, streams)


class Bare:
    """A policy without fields; what it does is said by those derived from it."""

    name = "bare"

    def __init__(self, scenario):
        pass

    def fields(self, world):
        return {}

    def begin(self, agent, memory):
        return 0

    def decide(self, view, memory, random):
        return Choice(Travel(view.neighbours[-1]), memory)


def ends(scenario, **settings):
    return list(simulate(scenario, seed=1, episodes=1, **settings))


@pytest.mark.parametrize(
    "answer", [lambda *_: 1 / 0, lambda *_: None, lambda *_: [], lambda s, a, b, way: [float("nan")] * (len(way) - 1)]
)
def test_a_method_that_is_added_to_a_built_in_backend_is_checked_too(answer):
    kind = type("Foresees", (NodeWorld,), {"name": "foresees", "feasible_way": answer})
    with pytest.raises(PluginError, match="feasible_way"):
        ends(load_scenario("hard"), backend=kind())


def test_a_replaced_feasible_way_of_physics_is_the_one_that_is_asked():
    asked = []

    class Asked(Physics):
        def feasible_way(self, agent, box, way):
            asked.append(way)
            return [1.0] * (len(way) - 1)

    ends(load_scenario("sanity"), backend=Asked())
    assert asked


@pytest.mark.parametrize(
    ("kind", "name", "instead"),
    [(NodeWorld, "undertake", "start"), (NodeWorld, "needs", "footprint"), (NodeWorld, "_seconds", "private")],
)
def test_what_only_the_built_in_part_calls_cannot_be_replaced(kind, name, instead):
    made = type("Mine", (kind,), {"name": "mine", name: lambda self, *_: 0})()
    with pytest.raises(PluginError, match=f"Mine replaces '{name}' of NodeWorld.*{instead}"):
        ends(load_scenario("sanity"), backend=made)


@pytest.mark.parametrize("name", ["think", "_explore"])
def test_nor_can_it_in_a_policy(name):
    kind = type("Mine", (Colony,), {name: lambda self, *_: 0})
    with pytest.raises(PluginError, match=f"Mine replaces '{name}'"):
        ends(load_scenario("sanity"), policy=kind)


def test_a_box_out_of_reach_is_not_claimed_and_its_holder_keeps_it():
    class Grabs(Bare):
        def decide(self, view, memory, random):
            if view.agent == 0:
                near = view.box_node(0) in (view.node, *view.neighbours)
                return Choice(Push(0, view.node + 1, 0) if near else Wait(()), memory)
            return Choice(Push(0, view.neighbours[-1], 0), memory)

    scenario = scenario_from_document(
        line(9, agents=[0, 7], boxes=[[1, 0.5]], holes=[{"node": 5, "depth": 0.5}], goal=8, detection_radius=20.0)
    )
    holders = []

    class Watch(Watching):
        def start(self, agent, intent, now):
            holders.append((agent, self.world.box_claim[0]))
            return super().start(agent, intent, now)

    ends(scenario, policy=Grabs, backend=Watch())
    assert (1, 1) not in holders and (0, 0) in holders


def test_a_first_request_to_clear_a_node_is_heard_in_synchronous_mode():
    class Polite(Bare):
        def decide(self, view, memory, random):
            if view.agent == 0 and view.occupied(view.neighbours[-1]):
                return Choice(Wait((view.neighbours[-1],), None, view.neighbours[-1]), memory)
            if view.agent == 1 and not memory and not view.asked_to_clear:
                return Choice(Wait(()), memory)
            return Choice(Travel(view.neighbours[-1]), 1)

    for mode in ("synchronous", "asynchronous"):
        events = ends(scenario_from_document(line(5, agents=[0, 1])), policy=Polite, mode=mode)
        assert events[-1].status == "goal", mode


@pytest.mark.parametrize("seconds", [500.0, 5000.0, None])
def test_a_deadlock_is_told_when_nothing_can_happen_whatever_waits_had_been_meant_to_last(seconds):
    class Waits(Bare):
        def decide(self, view, memory, random):
            if view.agent == 1 and view.node == 2:
                return Choice(Travel(1), 1)
            return Choice(Wait((1, 2), None if memory else seconds), 1)

    events = ends(scenario_from_document(line(6, agents=[0, 2], stall_seconds=1000)), policy=Waits)
    arrived = next(event.time for event in events if event.kind == "end")
    assert (events[-1].status, events[-1].time) == ("deadlock", arrived)


class Noisy:
    """A field that changes what it is told."""

    name, by_box = "N", False

    def __init__(self, world):
        pass

    def at(self, node, key=-1):
        return 0.0

    def keys(self, node):
        return ()

    def deposit(self, visit):
        visit.node = 0
        return ()

    def end_episode(self):
        pass

    def frame(self):
        return []

    def load(self, frame):
        pass


def test_what_a_field_changes_in_a_visit_no_other_field_reads():
    class First(Colony):
        def fields(self, world):
            return {"N": Noisy(world), **super().fields(world)}

    scenario = load_scenario("hard")
    with_it = [(e.time, e.kind, e.node) for e in ends(scenario, policy=First)]
    assert with_it == [(e.time, e.kind, e.node) for e in ends(scenario, policy=Colony)]


def test_a_field_has_the_name_under_which_it_is_kept():
    class Misnamed(Bare):
        def fields(self, world):
            return {"X": Noisy(world)}

    with pytest.raises(PluginError, match="'X' calls itself 'N'"):
        ends(load_scenario("sanity"), policy=Misnamed)


@pytest.mark.parametrize("where", ["module", "class"])
def test_exit_in_a_part_that_is_loaded_is_told(where, tmp_path, monkeypatch):
    made = "class P:\n    def __init__(self, s):\n        sys.exit(0)\n"
    text = "import sys\n" + ("sys.exit(0)\n" if where == "module" else made)
    (tmp_path / f"exits_{where}.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(PluginError, match="SystemExit"):
        colonysim.run("sanity", policy=f"exits_{where}:P", out=tmp_path / "run")
    sys.modules.pop(f"exits_{where}", None)


def test_numbers_and_lists_of_numpy_are_taken_and_end_up_as_plain_ones(tmp_path):
    class Numpy(Bare):
        def decide(self, view, memory, random):
            nodes = np.array(view.neighbours)
            shares = np.full(len(nodes), 1 / len(nodes))
            return Choice(Travel(nodes[-1]), memory, np.bool_(True), nodes, np.full(len(nodes), -1), shares)

    run = colonysim.run(scenario_from_document(line(4)), policy=Numpy, out=tmp_path / "run")
    rows = run.table("decisions").to_pylist()
    assert rows and all(row["targets"] and row["explored"] is True for row in rows)

    class Once(Bare):
        def decide(self, view, memory, random):
            return Choice(Travel(view.neighbours[-1]), memory, False, iter((0,)), iter((-1,)), iter((1.0,)))

    run = colonysim.run(scenario_from_document(line(4)), policy=Once, out=tmp_path / "once")
    assert all(len(row["targets"]) == 1 for row in run.table("decisions").to_pylist())


@pytest.mark.parametrize(
    ("choice", "why"),
    [
        (lambda node: Choice(Travel(node), 0, "yes"), "explored"),
        (lambda node: Choice(Travel(node), 0, False, (node,), (-1,), (7.0,)), "probabilities"),
    ],
)
def test_choices_that_no_trace_should_hold(choice, why):
    class Odd(Bare):
        def decide(self, view, memory, random):
            return choice(view.neighbours[-1])

    with pytest.raises(PluginError, match=why):
        ends(load_scenario("sanity"), policy=Odd)


def test_a_deposit_that_is_an_array_of_floats_is_an_error_and_no_traceback():
    class Array(Noisy):
        def deposit(self, visit):
            return np.array([[visit.node, -1, 1.0], [visit.node, -1, 2.0]])

    class Its(Bare):
        def fields(self, world):
            return {"N": Array(world)}

    with pytest.raises(PluginError, match="no such node"):  # its numbers are no whole ones
        ends(load_scenario("sanity"), policy=Its)


@pytest.mark.parametrize(
    ("footprint", "why"),
    [
        (lambda at, to: {(to,), to}, "expected a node or an edge"),
        (lambda at, to: {at}, "lacks node"),
    ],
)
def test_footprints_that_are_none(footprint, why):
    class Sweeps(Watching):
        def footprint(self, agent, intent):
            return footprint(self.world.agent_node[agent], intent.node)

    with pytest.raises(PluginError, match=why):
        ends(load_scenario("sanity"), backend=Sweeps())


def test_an_edge_is_one_place_whichever_end_is_named_first():
    class Sweeps(Watching):
        def footprint(self, agent, intent):
            return {(self.world.agent_node[agent], intent.node), intent.node}

    class Meets(Bare):
        def decide(self, view, memory, random):
            return Choice(Travel(view.node + 1 if view.agent == 0 else view.node - 1), memory)

    events = ends(scenario_from_document(line(4, agents=[1, 2], goal=3)), policy=Meets, backend=Sweeps())
    assert not any(event.kind == "end" and event.time < 1.0 for event in events)


@pytest.mark.parametrize(("to", "why"), [(4, "did not set out for node 4"), (1, "agent 1 stands on node 1")])
def test_an_agent_is_not_put_where_it_cannot_be(to, why):
    class Teleports(NodeWorld):
        name = "teleports"

        def start(self, agent, intent, now):
            return Done(1.0, Outcome("arrived" if to == 4 else "failed", to))

    class Goes(Bare):
        def decide(self, view, memory, random):
            return Choice(Travel(view.node - 1 if view.agent else view.node + 1), memory)

    document = line(6, agents=[0] if to == 4 else [2, 1], goal=5)
    with pytest.raises(PluginError, match=why):
        ends(scenario_from_document(document), policy=Goes, backend=Teleports())


def test_a_tick_that_no_waiting_would_survive_is_refused():
    class Ticks(NodeWorld):
        name, tick = "ticks", 1e-20

    with pytest.raises(PluginError, match="tick is 1e-20"):
        ends(load_scenario("sanity"), backend=Ticks())


def test_kinds_is_a_list():
    with pytest.raises(ColonysimError, match="expected a list"):
        ends(load_scenario("sanity"), kinds="episode")


def test_the_last_event_of_an_episode_that_ran_out_of_time_has_that_time():
    events = ends(scenario_from_document(line(9, time_limit=2.5)), policy=Bare)
    assert (events[-1].status, events[-1].time) == ("timeout", 2.5)
