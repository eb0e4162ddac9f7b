# cython: boundscheck=False, wraparound=False, initializedcheck=False, auto_pickle=False
"""The rules of heights: along which edges an agent can travel and a box can be pushed."""

from __future__ import annotations

from array import array
from math import isnan, nan
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    from colonysim.scenario.scenario import Scenario

__all__ = ["SAME_HEIGHT", "Terrain"]

SAME_HEIGHT = 1e-6
"""Heights are sums of the scenario's numbers: below this they are equal."""


class Terrain:
    """The edges of the graph and the surfaces of its nodes, in flat arrays.

    The edges out of node i have the indices `first[i]` to `first[i + 1] - 1`. `surface` changes when a box is moved,
    and where the scenario has a timeline `rises` too: that of an edge which is not there is no number, so that no rule
    of heights lets anything pass.

    Args:
        scenario: Its place and rules.
        surface: The height of each node's surface with the boxes on it, graph units; the world's own array.

    Attributes:
        first: The index of each node's first edge, and behind them the number of edges (nodes + 1 values).
        ends: The node that each edge leads to.
        lengths: The length of each edge, graph units in the xy plane.
        rises: How much each edge rises if it is a slope, graph units; 0 for others, nan for edges that are not there.
        surface: The array given.
        reach: Heights that differ by less than this are level, graph units.
        size: The number of nodes.
    """

    def __init__(self, scenario: Scenario, surface: array[float]) -> None:
        topology = self._topology = scenario.topology
        self.first, self.ends, self.lengths, self.rises = topology.edges
        self.surface, self.reach, self.size = surface, scenario.reach, len(topology)
        self._slack = SAME_HEIGHT
        self._forbidden = bytearray(len(self.ends))
        for i, j in scenario.no_push:
            edge = self.edge(i, j)
            if edge >= 0:
                self._forbidden[edge] = 1
        self._slopes, self._absent = topology.rises, scenario.newcomers.edges if scenario.newcomers else ()
        if scenario.changes:
            self.own_edges()
            self.restore()

    def own_edges(self) -> None:
        """Has edges come and go here only: those of the topology are everybody's."""
        self.rises = array("d", bytes(self.rises))

    def restore(self) -> None:
        """Puts the edges back as they are at the start of an episode."""
        for edge, rise in enumerate(self._topology.edges.rises):
            self.rises[edge] = rise
        for i, j in self._absent:
            self.take_edge(i, j)

    def has_edge(self, i: int, j: int) -> bool:
        """Whether there is an edge from `i` to `j` now."""
        edge = self.edge(i, j)
        return edge >= 0 and not isnan(self.rises[edge])

    def taken(self) -> list[tuple[int, int]]:
        """The edges (i, j), i < j, that are not there now."""
        return [
            (i, self.ends[edge])
            for i in range(self.size)
            for edge in range(self.first[i], self.first[i + 1])
            if i < self.ends[edge] and isnan(self.rises[edge])
        ]

    def shape(self, floor: array[float], taken: Iterable[tuple[int, int]]) -> None:
        """Lets slopes rise as the nodes' bare surfaces say, and takes edges away; all others are there."""
        for i in range(self.size):
            for edge in range(self.first[i], self.first[i + 1]):
                if i < self.ends[edge]:
                    self.give_edge(i, self.ends[edge], floor)
        for i, j in taken:
            self.take_edge(i, j)

    def take_edge(self, i: int, j: int) -> None:
        """Takes the edge between two nodes away, in both directions."""
        self.rises[self.edge(i, j)] = self.rises[self.edge(j, i)] = nan

    def give_edge(self, i: int, j: int, floor: array[float]) -> None:
        """Puts the edge between two nodes back; if it is a slope, it rises as the nodes' bare surfaces now say."""
        rise = floor[j] - floor[i] if (i, j) in self._slopes else 0.0
        self.rises[self.edge(i, j)], self.rises[self.edge(j, i)] = rise, -rise

    def lean(self, node: int, floor: array[float]) -> None:
        """Lets the slopes at a node rise as the nodes' bare surfaces now say."""
        for edge in range(self.first[node], self.first[node + 1]):
            j = self.ends[edge]
            if (node, j) in self._slopes and self.has_edge(node, j):
                self.give_edge(node, j, floor)

    def edge(self, i: int, j: int) -> int:
        """The index of the edge from `i` to `j`, or -1.

        Raises:
            IndexError: There is no node `i`.
        """
        if not 0 <= i < self.size:
            raise IndexError(f"there is no node {i}")
        for edge in range(self.first[i], self.first[i + 1]):
            if self.ends[edge] == j:
                return edge
        return -1

    def is_level(self, difference: float) -> bool:
        """The height rule: whether two heights differ by less than `reach`, a slope's rise being taken off already."""
        return -self.reach < difference < self.reach

    def leads(self, level: float, edge: int) -> bool:
        """Whether an agent that stands at height `level` can travel along an edge."""
        return self.is_level(self.surface[self.ends[edge]] - level - self.rises[edge])

    def slides(self, base: float, edge: int) -> bool:
        """Whether a box whose underside is at height `base` may be pushed along an edge.

        The surface at its end may not be above the base, and the scenario may forbid the edge.
        """
        return not self._forbidden[edge] and self.surface[self.ends[edge]] <= base + self.rises[edge] + self._slack

    def falls(self, base: float, edge: int) -> bool:
        """Whether a box that is pushed along an edge would drop at its end, by `reach` or more."""
        return base + self.rises[edge] - self.surface[self.ends[edge]] >= self.reach
