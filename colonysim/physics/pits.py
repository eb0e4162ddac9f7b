"""Square pits: where their walls are, the frames that close the ground round rotated ones, and the room that takes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["WALL", "Pit", "closest", "has_room"]

WALL = 0.15
"""Two pits leave at least this much ground between them, metres: their floors reach .1 m under their walls."""
_FRAME = 0.7
"""Width of the strips round a rotated pit where there is room for them, metres."""
_LAP = 0.02
"""A narrow frame still laps over the ground's tiles by this much, metres."""
_OVERLAP = 0.03
"""The strips of a narrow frame are longer than the pit's sides by this much at each end, metres."""

Strip = tuple[float, float, float, float]
"""Centre and half sizes in a pit's own axes, metres."""
Rectangle = tuple[float, float, float, float, float]
"""Centre x, y, heading and half sizes, metres."""


@dataclass(frozen=True, slots=True)
class Pit:
    """A square pit: centre, heading of its sides, side length, height of its rim, and depth."""

    x: float
    y: float
    yaw: float
    side: float = 1.2
    rim: float = 0.0
    depth: float = 0.25

    def local(self, x: float, y: float) -> tuple[float, float]:
        """A point in the pit's own axes."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return c * (x - self.x) + s * (y - self.y), -s * (x - self.x) + c * (y - self.y)

    def contains(self, x: float, y: float, margin: float = 0.0) -> bool:
        """Whether a point lies within the pit's walls, or within `margin` outside of them."""
        reach = self.side + 2 * margin
        if abs(x - self.x) > reach or abs(y - self.y) > reach:
            return False
        u, v = self.local(x, y)
        return max(abs(u), abs(v)) <= self.side / 2 + margin

    def distance(self, x: float, y: float) -> float:
        """Distance of a point from the pit's square, 0 inside."""
        u, v = self.local(x, y)
        return math.hypot(max(0.0, abs(u) - self.side / 2), max(0.0, abs(v) - self.side / 2))

    @property
    def spread(self) -> float:
        """Ratio of the width along the axes of the rotated square to its side."""
        return abs(math.cos(self.yaw)) + abs(math.sin(self.yaw))

    @property
    def is_straight(self) -> bool:
        """Whether its sides lie along the axes: tiles alone make its walls."""
        return self.spread < 1 + 1e-9

    def frame(self, narrow: bool = False) -> tuple[Strip, ...]:
        """The strips that close the ground between a rotated pit and the tiles; none round a straight pit.

        Args:
            narrow: No wider than they have to be, and without corners.
        """
        if self.is_straight:
            return ()
        half, least = self.side / 2, self.side / 2 * (self.spread**2 - 1) + _LAP
        width = least if narrow else max(_FRAME, least)
        across, along = (half + _OVERLAP,) * 2 if narrow else (half + width, half)
        middle = half + width / 2
        return (
            (0.0, middle, across, width / 2),
            (0.0, -middle, across, width / 2),
            (middle, 0.0, width / 2, along),
            (-middle, 0.0, width / 2, along),
        )

    @property
    def reach(self) -> float:
        """Distance of the outermost corner of its walls and its narrow frame from its centre, metres."""
        walls = math.sqrt(2.0) * (self.side / 2 + WALL)
        return max(
            [walls, *(math.hypot(abs(u) + half_u, abs(v) + half_v) for u, v, half_u, half_v in self.frame(True))]
        )

    def cut(self, narrow: bool = False) -> float:
        """Half of what tiles leave free along the axes: the pit itself, or room between it and its frame's border."""
        half = self.side / 2
        if self.is_straight:
            return half
        _, middle, _, strip = self.frame(narrow)[0]
        return (half * self.spread + (middle + strip) / self.spread) / 2

    def rectangles(self, margin: float, narrow: bool = True) -> tuple[Rectangle, ...]:
        """Its square with so much round it, and its frame."""
        c, s, half = math.cos(self.yaw), math.sin(self.yaw), self.side / 2 + margin
        strips = [
            (self.x + c * u - s * v, self.y + s * u + c * v, self.yaw, half_u, half_v)
            for u, v, half_u, half_v in self.frame(narrow)
        ]
        return ((self.x, self.y, self.yaw, half, half), *strips)


def _gap(one: Rectangle, other: Rectangle) -> float:
    """The widest gap between two rectangles along a side of either, metres; negative if they overlap."""
    gaps = []
    for yaw in (one[2], one[2] + math.pi / 2, other[2], other[2] + math.pi / 2):
        c, s = math.cos(yaw), math.sin(yaw)
        away = abs(c * (other[0] - one[0]) + s * (other[1] - one[1]))
        reaches = (
            half_u * abs(math.cos(yaw - turned)) + half_v * abs(math.sin(yaw - turned))
            for _, _, turned, half_u, half_v in (one, other)
        )
        gaps.append(away - sum(reaches))
    return max(gaps)


def closest(pits: Sequence[Pit]) -> tuple[int, int] | None:
    """Two pits that are too close, by index: between them no wall or no frame fits. None if all have room."""
    ordered = sorted(range(len(pits)), key=lambda i: pits[i].x)
    reach = 4.0 * max((pit.side for pit in pits), default=0.0)
    for n, i in enumerate(ordered):
        for j in ordered[n + 1 :]:
            if pits[j].x - pits[i].x > reach:
                break
            one, other = pits[i], pits[j]
            if _covers(one, other, True) or _covers(other, one, True):
                return min(i, j), max(i, j)
    return None


def has_room(pit: Pit, others: Sequence[Pit]) -> bool:
    """Whether the usual frame round a pit covers no other pit."""
    near = 4.0 * max((pit.side, *(other.side for other in others), _FRAME))
    return not any(
        other is not pit
        and abs(other.x - pit.x) < near
        and abs(other.y - pit.y) < near
        and _covers(pit, other, narrow=False)
        for other in others
    )


def _covers(pit: Pit, other: Pit, narrow: bool) -> bool:
    """Whether a pit, its walls or its frame reach over another pit."""
    hole = other.rectangles(0.0)[0]
    return any(_gap(part, hole) < -1e-9 for part in pit.rectangles(WALL, narrow))
