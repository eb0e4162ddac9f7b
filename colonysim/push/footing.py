# cython: boundscheck=False, wraparound=False, auto_pickle=False
"""The ground as a driving robot knows it: its height, and the room there is to its border and to cliffs.

It answers for single places and in plain numbers: a way is looked at place by place, and is often found too narrow
at one of the first.
"""

from __future__ import annotations

import math
from array import array
from functools import lru_cache

from colonysim.physics.terrain import Terrain

__all__ = ["AMPLE", "BORDER_CLEARANCE", "COMFORT", "Footing", "footing_on"]

BORDER_CLEARANCE = 0.40
"""Least distance of a robot's centre from the ground's border, metres."""
COMFORT = 0.15
"""Ways that have this slack cost nothing extra, metres."""
AMPLE = 1.0
"""No slack is reported larger than this, metres."""

_STEEPEST = 0.3
_STEP = 0.005
"""Together with the steepest slope over .1 m: a step of .035 m is passed over, one of .04 m stops the wheels."""
# At the ground's border and at cliffs: eight looks at each of several distances, the last of them further than needed.
_REACHES = (0.1, 0.2, 0.3, BORDER_CLEARANCE, BORDER_CLEARANCE + COMFORT)
_DIRECTIONS, _DISTANCES = 8, len(_REACHES)
_ANGLES = [k * (math.pi / 4) for k in range(_DIRECTIONS)]
_LOOKS_X = array("d", [reach * math.cos(angle) for angle in _ANGLES for reach in _REACHES])
_LOOKS_Y = array("d", [reach * math.sin(angle) for angle in _ANGLES for reach in _REACHES])
_RISES = array("d", [_STEEPEST * reach + 0.02 for reach in _REACHES])
_STEPS = array("d", [_STEEPEST * (b - a) + _STEP for a, b in zip((0.0, *_REACHES), _REACHES, strict=False)])
_FURTHEST = BORDER_CLEARANCE + COMFORT + 0.01
_NOWHERE = -math.inf
# Rows of the arrays below.
_GROUND, _RAMP = 5, 9


class Footing:
    """Height and room at any place of a terrain; pits count as filled.

    Args:
        terrain: The fixed ground.
    """

    def __init__(self, terrain: Terrain) -> None:
        grounds = [(g.xmin, g.ymin, g.xmax, g.ymax, g.z) for g in terrain.grounds]
        ramps = [
            (r.x0, r.y0, math.cos(r.yaw), math.sin(r.yaw), r.half_width, r.landing, r.length, r.z0, r.z1 - r.z0)
            for r in terrain.ramps
        ]
        self._grounds = array("d", [number for ground in grounds for number in ground])
        self._ramps = array("d", [number for ramp in ramps for number in ramp])
        self._all_grounds = array("i", range(0, _GROUND * len(grounds), _GROUND))
        self._all_ramps = array("i", range(0, _RAMP * len(ramps), _RAMP))
        # For one look around: those within reach of it. All others are nowhere near.
        self._near_grounds, self._near_ramps = array("i", self._all_grounds), array("i", self._all_ramps)

    def height(self, x: float, y: float) -> float:
        """Height of the ground, metres; minus infinity off the ground."""
        grounds, ramps = self._all_grounds, self._all_ramps
        return self._top(x, y, grounds, len(grounds), ramps, len(ramps))

    def _top(
        self, x: float, y: float, some_grounds: array[int], ground_count: int, some_ramps: array[int], ramp_count: int
    ) -> float:
        """The height of the highest of some grounds and ramps that the place is on."""
        grounds, ramps = self._grounds, self._ramps
        top = _NOWHERE
        for k in range(ground_count):
            i = some_grounds[k]
            inside = grounds[i] <= x <= grounds[i + 2] and grounds[i + 1] <= y <= grounds[i + 3]
            if inside and grounds[i + 4] > top:
                top = grounds[i + 4]
        for k in range(ramp_count):
            i = some_ramps[k]
            dx, dy, c, s = x - ramps[i], y - ramps[i + 1], ramps[i + 2], ramps[i + 3]
            along, across = c * dx + s * dy, -s * dx + c * dy
            landing, length = ramps[i + 5], ramps[i + 6]
            if abs(across) <= ramps[i + 4] and -landing <= along <= length + landing:
                height = ramps[i + 7] + max(0.0, min(1.0, along / length)) * ramps[i + 8]
                if height > top:
                    top = height
        return top

    def slack(self, x: float, y: float) -> float:
        """Room towards the ground's border and towards cliffs, in coarse grades, metres."""
        if self._amid(x, y):
            return AMPLE
        grounds, ramps = self._near_grounds, self._near_ramps
        ground_count = ramp_count = 0
        for k in range(len(self._all_grounds)):
            i = self._all_grounds[k]
            if self._within(i, _FURTHEST, x, y):
                grounds[ground_count] = i
                ground_count += 1
        for k in range(len(self._all_ramps)):
            i = self._all_ramps[k]
            if self._beside_ramp(i, x, y):
                ramps[ramp_count] = i
                ramp_count += 1
        here = self._top(x, y, grounds, ground_count, ramps, ramp_count)
        if here == _NOWHERE:
            return -BORDER_CLEARANCE
        slack = AMPLE
        for direction in range(_DIRECTIONS):
            k, before = _DISTANCES * direction, here
            for j in range(_DISTANCES):
                there = self._top(x + _LOOKS_X[k + j], y + _LOOKS_Y[k + j], grounds, ground_count, ramps, ramp_count)
                # Neither a cliff nor, on the way there, a step that stops the wheels; off the ground it is no number.
                if not (abs(there - here) <= _RISES[j] and abs(there - before) <= _STEPS[j]):
                    if j < _DISTANCES - 1:
                        return -COMFORT
                    slack = 0.0
                before = there
        return slack

    def _amid(self, x: float, y: float) -> bool:
        """Whether the ground is the same level rectangle as far as `slack` would look: there is ample room."""
        for k in range(len(self._all_ramps)):
            if self._beside_ramp(self._all_ramps[k], x, y):
                return False
        level = _NOWHERE
        for k in range(len(self._all_grounds)):
            i = self._all_grounds[k]
            if self._within(i, -_FURTHEST, x, y):
                level = max(level, self._grounds[i + 4])
        for k in range(len(self._all_grounds)):
            i = self._all_grounds[k]
            if self._grounds[i + 4] > level and self._within(i, _FURTHEST, x, y):
                return False
        return level > _NOWHERE

    def _within(self, i: int, margin: float, x: float, y: float) -> bool:
        """Whether a place lies on a ground, or up to `margin` beside it (inside it, if negative)."""
        g = self._grounds
        return g[i] - margin <= x <= g[i + 2] + margin and g[i + 1] - margin <= y <= g[i + 3] + margin

    def _beside_ramp(self, i: int, x: float, y: float) -> bool:
        """Whether a place lies on a ramp, or as far beside it as `slack` would look."""
        ramps = self._ramps
        dx, dy, c, s = x - ramps[i], y - ramps[i + 1], ramps[i + 2], ramps[i + 3]
        along, beyond = c * dx + s * dy, ramps[i + 5] + _FURTHEST
        return abs(c * dy - s * dx) <= ramps[i + 4] + _FURTHEST and -beyond <= along <= ramps[i + 6] + beyond


footing_on = lru_cache(maxsize=16)(Footing)
"""The footing of a terrain; made once."""
