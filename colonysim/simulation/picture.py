"""A small map of a colony as it is now, for notebooks."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

from colonysim.scenario.picture import draw_map

if TYPE_CHECKING:
    from colonysim.simulation.colony import Colony

__all__ = ["picture"]


def picture(colony: Colony) -> str:
    """HTML of a colony: the map with what is where, and how far it has come."""
    place, topology = colony.world, colony.scenario.topology
    index = topology.index
    holes = {index[node]: filled for node, filled in zip(place.holes.tolist(), place.filled.tolist(), strict=True)}
    boxes = [index[node] for node in colony.boxes.node.tolist() if node >= 0]
    where = zip(colony.agents.node.tolist(), colony.agents.status.tolist(), strict=True)
    agents = {n: index[node] for n, (node, status) in enumerate(where) if status not in ("goal", "absent")}
    edges = [(index[i], index[j]) for i, j in place.graph.edges]
    shown = [node for node in boxes if not holes.get(node)]
    place_now = draw_map(topology, edges, holes, shown, agents, index[place.goal])
    return f"<div>{place_now}<p>{html.escape(repr(colony)[1:-1])}</p></div>"
