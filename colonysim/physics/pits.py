"""Square pits: where their walls are, the frames that close the ground round rotated ones, and the room that takes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["WALL", "Pit", "closest", "frame_width", "squares_apart"]

WALL = 0.15
"""Two pits leave at least this much ground between them, metres: their floors reach .1 m under their walls."""
_FRAME = 0.7
"""Width of the strips round a rotated pit where there is room for them, metres."""
_LAP = 0.02
"""A narrow frame still laps over the ground's tiles by this much, metres."""

_Square = tuple[float, float, float, float]
"""Centre x, y, heading, half the side."""


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

    @property
    def least_frame(self) -> float:
        """How wide a frame has to be to reach the tiles, which end along the axes; 0 round a straight pit."""
        return 0.0 if self.is_straight else self.side / 2 * (self.spread**2 - 1) + _LAP

    def square(self, margin: float = 0.0) -> _Square:
        """Its centre, heading and half side, `margin` further out."""
        return self.x, self.y, self.yaw, self.side / 2 + margin


def squares_apart(one: _Square, other: _Square) -> float:
    """The widest gap between two squares that a straight line along a side of one leaves; negative if they overlap."""
    gaps = []
    for yaw in (one[2], one[2] + math.pi / 2, other[2], other[2] + math.pi / 2):
        c, s = math.cos(yaw), math.sin(yaw)
        away = abs(c * (other[0] - one[0]) + s * (other[1] - one[1]))
        gaps.append(away - sum(half * _width(yaw - turned) for _, _, turned, half in (one, other)))
    return max(gaps)


def _width(angle: float) -> float:
    return abs(math.cos(angle)) + abs(math.sin(angle))


def closest(pits: Sequence[Pit]) -> tuple[int, int] | None:
    """The first two pits that are too close: between them no wall or no frame fits."""
    ordered = sorted(range(len(pits)), key=lambda i: pits[i].x)
    reach = 4.0 * max((pit.side for pit in pits), default=0.0)
    for n, i in enumerate(ordered):
        for j in ordered[n + 1 :]:
            if pits[j].x - pits[i].x > reach:
                break
            if _too_close(pits[i], pits[j]):
                return min(i, j), max(i, j)
    return None


def _too_close(one: Pit, other: Pit) -> bool:
    if squares_apart(one.square(), other.square()) < WALL:
        return True
    return any(squares_apart(a.square(a.least_frame), b.square()) < 0.0 for a, b in ((one, other), (other, one)))


def frame_width(pit: Pit, others: Sequence[Pit]) -> float:
    """Width of a rotated pit's frame, metres: the usual one, or where that would cover another pit the least."""
    near = 4.0 * max(pit.side, *(other.side for other in others), _FRAME) if others else 0.0
    for other in others:
        if other is pit or abs(other.x - pit.x) > near or abs(other.y - pit.y) > near:
            continue
        if squares_apart(pit.square(_FRAME), other.square()) < 0.0:
            return pit.least_frame
    return max(_FRAME, pit.least_frame)
