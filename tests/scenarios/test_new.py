"""New worlds: valid, the same for the same seed, and solved by the boxes that come with them."""

from __future__ import annotations

from collections import deque

import pytest

import colonysim
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.world.intents import BoxPlace, Outcome, Push
from colonysim.world.invent import invent, to_yaml
from colonysim.world.loading import load_scenario
from colonysim.world.state import World

WORLDS = [
    {"kind": "grid", "columns": 20, "rows": 12, "holes": 6, "spare": 5, "agents": 9},
    {"kind": "grid", "columns": 30, "rows": 30, "holes": 10, "depth": 3, "agents": 60, "crowded": True},
    {"kind": "rooms", "columns": 3, "rows": 2, "size": 8, "holes": 5, "depth": 2, "agents": 12, "crowded": True},
    {"kind": "rooms", "columns": 1, "rows": 4, "size": 2, "agents": 3},
    {"kind": "platforms", "columns": 3, "rows": 3, "size": 5, "agents": 4},
    {"kind": "platforms", "columns": 2, "rows": 3, "size": 8, "depth": 2, "spare": 6, "agents": 20},
    {"kind": "geometric", "columns": 12, "rows": 9, "agents": 7},
]


def reached(world, starts):
    """All nodes that agents from there could travel to now."""
    seen, waiting = set(starts), deque(starts)
    while waiting:
        i = waiting.popleft()
        for j in world.topology.neighbours[i]:
            if j not in seen and world.reachable(i, j):
                seen.add(j)
                waiting.append(j)
    return seen


def way_into(world, box, hole):
    """A way on which the box can be pushed into the hole as things are, or None."""
    start, base = world.box_node[box], world.box_base[box]
    came, waiting = {start: start}, deque([start])
    while waiting:
        i = waiting.popleft()
        for j in world.topology.neighbours[i]:
            if j in came or not world.can_slide(base, i, j):
                continue
            came[j] = i
            if j == hole:
                way = [hole]
                while way[-1] != start:
                    way.append(came[way[-1]])
                return way[::-1]
            if not world.falls(base, i, j):
                waiting.append(j)
    return None


def solve(scenario):
    """Fills hole after hole with a box that can be reached; whether the goal can be reached in the end."""
    world = World(scenario)
    while True:
        free = reached(world, scenario.agents)
        if scenario.goal in free:
            return True
        for hole in sorted(scenario.holes, key=lambda h: (h.node not in world.stacks, h.node)):  # the begun ones first
            if world.surface[hole.node] > hole.rim - scenario.reach:
                continue
            near = [
                box for box, at in enumerate(world.box_node)
                if at != hole.node and free & set(world.topology.neighbours[at])
            ]  # fmt: skip
            ways = [(way, box) for box in near if (way := way_into(world, box, hole.node))]
            if ways:
                way, box = min(ways, key=lambda pair: len(pair[0]))
                places = (BoxPlace(box, hole.node),)
                world.apply(0, Push(box, way[-1], -1), Outcome("arrived", world.agent_node[0], places))
                break
        else:
            return False


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("wanted", WORLDS, ids=lambda wanted: f"{wanted['kind']}-{wanted['columns']}x{wanted['rows']}")
def test_a_new_world_can_be_solved_with_its_own_boxes(wanted, seed, tmp_path):
    document = invent(**wanted, seed=seed)
    path = tmp_path / "new.yaml"
    path.write_text(to_yaml(document))
    scenario = load_scenario(path)
    assert len(scenario.agents) == wanted["agents"]
    depth = wanted.get("depth", 1)
    assert len(scenario.boxes) >= wanted.get("holes", 0) * depth + wanted.get("spare", 0)
    assert solve(scenario)
    assert document == invent(**wanted, seed=seed)
    assert seed == 0 or document != invent(**wanted, seed=0)


def test_platforms_are_cut_off_from_each_other_until_holes_are_filled():
    scenario = colonysim.scenario_from_document(invent("platforms", columns=2, rows=2, size=5))
    free = reached(World(scenario), scenario.agents)
    assert len(free) == 25 - 2 and scenario.goal not in free, "the first platform without its two boxes"


def test_a_colony_solves_new_platforms():
    scenario = colonysim.scenario_from_document(invent("platforms", columns=2, rows=2, size=5, seed=3))
    run = colonysim.run(scenario, episodes=12, seed=5, trace=False)
    assert max(episode.success for episode in run.episodes) == 1.0


def test_rooms_have_walls_and_one_door_between_each_two():
    place = colonysim.scenario_from_document(invent("rooms", columns=3, rows=2, size=4)).topology
    assert len(place) == 3 * 2 * 16 + 7
    assert place.edge_count == 6 * 24 + 7 * 2


def test_a_crowd_is_drawn_from_free_nodes_within_its_borders():
    def agents(**crowd):
        document = invent("grid", columns=8, rows=8, holes=2) | {"agents": {"seed": 1, **crowd}}
        scenario = colonysim.scenario_from_document(document)
        taken = {scenario.goal, *(h.node for h in scenario.holes), *(b.node for b in scenario.boxes)}
        assert not taken & set(scenario.agents) and len(set(scenario.agents)) == len(scenario.agents)
        return scenario.agents

    assert agents(count=59) and agents(count=5) != agents(count=5, seed=2)
    assert all(node % 8 < 2 and node < 16 for node in agents(count=3, within=[0, 0, 1, 1]))
    with pytest.raises(ScenarioError, match=r"agents\.count: 60 agents, but only 59 nodes are free"):
        agents(count=60)
    with pytest.raises(ScenarioError, match="within these borders"):
        agents(count=5, within=[0.0, 0.0, 1.0, 1.0])
    with pytest.raises(ScenarioError, match=r"agents\.count"):
        agents(count=0)


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ({"kind": "platforms", "size": 4}, "at least 5, not 4"),
        ({"kind": "platforms", "holes": 2}, "are their doors"),
        ({"kind": "platforms", "size": 5, "depth": 3}, "no room for so many boxes"),
        ({"kind": "platforms", "spare": 500}, "room for 9 spare boxes"),
        ({"kind": "grid", "columns": 8, "rows": 8, "holes": 5}, "need 5 squares"),
        ({"kind": "grid", "columns": 8, "rows": 8, "holes": 1, "depth": 4}, "at most 3 boxes deep"),
        ({"kind": "grid", "agents": 12, "crowded": True}, "room for 8 agents"),
        ({"kind": "geometric", "holes": 1}, "without holes"),
        ({"kind": "grid", "columns": 0}, "at least 1"),
    ],
)
def test_what_does_not_fit_is_refused(wanted, message):
    with pytest.raises(ColonysimError, match=message):
        invent(**wanted)
