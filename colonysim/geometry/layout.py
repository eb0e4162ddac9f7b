"""From a scenario's graph to rigid bodies: ground, pits, ramps, boxes, robots."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from colonysim.geometry.fit import check_fit, pushers
from colonysim.geometry.grounds import check_given, derived_terrain, given_terrain
from colonysim.geometry.pits import heading, pits_for, pits_given, ways_to_holes
from colonysim.geometry.plan import Plan
from colonysim.geometry.robot_choice import robot_of, robots_of
from colonysim.geometry.scale import (
    BOX_HEIGHT,
    BOX_LENGTH,
    MARGIN,
    MOST_WAYS,
    RAMP_HALF_WIDTH,
    XY_SCALE,
    check_size,
)
from colonysim.geometry.trouble import Trouble
from colonysim.geometry.units import in_units
from colonysim.physics import BoxSpec, Ground, Robot, RobotSpec, Terrain

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.scenario.scenario import Scenario

__all__ = ["Layout", "lay_out"]

_COMING_OR_GOING = ("add_box", "remove_box", "add_agent")
"""Kinds of changes for which there have to be places for bodies that are not there."""
SHELF_AWAY = 20.0
"""How far beyond all other ground bodies wait that are not there, in units of the robot."""
SHELF_ROOM = 3.0
"""Distance of two of them, in units of the robot."""


@dataclass(frozen=True, slots=True)
class Layout:
    """A scenario in units of its robot: metres and kilograms with the standard one, see `colonysim.physics.robot`.

    Attributes:
        robot: What robot all are whose group has none of its own, in SI units.
        models: What robot each is, in SI units; all have the scale of `robot`.
        terrain: Ground, pits and ramps.
        places: x, y of each node.
        heights: Height of each node's ground; of a hole, of its rim.
        pit_at: For each hole's node, the index of its pit in the terrain.
        boxes: The boxes where they start.
        robots: The robots where they start.
        stray_beyond: A box further than this from its node is stray: a quarter of the mean edge.
        shelf: Where bodies wait that are not there: for each box, then for each robot, a place (x, y, z) on a ground of
            their own beyond all others; empty if the scenario has no timeline.
    """

    robot: Robot
    models: tuple[Robot, ...]
    terrain: Terrain
    places: tuple[tuple[float, float], ...]
    heights: tuple[float, ...]
    pit_at: Mapping[int, int]
    boxes: tuple[BoxSpec, ...]
    robots: tuple[RobotSpec, ...]
    stray_beyond: float
    shelf: tuple[tuple[float, float, float], ...] = ()


def lay_out(scenario: Scenario) -> Layout:
    """Derives the bodies from the graph; the scenario's `physics:` section takes precedence.

    What that leaves open has the size, in units of the robot, that it has with the standard one.

    Pits are whole boxes deep, their sides along the edge that they will be filled over; boxes face the way they will
    be pushed first.

    Raises:
        ScenarioError: The place cannot be built: pits too close to each other, levels that overlap, a box that is
            wider than a pit, more or larger parts than an engine can move in a reasonable time. Or the robot is none
            that the controls can handle, or the place is too narrow for it.
    """
    robot = robot_of(scenario)
    try:
        return _laid_out(scenario, robot, robots_of(scenario))
    except Trouble as trouble:
        raise trouble.fault(scenario, robot.scale) from None


def _laid_out(scenario: Scenario, robot: Robot, models: tuple[Robot, ...]) -> Layout:
    topology, physics = scenario.topology, in_units(scenario.physics, robot)
    scale = float(physics.get("xy_scale") or XY_SCALE)
    lowest = min((box.height for box in scenario.boxes), default=1.0)
    z_scale = float(physics.get("z_scale") or BOX_HEIGHT / lowest)
    length = float(physics.get("box_length") or BOX_LENGTH)
    places = tuple((scale * x, scale * y) for x, y in zip(topology.x, topology.y, strict=True))
    heights = [z_scale * z for z in topology.z]
    for hole in scenario.holes:
        heights[hole.node] = z_scale * hole.rim
    same = physics.get("box_height")
    box_heights = [float(same) if same else z_scale * box.height for box in scenario.boxes]
    check_size(scenario, places, heights, box_heights, z_scale)
    ways = ways_to_holes(scenario)
    pits, pit_at = pits_for(scenario, physics, places, heights, box_heights, ways, length, z_scale)
    given = physics.get("terrain")
    if given:
        terrain = given_terrain(given, pits)
        if given.get("pits"):
            pit_at = pits_given(scenario, places, terrain)
        pits, heights = list(terrain.pits), _heights_on(scenario, places, terrain, pit_at)
    boxes = tuple(
        BoxSpec(
            *places[box.node], heights[box.node], heading(places, *ways.first.get(box.node, (box.node, -1))),
            length, high, float(physics.get("box_mass") or 12.0), float(physics.get("box_friction") or 0.5),
        )
        for box, high in zip(scenario.boxes, box_heights, strict=True)
    )  # fmt: skip
    margin, half_width = physics.get("margin"), float(physics.get("ramp_half_width") or RAMP_HALF_WIDTH)
    plan = Plan(
        scenario, scale, z_scale, tuple(heights), tuple(pits), pit_at, boxes,
        MARGIN if margin is None else float(margin), half_width,
    )  # fmt: skip
    check_fit(plan, pushers(scenario, models))
    if given:
        _check_work(scenario, scale, len(terrain.grounds), len(terrain.ramps))
        check_given(plan, terrain)
    else:
        _check_work(scenario, scale, len(plan.levels), len(plan.slopes))
        terrain = derived_terrain(plan, robot.scale)
    shelf: tuple[tuple[float, float, float], ...] = ()
    if any(change.kind in _COMING_OR_GOING for change in scenario.changes):
        terrain, shelf = _with_shelf(terrain, len(scenario.boxes) + len(scenario.agents))
    return Layout(
        robot,
        models,
        terrain,
        places,
        tuple(heights),
        pit_at,
        boxes,
        tuple(
            RobotSpec(
                *places[node], heights[node],
                heading(places, node, topology.neighbours[node][0] if topology.neighbours[node] else -1),
            )
            for node in scenario.agents
        ),
        0.25 * scale * topology.mean_length,
        shelf,
    )  # fmt: skip


def _with_shelf(terrain: Terrain, bodies: int) -> tuple[Terrain, tuple[tuple[float, float, float], ...]]:
    """Ground for bodies that are not there, far beyond all other, and a place on it for each."""
    low, x = min(ground.z for ground in terrain.grounds), max(ground.xmax for ground in terrain.grounds) + SHELF_AWAY
    y = min(ground.ymin for ground in terrain.grounds)
    places = tuple((x, y + SHELF_ROOM * i, low) for i in range(bodies))
    half = SHELF_ROOM / 2
    ground = Ground(x - half, y - half, x + half, y + SHELF_ROOM * bodies - half, low)
    return replace(terrain, grounds=(*terrain.grounds, ground)), places


def _check_work(scenario: Scenario, scale: float, levels: int, ramps: int) -> None:
    """Every tenth of a metre of the edges is looked at on every level and ramp."""
    total = scale * scenario.topology.mean_length * scenario.topology.edge_count
    if total * (levels + ramps) > MOST_WAYS:
        raise Trouble(
            "physics", f"{{:.0f}} m of edges over {levels} levels and {ramps} ramps are"
            " too much to build, expected at most {:.0f} m over one level", total, MOST_WAYS,
        )  # fmt: skip


def _heights_on(
    scenario: Scenario, places: Sequence[tuple[float, float]], terrain: Terrain, pit_at: Mapping[int, int]
) -> list[float]:
    """Heights of all nodes on ground that was given: of a hole, of its rim."""
    heights = []
    for node, (x, y) in enumerate(places):
        height = terrain.pits[pit_at[node]].rim if node in pit_at else terrain.height(x, y)
        if not math.isfinite(height):
            name = scenario.topology.ids[node]
            raise Trouble("physics.terrain", f"no ground under node {name} ({{:.2f}}, {{:.2f}} m)", x, y)
        heights.append(height)
    return heights
