"""Ground, pits and ramps, and the slabs that they are made of."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

from colonysim.physics.pits import WALL, Pit, closest, has_room
from colonysim.physics.shapes import Slab

__all__ = ["Ground", "Pit", "Ramp", "Terrain", "TerrainError"]

_LEVEL = 0.02
_MIN_THICKNESS = 0.4
_SAMPLED = 0.2
"""Round pits the ground is looked at in steps of this length, metres."""


@dataclass(frozen=True, slots=True)
class Ramp:
    """A pitched strip from one point to another, creased at both, with a level landing at each end."""

    x0: float
    y0: float
    z0: float
    x1: float
    y1: float
    z1: float
    half_width: float = 2.2
    landing: float = 0.6

    @property
    def length(self) -> float:
        """Length in the xy plane."""
        return math.hypot(self.x1 - self.x0, self.y1 - self.y0)

    @property
    def yaw(self) -> float:
        """Heading from the first point to the second."""
        return math.atan2(self.y1 - self.y0, self.x1 - self.x0)

    @property
    def slope(self) -> float:
        """Rise angle from the first point to the second."""
        return math.atan2(self.z1 - self.z0, self.length)

    def height(self, x: float, y: float) -> float | None:
        """Height of the strip and its landings at a point, None beside them."""
        yaw, length = self.yaw, self.length
        c, s = math.cos(yaw), math.sin(yaw)
        along = c * (x - self.x0) + s * (y - self.y0)
        across = -s * (x - self.x0) + c * (y - self.y0)
        if abs(across) > self.half_width or not -self.landing <= along <= length + self.landing:
            return None
        share = min(1.0, max(0.0, along / length))
        return self.z0 + share * (self.z1 - self.z0)


@dataclass(frozen=True, slots=True)
class Ground:
    """A level rectangle along the axes; pits are cut out of it."""

    xmin: float
    ymin: float
    xmax: float
    ymax: float
    z: float

    def contains(self, x: float, y: float, margin: float = 0.0) -> bool:
        """Whether a point lies on the rectangle, at least `margin` from its border."""
        return self.xmin + margin <= x <= self.xmax - margin and self.ymin + margin <= y <= self.ymax - margin


class TerrainError(ValueError):
    """Ground that cannot be.

    Args:
        words: What is wrong, with a `{:.2f}` in the place of each length.
        lengths: The lengths.
    """

    def __init__(self, words: str, *lengths: float) -> None:
        super().__init__(words.format(*lengths))
        self.words, self.lengths = words, lengths


@dataclass(frozen=True, slots=True)
class Terrain:
    """All of the fixed ground.

    Raises:
        TerrainError: A pit lies on no ground, under a ramp or its landings, or too close to another pit to be framed.
    """

    grounds: tuple[Ground, ...]
    pits: tuple[Pit, ...] = ()
    ramps: tuple[Ramp, ...] = ()

    def __post_init__(self) -> None:
        for pit in self.pits:
            if not any(g.contains(pit.x, pit.y) and abs(g.z - pit.rim) < _LEVEL for g in self.grounds):
                words = "no ground at the rim's height, {:.2f} m, round the pit at {:.2f}, {:.2f} m"
                raise TerrainError(words, pit.rim, pit.x, pit.y)
            if self._is_under_ramp(pit):
                raise TerrainError("a ramp or its landing lies over the pit at {:.2f}, {:.2f} m", pit.x, pit.y)
        if crowded := closest(self.pits):
            one, other = (self.pits[i] for i in crowded)
            words = "the pits at {:.2f}, {:.2f} m and at {:.2f}, {:.2f} m leave too little ground between them"
            raise TerrainError(words, one.x, one.y, other.x, other.y)

    def height(self, x: float, y: float) -> float:
        """Nominal height of the surface (the floor inside a pit); minus infinity off the ground."""
        for pit in self.pits:
            if pit.contains(x, y):
                return pit.rim - pit.depth
        return self._top(x, y)

    def _top(self, x: float, y: float) -> float:
        """Height of ground and ramps, pits left out."""
        heights = [g.z for g in self.grounds if g.contains(x, y)]
        heights += [h for ramp in self.ramps if (h := ramp.height(x, y)) is not None]
        return max(heights, default=-math.inf)

    def carries(self, pit: Pit, narrow: bool = True) -> bool:
        """Whether there is level ground for a pit's walls, and nothing lower where its frame would stand out.

        Args:
            pit: The pit; it may be one of the terrain's or not.
            narrow: Which frame.
        """
        walls, *strips = pit.rectangles(WALL, narrow)
        if any(abs(self._top(x, y) - pit.rim) >= _LEVEL for x, y in _sampled(walls)):
            return False
        if self._is_under_ramp(pit):
            return False
        tops = (self._top(x, y) for strip in strips for x, y in _sampled(strip))
        return all(top == -math.inf or abs(top - pit.rim) < _LEVEL for top in tops)

    def _is_under_ramp(self, pit: Pit) -> bool:
        hole = pit.rectangles(0.0)[0]
        return any(ramp.height(x, y) is not None for ramp in self.ramps for x, y in _sampled(hole))

    def slabs(self) -> Iterator[Slab]:
        """The fixed boxes that make up the ground: tiles, frames and floors of pits, ramps."""
        thickness = max([_MIN_THICKNESS, *(pit.depth + 0.2 for pit in self.pits)])
        narrow = [
            not pit.is_straight and not (has_room(pit, self.pits) and self.carries(pit, narrow=False))
            for pit in self.pits
        ]
        for ground in self.grounds:
            cuts = [
                _cut(pit, is_narrow)
                for pit, is_narrow in zip(self.pits, narrow, strict=True)
                if ground.z > pit.rim - pit.depth
            ]
            yield from _tiles(ground, cuts, thickness)
        for pit, is_narrow in zip(self.pits, narrow, strict=True):
            yield from _pit_slabs(pit, is_narrow, thickness)
        for ramp in self.ramps:
            yield from _ramp_slabs(ramp)


_Rectangle = tuple[float, float, float, float]


def _sampled(rectangle: tuple[float, float, float, float, float]) -> Iterator[tuple[float, float]]:
    """Places all over a rectangle, up to its border."""
    x, y, yaw, half_u, half_v = rectangle
    half_u, half_v = half_u - 1e-6, half_v - 1e-6
    c, s = math.cos(yaw), math.sin(yaw)
    across, along = (math.ceil(2 * half / _SAMPLED) for half in (half_u, half_v))
    for i in range(across + 1):
        for j in range(along + 1):
            u, v = half_u * (2 * i / across - 1), half_v * (2 * j / along - 1)
            yield x + c * u - s * v, y + s * u + c * v


def _cut(pit: Pit, narrow: bool) -> _Rectangle:
    """What the ground's tiles leave free."""
    half = pit.cut(narrow)
    return pit.x - half, pit.y - half, pit.x + half, pit.y + half


def _tiles(ground: Ground, cuts: list[_Rectangle], thickness: float) -> Iterator[Slab]:
    """Cover a rectangle except for the cuts: rows between the cuts' borders, split at each cut."""
    rows = sorted({ground.ymin, ground.ymax, *(y for c in cuts for y in (c[1], c[3]))})
    rows = [y for y in rows if ground.ymin <= y <= ground.ymax]
    for low, high in itertools.pairwise(rows):
        left = ground.xmin
        for cut in sorted(c for c in cuts if c[1] < high and c[3] > low):
            if min(cut[0], ground.xmax) > left:
                yield _tile(left, low, min(cut[0], ground.xmax), high, ground.z, thickness)
            left = max(left, cut[2])
        if left < ground.xmax:
            yield _tile(left, low, ground.xmax, high, ground.z, thickness)


def _tile(xmin: float, ymin: float, xmax: float, ymax: float, top: float, thickness: float) -> Slab:
    return Slab(
        ((xmin + xmax) / 2, (ymin + ymax) / 2, top - thickness / 2),
        ((xmax - xmin) / 2, (ymax - ymin) / 2, thickness / 2),
    )


def _pit_slabs(pit: Pit, narrow: bool, thickness: float) -> Iterator[Slab]:
    half = pit.side / 2
    floor = pit.rim - pit.depth
    yield Slab((pit.x, pit.y, floor - 0.1), (half + 0.1, half + 0.1, 0.1), pit.yaw)
    c, s = math.cos(pit.yaw), math.sin(pit.yaw)
    for u, v, half_u, half_v in pit.frame(narrow):
        yield Slab(
            (pit.x + c * u - s * v, pit.y + s * u + c * v, pit.rim - thickness / 2),
            (half_u, half_v, thickness / 2),
            pit.yaw,
        )


def _ramp_slabs(ramp: Ramp) -> Iterator[Slab]:
    c, s, slope = math.cos(ramp.yaw), math.sin(ramp.yaw), ramp.slope
    half = _MIN_THICKNESS / 2
    # The box hangs below its top face along the face's own normal.
    sink = half * math.sin(slope)
    yield Slab(
        (
            (ramp.x0 + ramp.x1) / 2 + sink * c,
            (ramp.y0 + ramp.y1) / 2 + sink * s,
            (ramp.z0 + ramp.z1) / 2 - half * math.cos(slope),
        ),
        (math.hypot(ramp.length, ramp.z1 - ramp.z0) / 2, ramp.half_width, half),
        ramp.yaw,
        slope,
    )
    for x, y, z, side in ((ramp.x0, ramp.y0, ramp.z0, -1.0), (ramp.x1, ramp.y1, ramp.z1, 1.0)):
        reach = side * ramp.landing / 2
        centre = (x + reach * c, y + reach * s, z - half)
        yield Slab(centre, (ramp.landing / 2, ramp.half_width, half), ramp.yaw)
