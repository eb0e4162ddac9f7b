"""A small map of a place with what is in it, for notebooks."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from colonysim.scenario.scenario import Scenario
    from colonysim.world.topology import Topology

__all__ = ["AGENT", "BOX", "GOAL", "HOLE", "draw_map", "map_at_start", "picture"]

SIZE, MARGIN, SMALLEST = 420.0, 14.0, 2.0
"""Longer side of the map, its margin and the least radius of a node, pixels."""
MOST_NODES = 3000
"""A larger place is told in words only."""
# From the Okabe-Ito palette, told apart with any colour vision; agents pink, boxes blue as in the paper.
AGENT, BOX, GOAL, HOLE = "#CC79A7", "#0072B2", "#009E73", "#3A3A3A"
EDGE, NODE, RIM, FILLED = "#BBBBBB", "#FFFFFF", "#888888", "#8FBBD9"


def picture(scenario: Scenario) -> str:
    """HTML of a scenario: its map at the start of an episode, and what it has."""
    told = f"<p>{html.escape(scenario.description)}</p>" if scenario.description else ""
    return f"<div>{map_at_start(scenario)}<p>{html.escape(repr(scenario)[1:-1])}</p>{told}</div>"


def map_at_start(scenario: Scenario) -> str:
    """HTML of the map at the start of an episode, as `draw_map` makes it."""
    holes = {hole.node: False for hole in scenario.holes}
    boxes = [box.node for box in scenario.boxes_at_start]
    agents = dict(enumerate(scenario.agents_at_start))
    return draw_map(scenario.topology, _edges(scenario.topology), holes, boxes, agents, scenario.goal)


def draw_map(
    topology: Topology,
    edges: Iterable[tuple[int, int]],
    holes: Mapping[int, bool],
    boxes: Iterable[int],
    agents: Mapping[int, int],
    goal: int,
) -> str:
    """HTML with one SVG: edges, nodes, holes, boxes, agents and the goal, and what the colours mean.

    Args:
        topology: The place; nodes are its indices.
        edges: Those that there are now.
        holes: For the node of each hole whether it is filled.
        boxes: The node of each box that is shown.
        agents: The node of each agent that is shown.
        goal: The goal.

    Returns:
        Nothing for a place of more than 3,000 nodes.
    """
    if not 0 < len(topology) <= MOST_NODES:
        return ""
    x0, y1 = min(topology.x), max(topology.y)
    wide, high = max(topology.x) - x0, y1 - min(topology.y)
    span = max(wide, high, 1e-9)
    scale = (SIZE - 2 * MARGIN) / span
    at = [
        (MARGIN + (x - x0) * scale, MARGIN + (y1 - y) * scale)
        for x, y in zip(topology.x, topology.y, strict=True)
    ]  # fmt: skip
    shortest = min((length for lengths in topology.lengths for length in lengths), default=span)
    radius = max(SMALLEST, min(9.0, 0.3 * scale * shortest))
    parts = [
        f'<line x1="{at[i][0]:.1f}" y1="{at[i][1]:.1f}" x2="{at[j][0]:.1f}" y2="{at[j][1]:.1f}" stroke="{EDGE}"/>'
        for i, j in edges
    ]
    for node, (x, y) in enumerate(at):
        title = f"<title>node {topology.ids[node]}</title>"
        if node in holes:
            parts.append(_square(x, y, radius, FILLED if holes[node] else HOLE, title))
        else:
            parts.append(_circle(x, y, 0.7 * radius, GOAL if node == goal else NODE, title))
    parts += [_square(*at[node], 0.75 * radius, BOX) for node in boxes]
    parts += [
        _circle(*at[node], 0.6 * radius, AGENT, f"<title>agent {agent}</title>") for agent, node in agents.items()
    ]
    width, height = 2 * MARGIN + scale * wide, 2 * MARGIN + scale * high
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" role="img">'
    return f"{svg}{''.join(parts)}</svg>{_legend(holes)}"


def _edges(topology: Topology) -> Iterable[tuple[int, int]]:
    return ((i, j) for i, others in enumerate(topology.neighbours) for j in others if i < j)


def _legend(holes: Mapping[int, bool]) -> str:
    words = {"agent": AGENT, "box": BOX, "hole": HOLE, "filled hole": FILLED, "goal": GOAL}
    if not any(holes.values()):
        del words["filled hole"]
    marks = (f'<span style="color: {color}">&#9632;</span> {word}' for word, color in words.items())
    return f'<p style="font-size: smaller">{" &nbsp; ".join(marks)}</p>'


def _circle(x: float, y: float, radius: float, color: str, title: str) -> str:
    return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="{color}" stroke="{RIM}">{title}</circle>'


def _square(x: float, y: float, half: float, color: str, title: str = "") -> str:
    side = 2 * half
    where = f'x="{x - half:.1f}" y="{y - half:.1f}" width="{side:.1f}" height="{side:.1f}"'
    return f'<rect {where} fill="{color}" stroke="{RIM}">{title}</rect>'
