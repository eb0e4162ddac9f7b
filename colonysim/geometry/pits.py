"""Pits for holes: where boxes will come from, how deep and which way the pits lie."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from colonysim.geometry.scale import BOX_HEIGHT, PIT_PLAY
from colonysim.geometry.trouble import Trouble
from colonysim.physics import Pit

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.physics import Terrain
    from colonysim.scenario.scenario import Scenario

__all__ = ["Ways", "heading", "pits_for", "pits_given", "ways_to_holes"]

_OFF_CENTRE = 0.1
"""A box is pushed to the node itself: with its pit further off than this it comes to lie on the rim, metres."""


@dataclass(frozen=True, slots=True)
class Ways:
    """Where boxes will go.

    Attributes:
        first: For each box's node, the first edge (from, to) of its way to the nearest hole.
        last: For each hole's node, the last edge (from, to) of the shortest way of a box into it.
    """

    first: dict[int, tuple[int, int]]
    last: dict[int, tuple[int, int]]


def ways_to_holes(scenario: Scenario) -> Ways:
    """Shortest ways from each box to each hole over edges that allow a push, through no other hole."""
    topology = scenario.topology
    holes = {hole.node for hole in scenario.holes}
    standing = {box.node for box in scenario.boxes}
    first: dict[int, tuple[int, int]] = {}
    best: dict[int, float] = {}
    last: dict[int, tuple[int, int]] = {}
    for box in scenario.boxes:
        queue: list[tuple[float, int, int, int]] = [(0.0, box.node, -1, -1)]
        seen: set[int] = set()
        while queue:
            far, node, before, start = heapq.heappop(queue)
            if node in seen:
                continue
            seen.add(node)
            if node in holes:
                if far < best.get(node, math.inf):
                    best[node], last[node] = far, (before, node)
                first.setdefault(box.node, (box.node, start))
                continue
            for j, length in zip(topology.neighbours[node], topology.lengths[node], strict=True):
                if (node, j) not in scenario.no_push and j not in seen:
                    # Going round another box is a detour that only pays where there is no other way.
                    detour = 100.0 if j in standing else 0.0
                    heapq.heappush(queue, (far + length + detour, j, node, j if start < 0 else start))
    return Ways(first, last)


def heading(places: Sequence[tuple[float, float]], i: int, j: int) -> float:
    """Which way node `j` lies from node `i`, radians; 0 if either is no node (-1)."""
    if j < 0 or i < 0:
        return 0.0
    return math.atan2(places[j][1] - places[i][1], places[j][0] - places[i][0])


def pits_for(
    scenario: Scenario,
    physics: Mapping[str, Any],
    places: Sequence[tuple[float, float]],
    heights: Sequence[float],
    box_heights: Sequence[float],
    ways: Ways,
    length: float,
    z_scale: float,
) -> tuple[list[Pit], dict[int, int]]:
    """A pit around each hole, whole boxes deep and square to the last edge of a box's way into it.

    Returns:
        The pits, and for each hole's node the index of its pit.

    Raises:
        Trouble: A pit is no wider than a box.
    """
    side = float(physics.get("pit_side") or length + PIT_PLAY)
    if side <= length:
        needed = math.hypot(length, max(box_heights, default=0.0))
        words = "a pit of {:g} m takes no box of {:g} m, expected at least {:.4g} m"
        raise Trouble("physics.pit_side", words, side, length, needed)
    unit = min(box_heights, default=BOX_HEIGHT)
    pits: list[Pit] = []
    pit_at: dict[int, int] = {}
    for hole in scenario.holes:
        layers = max(1, round(hole.depth * z_scale / unit))
        before, node = ways.last.get(hole.node, (-1, hole.node))
        if before < 0:
            before = scenario.topology.neighbours[node][0] if scenario.topology.neighbours[node] else -1
        yaw = heading(places, before, node)
        pit_at[hole.node] = len(pits)
        pits.append(Pit(*places[hole.node], yaw, side, heights[hole.node], layers * unit))
    return pits, pit_at


def pits_given(scenario: Scenario, places: Sequence[tuple[float, float]], terrain: Terrain) -> dict[int, int]:
    """For each hole's node the given pit around it.

    Raises:
        Trouble: There is none around one of them.
    """
    pit_at: dict[int, int] = {}
    for hole in scenario.holes:
        x, y = places[hole.node]
        around = [i for i, pit in enumerate(terrain.pits) if pit.contains(x, y)]
        if not around:
            name = scenario.topology.ids[hole.node]
            raise Trouble("physics.terrain.pits", f"no pit at the hole {name} ({{:.2f}}, {{:.2f}} m)", x, y)
        pit = terrain.pits[around[0]]
        if (off := math.dist((x, y), (pit.x, pit.y))) > _OFF_CENTRE:
            words = f"the pit of hole {scenario.topology.ids[hole.node]} lies {{:.2f}} m off its node"
            raise Trouble("physics.terrain.pits", f"{words}, expected at most {{:.2f}} m", off, _OFF_CENTRE)
        pit_at[hole.node] = around[0]
    return pit_at
