"""Whether a place has room for its robot: boxes that it can push, pits that take them, nodes and edges wide enough."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from colonysim.physics.scene import GROUND_FRICTION
from colonysim.push.paths import PIT_CLEARANCE, ROBOT_CLEARANCE

if TYPE_CHECKING:
    from colonysim.geometry.layout import Layout
    from colonysim.scenario.scenario import Scenario

__all__ = ["BOX_LENGTHS", "check_fit"]

BOX_LENGTHS = (0.7, 1.3)
"""Sides of boxes that a robot can push, in units of the robot: the network was trained with 1."""
_PULL = 1.6
"""A robot has to grip the ground this many times as hard as it takes to push a box, to push it up a slope too."""
_GRAVITY = 9.81
_ROUNDING = 1e-9


def check_fit(scenario: Scenario, layout: Layout) -> None:
    """Whether robots of this size can stand on the nodes, travel the edges, and push the boxes into the pits.

    Raises:
        ScenarioError: Something is too small or too large for them; it names the nodes.
    """
    _check_boxes(scenario, layout)
    _check_pits(scenario, layout)
    _check_nodes(scenario, layout)


def _check_boxes(scenario: Scenario, layout: Layout) -> None:
    unit = layout.robot.scale
    for number, box in enumerate(layout.boxes):
        low, high = BOX_LENGTHS
        if not low - _ROUNDING <= box.length <= high + _ROUNDING:
            node = scenario.topology.ids[scenario.boxes[number].node]
            raise scenario.fault(
                "physics.box_length", f"the box at node {node} is {unit * box.length:g} m wide, expected"
                f" {unit * low:g} to {unit * high:g} m for this robot",
            )  # fmt: skip
        pull = layout.robot.mass * layout.robot.grip / _PULL
        needed = box.mass * layout.robot.mass_unit * box.friction * GROUND_FRICTION
        if needed > pull * (1 + _ROUNDING):
            node = scenario.topology.ids[scenario.boxes[number].node]
            raise scenario.fault(
                "physics.box_mass", f"the box at node {node} takes {_GRAVITY * needed:.3g} N to push, expected at most"
                f" {_GRAVITY * pull:.3g} N for this robot; see box_mass, box_friction, and the robot's masses and grip",
            )  # fmt: skip


def _check_pits(scenario: Scenario, layout: Layout) -> None:
    """A box that tips over the edge is for a moment as long as its diagonal."""
    unit, ids = layout.robot.scale, scenario.topology.ids
    for box in layout.boxes:
        needed = math.hypot(box.length, box.height)
        for node, number in layout.pit_at.items():
            side = layout.terrain.pits[number].side
            if box.length < side < needed:
                raise scenario.fault(
                    "physics.pit_side", f"the pit at hole {ids[node]} is {unit * side:g} m wide, expected at least"
                    f" {unit * needed:.4g} m, for a box {unit * box.length:g} m wide and {unit * box.height:g} m high",
                )  # fmt: skip


def _check_nodes(scenario: Scenario, layout: Layout) -> None:
    """Robots that stand on neighbouring nodes must not touch, nor their wheels hang over a pit beside a node."""
    unit, topology, places = layout.robot.scale, scenario.topology, layout.places
    ids, robots = topology.ids, len(scenario.agents)
    for i, others in enumerate(topology.neighbours if robots > 1 else ()):
        for j in others:
            if i < j and (away := math.dist(places[i], places[j])) < ROBOT_CLEARANCE:
                raise scenario.fault(
                    "physics", f"nodes {ids[i]} and {ids[j]} are {unit * away:.3g} m apart, expected at least"
                    f" {unit * ROBOT_CLEARANCE:.3g} m, so that two of the robots have room; see xy_scale and robot",
                )  # fmt: skip
    for i, (x, y) in enumerate(places):
        if i in layout.pit_at:
            continue
        for hole, number in layout.pit_at.items():
            pit = layout.terrain.pits[number]
            if (beside := pit.distance(x, y)) < PIT_CLEARANCE:
                raise scenario.fault(
                    "physics", f"node {ids[i]} lies {unit * beside:.3g} m from the pit of hole {ids[hole]}, expected"
                    f" at least {unit * PIT_CLEARANCE:.3g} m, so that the robot has room; see xy_scale and pit_side",
                )  # fmt: skip
