"""Which things lie within a radius: a grid of square cells, so that a query costs what lies near, not what exists."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Cells"]


class Cells:
    """Numbered things at points in the plane, found by radius.

    Args:
        radius: The only radius that will be asked for; also the side of a cell.
        x: East coordinate of each node.
        y: North coordinate of each node.
    """

    __slots__ = ("_cells", "_node", "_radius", "_side", "_x", "_y")

    def __init__(self, radius: float, x: Sequence[float], y: Sequence[float]) -> None:
        self._radius = radius
        # A cell side below any useful length would only make empty cells to look through.
        self._side = max(radius, 1e-6)
        self._x = x
        self._y = y
        self._cells: dict[tuple[int, int], set[int]] = {}
        self._node: dict[int, int] = {}

    def _cell(self, node: int) -> tuple[int, int]:
        return int(self._x[node] // self._side), int(self._y[node] // self._side)

    def put(self, thing: int, node: int) -> None:
        """Places `thing` on `node`, wherever it was before."""
        old = self._node.get(thing)
        if old is not None:
            self._cells[self._cell(old)].discard(thing)
        self._node[thing] = node
        self._cells.setdefault(self._cell(node), set()).add(thing)

    def near(self, node: int) -> list[int]:
        """The things within the radius of `node`, in ascending order."""
        cells = self._cells
        if not cells:
            return []
        column, row = self._cell(node)
        x, y = self._x[node], self._y[node]
        limit = self._radius * self._radius
        found = []
        for i in (column - 1, column, column + 1):
            for j in (row - 1, row, row + 1):
                for thing in cells.get((i, j), ()):
                    at = self._node[thing]
                    dx, dy = self._x[at] - x, self._y[at] - y
                    if dx * dx + dy * dy <= limit:
                        found.append(thing)
        found.sort()
        return found
