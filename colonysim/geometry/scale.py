"""How large things are unless a scenario says otherwise, and how large they may be, in units of the robot."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from colonysim.geometry.trouble import Trouble

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.physics import Robot
    from colonysim.scenario.scenario import Scenario

__all__ = [
    "BOX_HEIGHT", "BOX_LENGTH", "DEEPEST_PIT", "FARTHEST", "HIGHEST_BOX", "LONGEST_EDGE", "LOWEST_BOX", "MARGIN",
    "MOST_BODIES", "MOST_LEVELS", "MOST_NODES", "MOST_WAYS", "PIT_PLAY", "RAMP_HALF_WIDTH", "XY_SCALE", "check_size",
    "metres_of",
]  # fmt: skip

XY_SCALE = 1.6
BOX_HEIGHT = 0.25
"""Without a z_scale the lowest box of a scenario becomes this high, metres."""
BOX_LENGTH = 1.0
PIT_PLAY = 0.2
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


def metres_of(scenario: Scenario, robot: Robot) -> float:
    """Metres of a graph unit in the plane: what the scenario says, else what suits the size of its robot."""
    return float(scenario.physics.get("xy_scale") or XY_SCALE * robot.scale)


def check_size(
    scenario: Scenario,
    places: Sequence[tuple[float, float]],
    heights: Sequence[float],
    box_heights: Sequence[float],
    z_scale: float,
) -> None:
    """Whether an engine can build the place, and robots get anywhere in it, in a reasonable time.

    Raises:
        Trouble: Something is too large, too far or too many.
    """
    topology = scenario.topology
    if len(topology) > MOST_NODES:
        raise Trouble("physics", f"{len(topology)} nodes, expected at most {MOST_NODES} on a physics backend")
    bodies = len(scenario.agents) + len(scenario.boxes)
    if bodies > MOST_BODIES:
        raise Trouble("physics", f"{bodies} robots and boxes, expected at most {MOST_BODIES} on a physics backend")
    if len({round(height, 2) for height in heights}) > MOST_LEVELS:
        raise Trouble("physics", f"more than {MOST_LEVELS} levels, expected fewer on a physics backend")
    for node, (place, height) in enumerate(zip(places, heights, strict=True)):
        far = max(map(abs, (*place, height)))
        if far > FARTHEST:
            name = topology.ids[node]
            setting = "z_scale" if far == abs(height) else "xy_scale"
            raise Trouble(
                "physics", f"node {name} lies {{:g}} m off, expected at most {{:g}} m; see {setting}", far, FARTHEST
            )
        for j in topology.neighbours[node]:
            if (length := math.dist(place, places[j])) > LONGEST_EDGE:
                names = f"{topology.ids[node]}-{topology.ids[j]}"
                words = f"edge {names} is {{:g}} m long, expected at most {{:g}} m; see xy_scale"
                raise Trouble("physics", words, length, LONGEST_EDGE)
    for box, height in enumerate(box_heights):
        if not LOWEST_BOX <= height <= HIGHEST_BOX:
            raise Trouble(
                f"boxes.{box}", "the box is {:g} m high, expected {:g} to {:g} m; see z_scale and box_height",
                height, LOWEST_BOX, HIGHEST_BOX,
            )  # fmt: skip
    for hole in scenario.holes:
        if hole.depth * z_scale > DEEPEST_PIT:
            words = f"hole {topology.ids[hole.node]} is {{:g}} m deep, expected at most {{:g}} m; see z_scale"
            raise Trouble("physics", words, hole.depth * z_scale, DEEPEST_PIT)
