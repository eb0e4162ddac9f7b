"""The place: nodes, edges and heights that never change during a run, as flat arrays indexed by node."""

from __future__ import annotations

import math
from array import array
from dataclasses import dataclass, field
from functools import cached_property
from itertools import accumulate, chain
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    import networkx as nx

__all__ = ["Edges", "Topology"]


class Edges(NamedTuple):
    """The directed edges of a place in flat arrays; node i has those with the indices `first[i]` to `first[i + 1] - 1`.

    Attributes:
        first: The index of each node's first edge, and behind them the number of edges (nodes + 1 values).
        ends: The node that each edge leads to, ascending for each node.
        lengths: The length of each edge in the xy plane, graph units.
        rises: On a slope how much the end of the edge lies above its beginning, graph units; else 0.
    """

    first: array[int]
    ends: array[int]
    lengths: array[float]
    rises: array[float]


@dataclass(frozen=True, eq=False, repr=False)
class Topology:
    """An undirected graph in space; nodes are counted from 0, `ids` holds their numbers in the scenario file.

    Attributes:
        ids: The number of each node in the scenario file.
        x: East coordinate of each node, graph units.
        y: North coordinate of each node, graph units.
        z: Height of each node's bare surface, graph units; of a hole, its floor.
        neighbours: For each node its neighbours in ascending order.
        lengths: For each node the lengths of its edges in the xy plane, in the order of `neighbours`.
        rises: For a slope edge (i, j), in both directions, how much j lies above i.
    """

    ids: tuple[int, ...]
    x: tuple[float, ...]
    y: tuple[float, ...]
    z: tuple[float, ...]
    neighbours: tuple[tuple[int, ...], ...]
    lengths: tuple[tuple[float, ...], ...]
    rises: Mapping[tuple[int, int], float] = field(default_factory=dict)

    @classmethod
    def build(
        cls,
        ids: Sequence[int],
        positions: Sequence[tuple[float, float, float]],
        edges: Iterable[tuple[int, int]],
        slopes: Iterable[tuple[int, int]] = (),
    ) -> Topology:
        """Builds the arrays from positions (x, y, z) and edges, both given by index.

        Args:
            ids: The number of each node in the scenario file.
            positions: x, y, z of each node.
            edges: Pairs of indices; order and repetitions do not matter.
            slopes: Edges whose difference of height is a ramp that can be travelled.
        """
        x = tuple(float(p[0]) for p in positions)
        y = tuple(float(p[1]) for p in positions)
        z = tuple(float(p[2]) for p in positions)
        joined: list[list[int]] = [[] for _ in ids]
        # One object for each node, not one for each edge; where its number is its index, the one that is there already.
        nodes = [number if number == node else node for node, number in enumerate(ids)]
        for i, j in edges:
            joined[i].append(nodes[j])
            joined[j].append(nodes[i])
        neighbours = tuple(tuple(sorted(set(others))) for others in joined)
        del joined
        lengths = tuple(
            tuple(math.sqrt((x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2) for j in others)
            for i, others in enumerate(neighbours)
        )
        rises: dict[tuple[int, int], float] = {}
        for i, j in slopes:
            rises[i, j] = z[j] - z[i]
            rises[j, i] = z[i] - z[j]
        return cls(tuple(ids), x, y, z, neighbours, lengths, rises)

    def __repr__(self) -> str:
        return f"<Topology: {len(self)} nodes, {self.edge_count} edges>"

    def __len__(self) -> int:
        return len(self.ids)

    @cached_property
    def index(self) -> dict[int, int]:
        """From a node's number in the scenario file to its index."""
        return {node_id: node for node, node_id in enumerate(self.ids)}

    @cached_property
    def edges(self) -> Edges:
        """All directed edges in four flat arrays; made when first asked for."""
        rises = self.rises
        return Edges(
            array("i", accumulate(map(len, self.neighbours), initial=0)),
            array("i", chain.from_iterable(self.neighbours)),
            array("d", chain.from_iterable(self.lengths)),
            array("d", (rises.get((i, j), 0.0) for i, others in enumerate(self.neighbours) for j in others)),
        )

    @cached_property
    def most_neighbours(self) -> int:
        """How many neighbours a node has at most."""
        return max(map(len, self.neighbours), default=0)

    @cached_property
    def edge_count(self) -> int:
        """The number of undirected edges."""
        return sum(len(others) for others in self.neighbours) // 2

    @cached_property
    def mean_length(self) -> float:
        """The mean length of an edge, graph units; 1 where there are no edges."""
        count = 2 * self.edge_count
        return sum(map(sum, self.lengths)) / count if count else 1.0

    def length(self, i: int, j: int) -> float:
        """The length of the edge i-j in the xy plane.

        Raises:
            ValueError: The two nodes are not neighbours.
        """
        return self.lengths[i][self.neighbours[i].index(j)]

    def distance(self, i: int, j: int) -> float:
        """Euclidean distance of two nodes in the xy plane, whether they are neighbours or not."""
        return math.sqrt((self.x[i] - self.x[j]) ** 2 + (self.y[i] - self.y[j]) ** 2)

    @cached_property
    def graph(self) -> nx.Graph[int]:
        """The same place as a NetworkX graph, keyed by the scenario's numbers (pos, z; length, rise)."""
        import networkx as nx

        graph: nx.Graph[int] = nx.Graph()
        for i, node_id in enumerate(self.ids):
            graph.add_node(node_id, pos=(self.x[i], self.y[i]), z=self.z[i])
        for i, others in enumerate(self.neighbours):
            for j, length in zip(others, self.lengths[i], strict=True):
                if i < j:
                    rise = self.rises.get((i, j), 0.0)
                    graph.add_edge(self.ids[i], self.ids[j], length=length, rise=rise)
        return graph
