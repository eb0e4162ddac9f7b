"""From a scenario's graph to rigid bodies in metres: ground, pits, ramps, boxes, robots."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from colonysim.physics import BoxSpec, Ground, Pit, Ramp, RobotSpec, Terrain
from colonysim.push.footing import footing_on

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.scenario.scenario import Scenario

__all__ = ["Layout", "lay_out"]

XY_SCALE = 1.6
BOX_HEIGHT = 0.25
"""Without a z_scale the lowest box of a scenario becomes this high, metres."""
BOX_LENGTH = 1.0
CLEARANCE = 0.2
"""A pit is this much wider than a box, metres."""
MARGIN = 1.75
RAMP_HALF_WIDTH = 2.2
_SAME_LEVEL = 0.02
_WHEELS = 0.35
"""The ground must be sound this far beside the middle of a way, metres."""
_STEP = 0.1
"""Steps and slopes a robot's wheels climb, metres in a tenth of a metre."""


FARTHEST = 1000.0
"""No node lies further from the origin along any axis, metres: the engine's numbers are good to a tenth of a millimetre
there."""
LONGEST_EDGE = 200.0
"""Metres; a robot takes minutes for it."""
MOST_NODES, MOST_BODIES, MOST_LEVELS = 20_000, 500, 200
MOST_WAYS = 100_000.0
"""Metres of edges, times levels and ramps: every tenth of a metre is looked at."""
LOWEST_BOX, HIGHEST_BOX, DEEPEST_PIT = 0.01, 10.0, 50.0


@dataclass(frozen=True, slots=True)
class Layout:
    """A scenario in metres.

    Attributes:
        terrain: Ground, pits and ramps.
        places: x, y of each node.
        heights: Height of each node's ground; of a hole, of its rim.
        pit_at: For each hole's node, the index of its pit in the terrain.
        boxes: The boxes where they start.
        robots: The robots where they start.
        stray_beyond: A box further than this from its node is stray: a quarter of the mean edge.
    """

    terrain: Terrain
    places: tuple[tuple[float, float], ...]
    heights: tuple[float, ...]
    pit_at: Mapping[int, int]
    boxes: tuple[BoxSpec, ...]
    robots: tuple[RobotSpec, ...]
    stray_beyond: float


def lay_out(scenario: Scenario) -> Layout:
    """Derives the bodies from the graph; the scenario's `physics:` section takes precedence.

    Pits are whole boxes deep, their sides along the edge that they will be filled over; boxes face the way they will
    be pushed first.

    Raises:
        ScenarioError: The place cannot be built: pits too close to each other, levels that overlap, a box that is
            wider than a pit, more or larger parts than an engine can move in a reasonable time.
    """
    topology, physics = scenario.topology, scenario.physics
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
    _check_size(scenario, places, heights, box_heights, z_scale)
    ways = _ways_to_holes(scenario)
    pits, pit_at = _pits(scenario, physics, places, heights, box_heights, ways, length, z_scale)
    terrain = _terrain(scenario, physics, scale, places, heights, pits)
    given = physics.get("terrain")
    if given:
        if given.get("pits"):
            pit_at = _pits_of_holes(scenario, places, terrain)
        heights = _heights_on(scenario, places, terrain, pit_at)
    total = scale * topology.mean_length * topology.edge_count
    if total * (len(terrain.grounds) + len(terrain.ramps)) > MOST_WAYS:
        raise scenario.fault(
            "physics", f"{total:.0f} m of edges over {len(terrain.grounds)} levels and {len(terrain.ramps)} ramps are"
            f" too much to build, expected at most {MOST_WAYS:.0f} m over one level",
        )  # fmt: skip
    _check_ways(scenario, places, heights, terrain)
    return Layout(
        terrain,
        places,
        tuple(heights),
        pit_at,
        tuple(
            BoxSpec(
                *places[box.node], heights[box.node], _heading(places, *ways.first.get(box.node, (box.node, -1))),
                length, high, float(physics.get("box_mass") or 12.0), float(physics.get("box_friction") or 0.5),
            )
            for box, high in zip(scenario.boxes, box_heights, strict=True)
        ),
        tuple(
            RobotSpec(
                *places[node], heights[node],
                _heading(places, node, topology.neighbours[node][0] if topology.neighbours[node] else -1),
            )
            for node in scenario.agents
        ),
        0.25 * scale * topology.mean_length,
    )  # fmt: skip


def _check_size(
    scenario: Scenario,
    places: Sequence[tuple[float, float]],
    heights: Sequence[float],
    box_heights: Sequence[float],
    z_scale: float,
) -> None:
    """Whether an engine can build the place, and robots get anywhere in it, in a reasonable time."""
    topology, fault = scenario.topology, scenario.fault
    if len(topology) > MOST_NODES:
        raise fault("physics", f"{len(topology)} nodes, expected at most {MOST_NODES} on a physics backend")
    bodies = len(scenario.agents) + len(scenario.boxes)
    if bodies > MOST_BODIES:
        raise fault("physics", f"{bodies} robots and boxes, expected at most {MOST_BODIES} on a physics backend")
    if len({round(height, 2) for height in heights}) > MOST_LEVELS:
        raise fault("physics", f"more than {MOST_LEVELS} levels, expected fewer on a physics backend")
    for node, (place, height) in enumerate(zip(places, heights, strict=True)):
        far = max(map(abs, (*place, height)))
        if far > FARTHEST:
            name = topology.ids[node]
            raise fault("physics", f"node {name} lies {far:g} m off, expected at most {FARTHEST:g} m; see xy_scale")
        for j in topology.neighbours[node]:
            if (length := math.dist(place, places[j])) > LONGEST_EDGE:
                names = f"{topology.ids[node]}-{topology.ids[j]}"
                raise fault("physics", f"edge {names} is {length:g} m long, expected at most {LONGEST_EDGE:g} m")
    for box, height in enumerate(box_heights):
        if not LOWEST_BOX <= height <= HIGHEST_BOX:
            expected = f"{LOWEST_BOX:g} to {HIGHEST_BOX:g} m; see z_scale"
            raise fault(f"boxes.{box}", f"the box is {height:g} m high, expected {expected}")
    for hole in scenario.holes:
        if hole.depth * z_scale > DEEPEST_PIT:
            name = topology.ids[hole.node]
            raise fault("physics", f"hole {name} is {hole.depth * z_scale:g} m deep, expected at most {DEEPEST_PIT:g}")


@dataclass(frozen=True, slots=True)
class _Ways:
    """Where boxes will go.

    Attributes:
        first: For each box's node, the first edge (from, to) of its way to the nearest hole.
        last: For each hole's node, the last edge (from, to) of the shortest way of a box into it.
    """

    first: dict[int, tuple[int, int]]
    last: dict[int, tuple[int, int]]


def _ways_to_holes(scenario: Scenario) -> _Ways:
    """Shortest ways from each box to each hole over edges that allow a push, through no other hole."""
    topology = scenario.topology
    holes = {hole.node for hole in scenario.holes}
    standing = {box.node for box in scenario.boxes}
    first: dict[int, tuple[int, int]] = {}
    best: dict[int, float] = {}
    last: dict[int, tuple[int, int]] = {}
    for box in scenario.boxes:
        queue: list[tuple[float, int, int, int]] = [(0.0, box.node, -1, -1)]
        seen: set[int] = set()
        while queue:
            far, node, before, start = heapq.heappop(queue)
            if node in seen:
                continue
            seen.add(node)
            if node in holes:
                if far < best.get(node, math.inf):
                    best[node], last[node] = far, (before, node)
                first.setdefault(box.node, (box.node, start))
                continue
            for j, length in zip(topology.neighbours[node], topology.lengths[node], strict=True):
                if (node, j) not in scenario.no_push and j not in seen:
                    # Going round another box is a detour that only pays where there is no other way.
                    detour = 100.0 if j in standing else 0.0
                    heapq.heappush(queue, (far + length + detour, j, node, j if start < 0 else start))
    return _Ways(first, last)


def _heading(places: Sequence[tuple[float, float]], i: int, j: int) -> float:
    if j < 0 or i < 0:
        return 0.0
    return math.atan2(places[j][1] - places[i][1], places[j][0] - places[i][0])


def _pits(
    scenario: Scenario,
    physics: Mapping[str, Any],
    places: Sequence[tuple[float, float]],
    heights: Sequence[float],
    box_heights: Sequence[float],
    ways: _Ways,
    length: float,
    z_scale: float,
) -> tuple[list[Pit], dict[int, int]]:
    side = float(physics.get("pit_side") or length + CLEARANCE)
    if side <= length:
        raise scenario.fault("physics.pit_side", f"a pit of {side} m takes no box of {length} m")
    unit = min(box_heights, default=BOX_HEIGHT)
    pits: list[Pit] = []
    pit_at: dict[int, int] = {}
    for hole in scenario.holes:
        layers = max(1, round(hole.depth * z_scale / unit))
        before, node = ways.last.get(hole.node, (-1, hole.node))
        if before < 0:
            before = scenario.topology.neighbours[node][0] if scenario.topology.neighbours[node] else -1
        yaw = _heading(places, before, node)
        pit_at[hole.node] = len(pits)
        pits.append(Pit(*places[hole.node], yaw, side, heights[hole.node], layers * unit))
    return pits, pit_at


def _pits_of_holes(scenario: Scenario, places: Sequence[tuple[float, float]], terrain: Terrain) -> dict[int, int]:
    """For each hole's node the given pit around it."""
    pit_at: dict[int, int] = {}
    for hole in scenario.holes:
        x, y = places[hole.node]
        around = [i for i, pit in enumerate(terrain.pits) if pit.contains(x, y)]
        if not around:
            name = scenario.topology.ids[hole.node]
            raise scenario.fault("physics.terrain.pits", f"no pit at the hole {name} ({x:.2f}, {y:.2f} m)")
        pit_at[hole.node] = around[0]
    return pit_at


def _heights_on(
    scenario: Scenario, places: Sequence[tuple[float, float]], terrain: Terrain, pit_at: Mapping[int, int]
) -> list[float]:
    """Heights of all nodes on ground that was given: of a hole, of its rim."""
    heights = []
    for node, (x, y) in enumerate(places):
        height = terrain.pits[pit_at[node]].rim if node in pit_at else terrain.height(x, y)
        if not math.isfinite(height):
            name = scenario.topology.ids[node]
            raise scenario.fault("physics.terrain", f"no ground under node {name} ({x:.2f}, {y:.2f} m)")
        heights.append(height)
    return heights


def _check_ways(
    scenario: Scenario, places: Sequence[tuple[float, float]], heights: Sequence[float], terrain: Terrain
) -> None:
    """Whoever may travel an edge on paper must find ground all along it."""
    topology = scenario.topology
    for i, others in enumerate(topology.neighbours):
        for j in others:
            level = abs(heights[i] - heights[j]) < _SAME_LEVEL
            if i > j or not (level or (i, j) in topology.rises):
                continue
            if not all(_is_smooth(terrain, places[i], places[j], aside) for aside in (-_WHEELS, 0.0, _WHEELS)):
                names = f"{topology.ids[i]} and {topology.ids[j]}"
                raise scenario.fault(
                    "physics", f"the ground between {names} has a gap or a step; give the ground in physics.terrain"
                )


def _is_smooth(terrain: Terrain, start: tuple[float, float], end: tuple[float, float], aside: float) -> bool:
    away = math.dist(start, end) or 1.0
    c, s = (end[0] - start[0]) / away, (end[1] - start[1]) / away
    before: float | None = None
    footing = footing_on(terrain)
    pits = [pit for pit in terrain.pits if math.dist(start, (pit.x, pit.y)) < away + _WHEELS + pit.side]
    for k in range(math.ceil(away / 0.1) + 1):
        along = min(0.1 * k, away)
        x, y = start[0] + along * c - aside * s, start[1] + along * s + aside * c
        if pits and any(pit.contains(x, y) for pit in pits):
            before = None
            continue
        height = footing.height(x, y)
        if not math.isfinite(height) or (before is not None and abs(height - before) > _STEP):
            return False
        before = height
    return True


_Rectangle = tuple[float, float, float, float]


def _terrain(
    scenario: Scenario,
    physics: Mapping[str, Any],
    scale: float,
    places: Sequence[tuple[float, float]],
    heights: Sequence[float],
    pits: list[Pit],
) -> Terrain:
    given = physics.get("terrain")
    try:
        if given:
            return Terrain(
                tuple(Ground(**ground) for ground in given["grounds"]),
                tuple(Pit(**pit) for pit in given["pits"]) if given.get("pits") else tuple(pits),
                tuple(Ramp(**ramp) for ramp in given.get("ramps") or ()),
            )
        half_width = float(physics.get("ramp_half_width") or RAMP_HALF_WIDTH)
        margin = physics.get("margin")
        ramps = _ramps(scenario, places, heights, half_width)
        grounds = _grounds(places, heights, ramps, MARGIN if margin is None else float(margin))
        return Terrain(tuple(grounds), tuple(pits), tuple(ramps))
    except ValueError as error:
        raise scenario.fault("physics", f"the place cannot be built at xy_scale {scale}: {error}") from None


def _ramps(
    scenario: Scenario, places: Sequence[tuple[float, float]], heights: Sequence[float], half_width: float
) -> list[Ramp]:
    ramps = []
    for (i, j), rise in sorted(scenario.topology.rises.items()):
        if rise > 0.0:
            ramp = Ramp(*places[i], heights[i], *places[j], heights[j], half_width)
            c, s = abs(math.cos(ramp.yaw)), abs(math.sin(ramp.yaw))
            # The level grounds end square to the axes: an oblique ramp's landings have to reach them.
            askew = 2.0 * half_width * min(c, s) / max(c, s)
            ramps.append(replace(ramp, landing=max(ramp.landing, askew)))
    return ramps


def _grounds(
    places: Sequence[tuple[float, float]], heights: Sequence[float], ramps: Sequence[Ramp], margin: float
) -> list[Ground]:
    """One rectangle a level, higher ones cut back where a lower level or a ramp lies."""
    levels: list[tuple[float, list[tuple[float, float]]]] = []
    for place, height in sorted(zip(places, heights, strict=True), key=lambda pair: pair[1]):
        if levels and height - levels[-1][0] < _SAME_LEVEL:
            levels[-1][1].append(place)
        else:
            levels.append((height, [place]))
    grounds: list[Ground] = []
    carved: list[_Rectangle] = []
    for height, nodes in levels:
        whole = (
            min(x for x, _ in nodes) - margin, min(y for _, y in nodes) - margin,
            max(x for x, _ in nodes) + margin, max(y for _, y in nodes) + margin,
        )  # fmt: skip
        feet = [ramp for ramp in ramps if abs(ramp.z0 - height) < _SAME_LEVEL]
        for ramp in feet:
            whole = _clip(whole, ramp)
        pieces = [whole]
        for hollow in carved:
            pieces = [rest for piece in pieces for rest in _without(piece, hollow)]
        for x, y in nodes:
            on_ramp = any(ramp.height(x, y) is not None for ramp in ramps)
            if not on_ramp and not any(a <= x <= c and b <= y <= d for a, b, c, d in pieces):
                raise ValueError(f"levels overlap at {x:.2f}, {y:.2f} m; give the ground in physics.terrain")
        grounds += [Ground(a, b, c, d, height) for a, b, c, d in pieces if c - a > 1e-6 and d - b > 1e-6]
        if height < levels[-1][0] - _SAME_LEVEL:
            carved.append(whole)
            carved += [_strip(ramp, whole) for ramp in feet]
    return grounds


def _wedge(ramp: Ramp) -> float:
    """The crease is not square to the axes: the ramp's landings cover the wedge between the two."""
    c, s = abs(math.cos(ramp.yaw)), abs(math.sin(ramp.yaw))
    return ramp.half_width * min(c, s)


def _clip(whole: _Rectangle, ramp: Ramp) -> _Rectangle:
    """A low level ends at the foot of its ramp."""
    a, b, c, d = whole
    along_x = abs(math.cos(ramp.yaw)) >= abs(math.sin(ramp.yaw))
    wedge = _wedge(ramp)
    if along_x:
        if ramp.x1 > ramp.x0:
            c = min(c, ramp.x0 - wedge)
        else:
            a = max(a, ramp.x0 + wedge)
        return a, min(b, min(ramp.y0, ramp.y1) - ramp.half_width), c, max(d, max(ramp.y0, ramp.y1) + ramp.half_width)
    if ramp.y1 > ramp.y0:
        d = min(d, ramp.y0 - wedge)
    else:
        b = max(b, ramp.y0 + wedge)
    return min(a, min(ramp.x0, ramp.x1) - ramp.half_width), b, max(c, max(ramp.x0, ramp.x1) + ramp.half_width), d


def _strip(ramp: Ramp, low: _Rectangle) -> _Rectangle:
    """What a ramp takes from the level above it, between the low level and the ramp's top.

    No more than lies under the ramp over this whole length: beside an oblique ramp the ground shall leave no gap.
    """
    a, b, c, d = low
    wedge = _wedge(ramp)
    if abs(math.cos(ramp.yaw)) >= abs(math.sin(ramp.yaw)):
        rise, half = math.tan(ramp.yaw), ramp.half_width / abs(math.cos(ramp.yaw))
        end = ramp.x1 + math.copysign(wedge, ramp.x1 - ramp.x0)
        sides = (ramp.y0, ramp.y0 + rise * (end - ramp.x0))
        b, d = max(b, max(sides) - half), min(d, min(sides) + half)
        strip = (c, b, end, d) if ramp.x1 > ramp.x0 else (end, b, a, d)
    else:
        rise, half = 1.0 / math.tan(ramp.yaw), ramp.half_width / abs(math.sin(ramp.yaw))
        end = ramp.y1 + math.copysign(wedge, ramp.y1 - ramp.y0)
        sides = (ramp.x0, ramp.x0 + rise * (end - ramp.y0))
        a, c = max(a, max(sides) - half), min(c, min(sides) + half)
        strip = (a, d, c, end) if ramp.y1 > ramp.y0 else (a, end, c, b)
    if strip[2] <= strip[0] or strip[3] <= strip[1]:
        raise ValueError("a ramp is too long and oblique; give the ground in physics.terrain")
    return strip


def _without(whole: _Rectangle, hollow: _Rectangle) -> list[_Rectangle]:
    """A rectangle less another one, as rectangles."""
    a, b, c, d = whole
    e, f, g, h = hollow
    if e >= c or g <= a or f >= d or h <= b:
        return [whole]
    rests = []
    if b < f:
        rests.append((a, b, c, f))
    if h < d:
        rests.append((a, h, c, d))
    low, high = max(b, f), min(d, h)
    if a < e:
        rests.append((a, low, e, high))
    if g < c:
        rests.append((g, low, c, high))
    return rests
