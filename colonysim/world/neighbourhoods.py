# cython: boundscheck=False, wraparound=False, initializedcheck=False, auto_pickle=False
"""Neighbourhood index: for each node of a topology the nodes within a radius, computed once for each topology."""

from __future__ import annotations

from array import array
from itertools import accumulate
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

if TYPE_CHECKING:
    from colonysim.world.topology import Topology

__all__ = ["Neighbourhoods", "neighbourhoods"]

ROOM = 1 << 24
"""If all neighbourhoods have more nodes than this together (64 MB), they are not stored but computed when needed."""

_KNOWN: WeakKeyDictionary[Topology, dict[float, Neighbourhoods]] = WeakKeyDictionary()
"""For each topology, by radius, the few indices that were made last."""
MOST = 4
"""No more are kept for a topology."""


def neighbourhoods(topology: Topology, radius: float) -> Neighbourhoods:
    """The neighbourhood index of a topology; the same object until some other radii have been asked for.

    Args:
        topology: The place.
        radius: The radius, graph units.
    """
    known = _KNOWN.setdefault(topology, {})
    found = known.pop(radius, None)
    known[radius] = found = Neighbourhoods(topology, radius) if found is None else found
    if len(known) > MOST:
        del known[next(iter(known))]
    return found


class Neighbourhoods:
    """For each node the nodes within a radius in the xy plane, the node itself among them.

    Nodes are sorted into square cells whose side is the radius, so that only a node's own cell and the eight around it
    have to be searched.

    Args:
        topology: The place.
        radius: The radius, graph units.
        room: If all neighbourhoods have more nodes than this together, they are not stored.

    Attributes:
        radius: The radius, graph units.
        x: East coordinate of each node, graph units.
        y: North coordinate of each node, graph units.
        limit: The radius squared.
        most: An upper bound of the number of nodes within the radius of any node.
        kept: Whether the neighbourhoods are stored in `first` and `nodes`; `gather` answers either way.
        first: The neighbourhood of node i is `nodes[first[i]]` to `nodes[first[i + 1] - 1]`.
        nodes: All neighbourhoods, one after the other.
    """

    def __init__(self, topology: Topology, radius: float, room: int = ROOM) -> None:
        size = len(topology)
        self.radius = radius
        self.x, self.y, self.limit = array("d", topology.x), array("d", topology.y), radius * radius
        self.most = self._fill_cells(size, max(radius, 1e-6))
        self.first, self.nodes, self.kept = array("i", bytes(4 * size + 4)), array("i"), True
        self._gather_all(size, room)

    def _fill_cells(self, size: int, side: float) -> int:
        """Sorts the nodes into cells; returns the largest number of nodes in a cell and the eight around it."""
        cells: dict[tuple[int, int], int] = {}
        self._cell, sizes = array("i", bytes(4 * size)), array("i", bytes(4 * size + 4))
        for node in range(size):
            place = (int(self.x[node] // side), int(self.y[node] // side))
            cell = self._cell[node] = cells.setdefault(place, len(cells))
            sizes[cell + 1] += 1
        # The nodes cell by cell, and for each cell itself and those around it that have nodes.
        filled = array("i", accumulate(sizes[: len(cells) + 1]))
        self._members_first, self._members = array("i", filled), array("i", bytes(4 * size))
        for node in range(size):
            cell = self._cell[node]
            self._members[filled[cell]] = node
            filled[cell] += 1
        beside, ends, most = array("i"), [0], 0
        for column, row in cells:
            count = 0
            for i in range(column - 1, column + 2):
                for j in range(row - 1, row + 2):
                    cell = cells.get((i, j), -1)
                    if cell >= 0:
                        beside.append(cell)
                        count += sizes[cell + 1]
            ends.append(len(beside))
            most = max(most, count)
        self._beside_first, self._beside = array("i", ends), beside
        return most

    def _gather_all(self, size: int, room: int) -> None:
        """Fills `first` and `nodes`, unless that takes more than `room` nodes."""
        found, nodes, total = array("i", bytes(4 * self.most)), array("i"), 0
        for node in range(size):
            count = self.gather(node, found)
            total += count
            if total > room:
                self.kept, nodes = False, array("i")
                break
            nodes.extend(found[:count])
            self.first[node + 1] = total
        self.nodes = nodes

    def gather(self, node: int, found: array[int]) -> int:
        """Writes the nodes within the radius of a node into `found`; returns how many there are."""
        x, y, limit, cell, count = self.x[node], self.y[node], self.limit, self._cell[node], 0
        for k in range(self._beside_first[cell], self._beside_first[cell + 1]):
            other = self._beside[k]
            for m in range(self._members_first[other], self._members_first[other + 1]):
                j = self._members[m]
                dx, dy = self.x[j] - x, self.y[j] - y
                if dx * dx + dy * dy <= limit:
                    found[count] = j
                    count += 1
        return count

    def both(self, i: int, j: int) -> bool:
        """Whether two nodes lie within the radius of each other."""
        dx, dy = self.x[i] - self.x[j], self.y[i] - self.y[j]
        return dx * dx + dy * dy <= self.limit
