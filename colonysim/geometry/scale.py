"""How large things are unless a scenario says otherwise, and how large they may be, in units of the robot."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.scenario.scenario import Scenario

__all__ = [
    "BOX_HEIGHT", "BOX_LENGTH", "CLEARANCE", "DEEPEST_PIT", "FARTHEST", "HIGHEST_BOX", "LONGEST_EDGE", "LOWEST_BOX",
    "MARGIN", "MOST_BODIES", "MOST_LEVELS", "MOST_NODES", "MOST_WAYS", "RAMP_HALF_WIDTH", "XY_SCALE", "check_size",
]  # fmt: skip

XY_SCALE = 1.6
BOX_HEIGHT = 0.25
"""Without a z_scale the lowest box of a scenario becomes this high, metres."""
BOX_LENGTH = 1.0
CLEARANCE = 0.2
"""A pit is this much wider than a box, metres."""
MARGIN = 1.75
RAMP_HALF_WIDTH = 2.2
FARTHEST = 1000.0
"""No node lies further from the origin along any axis, metres: the engine's numbers are good to a tenth of a millimetre
there."""
LONGEST_EDGE = 200.0
"""Metres; a robot takes minutes for it."""
MOST_NODES, MOST_BODIES, MOST_LEVELS = 20_000, 500, 200
MOST_WAYS = 100_000.0
"""Metres of edges, times levels and ramps: every tenth of a metre is looked at."""
LOWEST_BOX, HIGHEST_BOX, DEEPEST_PIT = 0.01, 10.0, 50.0


def check_size(
    scenario: Scenario,
    places: Sequence[tuple[float, float]],
    heights: Sequence[float],
    box_heights: Sequence[float],
    z_scale: float,
) -> None:
    """Whether an engine can build the place, and robots get anywhere in it, in a reasonable time.

    Raises:
        ScenarioError: Something is too large, too far or too many.
    """
    topology, fault = scenario.topology, scenario.fault
    if len(topology) > MOST_NODES:
        raise fault("physics", f"{len(topology)} nodes, expected at most {MOST_NODES} on a physics backend")
    bodies = len(scenario.agents) + len(scenario.boxes)
    if bodies > MOST_BODIES:
        raise fault("physics", f"{bodies} robots and boxes, expected at most {MOST_BODIES} on a physics backend")
    if len({round(height, 2) for height in heights}) > MOST_LEVELS:
        raise fault("physics", f"more than {MOST_LEVELS} levels, expected fewer on a physics backend")
    for node, (place, height) in enumerate(zip(places, heights, strict=True)):
        far = max(map(abs, (*place, height)))
        if far > FARTHEST:
            name = topology.ids[node]
            raise fault("physics", f"node {name} lies {far:g} m off, expected at most {FARTHEST:g} m; see xy_scale")
        for j in topology.neighbours[node]:
            if (length := math.dist(place, places[j])) > LONGEST_EDGE:
                names = f"{topology.ids[node]}-{topology.ids[j]}"
                raise fault("physics", f"edge {names} is {length:g} m long, expected at most {LONGEST_EDGE:g} m")
    for box, height in enumerate(box_heights):
        if not LOWEST_BOX <= height <= HIGHEST_BOX:
            expected = f"{LOWEST_BOX:g} to {HIGHEST_BOX:g} m; see z_scale"
            raise fault(f"boxes.{box}", f"the box is {height:g} m high, expected {expected}")
    for hole in scenario.holes:
        if hole.depth * z_scale > DEEPEST_PIT:
            name = topology.ids[hole.node]
            raise fault("physics", f"hole {name} is {hole.depth * z_scale:g} m deep, expected at most {DEEPEST_PIT:g}")
