"""Whether a place has room for its robot: boxes that it can push, pits that take them, nodes far enough apart."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING

from colonysim.geometry.plan import edge_path, node_path
from colonysim.geometry.trouble import Trouble
from colonysim.physics import Pit
from colonysim.physics.engine import GRAVITY
from colonysim.physics.scene import GROUND_FRICTION
from colonysim.push.paths import BOX_CLEARANCE, PIT_CLEARANCE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.geometry.plan import Plan
    from colonysim.physics import Robot
    from colonysim.scenario.scenario import Scenario

__all__ = ["BOX_LENGTHS", "check_fit", "narrow_nodes", "pushers"]

BOX_LENGTHS = (0.7, 1.3)
"""Sides of boxes that a robot can push, in units of the robot: the network was trained with 1."""
BOX_ROOM = BOX_CLEARANCE + 0.01
"""Least distance of a node from the sides of a box beside it. Robots plan no way to nearer places: with .50 m colonies
came to a halt on lines, and past corners of boxes with .49 m; with .51 m they reached the goal as with more."""
ROBOTS_APART = 0.75
"""Least distance of nodes on which robots stand at once: side by side, or nose to tail, they just fit. On nodes up to
the whole disc in which a robot turns (.94) they may touch as they turn, and came past each other all the same."""
_PULL = 1.6
"""A robot has to grip the ground this many times as hard as it takes to push a box, to push it up a slope too."""
LIGHTEST = 1.0
"""Least mass of a box, in units of the robot: one of .1 kg is flung about, and robots fall over it."""
_ROUNDING = 1e-9


def pushers(scenario: Scenario, models: Sequence[Robot]) -> list[Robot]:
    """The robots, each once, of those agents that push.

    Args:
        scenario: The scenario.
        models: What robot each agent is.
    """
    idle = {agent for group in scenario.groups if not group.pushes for agent in group.agents}
    return [*dict.fromkeys(robot for agent, robot in enumerate(models) if agent not in idle)]


def check_fit(plan: Plan, robots: Sequence[Robot]) -> None:
    """Whether each of these robots, all of one scale, can push the boxes, and into the pits.

    Raises:
        Trouble: Something is too small or too large for them; it names the nodes.
    """
    for robot in robots:
        _check_boxes(plan, robot)
    _check_pits(plan)


def _check_boxes(plan: Plan, robot: Robot) -> None:
    (narrowest, widest), lowest = BOX_LENGTHS, robot.in_units().clearance
    pull = robot.mass * robot.grip / _PULL
    for start, box in zip(plan.scenario.boxes, plan.boxes, strict=True):
        what, kilograms = f"the box at node {plan.named(start.node)}", box.mass * robot.mass_unit
        needed = kilograms * box.friction * GROUND_FRICTION
        if not narrowest - _ROUNDING <= box.length <= widest + _ROUNDING:
            words = f"{what} is {{:g}} m wide, expected {{:g}} to {{:g}} m for this robot"
            raise Trouble("physics.box_length", words, box.length, narrowest, widest)
        if box.height < lowest * (1 - _ROUNDING):
            words = f"{what} is {{:g}} m high, expected at least {{:g}} m, where the robot's bumper begins"
            raise Trouble("physics.box_height", words, box.height, lowest)
        if box.mass < LIGHTEST * (1 - _ROUNDING):
            expected = f"expected at least {LIGHTEST * robot.mass_unit:.3g} kg for this robot"
            raise Trouble("physics.box_mass", f"{what} has {kilograms:.3g} kg, {expected}")
        if needed > pull * (1 + _ROUNDING):
            raise Trouble(
                "physics.box_mass", f"{what} takes {GRAVITY * needed:.3g} N to push, expected at most"
                f" {GRAVITY * pull:.3g} N for this robot; see box_mass, box_friction, and the robot's masses and grip",
            )  # fmt: skip


def _check_pits(plan: Plan) -> None:
    """A box that tips over the edge is for a moment as long as its diagonal."""
    for box in plan.boxes:
        needed = math.hypot(box.length, box.height)
        for node, number in plan.pit_at.items():
            side = plan.pits[number].side
            if side < needed:
                raise Trouble(
                    "physics.pit_side", f"the pit at hole {plan.named(node)} is {{:g}} m wide, expected at least"
                    " {:.4g} m, for a box {:g} m wide and {:g} m high", side, needed, box.length, box.height,
                )  # fmt: skip


def narrow_nodes(plan: Plan) -> Trouble | None:
    """The first nodes on which robots would touch, be too near a box to hold it, or hang over a pit, or boxes would."""
    return _narrow_edge(plan) or _narrow_start(plan) or _narrow_box(plan) or _narrow_pit(plan) or _narrow_hole(plan)


def _narrow_edge(plan: Plan) -> Trouble | None:
    """Two robots that stand on neighbouring nodes touch."""
    topology, places = plan.scenario.topology, plan.places
    if len(plan.scenario.agents) < 2:
        return None
    for i, others in enumerate(topology.neighbours):
        for j in others:
            if i < j and (away := math.dist(places[i], places[j])) < ROBOTS_APART - _ROUNDING:
                nodes = f"nodes {plan.named(i)} and {plan.named(j)}"
                return Trouble(
                    edge_path(plan.scenario, i, j), f"{nodes} are {{:.2f}} m apart, too close for two of the robots",
                    away, away=away, needed=ROBOTS_APART,
                )  # fmt: skip
    return None


def _narrow_start(plan: Plan) -> Trouble | None:
    """Two robots, or two boxes, touch where they begin, whether an edge joins their nodes or not."""
    scenario, places = plan.scenario, plan.places
    for i, j in itertools.combinations(scenario.agents_at_start, 2):
        if (away := math.dist(places[i], places[j])) < ROBOTS_APART - _ROUNDING:
            return Trouble(
                node_path(scenario, max(i, j)), f"the robots on nodes {plan.named(i)} and {plan.named(j)} begin"
                " {:.2f} m from each other, too close", away, away=away, needed=ROBOTS_APART,
            )  # fmt: skip
    starts = list(zip(scenario.boxes_at_start, plan.boxes, strict=False))
    for (one, box), (other, beside) in itertools.combinations(starts, 2):
        apart = Pit(box.x, box.y, box.yaw, box.length).distance(beside.x, beside.y)
        if one.node != other.node and apart < beside.length / 2 - _ROUNDING:
            return Trouble(
                node_path(scenario, max(one.node, other.node)), f"the boxes at nodes {plan.named(one.node)} and"
                f" {plan.named(other.node)} begin in each other", needed=box.length,
                away=math.dist(places[one.node], places[other.node]),
            )  # fmt: skip
    return None


def _narrow_box(plan: Plan) -> Trouble | None:
    """A robot on a node is so near a box that it plans no way there, nor takes hold of the box."""
    standing = {box.node for box in plan.scenario.boxes}
    for i, (x, y) in enumerate(plan.places):
        if i in standing or i in plan.pit_at:
            continue
        for start, box in zip(plan.scenario.boxes, plan.boxes, strict=True):
            beside = Pit(box.x, box.y, box.yaw, box.length).distance(x, y)
            if beside < BOX_ROOM - _ROUNDING:
                return Trouble(
                    node_path(plan.scenario, i), f"node {plan.named(i)} lies {{:.2f}} m from the box at node"
                    f" {plan.named(start.node)}, too close for a robot that gets there or takes hold of it",
                    beside, needed=BOX_ROOM,
                )  # fmt: skip
    return None


def _narrow_pit(plan: Plan) -> Trouble | None:
    """A robot on a node has a wheel over a pit beside it."""
    for i, (x, y) in enumerate(plan.places):
        if i in plan.pit_at:
            continue
        for hole, number in plan.pit_at.items():
            pit = plan.pits[number]
            if (beside := pit.distance(x, y)) < PIT_CLEARANCE - _ROUNDING:
                return Trouble(
                    node_path(plan.scenario, i), f"node {plan.named(i)} lies {{:.2f}} m from the pit of hole"
                    f" {plan.named(hole)}, too close for a robot", beside, needed=PIT_CLEARANCE,
                )  # fmt: skip
    return None


def _narrow_hole(plan: Plan) -> Trouble | None:
    """On every node from which a box may be pushed into a hole it hangs over the pit, so none is pushed there."""
    scenario = plan.scenario
    standing = {box.node for box in scenario.boxes}
    for hole, number in plan.pit_at.items():
        sides = [i for i in scenario.topology.neighbours[hole] if (i, hole) not in scenario.no_push]
        if not plan.boxes or not sides or standing.union(plan.pit_at).intersection(sides):
            continue
        beside, needed = max(plan.pits[number].distance(*plan.places[i]) for i in sides), plan.boxes[0].length / 2
        if beside < needed - _ROUNDING:
            return Trouble(
                node_path(scenario, hole), f"the nodes beside hole {plan.named(hole)} lie at most {{:.2f}} m from its"
                " pit, too close for a box that is pushed there first", beside, needed=needed,
            )  # fmt: skip
    return None
