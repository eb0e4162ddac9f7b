"""Push executors that each break one promise; `check_executor` must name it."""

from __future__ import annotations

import random
import secrets
from dataclasses import replace

from colonysim.push import ManoeuvreResult, WheelSpeeds, ignore, scripted_push


class Sound:
    """Pushes as `scripted` does; the others are derived from it."""

    def __init__(self):
        self.pushes = 0

    def __call__(self, scene, robot, task, obstacles, log=ignore, seed=0):
        return self.push(scene, robot, task, obstacles, log, seed)

    def push(self, scene, robot, task, obstacles, log, seed):
        return (yield from scripted_push(scene, robot, task, obstacles, log))


def waits(log, ticks):
    for _ in range(ticks):
        log("script", "wait", 1)
        yield WheelSpeeds(0.0, 0.0)


class NoManoeuvre(Sound):
    def __call__(self, scene, robot, task, obstacles, log=ignore, seed=0):
        return WheelSpeeds(1.0, 1.0)


class Infinite(Sound):
    def push(self, scene, robot, task, obstacles, log, seed):
        log("script", "forward", 1)
        yield WheelSpeeds(float("nan"), 1.0)
        return ManoeuvreResult(False, "slow")


class Raises(Sound):
    def push(self, scene, robot, task, obstacles, log, seed):
        yield from waits(log, 5)
        raise LookupError("no way")


class NoResult(Sound):
    def push(self, scene, robot, task, obstacles, log, seed):
        yield from waits(log, 5)


class Hasty(Sound):
    """Turns the robot before the manoeuvre has begun."""

    def __call__(self, scene, robot, task, obstacles, log=ignore, seed=0):
        pose = scene.robot(robot)
        scene.place_robot(robot, pose.x, pose.y, pose.z - 0.2, pose.yaw + 0.1)
        return super().__call__(scene, robot, task, obstacles, log, seed)


class Ticking(Sound):
    """Lets time pass by itself."""

    def push(self, scene, robot, task, obstacles, log, seed):
        yield from waits(log, 3)
        scene.tick()
        return (yield from super().push(scene, robot, task, obstacles, log, seed))


class Teleporting(Sound):
    """Puts the box where it is to go."""

    def push(self, scene, robot, task, obstacles, log, seed):
        yield from waits(log, 3)
        scene.place_box(task.box, *task.goal, task.rim, task.line)
        return ManoeuvreResult(True, "done")


class Commanding(Sound):
    """Has another robot drive."""

    def push(self, scene, robot, task, obstacles, log, seed):
        scene.drive(1, 3.0, 3.0)
        return (yield from super().push(scene, robot, task, obstacles, log, seed))


class Endless(Sound):
    def push(self, scene, robot, task, obstacles, log, seed):
        while True:
            yield from waits(log, 60)


class Boasting(Sound):
    """Says that it is done before it has begun."""

    def push(self, scene, robot, task, obstacles, log, seed):
        yield from waits(log, 3)
        return ManoeuvreResult(True, "done")


class Silent(Sound):
    """Tells nobody what it does."""

    def push(self, scene, robot, task, obstacles, log, seed):
        return (yield from scripted_push(scene, robot, task, obstacles))


class Unsteady(Sound):
    def push(self, scene, robot, task, obstacles, log, seed):
        yield from waits(log, 1 + secrets.randbelow(1000))
        return (yield from super().push(scene, robot, task, obstacles, log, seed))


class Global(Sound):
    def push(self, scene, robot, task, obstacles, log, seed):
        yield from waits(log, 1 + random.randrange(1000))
        return (yield from super().push(scene, robot, task, obstacles, log, seed))


class Tiring(Sound):
    """Takes a little longer each time."""

    def push(self, scene, robot, task, obstacles, log, seed):
        self.pushes += 1
        yield from waits(log, 3 * self.pushes)
        return (yield from super().push(scene, robot, task, obstacles, log, seed))


class Crowded(Sound):
    """Waits while another of its pushes is under way."""

    def push(self, scene, robot, task, obstacles, log, seed):
        self.pushes += 1
        try:
            yield from waits(log, 30 * self.pushes)
            return (yield from super().push(scene, robot, task, obstacles, log, seed))
        finally:
            self.pushes -= 1


class Stubborn(Sound):
    """Does not let itself be stopped."""

    def push(self, scene, robot, task, obstacles, log, seed):
        try:
            return (yield from super().push(scene, robot, task, obstacles, log, seed))
        except GeneratorExit:
            yield WheelSpeeds(0.0, 0.0)


class Contradicting(Sound):
    """Has succeeded, and gives a reason why not."""

    def push(self, scene, robot, task, obstacles, log, seed):
        result = yield from super().push(scene, robot, task, obstacles, log, seed)
        return replace(result, success=True, reason="slow")


FAULTS = [
    (NoManoeuvre, "protocol"),
    (Infinite, "protocol"),
    (Raises, "protocol"),
    (NoResult, "protocol"),
    (Hasty, "begins later"),
    (Ticking, "reads only"),
    (Teleporting, "reads only"),
    (Commanding, "own robot"),
    (Endless, "ends"),
    (Boasting, "honesty"),
    (Contradicting, "honesty"),
    (Silent, "log"),
    (Unsteady, "determinism"),
    (Global, "randomness"),
    (Tiring, "isolation"),
    (Crowded, "isolation"),
    (Stubborn, "cancel"),
]
