"""What others hand in, and what they might do with what they are handed: nothing leaves its bounds."""

from __future__ import annotations

import copy
import pickle
from itertools import zip_longest

import pytest
from small_worlds import line, place

import colonysim
from colonysim import simulate
from colonysim.backends.nodeworld import NodeWorld
from colonysim.errors import PluginError
from colonysim.pheromones import BoxWorth, HoleTrail, Write
from colonysim.policies.presets import Colony
from colonysim.policies.stigmergy import Memory, Stigmergy
from colonysim.testing.worlds import random_scenario
from colonysim.world.intents import Wait
from colonysim.world.state import World


def ends(events):
    return [event for event in events if event.kind != "episode"]


def star(rays: int):
    """A hub with boxes all round."""
    points = [(0.0, 0.0), *((1.0, 0.01 * ray) for ray in range(rays))]
    edges = [(0, ray) for ray in range(1, rays + 1)]
    boxes = [(ray, 1.0) for ray in range(2, rays)]
    return place(points, edges, goal=rays, agents=[0], boxes=boxes, max_steps=5)


def test_a_policy_serves_another_and_a_larger_map():
    small, hub = line(3, goal=2, agents=[0]), star(60)
    policy = Stigmergy(small)
    list(simulate(small, policy=policy, episodes=1))
    assert [e.kind for e in simulate(hub, policy=policy, episodes=2, seed=1)][-1] == "episode"


def test_two_runs_share_a_policy_and_take_turns():
    scenario = random_scenario(4, max_nodes=40, max_agents=6)
    policy, found = Stigmergy(scenario), {1: [], 2: []}
    runs = [simulate(scenario, policy=policy, episodes=2, seed=seed) for seed in found]
    for events in zip_longest(*runs):
        for seed, event in zip(found, events, strict=True):
            if event is not None:
                found[seed].append(event)
    for seed, events in found.items():
        assert ends(events) == ends(simulate(scenario, episodes=2, seed=seed))


def test_copies_of_a_policy_decide_alike():
    scenario = random_scenario(6, max_nodes=30, max_agents=4)
    for policy in (Stigmergy(scenario), Colony(scenario)):
        runs = [ends(simulate(scenario, policy=p, seed=1, episodes=2)) for p in (policy, copy.deepcopy(policy))]
        again = pickle.loads(pickle.dumps(policy))
        assert runs[0] == runs[1] == ends(simulate(scenario, policy=again, seed=1, episodes=2))
        assert (again.name, again.settings) == (policy.name, policy.settings)


def test_a_policy_that_lacks_a_field_is_told_which():
    class Short(Stigmergy):
        def fields(self, world):
            return {name: field for name, field in super().fields(world).items() if name != "E"}

    scenario = line(4, goal=3, agents=[0], parameters={"epsilon": 1.0})
    with pytest.raises(PluginError, match="policy 'colony', agent 0 at 0 s: decide raises KeyError: 'E'") as caught:
        list(simulate(scenario, policy=Short(scenario), episodes=1))
    assert isinstance(caught.value.__cause__, KeyError)


def test_keys_of_holes_that_do_not_exist_are_nobodys():
    class Odd(HoleTrail):
        def keys(self, node):
            return (-3, 0, 7)

    class Follows(Stigmergy):
        def fields(self, world):
            return {**super().fields(world), "H": Odd(world)}

    scenario = line(6, goal=5, agents=[0], holes={3: (-1.0, 0.0)}, boxes=[(1, 1.0)], detection_radius=1.0)
    run = list(simulate(scenario, policy=Follows(scenario), episodes=3, seed=1))
    assert any(event.action == "take" for event in run), "what is derived from a field is asked for its keys"


def test_worth_of_pairs_that_do_not_exist():
    worth = BoxWorth(World(line(3, goal=2, agents=[0], boxes=[(1, 1.0), (1, 1.0)])), start=10.0, decay=0.5)
    worth.load([Write(0, 0, 5.0)])
    assert (worth.at(0, 0), worth.at(1), worth.at(0)) == (5.0, 10.0, 10.0)
    assert [tuple(write) for write in worth.frame()] == [(0, 0, 5.0)]


def test_waits_footprints_and_requests_that_name_what_does_not_exist():
    class Wide(NodeWorld):
        def footprint(self, agent, intent):
            places = super().footprint(agent, intent)
            return places if isinstance(intent, Wait) else places | {(1, 500_000_000)}

    scenario = line(6, goal=5, agents=[0, 2, 4])
    with pytest.raises(PluginError, match=r"footprint of .* holds \(1, 500000000\), expected a node or an edge"):
        list(simulate(scenario, backend=Wide(), episodes=1, seed=1))
    world = World(scenario)
    world.ask(0, 99)
    assert not world.clear_requests and not world.requested_near(3)
    for asked in (world.holes_near, world.boxes_near):
        for node in (400_000_000, 6, -1):
            with pytest.raises(IndexError):
                asked(node)


def test_a_copied_world_hears_the_same_requests():
    world = World(line(5, goal=4, agents=[0, 2]))
    world.ask(0, 2)
    twin = copy.deepcopy(world)
    twin.unask(2)
    twin.ask(1, 0)
    assert twin.requested_near(1) and not twin.requested_near(3) and world.requested_near(3)


def test_a_memory_may_be_more_than_ours():
    class More(Memory):
        pass

    assert hash(Memory(0.1)) == hash(Memory(0.1)) and isinstance(More(0.5), Memory)


def test_many_holes_are_looked_for(monkeypatch):
    scenario = random_scenario(7, max_nodes=30, max_agents=5)
    noted = colonysim.run(scenario, episodes=2, seed=1, trace=False).trace_sha256
    monkeypatch.setattr("colonysim.world.visibility.ROOM", -1)
    assert colonysim.run(scenario, episodes=2, seed=1, trace=False).trace_sha256 == noted
