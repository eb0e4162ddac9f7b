"""A colony seen from above as an image, drawn by the processor alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from colonysim.canvas import Canvas, colour_of
from colonysim.scenario.picture import AGENT, BOX, EDGE, FILLED, GOAL, HOLE, NODE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from colonysim.canvas import Point
    from colonysim.simulation import Colony

__all__ = ["FPS", "SIZE", "picture"]

FPS = 10
"""Most decisions a second that a window shows."""

SIZE = 480
"""Pixels of the longer side."""
_LOW, _HIGH = np.array(colour_of("#C7C2B5")), np.array(colour_of(NODE))
_AGENT, _BOX, _GOAL, _HOLE, _FILLED, _EDGE = map(colour_of, (AGENT, BOX, GOAL, HOLE, FILLED, EDGE))
_ASKED, _GONE = colour_of("#E69F00"), colour_of("#B9AEB5")
"""A ring around an agent that has to decide, and an agent that will not go on: it is lost, or has no steps left."""


def picture(colony: Colony) -> NDArray[np.uint8]:
    """The place, and where boxes and agents are: an agent that is under way on the node that it comes from.

    Ground is the lighter the higher it lies; boxes in holes are as light as the holes that they have filled.

    Args:
        colony: The colony.

    Returns:
        Red, green and blue of each pixel; the longer side has `SIZE` pixels.
    """
    topology, graph = colony.scenario.topology, colony.world.graph
    points = {node: (x, y) for node, x, y in zip(topology.ids, topology.x, topology.y, strict=True)}
    unit = min((length for lengths in topology.lengths for length in lengths), default=1.0)
    where = np.array([*points.values()])
    low, high = where.min(axis=0) - 0.6 * unit, where.max(axis=0) + 0.6 * unit
    pixel = float((high - low).max()) / (2 * SIZE)  # at twice the size, and then halved
    width, height = (2 * round(side / pixel / 2) for side in (high - low).tolist())
    x, y = ((low + high) / 2).tolist()
    canvas = Canvas((x, y), pixel, width, height)
    for one, other in graph.edges:
        canvas.line(points[one], points[other], max(0.05 * unit, 2 * pixel), _EDGE)
    _draw_nodes(canvas, colony, {node: graph.nodes[node]["z"] for node in graph}, points, unit)
    _draw_boxes(canvas, colony, unit)
    _draw_agents(canvas, colony, unit)
    return canvas.halved()


def _draw_nodes(
    canvas: Canvas, colony: Colony, heights: dict[int, float], points: dict[int, Point], unit: float
) -> None:
    """Ground, holes and the goal."""
    place = colony.world
    holes = dict(zip(place.holes.tolist(), place.filled.tolist(), strict=True))
    ground = [z for node, z in heights.items() if node not in holes]
    low, rise = min(ground, default=0.0), max(ground, default=0.0) - min(ground, default=0.0)
    for node, point in points.items():
        if node in holes:
            canvas.square(point, 0.62 * unit, _FILLED if holes[node] else _HOLE)
            continue
        share = (heights[node] - low) / rise if rise > 0.0 else 1.0
        red, green, blue = (_LOW + share * (_HIGH - _LOW)).round().astype(int).tolist()
        canvas.disc(point, 0.22 * unit, _EDGE)
        canvas.disc(point, 0.18 * unit, (red, green, blue))
    canvas.ring(points[place.goal], 0.28 * unit, 0.38 * unit, _GOAL)


def _draw_boxes(canvas: Canvas, colony: Colony, unit: float) -> None:
    """Boxes: first those that lie in holes, below the rim."""
    ids, boxes = colony.scenario.topology.ids, colony.boxes
    rims = {ids[hole.node]: hole.rim for hole in colony.scenario.holes}
    at = zip(boxes.node.tolist(), boxes.position.tolist(), strict=True)
    there = [(z >= rims.get(node, -np.inf) - colony.scenario.reach, x, y) for node, (x, y, z) in at if node >= 0]
    for above, x, y in sorted(there):
        canvas.square((x, y), 0.5 * unit, _BOX if above else _FILLED)


def _draw_agents(canvas: Canvas, colony: Colony, unit: float) -> None:
    """Agents that are there, with a ring around those that have to decide."""
    agents, asked = colony.agents, colony.asked_together
    for agent, ((x, y, _), status) in enumerate(zip(agents.position.tolist(), agents.status.tolist(), strict=True)):
        if status not in ("goal", "absent"):
            canvas.disc((x, y), (0.24 if agent in asked else 0.2) * unit, _ASKED if agent in asked else _EDGE)
            canvas.disc((x, y), 0.18 * unit, _AGENT if status == "active" else _GONE)
