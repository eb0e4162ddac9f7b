"""Ramps that fit between what lies beside them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from colonysim.geometry.plan import edge_path
from colonysim.geometry.scale import BOX_HEIGHT
from colonysim.geometry.trouble import Trouble
from colonysim.physics import Ramp
from colonysim.physics.pits import WALL

if TYPE_CHECKING:
    from collections.abc import Iterator

    from colonysim.geometry.plan import Plan, Point
    from colonysim.physics.pits import Rectangle

__all__ = ["LEAST_HALF_WIDTH", "PAST", "ROOM", "STEEPEST", "fitted_ramps", "steep"]

STEEPEST = 0.3
"""Most that a ramp rises in a metre: robots plan no way up .33, and scripted pushes still went up .315."""
_GENTLE = 0.25
"""A ramp is not made steeper than this for level ground at its ends."""
ROOM = 0.55
"""Robots and boxes on their way need this much ground on each side, metres."""
LEAST_HALF_WIDTH = 0.8
_FLAT = 0.55
"""Where another edge leads past a ramp's end, the node gets this much level ground before the crease, metres."""
PAST = math.radians(115.0)
"""An edge leads past a ramp if it turns off by less than this from the ramp's direction."""
_SPACING = 0.2


def steep(plan: Plan) -> Trouble | None:
    """The first slope that robots cannot climb."""
    for i, j in plan.slopes:
        length = math.dist(plan.places[i], plan.places[j])
        rise = plan.heights[j] - plan.heights[i]
        if rise > STEEPEST * length:
            words, lengths = f"slope {plan.named(i, j)} rises {{:.2f}} m over {{:.2f}} m", [rise, length]
            if plan.scenario.boxes and plan.scenario.physics.get("z_scale") is None:
                words += " (physics.z_scale is {:.4g} by default, which makes the lowest box {:g} m high)"
                lengths += plan.z_scale, BOX_HEIGHT
            return Trouble(edge_path(plan.scenario, i, j), words, *lengths, away=length, needed=rise / STEEPEST)
    return None


def fitted_ramps(plan: Plan) -> list[Ramp]:
    """A ramp for each slope, as wide as what lies beside it allows."""
    return [_fitted(plan, i, j) for i, j in plan.slopes]


def _fitted(plan: Plan, foot: int, top: int) -> Ramp:
    (x0, y0), (x1, y1) = plan.places[foot], plan.places[top]
    z0, z1 = plan.heights[foot], plan.heights[top]
    length = math.dist((x0, y0), (x1, y1))
    c, s = (x1 - x0) / length, (y1 - y0) / length
    # The creases leave the nodes as far as the slope may get steeper.
    spare = max(0.0, length - (z1 - z0) / _GENTLE)
    flats = [_FLAT if _is_passed(plan, *ends) else 0.0 for ends in ((foot, top), (top, foot))]
    share = min(1.0, spare / sum(flats)) if sum(flats) else 0.0
    before, after = (share * flat for flat in flats)
    ramp = Ramp(x0 + before * c, y0 + before * s, z0, x1 - after * c, y1 - after * s, z1, plan.half_width)
    half = plan.half_width
    for (x, y, yaw, half_u, half_v), height in _beside(plan, foot, top, ramp.yaw):
        along, across = c * (x - ramp.x0) + s * (y - ramp.y0), abs(-s * (x - ramp.x0) + c * (y - ramp.y0))
        cd, sd = abs(math.cos(yaw - ramp.yaw)), abs(math.sin(yaw - ramp.yaw))
        reach, room = half_u * cd + half_v * sd, half_u * sd + half_v * cd
        # Level with an end it may lie beyond the crease there; the upper landing is a roof for what is lower.
        begin = 0.0 if height <= z0 else -ramp.landing
        end = ramp.length if height >= z1 else ramp.length + ramp.landing
        overlaps = begin + 1e-6 < along + reach and along - reach < end - 1e-6
        if overlaps and across >= LEAST_HALF_WIDTH + room:
            half = min(half, across - room)
    return Ramp(ramp.x0, ramp.y0, z0, ramp.x1, ramp.y1, z1, half)


def _is_passed(plan: Plan, end: int, other: int) -> bool:
    """Whether an edge of the same level leads past one end of a ramp."""
    (x, y), away = plan.places[end], plan.places[other]
    ahead = math.atan2(away[1] - y, away[0] - x)
    for j in plan.scenario.topology.neighbours[end]:
        if plan.level_of[j] == plan.level_of[end]:
            turn = math.atan2(plan.places[j][1] - y, plan.places[j][0] - x) - ahead
            if abs(math.remainder(turn, 2.0 * math.pi)) < PAST:
                return True
    return False


def _beside(plan: Plan, foot: int, top: int, yaw: float) -> Iterator[tuple[Rectangle, float]]:
    """What a ramp of that heading has to leave free, and the height of each."""
    for i, j in plan.lanes:
        for x, y in _along(plan.places[i], plan.places[j]):
            yield (x, y, yaw, ROOM, ROOM), plan.heights[i]
    for node, (x, y) in enumerate(plan.places):
        if node not in (foot, top):
            yield (x, y, yaw, ROOM, ROOM), plan.heights[node]
    for i, j in plan.slopes:
        if (i, j) != (foot, top):
            for x, y in _along(plan.places[i], plan.places[j]):
                yield (x, y, yaw, LEAST_HALF_WIDTH, LEAST_HALF_WIDTH), (plan.heights[i] + plan.heights[j]) / 2
    for pit in plan.pits:
        # A landing may be no part of a pit's walls, at whatever height.
        for part in pit.rectangles(WALL):
            yield part, math.nan


def _along(start: Point, end: Point) -> Iterator[Point]:
    parts = math.ceil(math.dist(start, end) / _SPACING)
    for k in range(parts + 1):
        yield start[0] + k / parts * (end[0] - start[0]), start[1] + k / parts * (end[1] - start[1])
