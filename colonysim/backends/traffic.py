"""What a manoeuvre needs of the place: the edges it crosses, the nodes it sweeps over; and the last resort, to stop."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, TypeAlias

from colonysim.physics import STANDARD, ticks_to_close

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.physics import WheelSpeeds
    from colonysim.world.state import Place
    from colonysim.world.topology import Topology

__all__ = ["LOOK_TICKS", "Traffic", "closing_in", "segment_distance", "ticks_until_close"]

Point: TypeAlias = tuple[float, float]
Course: TypeAlias = tuple[float, float, float]

CLEARANCE = 1.0
"""Two robots whose centres stay this far apart do not touch, whichever way they turn, metres."""
_TURNING = 0.05
"""Slower than this a robot turns on the spot, metres per second."""
_BUMP, _BRAKING = 0.93, 0.15
"""Robots stop this far apart: metres, and metres for each metre per second."""
_RADIUS, _FASTEST = STANDARD.wheel_radius, STANDARD.wheel_speed * STANDARD.wheel_radius
LOOK_TICKS = 3
"""Near others, robots look out for them 20 times a second."""
_AHEAD, _ASIDE = 0.3, 0.85
"""Who stands less far ahead, or further to the side, is passed, metres."""


class Traffic:
    """Which nodes and edges lie within reach of a robot that drives along a line.

    Args:
        topology: The graph.
        places: x, y of each node, metres.
    """

    def __init__(self, topology: Topology, places: Sequence[Point]) -> None:
        self._places = places
        self._edges = [(i, j) for i, others in enumerate(topology.neighbours) for j in others if i < j]
        self._conflicts: dict[tuple[int, int], frozenset[Place]] = {}

    def travel(self, i: int, j: int) -> frozenset[Place]:
        """The target, the edge itself, and every edge that comes too close to it without sharing a node."""
        key = (i, j)
        found = self._conflicts.get(key)
        if found is None:
            places = self._places
            start, end = places[i], places[j]
            near: set[Place] = {j, (min(i, j), max(i, j))}
            for a, b in self._edges:
                if a in key or b in key or _far_apart(start, end, places[a], places[b]):
                    continue
                if segment_distance(start, end, places[a], places[b]) < CLEARANCE:
                    near.add((a, b))
            found = self._conflicts[key] = frozenset(near)
        return found

    def sweep(self, here: int, target: int, points: Sequence[Point]) -> frozenset[Place]:
        """For a push: the target, the nodes near any part of the way, and the edges that cross it.

        Args:
            here: The node that box and robot are on.
            target: Where the box goes.
            points: The robot's way: staging poses and the end, metres.
        """
        near: set[Place] = {target}
        legs = list(itertools.pairwise(points)) or [(points[0], points[0])]
        for node, place in enumerate(self._places):
            if node != here and any(segment_distance(a, b, place, place) < CLEARANCE for a, b in legs):
                near.add(node)
        for i, j in self._edges:
            start, end = self._places[i], self._places[j]
            if any(
                not _far_apart(a, b, start, end) and segment_distance(a, b, start, end) < CLEARANCE for a, b in legs
            ):
                near.add((i, j))
        return frozenset(near)


def closing_in(robot: Course, speeds: WheelSpeeds, others: Iterable[Course]) -> bool:
    """Whether a robot that goes on like this is about to run into another one.

    Reservations keep robots apart that keep to their ways. A network that lines up for a push may back away from
    them; then this is what stops it, and it chooses again.

    Args:
        robot: x, y and yaw.
        speeds: What its wheels are about to do.
        others: x, y and yaw of the other robots.
    """
    left, right = speeds
    speed = (left + right) * _RADIUS / 2
    if abs(speed) < _TURNING:
        return False
    x, y, yaw = robot
    reach = _BUMP + _BRAKING * abs(speed)
    for u, v, _ in others:
        dx, dy = u - x, v - y
        if dx * dx + dy * dy < reach * reach:
            way = math.copysign(1.0, speed)
            c, s = way * math.cos(yaw), way * math.sin(yaw)
            if c * dx + s * dy > _AHEAD and abs(c * dy - s * dx) < _ASIDE:
                return True
    return False


def ticks_until_close(robot: Course, others: Iterable[Course]) -> int:
    """For how many ticks no other robot can come near; all given by x, y and yaw."""
    x, y, _ = robot
    nearest = math.inf
    for u, v, _ in others:
        away = math.hypot(u - x, v - y)
        # A pose that is no number is looked at in every tick.
        if not away >= nearest:
            nearest = away
    return ticks_to_close(nearest - _BUMP - _BRAKING * _FASTEST)


def _far_apart(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Whether the upright rectangles around two segments are CLEARANCE apart or more: asked first, for most are."""
    return (
        min(a[0], b[0]) - max(c[0], d[0]) >= CLEARANCE
        or min(c[0], d[0]) - max(a[0], b[0]) >= CLEARANCE
        or min(a[1], b[1]) - max(c[1], d[1]) >= CLEARANCE
        or min(c[1], d[1]) - max(a[1], b[1]) >= CLEARANCE
    )


def segment_distance(a: Point, b: Point, c: Point, d: Point) -> float:
    """The least distance between two segments a-b and c-d in the plane."""
    if _crosses(a, b, c, d):
        return 0.0
    return min(_to_segment(a, c, d), _to_segment(b, c, d), _to_segment(c, a, b), _to_segment(d, a, b))


def _to_segment(p: Point, a: Point, b: Point) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    square = dx * dx + dy * dy
    share = 0.0 if square == 0.0 else min(1.0, max(0.0, ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / square))
    return math.dist(p, (a[0] + share * dx, a[1] + share * dy))


def _crosses(a: Point, b: Point, c: Point, d: Point) -> bool:
    def side(p: Point, q: Point, r: Point) -> float:
        return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])

    return side(a, b, c) * side(a, b, d) < 0.0 and side(c, d, a) * side(c, d, b) < 0.0
