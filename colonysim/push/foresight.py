"""Features of the pushes along a box's way (its sequence of nodes), told before the first push begins.

They are made from the planner's room, the turns of box and robot, and the terrain; `way.py` makes chances of them.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from colonysim.physics import Pose, Scene
from colonysim.push.driving import BACK_OFF
from colonysim.push.paths import FreeSpace, Point, Surroundings
from colonysim.push.staging import at_face, face_for, plan_push, staging_points
from colonysim.push.task import PushTask

__all__ = ["Features", "foresee"]

AMPLE = 0.5
"""More room than this makes no difference, metres."""
_AROUND_BOX = 1.1
"""A robot keeps this far from the centre of a box that is imagined elsewhere, metres."""
_RING = 1.3
_LOOKS = 24


class Features(NamedTuple):
    """The ten numbers that the chance of one push is estimated from.

    Attributes:
        room: The planner's margin, up to .5 m either way; negative: it finds no way to do it.
        staging: Least slack of the places where the network takes over, up to .5 m either way.
        no_place: 1 if that is negative: there is no such place for one part of the push.
        blocked: 1 if something is in the way of the box itself.
        cut_off: 1 if the robot has no way to where the push begins.
        split: 1 if the push has to be split in two.
        askew: How far the box's face is off the push line, radians.
        staged: 1 if the robot has to go round the box first, or comes from elsewhere.
        slope: 1 on a slope.
        hole: 1 into a pit.
    """

    room: float
    staging: float
    no_place: float
    blocked: float
    cut_off: float
    split: float
    askew: float
    staged: float
    slope: float
    hole: float


def foresee(scene: Scene, robot: int, tasks: Sequence[PushTask], around: Surroundings) -> Iterator[Features]:
    """The features of the pushes of a way, from where robot and box are now.

    The first push is looked at as it is. For each further one the box is imagined on its node, turned as the push
    before leaves it, and the robot behind it; everything else stays where it is.

    Args:
        scene: The scene; nothing in it moves.
        robot: Index of the robot.
        tasks: The pushes of one box, in order.
        around: What to stay away from, the box left out or not; robots are better left out: they move on.
    """
    pose: Pose | None = None
    at: Pose | None = None
    for number, task in enumerate(tasks):
        pose, at = pose or scene.robot(robot), at or scene.box(task.box)
        contact = scene.boxes[task.box].length / 2 + scene.models[robot].bumper
        plan = plan_push(scene, task.box, task, around, at)
        without = replace(around, boxes=tuple(i for i in around.boxes if i != task.box))
        if number:
            others = replace(without, discs=(*around.discs, (at.x, at.y, _AROUND_BOX)))
        else:
            others = replace(without, boxes=(*without.boxes, task.box))
        space = FreeSpace(scene, without)
        first, last = plan.legs[0], plan.legs[-1]
        ready = at_face(pose, at, contact, first.heading)
        handovers = [staging_points(scene, task.box, leg.start, leg.heading, coarse=True) for leg in plan.legs]
        slacks = [max(space.slack(x, y) for x, y in points) for points in handovers[1 if ready else 0 :]]
        staging = min(slacks, default=AMPLE)
        reached = ready or staging < 0.0 or _can_reach(FreeSpace(scene, others), pose, handovers[0], at)
        yield Features(
            _limited(plan.margin),
            _limited(staging),
            float(staging < 0.0),
            float(plan.reason == "way of the box blocked"),
            float(not reached),
            float(len(plan.legs) > 1),
            abs(face_for(at, first.heading).mismatch),
            float(not ready),
            float(task.kind == "slope"),
            float(task.kind == "hole"),
        )
        c, s = math.cos(last.heading), math.sin(last.heading)
        at = at._replace(x=task.goal[0], y=task.goal[1], yaw=last.heading)
        pose = pose._replace(x=at.x - contact * c, y=at.y - contact * s, yaw=last.heading)


def _can_reach(space: FreeSpace, pose: Pose, places: Sequence[Point], at: Pose) -> bool:
    """Whether a robot, having left the box, has a way to one of several places."""
    start = pose[:2]
    away = math.dist(start, at[:2])
    if away < _AROUND_BOX:
        share = BACK_OFF / away
        start = (pose.x + share * (pose.x - at.x), pose.y + share * (pose.y - at.y))
    # Most often there is room to go round in a circle; looking for a way takes far longer.
    if any(_round(space, start, places[0], at, side) for side in (1.0, -1.0)):
        return True
    return any(space.path(start, place) is not None for place in places)


def _round(space: FreeSpace, start: Point, end: Point, at: Pose, side: float) -> bool:
    """Whether a circle about the box leads from one place to another, to the left (1) or the right (-1)."""
    a = math.atan2(start[1] - at.y, start[0] - at.x)
    turn = side * ((side * (math.atan2(end[1] - at.y, end[0] - at.x) - a)) % (2.0 * math.pi))
    ring = max(_RING, math.dist(start, at[:2]), math.dist(end, at[:2]))
    for look in range(_LOOKS + 1):
        angle = a + turn * look / _LOOKS
        if space.slack(at.x + ring * math.cos(angle), at.y + ring * math.sin(angle)) < 0.0:
            return False
    return space.slack(*end) >= 0.0


def _limited(room: float) -> float:
    return max(-AMPLE, min(AMPLE, room))
