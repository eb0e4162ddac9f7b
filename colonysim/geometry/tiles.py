"""Ground that follows the nodes and edges of each level: rectangles on a grid, for levels that reach into each other.

The plane is a grid of cells of at most .2 m, whose lines include the borders of levels and of ramps along the axes. A
cell belongs to the level whose nodes and edges are nearest. Cells that no edge comes close to, or that lie half-way
between two levels, may go to either, so that few large rectangles cover the rest.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from colonysim.geometry.ramps import fitted_ramps
from colonysim.physics import Ground, Pit, Ramp, Terrain
from colonysim.physics.pits import WALL

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from colonysim.geometry.plan import Plan, Point

__all__ = ["CELL_CENTRE", "tiles"]

_CELL = 0.2
"""Metres."""
CELL_CENTRE = 0.15
"""No place of a cell is further from its centre, metres."""
_MOST_CELLS = 2_000_000
"""On larger places cells are larger; narrow places between levels are then refused."""
_LANE = 0.7
"""Ground within this of a node or an edge is its level's, metres: nobody else's may be there."""
_EITHER = 0.5
"""Where two levels are equally near within this, the ground may be either's, metres."""


def tiles(plan: Plan) -> Terrain:
    """Terrain without pits, for levels of any shape."""
    ramps = fitted_ramps(plan)
    grid = _Grid(plan, ramps)
    grounds: list[Ground] = []
    for level, (height, _) in enumerate(plan.levels):
        grounds += [Ground(*rectangle, height) for rectangle in grid.cover(level)]
    return Terrain(tuple(grounds), ramps=tuple(ramps))


class _Grid:
    """Which level each cell belongs to, and which may have it.

    Args:
        plan: The graph in metres.
        ramps: The ramps, in the order of the plan's slopes.
    """

    def __init__(self, plan: Plan, ramps: Sequence[Ramp]) -> None:
        self._borders = [_bounds([plan.places[node] for node in nodes], plan.margin) for _, nodes in plan.levels]
        self._lines = _lines(self._borders, ramps)
        x, y = ((lines[:-1] + lines[1:]) / 2 for lines in self._lines)
        half_x, half_y = (np.diff(lines) / 2 for lines in self._lines)
        shape = (len(x), len(y))
        self._owner = np.full(shape, -1, dtype=np.int16)
        nearest, second = np.full(shape, np.inf), np.full(shape, np.inf)
        for level in range(len(plan.levels)):
            away = _distances(plan, level, x, y)
            closer = away < nearest
            second = np.where(closer, nearest, np.minimum(second, away))
            nearest = np.where(closer, away, nearest)
            self._owner[closer] = level
        self._free = (nearest > plan.margin) | ((nearest > _LANE) & (second < nearest + _EITHER))
        self._under = np.full(shape, -1, dtype=np.int16)
        for (foot, _), ramp in zip(plan.slopes, ramps, strict=True):
            under = _under(ramp, x, y, half_x, half_y)
            lower = under & ((self._under < 0) | (self._under > plan.level_of[foot]))
            self._under[lower] = plan.level_of[foot]

    def cover(self, level: int) -> Iterator[tuple[float, float, float, float]]:
        """Rectangles that cover what belongs to a level, as large as they come."""
        xs, ys = self._lines
        xmin, ymin, xmax, ymax = self._borders[level]
        columns, rows = (lines[:-1] + lines[1:] for lines in self._lines)
        inside = ((columns > 2 * xmin) & (columns < 2 * xmax))[:, None] & ((rows > 2 * ymin) & (rows < 2 * ymax))
        free = self._free | (self._under == level)
        allowed = inside & ((self._owner == level) | free) & ((self._under < 0) | (self._under == level))
        wanted = allowed & (self._owner == level) & ~free
        left = wanted.copy()
        for i, j in np.argwhere(wanted):
            if not left[i, j]:
                continue
            found = [_grown(allowed, i, j, order) for order in ((0, 1), (1, 0))]
            a, b, c, d = max(found, key=lambda r: int(left[r[0] : r[2], r[1] : r[3]].sum()))
            left[a:c, b:d] = False
            # What was free is this level's now.
            self._free[a:c, b:d] = False
            self._owner[a:c, b:d] = level
            yield float(xs[a]), float(ys[b]), float(xs[c]), float(ys[d])


def _grown(allowed: NDArray[np.bool_], i: int, j: int, order: tuple[int, int]) -> tuple[int, int, int, int]:
    """The rectangle that a cell grows to, first along one axis as far as it goes, then along the other."""
    low, high = [int(i), int(j)], [int(i) + 1, int(j) + 1]
    for axis in order:
        flags = allowed[:, low[1] : high[1]] if axis == 0 else allowed[low[0] : high[0], :]
        fine = np.all(flags, axis=1 - axis).tolist()
        while low[axis] > 0 and fine[low[axis] - 1]:
            low[axis] -= 1
        while high[axis] < len(fine) and fine[high[axis]]:
            high[axis] += 1
    return low[0], low[1], high[0], high[1]


def _bounds(points: Sequence[Point], margin: float) -> tuple[float, float, float, float]:
    x, y = zip(*points, strict=True)
    return min(x) - margin, min(y) - margin, max(x) + margin, max(y) + margin


def _lines(
    borders: Sequence[tuple[float, float, float, float]], ramps: Sequence[Ramp]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The grid's lines across each axis."""
    marks: tuple[set[float], set[float]] = (set(), set())
    for xmin, ymin, xmax, ymax in borders:
        marks[0].update((xmin, xmax))
        marks[1].update((ymin, ymax))
    area = math.prod(max(some) - min(some) for some in marks)
    cell = max(_CELL, math.sqrt(area / _MOST_CELLS))
    for ramp in ramps:
        c, s = math.cos(ramp.yaw), math.sin(ramp.yaw)
        if min(abs(c), abs(s)) < 1e-9:
            along, across = (0, 1) if abs(c) > abs(s) else (1, 0)
            ends = ((ramp.x0, ramp.x1), (ramp.y0, ramp.y1))
            marks[along].update(ends[along])
            marks[across].update((ends[across][0] - ramp.half_width, ends[across][0] + ramp.half_width))
    return _filled(sorted(marks[0]), cell), _filled(sorted(marks[1]), cell)


def _filled(marks: list[float], cell: float) -> NDArray[np.float64]:
    lines = [marks[0]]
    for mark in marks[1:]:
        if mark - lines[-1] > 1e-6:
            start, parts = lines[-1], math.ceil((mark - lines[-1]) / cell)
            lines += [start + (mark - start) * k / parts for k in range(1, parts)]
            lines.append(mark)
    return np.array(lines)


def _distances(plan: Plan, level: int, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of each cell from the nearest node or edge of a level, metres; infinite far from all of them."""
    away = np.full((len(x), len(y)), np.inf)
    reach = plan.margin + _LANE + _EITHER
    places = plan.places
    ways = [(node, node) for node in plan.levels[level][1]]
    ways += [(i, j) for i, j in plan.lanes if plan.level_of[i] == level]
    for i, j in ways:
        (x0, y0), (x1, y1) = places[i], places[j]
        near = _window(x, y, min(x0, x1) - reach, min(y0, y1) - reach, max(x0, x1) + reach, max(y0, y1) + reach)
        dx, dy = x[near[0], None] - x0, y[None, near[1]] - y0
        length = math.hypot(x1 - x0, y1 - y0)
        if length > 0.0:
            c, s = (x1 - x0) / length, (y1 - y0) / length
            along = np.clip(c * dx + s * dy, 0.0, length)
            dx, dy = dx - c * along, dy - s * along
        away[near] = np.minimum(away[near], np.hypot(dx, dy))
    for node, n in plan.pit_at.items():
        if plan.level_of[node] == level:
            _claim(away, plan.pits[n], x, y)
    return away


def _claim(away: NDArray[np.float64], pit: Pit, x: NDArray[np.float64], y: NDArray[np.float64]) -> None:
    """A pit's walls and its frame are its level's too, whoever comes near."""
    for centre_x, centre_y, yaw, half_u, half_v in pit.rectangles(WALL):
        far = math.hypot(half_u, half_v) + 2 * CELL_CENTRE
        near = _window(x, y, centre_x - far, centre_y - far, centre_x + far, centre_y + far)
        dx, dy = x[near[0], None] - centre_x, y[None, near[1]] - centre_y
        c, s = math.cos(yaw), math.sin(yaw)
        within = np.abs(c * dx + s * dy) <= half_u + CELL_CENTRE
        within &= np.abs(-s * dx + c * dy) <= half_v + CELL_CENTRE
        away[near] = np.where(within, 0.0, away[near])


def _window(
    x: NDArray[np.float64], y: NDArray[np.float64], xmin: float, ymin: float, xmax: float, ymax: float
) -> tuple[slice, slice]:
    return slice(*np.searchsorted(x, (xmin, xmax))), slice(*np.searchsorted(y, (ymin, ymax)))


def _under(
    ramp: Ramp,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    half_x: NDArray[np.float64],
    half_y: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """The cells that a ramp lies over: beyond its creases none, beside it none that stick out.

    A cell that sticks out beside a ramp goes to the level there, so that no groove is left between the two; one that
    sticks out beyond its upper crease lies under the landing.
    """
    c, s = math.cos(ramp.yaw), math.sin(ramp.yaw)
    dx, dy = x[:, None] - ramp.x0, y[None, :] - ramp.y0
    along, across = c * dx + s * dy, np.abs(-s * dx + c * dy)
    reach_along = abs(c) * half_x[:, None] + abs(s) * half_y[None, :]
    reach_across = abs(s) * half_x[:, None] + abs(c) * half_y[None, :]
    return (
        (along + reach_along > 1e-6)
        & (along - reach_along < ramp.length - 1e-6)
        & (across + reach_across <= ramp.half_width + 1e-6)
    )
