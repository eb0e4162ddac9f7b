"""What holds after every event, whatever the place, whoever decides and whatever moves the bodies."""

from __future__ import annotations

import pytest
from small_worlds import Rows

from colonysim import load_scenario
from colonysim.plugins import make_policy
from colonysim.simulation import simulate
from colonysim.testing.worlds import random_scenario
from colonysim.world.state import AgentStatus, World

SEEDS = range(60)


def check(world: World) -> None:
    """Nothing of the world contradicts another part of it."""
    scenario, topology = world.scenario, world.topology
    here = [a for a, status in enumerate(world.agent_status) if status is not AgentStatus.GOAL]
    places = [world.agent_node[a] for a in here]
    assert len(set(places)) == len(places), "two agents on a node"
    for agent in here:
        assert world.occupant[world.agent_node[agent]] == agent
    assert sorted(a for a in world.occupant if a >= 0) == here
    stacked = sorted(box for stack in world.stacks.values() for box in stack)
    assert stacked == list(range(len(scenario.boxes))), "a box lost or doubled"
    for node in range(len(topology)):
        height = topology.z[node]
        for box in world.stacks.get(node, ()):
            assert world.box_node[box] == node
            assert world.box_base[box] == pytest.approx(height)
            height += scenario.boxes[box].height
        assert world.surface[node] == pytest.approx(height)
    assert all(world.stacks.values()), "an empty stack is no stack"
    for holder in world.box_claim:
        assert holder == -1 or world.agent_status[holder] is AgentStatus.ACTIVE
    assert len([h for h in world.box_claim if h >= 0]) == len({h for h in world.box_claim if h >= 0})
    for agent, box in enumerate(world.agent_box):
        assert box < 0 or world.box_node[box] == world.agent_node[agent]
        if box >= 0:
            assert world.box_claim[box] in (-1, agent)
    for agent in here:
        for place in world.reserved[agent]:
            if isinstance(place, int):
                assert world.node_holder[place] == agent and world.occupant[place] in (-1, agent)
            else:
                assert world.edge_holder[place] == agent
    for node in range(len(topology)):
        holder = world.node_holder[node]
        assert holder == -1 or node in world.reserved[holder]
    for node in range(len(topology)):
        seen = [box for box in range(len(scenario.boxes))
                if topology.distance(world.box_node[box], node) <= scenario.detection_radius]  # fmt: skip
        assert world.boxes_near(node) == seen


def watch(scenario, name, mode, backend, seed, episodes):
    """Plays a scenario and checks its world after every event; the rows, and the events that were no arrivals."""
    worlds, rows = [], Rows()

    class Watched(type(make_policy(name, scenario))):
        def fields(self, world):
            worlds.append(world)
            return super().fields(world)

    policy, failed = Watched(scenario), []
    time, episode, steps = 0.0, 1, [0] * len(scenario.agents)
    for event in simulate(scenario, policy=policy, mode=mode, backend=backend, seed=seed, episodes=episodes, sink=rows):
        check(worlds[0])
        if event.episode != episode:
            time, episode, steps = 0.0, event.episode, [0] * len(scenario.agents)
        assert event.time >= time >= 0.0
        time = event.time
        assert event.step <= scenario.max_steps
        if event.agent >= 0:
            assert event.step >= steps[event.agent], "steps are never taken back"
            steps[event.agent] = event.step
        if event.kind == "end":
            assert event.began <= event.time
            if event.status != "arrived":
                failed.append(event)
    for result in rows.episodes:
        assert (result.success == 1.0) == (result.ended == "goal")
        assert result.steps <= scenario.max_steps
    return rows, failed


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
@pytest.mark.parametrize("name", ["colony", "paper", "random"])
def test_after_every_event(name, mode):
    ends = set()
    for seed in SEEDS:
        rows, failed = watch(random_scenario(seed), name, mode, "nodeworld", seed, 2)
        assert not failed, "the node world never fails a fair move"
        ends |= {result.ended for result in rows.episodes}
    assert "goal" in ends
    assert ends <= {"goal", "max_steps", "deadlock"}


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
@pytest.mark.parametrize("name", ["colony", "paper", "random"])
@pytest.mark.parametrize("where", ["sanity", "hard"])
def test_on_every_backend(where, name, mode, backend):
    scenario = load_scenario(where, None, {"max_steps": 10})
    rows, _ = watch(scenario, name, mode, backend, 2, 1)
    assert any(event[4] == "push" for event in rows.tables["events"])
