"""A local view answers within sight and refuses everything beyond."""

from __future__ import annotations

import pytest

from colonysim import scenario_from_document
from colonysim.backends.nodeworld import NodeWorld
from colonysim.pheromones import BoxWorth, Distance, HoleTrail
from colonysim.policies.view import LocalView, OutOfSightError
from colonysim.randomness import Streams
from colonysim.world.state import World

# Nodes 0 to 7 in a row, R = 2.5; the agent stands on 0, a box on 2 and one on 5, a hole at 6.
DOCUMENT = {
    "name": "row",
    "nodes": [[i, i, 0, 0.0] for i in range(8)],
    "edges": [[i, i + 1] for i in range(7)],
    "holes": [{"node": 6, "depth": 1.0}],
    "boxes": [[2, 1.0], [5, 1.0]],
    "agents": [0, 4],
    "goal": 7,
    "detection_radius": 2.5,
}


@pytest.fixture
def view() -> LocalView:
    scenario = scenario_from_document(DOCUMENT)
    world, body = World(scenario), NodeWorld()
    body.reset(world, Streams(0))
    fields = {"D": Distance(world, d_max=20.0), "B": BoxWorth(world, start=40.0), "H": HoleTrail(world)}
    view = LocalView(world, fields, body, agent=0)
    view.look()
    return view


def test_what_lies_within_sight_is_answered(view):
    assert view.boxes() == [0]
    assert (view.box_node(0), view.box_height(0), view.on_top(0)) == (2, 1.0, True)
    assert view.exits() == [1]
    assert view.graspable_from(1, 0)
    assert view.can_slide(0, 2, 1)
    assert view.can_follow(0, 2, 1)
    assert view.feasible(0, (1,)) == [1.0]
    assert view.feasible_way(0, (2, 1, 0)) == [1.0, 1.0]
    assert not view.crowded(1)
    assert view.fields["D"].values([0, 1]) == [13.0, 14.0]
    assert view.fields["B"].at(0, 0) == 40.0
    assert view.goal_position == (7.0, 0.0)


REFUSED = {
    "position": lambda view: view.position(3),
    "ways": lambda view: view.ways(3),
    "reachable": lambda view: view.reachable(2, 3),
    "free": lambda view: view.free(2),
    "occupied": lambda view: view.occupied(4),
    "crowded": lambda view: view.crowded(3),
    "box_node": lambda view: view.box_node(1),
    "box_height": lambda view: view.box_height(1),
    "on_top": lambda view: view.on_top(1),
    "graspable_from, the box": lambda view: view.graspable_from(0, 1),
    "graspable_from, the node": lambda view: view.graspable_from(3, 0),
    "can_slide": lambda view: view.can_slide(0, 2, 3),
    "can_follow": lambda view: view.can_follow(0, 2, 3),
    "feasible, the box": lambda view: view.feasible(1, (4,)),
    "feasible, the target": lambda view: view.feasible(0, (3,)),
    "feasible_way, the box": lambda view: view.feasible_way(1, (2, 1)),
    "feasible_way, a node": lambda view: view.feasible_way(0, (2, 3)),
    "hole_node": lambda view: view.hole_node(0),
    "headroom": lambda view: view.headroom(0),
    "hole_near": lambda view: view.hole_near(0, 1),
    "D.at": lambda view: view.fields["D"].at(2),
    "D.values": lambda view: view.fields["D"].values([1, 2]),
    "D.keys": lambda view: view.fields["D"].keys(2),
    "B.at": lambda view: view.fields["B"].at(1, 0),
    "H.at": lambda view: view.fields["H"].at(3, 0),
    "H.keys": lambda view: view.fields["H"].keys(3),
    "wanted": lambda view: view.wanted(2),
}


@pytest.mark.parametrize("ask", REFUSED.values(), ids=REFUSED)
def test_what_lies_beyond_is_refused(view, ask):
    with pytest.raises(OutOfSightError):
        ask(view)


NODES = (-1, 8, 10**8, -(10**9))
ASKED = {
    "D.at": lambda view, node: view.fields["D"].at(node),
    "H.at": lambda view, node: view.fields["H"].at(node, 0),
    "H.keys": lambda view, node: view.fields["H"].keys(node),
    "free": lambda view, node: view.free(node),
    "wanted": lambda view, node: view.wanted(node),
    "position": lambda view, node: view.position(node),
    "crowded": lambda view, node: view.crowded(node),
    "box_node": lambda view, node: view.box_node(-1),
}


@pytest.mark.parametrize("node", NODES)
@pytest.mark.parametrize("ask", ASKED.values(), ids=ASKED)
def test_nodes_and_boxes_that_do_not_exist_are_refused_like_those_out_of_sight(view, ask, node):
    with pytest.raises(OutOfSightError):
        ask(view, node)


@pytest.mark.parametrize("node", NODES)
def test_nodes_and_boxes_that_do_not_exist_are_nowhere_near(view, node):
    assert not view.passable(node) and not view.sees(node) and not view.beside_box(node)
    assert view.nearest_box((node,)) == (0, 1)


def test_trails_of_holes_and_nodes_that_do_not_exist_are_left_out():
    world = World(scenario_from_document(DOCUMENT))
    field = HoleTrail(world)
    field.load([(8, 0, 0.5), (10**8, 0, 0.5), (-1, 0, 0.5), (3, 7, 0.5), (3, -1, 0.5), (3, 0, 0.25)])
    assert [tuple(write) for write in field.frame()] == [(3, 0, pytest.approx(0.25))]
    assert field.at(10**8, 0) == 0.0 and list(field.keys(-1)) == []
