"""Ground, pits and ramps, and the slabs that they are made of."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

from colonysim.physics.shapes import Slab

_FRAME = 0.7
"""Width of the strips round a rotated pit, metres."""
_LEVEL = 0.02
_MIN_THICKNESS = 0.4


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


@dataclass(frozen=True, slots=True)
class Terrain:
    """All of the fixed ground.

    Raises:
        ValueError: A pit lies on no ground, under a ramp or its landings, or too close to another pit to be framed.
    """

    grounds: tuple[Ground, ...]
    pits: tuple[Pit, ...] = ()
    ramps: tuple[Ramp, ...] = ()

    def __post_init__(self) -> None:
        for pit in self.pits:
            if not any(g.contains(pit.x, pit.y) and abs(g.z - pit.rim) < _LEVEL for g in self.grounds):
                raise ValueError(f"no ground at the rim height {pit.rim} around the pit at {pit.x}, {pit.y}")
            half = pit.side / 2
            corners = [(pit.x + u, pit.y + v) for u in (-half, 0.0, half) for v in (-half, 0.0, half)]
            if any(ramp.height(x, y) is not None for ramp in self.ramps for x, y in corners):
                raise ValueError(f"a ramp or its landing lies over the pit at {pit.x:.2f}, {pit.y:.2f}")
        for i, one in enumerate(self.pits):
            for other in self.pits[i + 1 :]:
                gap = math.hypot(one.x - other.x, one.y - other.y)
                if gap < (one.side / 2 + _FRAME + other.side / 2) * math.sqrt(2):
                    raise ValueError(
                        f"the pits at {one.x}, {one.y} and {other.x}, {other.y} are {gap:.2f} m apart, "
                        "too close for the ground between them"
                    )

    def height(self, x: float, y: float) -> float:
        """Nominal height of the surface (the floor inside a pit); minus infinity off the ground."""
        for pit in self.pits:
            if pit.contains(x, y):
                return pit.rim - pit.depth
        heights = [g.z for g in self.grounds if g.contains(x, y)]
        heights += [h for ramp in self.ramps if (h := ramp.height(x, y)) is not None]
        return max(heights, default=-math.inf)

    def slabs(self) -> Iterator[Slab]:
        """The fixed boxes that make up the ground: tiles, frames and floors of pits, ramps."""
        thickness = max([_MIN_THICKNESS, *(pit.depth + 0.2 for pit in self.pits)])
        for ground in self.grounds:
            cuts = [_cut(pit) for pit in self.pits if ground.z > pit.rim - pit.depth]
            yield from _tiles(ground, cuts, thickness)
        for pit in self.pits:
            yield from _pit_slabs(pit, thickness)
        for ramp in self.ramps:
            yield from _ramp_slabs(ramp)


_Rectangle = tuple[float, float, float, float]


def _spread(yaw: float) -> float:
    """Ratio of the width along the axes of a rotated square to its side."""
    return abs(math.cos(yaw)) + abs(math.sin(yaw))


def _is_straight(pit: Pit) -> bool:
    return _spread(pit.yaw) < 1 + 1e-9


def _cut(pit: Pit) -> _Rectangle:
    """What the ground's tiles leave free: the pit itself, or room between it and its frame's border."""
    half = pit.side / 2
    if not _is_straight(pit):
        half = (half * _spread(pit.yaw) + (half + _FRAME) / _spread(pit.yaw)) / 2
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


def _pit_slabs(pit: Pit, thickness: float) -> Iterator[Slab]:
    half = pit.side / 2
    floor = pit.rim - pit.depth
    yield Slab((pit.x, pit.y, floor - 0.1), (half + 0.1, half + 0.1, 0.1), pit.yaw)
    if _is_straight(pit):
        return
    c, s = math.cos(pit.yaw), math.sin(pit.yaw)
    middle, strip = half + _FRAME / 2, _FRAME / 2
    for u, v, half_u, half_v in (
        (0.0, middle, half + _FRAME, strip),
        (0.0, -middle, half + _FRAME, strip),
        (middle, 0.0, strip, half),
        (-middle, 0.0, strip, half),
    ):
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
