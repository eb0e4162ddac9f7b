"""What ground is derived from: the graph at one scale, its levels, and where in the file each part stands."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.physics import BoxSpec, Pit
    from colonysim.scenario.scenario import Scenario

__all__ = ["SAME_LEVEL", "Plan", "Point", "edge_path", "node_path"]

SAME_LEVEL = 0.02
"""Nodes whose heights differ by less lie on one level, metres."""

Point = tuple[float, float]


@dataclass(frozen=True)
class Plan:
    """The graph in units of the robot.

    Attributes:
        scenario: Whose graph it is.
        scale: How long a graph unit is in the plane.
        z_scale: How high one is.
        heights: Height of each node's ground, of a hole its rim.
        pits: The pits at this scale.
        pit_at: For each hole's node the index of its pit.
        boxes: The boxes where they start, at this scale.
        margin: How far ground reaches beyond the outermost nodes of a level.
        half_width: Half the width of a ramp that has room.
    """

    scenario: Scenario
    scale: float
    z_scale: float
    heights: tuple[float, ...]
    pits: tuple[Pit, ...]
    pit_at: Mapping[int, int]
    boxes: tuple[BoxSpec, ...]
    margin: float
    half_width: float

    def at_scale(self, scale: float) -> Plan:
        """The same with other distances in the plane."""
        share = scale / self.scale
        pits = tuple(replace(pit, x=share * pit.x, y=share * pit.y) for pit in self.pits)
        boxes = tuple(replace(box, x=share * box.x, y=share * box.y) for box in self.boxes)
        return replace(self, scale=scale, pits=pits, boxes=boxes)

    @cached_property
    def places(self) -> tuple[Point, ...]:
        """x, y of each node."""
        topology = self.scenario.topology
        return tuple((self.scale * x, self.scale * y) for x, y in zip(topology.x, topology.y, strict=True))

    @cached_property
    def levels(self) -> tuple[tuple[float, tuple[int, ...]], ...]:
        """Height and nodes of each level, the lowest first."""
        levels: list[tuple[float, list[int]]] = []
        for node in sorted(range(len(self.heights)), key=lambda node: self.heights[node]):
            if levels and self.heights[node] - levels[-1][0] < SAME_LEVEL:
                levels[-1][1].append(node)
            else:
                levels.append((self.heights[node], [node]))
        return tuple((height, tuple(nodes)) for height, nodes in levels)

    @cached_property
    def level_of(self) -> tuple[int, ...]:
        """The index of each node's level."""
        found = [0] * len(self.heights)
        for level, (_, nodes) in enumerate(self.levels):
            for node in nodes:
                found[node] = level
        return tuple(found)

    @cached_property
    def lanes(self) -> tuple[tuple[int, int], ...]:
        """The edges (i, j), i < j, between nodes of one level."""
        neighbours, level = self.scenario.topology.neighbours, self.level_of
        return tuple((i, j) for i, others in enumerate(neighbours) for j in others if i < j and level[i] == level[j])

    @cached_property
    def slopes(self) -> tuple[tuple[int, int], ...]:
        """The slopes (foot, top) that rise."""
        level = self.level_of
        return tuple(sorted(edge for edge in self.scenario.topology.rises if level[edge[0]] < level[edge[1]]))

    def named(self, *nodes: int) -> str:
        """Nodes as their file calls them, joined by a dash."""
        return "-".join(str(self.scenario.topology.ids[node]) for node in nodes)


def node_path(scenario: Scenario, node: int) -> str:
    """The field that says where a node is."""
    return f"nodes.{node}" if scenario.document.get("nodes") is not None else "topology"


def edge_path(scenario: Scenario, i: int, j: int) -> str:
    """The field that joins two nodes: a slope or a listed edge, else what makes the edges."""
    ids, document = scenario.topology.ids, scenario.document
    edges = document.get("edges")
    listed: list[tuple[str, Sequence[Sequence[int]]]] = [("slopes", document.get("slopes") or ())]
    if isinstance(edges, dict):
        listed.append(("edges.include", edges.get("include") or ()))
    else:
        listed.append(("edges", edges or ()))
    for field, pairs in listed:
        for n, pair in enumerate(pairs):
            if {ids[i], ids[j]} == set(pair):
                return f"{field}.{n}"
    if isinstance(edges, dict):
        return "edges.radius"
    return "topology"
