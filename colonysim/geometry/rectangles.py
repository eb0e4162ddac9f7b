"""Ground as one rectangle a level: few large slabs, for maps whose levels lie side by side."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from colonysim.geometry.plan import SAME_LEVEL
from colonysim.physics import Ground, Ramp, Terrain

if TYPE_CHECKING:
    from colonysim.geometry.plan import Plan

__all__ = ["rectangles"]

_Rectangle = tuple[float, float, float, float]


def rectangles(plan: Plan) -> Terrain | None:
    """Terrain without pits: one rectangle a level, higher ones cut back where a lower level or a ramp lies.

    None if a node would be left without ground.
    """
    ramps = _ramps(plan)
    grounds = _grounds(plan, ramps)
    return None if grounds is None else Terrain(tuple(grounds), ramps=tuple(ramps))


def _ramps(plan: Plan) -> list[Ramp]:
    ramps, places, heights = [], plan.places, plan.heights
    for i, j in plan.slopes:
        ramp = Ramp(*places[i], heights[i], *places[j], heights[j], plan.half_width)
        c, s = abs(math.cos(ramp.yaw)), abs(math.sin(ramp.yaw))
        # The level grounds end square to the axes: an oblique ramp's landings have to reach them.
        askew = 2.0 * plan.half_width * min(c, s) / max(c, s)
        ramps.append(replace(ramp, landing=max(ramp.landing, askew)))
    return ramps


def _grounds(plan: Plan, ramps: list[Ramp]) -> list[Ground] | None:
    grounds: list[Ground] = []
    carved: list[_Rectangle] = []
    margin, top = plan.margin, plan.levels[-1][0]
    for height, members in plan.levels:
        nodes = [plan.places[node] for node in members]
        whole = (
            min(x for x, _ in nodes) - margin, min(y for _, y in nodes) - margin,
            max(x for x, _ in nodes) + margin, max(y for _, y in nodes) + margin,
        )  # fmt: skip
        feet = [ramp for ramp in ramps if abs(ramp.z0 - height) < SAME_LEVEL]
        for ramp in feet:
            whole = _clip(whole, ramp)
        pieces = [whole]
        for hollow in carved:
            pieces = [rest for piece in pieces for rest in _without(piece, hollow)]
        for x, y in nodes:
            on_ramp = any(ramp.height(x, y) is not None for ramp in ramps)
            if not on_ramp and not any(a <= x <= c and b <= y <= d for a, b, c, d in pieces):
                return None
        grounds += [Ground(a, b, c, d, height) for a, b, c, d in pieces if c - a > 1e-6 and d - b > 1e-6]
        if height < top - SAME_LEVEL:
            carved.append(whole)
            strips = [_strip(ramp, whole) for ramp in feet]
            if None in strips:
                return None
            carved += [strip for strip in strips if strip is not None]
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


def _strip(ramp: Ramp, low: _Rectangle) -> _Rectangle | None:
    """What a ramp takes from the level above it, between the low level and the ramp's top; None if it is too oblique.

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
    return strip if strip[2] > strip[0] and strip[3] > strip[1] else None


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
