"""A push seen from above as an image, drawn by the processor alone: it needs no display and no engine's renderer."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from colonysim.canvas import Canvas

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from colonysim.canvas import Colour
    from colonysim.physics.scene import Scene
    from colonysim.push.task import PushTask

__all__ = ["SIZE", "picture"]

SIZE = 360
"""Pixels of a side."""
_SPAN = 7.0
"""Metres of a side; the middle lies halfway between the start of the push line and its goal."""
_BARE, _LOW, _HIGH = (255, 255, 255), (199, 194, 181), (242, 240, 232)
"""What no ground is; the lowest and the highest ground."""
_PIT, _BOX, _SEATED, _ROBOT, _NOSE, _GOAL, _LINE = (
    (58, 58, 58), (0, 114, 178), (127, 178, 213), (204, 121, 167), (34, 34, 34), (0, 158, 115), (150, 150, 150)
)  # fmt: skip
_STRIPS = 16
"""A ramp is drawn in so many strips, the lighter the higher."""


def _placed(corners: Sequence[tuple[float, float]], x: float, y: float, yaw: float) -> list[tuple[float, float]]:
    c, s = math.cos(yaw), math.sin(yaw)
    return [(x + c * a - s * b, y + s * a + c * b) for a, b in corners]


def _rectangle(length: float, width: float) -> list[tuple[float, float]]:
    a, b = length / 2, width / 2
    return [(-a, -b), (a, -b), (a, b), (-a, b)]


def picture(scene: Scene, task: PushTask) -> NDArray[np.uint8]:
    """The place, the box, the robot and the goal of a push.

    Args:
        scene: The scene, of one box and one robot.
        task: The push.

    Returns:
        Red, green and blue of each pixel; shape (`SIZE`, `SIZE`, 3).
    """
    terrain = scene.terrain
    middle = (task.start[0] + task.goal[0]) / 2, (task.start[1] + task.goal[1]) / 2
    canvas = Canvas(middle, _SPAN / SIZE, SIZE, SIZE, _BARE)
    heights = [ground.z for ground in terrain.grounds] + [z for ramp in terrain.ramps for z in (ramp.z0, ramp.z1)]
    low, rise = min(heights), max(heights) - min(heights)

    def colour(z: float) -> Colour:
        share = (z - low) / rise if rise > 0.0 else 1.0
        red, green, blue = (round(a + share * (b - a)) for a, b in zip(_LOW, _HIGH, strict=True))
        return red, green, blue

    for ground in sorted(terrain.grounds, key=lambda ground: ground.z):
        corners = [(ground.xmin, ground.ymin), (ground.xmax, ground.ymin), (ground.xmax, ground.ymax)]
        canvas.fill([*corners, (ground.xmin, ground.ymax)], colour(ground.z))
    for ramp in terrain.ramps:
        whole = _rectangle(ramp.length / 2 + ramp.landing, 2 * ramp.half_width)
        for share, z in ((0.25, ramp.z0), (0.75, ramp.z1)):  # with its landings
            along = ramp.length * share + (ramp.landing if share > 0.5 else -ramp.landing) / 2
            x, y = ramp.x0 + along * math.cos(ramp.yaw), ramp.y0 + along * math.sin(ramp.yaw)
            canvas.fill(_placed(whole, x, y, ramp.yaw), colour(z))
        for strip in range(_STRIPS):
            share, long = (strip + 0.5) / _STRIPS, 1.05 * ramp.length / _STRIPS
            x, y = ramp.x0 + share * (ramp.x1 - ramp.x0), ramp.y0 + share * (ramp.y1 - ramp.y0)
            shape = _placed(_rectangle(long, 2 * ramp.half_width), x, y, ramp.yaw)
            canvas.fill(shape, colour(ramp.z0 + share * (ramp.z1 - ramp.z0)))
    for pit in terrain.pits:
        canvas.fill(_placed(_rectangle(pit.side, pit.side), pit.x, pit.y, pit.yaw), _PIT)
    canvas.fill(_placed(_rectangle(task.length, 0.04), *middle, task.line), _LINE)
    box, robot, model = scene.box(0), scene.robot(0), scene.models[0]
    side, height = scene.boxes[0].length, scene.boxes[0].height
    lies = bool(terrain.pits) and box.z < task.rim + height / 4
    canvas.fill(_placed(_rectangle(side, side), box.x, box.y, box.yaw), _SEATED if lies else _BOX)
    canvas.fill(_placed(_rectangle(model.length, 2 * model.half_width), robot.x, robot.y, robot.yaw), _ROBOT)
    ahead = 0.3 * model.length
    nose = robot.x + ahead * math.cos(robot.yaw), robot.y + ahead * math.sin(robot.yaw)
    canvas.fill(_placed(_rectangle(0.4 * model.length, 0.08), *nose, robot.yaw), _NOSE)
    canvas.ring(task.goal, 0.365, 0.435, _GOAL)
    return canvas.image
