"""Level grounds and the ramps between them, and whether wheels find ground all along each edge."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from colonysim.geometry.scale import MARGIN, RAMP_HALF_WIDTH
from colonysim.physics import Ground, Pit, Ramp, Terrain
from colonysim.push.footing import footing_on

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.scenario.scenario import Scenario

__all__ = ["check_ways", "terrain_of"]

_SAME_LEVEL = 0.02
_WHEELS = 0.35
"""The ground must be sound this far beside the middle of a way, metres."""
_STEP = 0.1
"""Steps and slopes a robot's wheels climb, metres in a tenth of a metre."""

_Rectangle = tuple[float, float, float, float]


def terrain_of(
    scenario: Scenario,
    physics: Mapping[str, Any],
    scale: float,
    places: Sequence[tuple[float, float]],
    heights: Sequence[float],
    pits: list[Pit],
) -> Terrain:
    """The ground that was given in `physics.terrain`, or one made of the nodes' levels, ramps and pits.

    Raises:
        ScenarioError: Levels overlap, or a ramp or pit does not fit.
    """
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


def check_ways(
    scenario: Scenario, places: Sequence[tuple[float, float]], heights: Sequence[float], terrain: Terrain
) -> None:
    """Whoever may travel an edge on paper must find ground all along it.

    Raises:
        ScenarioError: There is a gap or a step.
    """
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
