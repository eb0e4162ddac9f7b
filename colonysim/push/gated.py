"""The paper's classifier as a guide: where to push from, and whether to push at all."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

from colonysim.physics import Pose, Scene
from colonysim.push.choosing import Choose
from colonysim.push.driving import STAGING_SPEED, Part, Pilot
from colonysim.push.learned import StagedSettings, leg_task, push_in_legs
from colonysim.push.paths import FreeSpace, Obstacles, Point, Surroundings
from colonysim.push.staging import Leg, first_legs
from colonysim.push.state import State, observe
from colonysim.push.task import Log, Manoeuvre, PushTask, ignore

__all__ = ["Gate", "chance_of_push", "gated_push"]

Gate = Callable[[State], float]
"""The chance that the network's push succeeds from a state."""

LIKELY = 0.8
"""A robot that has this chance where it is does not look for a better place."""
_DISTANCES = (1.2, 1.4, 1.6)
_BEARINGS = 16
_ARRIVAL = 0.1
_FACING = 0.1


def chance_of_push(
    scene: Scene, robot: int, task: PushTask, gate: Gate, around: Surroundings, threshold: float = LIKELY
) -> float:
    """The chance of a push from where the robot is or from the best place around the box that is free.

    Args:
        scene: The scene.
        robot: Index of the robot.
        task: The push.
        gate: The classifier.
        around: What to stay away from, besides the box itself.
        threshold: If the robot has this chance where it is, other places are not looked at.
    """
    best, seen = 0.0, _with_box(around, task.box)
    for leg in first_legs(scene, task, around):
        part = leg_task(scene, task, leg)
        here = gate(observe(scene.robot(robot), scene.box(task.box), part, scene.models[robot].bumper))
        if here >= threshold:
            return here
        best = max(best, here, *(chance for chance, _ in _places(scene, robot, part, gate, seen)))
    return best


def gated_push(
    scene: Scene,
    robot: int,
    task: PushTask,
    obstacles: Obstacles,
    log: Log = ignore,
    *,
    choose: Choose,
    gate: Gate,
    threshold: float = 0.5,
    settings: StagedSettings | None = None,
) -> Manoeuvre:
    """The network pushes from wherever the classifier expects it to succeed: here, or from the best place at the box.

    No pose is scripted: a robot whose chance is low where it is drives to the place with the highest chance among
    those it can reach, and from there on the network chooses every control. After a push that went wrong the robot
    backs off and asks the classifier again.

    Args:
        scene: The scene.
        robot: Index of the robot.
        task: The push.
        obstacles: What to stay away from, besides the box itself.
        log: Told about every control, and who chose it.
        choose: Chooses the controls of the push.
        gate: The classifier.
        threshold: Least chance of a push that is begun.
        settings: Limits.

    Returns:
        A manoeuvre; its reasons are those of `staged_push` and `"infeasible"`: no place that can be reached has the
        chance asked for.
    """
    settings = settings or StagedSettings()

    def approach(pilot: Pilot, leg: Leg) -> Part:
        part = leg_task(scene, task, leg)
        if gate(observe(pilot.pose, scene.box(task.box), part, scene.models[robot].bumper)) >= LIKELY:
            return "done"
        return (yield from _to_likely_place(pilot, part, gate, threshold, obstacles))

    return push_in_legs(Pilot(scene, robot, log, settings.limit), task, obstacles, approach, choose, settings)


def _to_likely_place(pilot: Pilot, part: PushTask, gate: Gate, threshold: float, obstacles: Obstacles) -> Part:
    scene, robot = pilot.scene, pilot.robot

    def around() -> Surroundings:
        return _with_box(obstacles(), part.box)

    if (reason := (yield from pilot.leave_box())) != "done":
        return reason
    seen = pilot.near(around())
    here = gate(observe(pilot.pose, scene.box(part.box), part, scene.models[robot].bumper))
    space = FreeSpace(scene, seen)
    for chance, place in sorted(_places(scene, robot, part, gate, seen), reverse=True):
        if chance < max(threshold, here):
            break
        if space.path(pilot.pose[:2], place) is None:
            continue
        reason = yield from pilot.go(place, around, STAGING_SPEED, _ARRIVAL)
        if reason != "done":
            return reason
        at, pose = scene.box(part.box), pilot.pose
        if gate(observe(pose, at, part, scene.models[robot].bumper)) < threshold:
            # The classifier was asked about a robot that looks at the box.
            return (yield from pilot.turn_to(math.atan2(at.y - pose.y, at.x - pose.x), _FACING))
        return "done"
    return "done" if here >= threshold else "infeasible"


def _places(
    scene: Scene, robot: int, part: PushTask, gate: Gate, around: Surroundings
) -> Iterator[tuple[float, Point]]:
    """Free places around the box with the chance of a robot that stands there and looks at the box."""
    at, pose = scene.box(part.box), scene.robot(robot)
    points = [
        (at.x - distance * math.cos(angle), at.y - distance * math.sin(angle), angle)
        for distance in _DISTANCES
        for angle in (part.line + 2 * math.pi * k / _BEARINGS for k in range(_BEARINGS))
    ]
    space = FreeSpace(scene, around)
    for x, y, angle in points:
        if space.slack(x, y) >= 0.0:
            chance = gate(observe(Pose(x, y, pose.z, 0.0, 0.0, angle), at, part, scene.models[robot].bumper))
            yield chance, (x, y)


def _with_box(around: Surroundings, box: int) -> Surroundings:
    return around if box in around.boxes else replace(around, boxes=(*around.boxes, box))
