"""A small map of a colony as it is now, for notebooks."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from colonysim.simulation.colony import Colony

__all__ = ["picture"]

SIZE, MARGIN, SMALLEST = 420.0, 14.0, 2.0
"""Longer side of the map, its margin and the least radius of a node, pixels."""
MOST_NODES = 3000
"""A larger place is told in words only."""
EDGE, NODE, HOLE, FILLED, BOX, AGENT, GOAL = "#bbb", "#fff", "#333", "#c9a66b", "#b5651d", "#0072b2", "#009e73"


def picture(colony: Colony) -> str:
    """HTML with one SVG: edges, holes (black), boxes (brown), agents (blue, numbered) and the goal (green)."""
    words = f"<p>{html.escape(repr(colony)[1:-1])}</p>"
    place = colony.world
    if not 0 < len(place) <= MOST_NODES:
        return words
    xy = place.position[:, :2]
    low, span = xy.min(axis=0), max(float((xy.max(axis=0) - xy.min(axis=0)).max()), 1e-9)
    scale = (SIZE - 2 * MARGIN) / span
    at = {
        int(node): (MARGIN + (x - low[0]) * scale, MARGIN + (xy[:, 1].max() - y) * scale)
        for node, (x, y) in zip(place.node, xy, strict=True)
    }
    lengths = [length for lengths in colony.scenario.topology.lengths for length in lengths]
    radius = max(SMALLEST, min(9.0, 0.3 * scale * (min(lengths) if lengths else span)))
    width, height = (2 * MARGIN + scale * float(side) for side in xy.max(axis=0) - low)
    parts = [
        f'<line x1="{at[i][0]:.1f}" y1="{at[i][1]:.1f}" x2="{at[j][0]:.1f}" y2="{at[j][1]:.1f}" stroke="{EDGE}"/>'
        for i, j in place.graph.edges
    ]
    filled = dict(zip(place.holes.tolist(), place.filled.tolist(), strict=True))
    for node, (x, y) in at.items():
        if node in filled:
            color = FILLED if filled[node] else HOLE
            parts.append(_square(x, y, radius, color))
        else:
            color = GOAL if node == place.goal else NODE
            parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{0.7 * radius:.1f}" fill="{color}" stroke="#888"/>')
    for node in colony.boxes.node.tolist():
        if node >= 0 and not filled.get(node):
            parts.append(_square(*at[node], 0.75 * radius, BOX))
    for agent, (node, status) in enumerate(zip(colony.agents.node.tolist(), colony.agents.status, strict=True)):
        if status not in ("goal", "absent"):
            x, y = at[node]
            where = f'cx="{x:.1f}" cy="{y:.1f}" r="{0.6 * radius:.1f}"'
            parts.append(f'<circle {where} fill="{AGENT}"><title>agent {agent}</title></circle>')
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" role="img">'
    return f"<div>{svg}{''.join(parts)}</svg>{words}</div>"


def _square(x: float, y: float, half: float, color: str) -> str:
    side = 2 * half
    return f'<rect x="{x - half:.1f}" y="{y - half:.1f}" width="{side:.1f}" height="{side:.1f}" fill="{color}"/>'
