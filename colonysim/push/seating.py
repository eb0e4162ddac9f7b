"""How a box gets down into its pit, and when it is there."""

import math

from colonysim.physics.scene import Scene
from colonysim.push.driving import Part, Pilot
from colonysim.push.task import PushTask

__all__ = ["OVERRUN", "SETTLE_SECONDS", "is_deep", "lies", "pressed", "settle"]

OVERRUN = 0.10
"""The bumper ends this far past a pit's edge, so that it presses the box in, metres."""
SETTLE_SECONDS = 0.8
"""A box has come to rest this long after nobody pushes it any more."""
_DEEP = 1.5


def is_deep(scene: Scene, task: PushTask) -> bool:
    """Whether the goal is a pit so deep that a box, pushed carelessly, leans or tumbles in it."""
    return task.pit is not None and scene.terrain.pits[task.pit].depth > _DEEP * scene.boxes[task.box].height


def lies(scene: Scene, task: PushTask) -> bool:
    """Whether the box lies flat in its pit; True where there is none."""
    return task.pit is None or scene.box_seated(task.box, scene.terrain.pits[task.pit])


def pressed(scene: Scene, robot: int, task: PushTask) -> bool:
    """Whether the bumper is as far past the pit's edge as it may go."""
    if task.pit is None:
        return False
    pose = scene.robot(robot)
    c, s = math.cos(task.line), math.sin(task.line)
    nose = c * (task.goal[0] - pose.x) + s * (task.goal[1] - pose.y) - scene.models[robot].bumper
    return nose <= scene.terrain.pits[task.pit].side / 2 - OVERRUN


def settle(pilot: Pilot, task: PushTask) -> Part:
    """Stand still until the box has come to rest in its pit.

    Returns:
        `"done"` if it lies there, `"not seated"` if not, or a fault of the robot.
    """
    if (fault := (yield from pilot.wait(SETTLE_SECONDS))) != "done":
        return fault
    return "done" if lies(pilot.scene, task) else "not seated"
