# cython: auto_pickle=False
"""Driving one robot: turning on the spot, following waypoints, backing off."""

import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from math import atan2, hypot

from colonysim.physics.scene import Scene, ticks_to_close
from colonysim.physics.shapes import Pose, wrap
from colonysim.physics.traction import WheelSpeeds, wheel_speeds
from colonysim.push.paths import ROBOT_CLEARANCE, FreeSpace, Obstacles, Point, Surroundings
from colonysim.push.task import Chooser, Log, Manoeuvre, ManoeuvreResult, ignore

Part = Generator[WheelSpeeds, None, str]
"""A part of a manoeuvre; it returns `"done"` or the reason why it ended."""

TRAVEL_SPEED = 0.8
"""Metres per second on the way between nodes."""
STAGING_SPEED = 0.6
BACK_SPEED = 0.3
_TURN_RATE, _CURVE = 2.0, 1.5
"""Most radians per second on the spot, and while driving."""
_TURN_START, _TURN_STOP = 0.3, 0.06
"""With one threshold for both a robot orbits its target instead of turning towards it."""
_FAULT_TICKS = 6
_GUARD_TICKS = 9
_HOLD_TICKS = 4
"""On its way a robot chooses its wheel speeds 15 times a second, and holds them for this many ticks."""
_LOOK_AHEAD = 0.9
_PATIENCE = 12.0
_FAR_ROBOT = 3.0
_TOUCH = 0.12
BACK_OFF = 0.35
"""Metres that a robot backs off from a box before it turns."""
_STALL_SECONDS = 3.0
_CLOSE = 0.12
"""A waypoint before the last counts as reached this close by, metres."""
_ASIDE = math.pi / 3
_IN_THE_WAY = ROBOT_CLEARANCE - 0.06


class Pilot:
    """One robot under the control of a manoeuvre: its clock, its log, and what it may do.

    Args:
        scene: The scene; it is read, never ticked.
        robot: Index of the robot.
        log: Told about the controls, one call for each run of equal ones.
        limit: Simulated seconds after which every part ends with `"timeout"`.
    """

    def __init__(self, scene: Scene, robot: int, log: Log = ignore, limit: float = 60.0) -> None:
        self.scene = scene
        self.robot = robot
        self.begun = scene.time
        self.deadline = scene.time + limit
        self._log = log
        self._chooser: Chooser = "script"
        self._control = ""
        self._ticks = 0

    @property
    def pose(self) -> Pose:
        """Where the robot is."""
        return self.scene.robot(self.robot)

    @property
    def seconds(self) -> float:
        """Simulated seconds since the manoeuvre began."""
        return self.scene.time - self.begun

    def hold(
        self, control: str, speeds: WheelSpeeds, chooser: Chooser = "script"
    ) -> Generator[WheelSpeeds, None, str | None]:
        """Hold wheel speeds for one tick; returns what ends the manoeuvre, else None."""
        self.note(control, chooser)
        yield speeds
        return None if self.scene.ticks % _FAULT_TICKS else self.fault()

    def note(self, control: str, chooser: Chooser = "script") -> None:
        """A control is held for one more tick."""
        # Most often they are the very same strings.
        same = control is self._control and chooser is self._chooser
        if not same and (control != self._control or chooser != self._chooser):
            self.flush()
            self._control, self._chooser = control, chooser
        self._ticks += 1

    def fault(self) -> str | None:
        """What ends the manoeuvre now, else None; to be asked a few times a second."""
        scene = self.scene
        return "timeout" if scene.time >= self.deadline else scene.robot_fault(self.robot)

    def flush(self) -> None:
        """Report the control held so far to the log; to be called at a manoeuvre's end."""
        if self._ticks:
            self._log(self._chooser, self._control, self._ticks)
        self._control, self._ticks = "", 0

    def wait(self, seconds: float) -> Part:
        """Stand still."""
        until = self.scene.time + seconds
        while self.scene.time < until:
            if fault := (yield from self.hold("wait", WheelSpeeds(0.0, 0.0))):
                return fault
        return "done"

    def turn_to(self, heading: float, tolerance: float = 0.02) -> Part:
        """Turn on the spot until the heading is within `tolerance` radians."""
        while abs(error := wrap(heading - self.pose.yaw)) > tolerance:
            rate = max(0.15, min(_TURN_RATE, 4.0 * abs(error)))
            if fault := (yield from self.hold("rotate", wheel_speeds(0.0, math.copysign(rate, error)))):
                return fault
        return "done"

    def straight(self, distance: float, speed: float, control: str) -> Part:
        """Drive straight by a signed distance; ends early, as done, when nothing moves any more."""
        start = self.pose
        c, s = math.cos(start.yaw), math.sin(start.yaw)
        until = self.scene.time + abs(distance) / speed + 1.0
        speeds = wheel_speeds(math.copysign(speed, distance), 0.0)
        while self.scene.time < until:
            pose = self.pose
            if abs(c * (pose.x - start.x) + s * (pose.y - start.y)) >= abs(distance):
                break
            if fault := (yield from self.hold(control, speeds)):
                return fault
        return "done"

    def leave_box(self) -> Part:
        """Back off when a box stands right at the bumper, else do nothing."""
        pose, bumper = self.pose, self.scene.models[self.robot].bumper
        for i, spec in enumerate(self.scene.boxes):
            box = self.scene.box(i)
            ahead, aside = in_frame(pose, box.x, box.y)
            reach = spec.length / 2
            # The upper edge of a box that lies in a pit is level with the ground: nothing to back off from.
            if box.z < pose.z or abs(aside) > reach + 0.3 or ahead < 0.0:
                continue
            if ahead < reach * 1.42 + bumper + _TOUCH and hypot(ahead, aside) < 2 * reach + bumper:
                return (yield from self.straight(-BACK_OFF, BACK_SPEED, "back"))
        return "done"

    def follow(
        self,
        path: Sequence[Point],
        speed: float,
        tolerance: float = 0.05,
        blocked: Callable[[Point], bool] | None = None,
        arrived: Callable[[], bool] | None = None,
    ) -> Part:
        """Drive along waypoints, turning on the spot where the way bends.

        Args:
            path: The waypoints, the target last.
            speed: Metres per second.
            tolerance: How close to the target it ends, metres.
            blocked: Asked a few times a second with a point ahead; True ends the part with `"blocked"`.
            arrived: Asked before each choice of speeds; True ends the part early, as done.
        """
        scene, last = self.scene, len(path) - 1
        for k, place in enumerate(path):
            waypoint = _Waypoint(scene, self.robot, place, tolerance if k == last else _CLOSE, speed, k == last)
            while True:
                if arrived is not None and arrived():
                    return "done"
                if waypoint.reached():
                    break
                if waypoint.stalled():
                    return "stuck"
                # Choices come at any remainder of the ticks, so one of these is met by exactly one choice.
                if blocked is not None and scene.ticks % _GUARD_TICKS < _HOLD_TICKS and blocked(waypoint.ahead()):
                    return "blocked"
                control, speeds = waypoint.control(), waypoint.speeds()
                for _ in range(_HOLD_TICKS):
                    self.note(control)
                    yield speeds
                if fault := self.fault():
                    return fault
        return "done"

    def go(
        self,
        goal: Point,
        obstacles: Obstacles,
        speed: float,
        tolerance: float = 0.05,
        arrived: Callable[[], bool] | None = None,
        path: Sequence[Point] | None = None,
    ) -> Part:
        """Plan a way to a point and drive it, waiting for robots that stand in it and planning again.

        Args:
            goal: The point, metres.
            obstacles: What to drive round.
            speed: Metres per second.
            tolerance: How close to the point it ends, metres.
            arrived: Asked before each choice of speeds; True ends the part early, as done.
            path: A way that has just been found, not to be looked for again.
        """
        until = self.scene.time + _PATIENCE
        lookout = _Lookout(self.scene, self.robot, obstacles)
        while True:
            pose = self.pose
            way = path or FreeSpace(self.scene, self.near(obstacles())).path((pose.x, pose.y), goal)
            path, reason = None, "no way"
            if way is not None:
                reason = yield from self.follow(way, speed, tolerance, lookout.blocked, arrived)
                if reason not in ("blocked", "stuck"):
                    return reason
            # Another robot may be about to leave; what stands still will not.
            if self.scene.time >= until or (reason == "no way" and not self.near(obstacles()).robots):
                return reason
            if (fault := (yield from self.wait(0.7))) != "done":
                return fault
            if reason == "stuck" and (fault := (yield from self.straight(-0.2, BACK_SPEED, "back"))) != "done":
                return fault

    def near(self, around: Surroundings) -> Surroundings:
        """Without the robots that are far away: by the time this one gets there they may have left."""
        here = self.pose
        close = tuple(i for i in around.robots if math.dist(here[:2], self.scene.robot(i)[:2]) < _FAR_ROBOT)
        return replace(around, robots=close)


class _Lookout:
    """Looks out for other robots on the way, and not again before one of them can be near.

    Args:
        scene: The scene.
        robot: Index of the robot.
        obstacles: Whether a robot is one is asked only of those at the point.
    """

    def __init__(self, scene: Scene, robot: int, obstacles: Obstacles) -> None:
        self._scene, self._robot, self._obstacles = scene, robot, obstacles
        self._look_at = 0

    def blocked(self, ahead: Point) -> bool:
        """Whether another robot is at a point, at most .9 m ahead, and would be approached by going there."""
        scene = self._scene
        if scene.ticks < self._look_at:
            return False
        x, y, _ = scene.course(self._robot)
        nearest = math.inf
        for i in scene.present_robots():
            if i == self._robot:
                continue
            u, v, _ = scene.course(i)
            there, away = hypot(u - ahead[0], v - ahead[1]), hypot(u - x, v - y)
            if there < _IN_THE_WAY and there < away and i in self._obstacles().robots:
                return True
            if not away >= nearest:
                nearest = away
        self._look_at = scene.ticks + ticks_to_close(nearest - _LOOK_AHEAD - _IN_THE_WAY)
        return False


class _Waypoint:
    """A place that a robot drives to: on the spot it turns towards it, then drives there and corrects its heading.

    Most ticks of a colony are spent here; compiled, it is plain numbers (`driving.pxd`).

    Args:
        scene: The scene.
        robot: Index of the robot.
        place: The waypoint, metres.
        near: How close is close enough, metres.
        speed: Metres per second.
        last: Whether the robot slows down towards it.
    """

    def __init__(self, scene: Scene, robot: int, place: Point, near: float, speed: float, last: bool) -> None:
        self._scene, self._robot = scene, robot
        self._x, self._y = place
        self._near, self._speed, self._last = near, speed, last
        self._turning = True
        self._best, self._since = math.inf, scene.time

    def reached(self) -> bool:
        """Looks where the robot is; whether it is there, or has just passed."""
        x, y, yaw = self._scene.course(self._robot)
        dx, dy = self._x - x, self._y - y
        distance, error = hypot(dx, dy), wrap(atan2(dy, dx) - yaw)
        self._here_x, self._here_y, self._distance, self._error = x, y, distance, error
        self._turning = abs(error) > (_TURN_STOP if self._turning else _TURN_START)
        return distance <= self._near or (distance < 2 * self._near and abs(error) > _ASIDE)

    def stalled(self) -> bool:
        """Whether the robot has come no closer for a while though it drives."""
        distance, now = self._distance, self._scene.time
        # Turning on the spot does not bring it closer, so only driving counts as stalling.
        if self._turning or distance < self._best - 0.02:
            self._best, self._since = min(self._best, distance), now
            return False
        return now - self._since > _STALL_SECONDS

    def ahead(self) -> Point:
        """A point on the way, .9 m ahead or the waypoint itself."""
        share, x, y = min(1.0, _LOOK_AHEAD / self._distance), self._here_x, self._here_y
        return x + share * (self._x - x), y + share * (self._y - y)

    def control(self) -> str:
        """What the robot does now."""
        return "rotate" if self._turning else "travel"

    def speeds(self) -> WheelSpeeds:
        """The wheel speeds for that."""
        error, forward = self._error, 0.0
        if self._turning:
            turn = max(0.2, min(_TURN_RATE, 4.0 * abs(error)))
        else:
            turn = min(_CURVE, 4.0 * abs(error))
            forward = min(self._speed, 2.0 * self._distance + 0.05) if self._last else self._speed
        return wheel_speeds(forward, turn if error >= 0.0 else -turn)


def in_frame(pose: Pose, x: float, y: float) -> Point:
    """A point as distances ahead and to the left of a robot."""
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    return c * (x - pose.x) + s * (y - pose.y), -s * (x - pose.x) + c * (y - pose.y)


def drive_to(
    scene: Scene,
    robot: int,
    x: float,
    y: float,
    obstacles: Obstacles | None = None,
    *,
    speed: float = TRAVEL_SPEED,
    tolerance: float = 0.05,
    log: Log = ignore,
    limit: float = 60.0,
) -> Manoeuvre:
    """Travel to a point.

    Args:
        scene: The scene.
        robot: Index of the robot.
        x: Target, metres.
        y: Target, metres.
        obstacles: What to drive round; None drives straight there, whatever is in the way.
        speed: Metres per second.
        tolerance: How close is close enough, metres.
        log: Told about the controls.
        limit: Simulated seconds after which it gives up.

    Returns:
        A manoeuvre that ends with one of the reasons `"done"`, `"timeout"`, `"blocked"` (a robot stood in
        the way), `"no way"`, `"stuck"`, or a fault of the robot.
    """
    pilot = Pilot(scene, robot, log, limit)
    try:
        reason = yield from pilot.leave_box()
        if reason == "done":
            if obstacles is None:
                reason = yield from pilot.follow([(x, y)], speed, tolerance)
            else:
                reason = yield from pilot.go((x, y), obstacles, speed, tolerance)
    finally:
        pilot.flush()
    return ManoeuvreResult(reason == "done", reason, pilot.seconds)
