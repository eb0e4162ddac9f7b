"""Whether robots find sound ground all along each edge, by the same measure as when they plan their ways."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from colonysim.geometry.plan import SAME_LEVEL
from colonysim.push.footing import Footing, footing_on

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from colonysim.geometry.plan import Point
    from colonysim.physics import Terrain
    from colonysim.scenario.scenario import Scenario

__all__ = ["first_broken", "travelled"]

_PART = 0.1
"""A way is looked at in parts of this length, metres."""
_ASIDE = 8
"""Robots may leave the middle of a way by this many parts, to get round the side of a ramp."""
_TOLERANCE = SAME_LEVEL + 0.01


def travelled(scenario: Scenario, heights: Sequence[float]) -> Iterator[tuple[int, int]]:
    """The edges (i, j), i < j, that robots may drive over: those of one level, and slopes."""
    topology = scenario.topology
    for i, others in enumerate(topology.neighbours):
        for j in others:
            if i < j and (abs(heights[i] - heights[j]) < SAME_LEVEL or (i, j) in topology.rises):
                yield i, j


def first_broken(
    scenario: Scenario, places: Sequence[Point], heights: Sequence[float], terrain: Terrain
) -> tuple[int, ...] | None:
    """The first node (one index) or edge (two) without sound ground, None if all is well; pits count as filled.

    A node is sound if a robot can turn there; an edge, if a robot gets along it without leaving it by more than .8 m,
    and on the way is never higher or lower than between the two ends.
    """
    footing = footing_on(terrain)
    used: set[int] = set(scenario.agents)
    edges = list(travelled(scenario, heights))
    used.update(node for edge in edges for node in edge)
    for node in sorted(used):
        if not _is_sound(footing, *places[node], heights[node], heights[node]):
            return (node,)
    for i, j in edges:
        if not _leads(footing, places[i], places[j], min(heights[i], heights[j]), max(heights[i], heights[j])):
            return i, j
    return None


def _is_sound(footing: Footing, x: float, y: float, low: float, high: float) -> bool:
    return low - _TOLERANCE <= footing.height(x, y) <= high + _TOLERANCE and footing.slack(x, y) >= 0.0


def _leads(footing: Footing, start: Point, end: Point, low: float, high: float) -> bool:
    away = math.dist(start, end)
    c, s = (end[0] - start[0]) / away, (end[1] - start[1]) / away
    parts = math.ceil(away / _PART)

    def sound(k: int, aside: int) -> bool:
        along, across = away * k / parts, _PART * aside
        return _is_sound(footing, start[0] + along * c - across * s, start[1] + along * s + across * c, low, high)

    if all(sound(k, 0) for k in range(1, parts)):
        return True
    reached = {0}
    for k in range(1, parts + 1):
        ahead = {a + d for a in reached for d in (-1, 0, 1) if abs(a + d) <= _ASIDE}
        reached = {a for a in ahead if sound(k, a)}
        border = list(reached)
        while border:  # and sideways from there
            a = border.pop()
            for b in (a - 1, a + 1):
                if b not in reached and abs(b) <= _ASIDE and sound(k, b):
                    reached.add(b)
                    border.append(b)
    return 0 in reached
