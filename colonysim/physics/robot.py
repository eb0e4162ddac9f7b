"""The robot: four wheels, a bumper low enough to press a box into a pit, and its traction.

Sphere wheels with engine friction grip differently in every world direction, so the wheels here are
frictionless and traction is a servo on the body: every physics step it pulls the body's forward,
sideways and turning speed towards what the wheels ask for, within the friction the ground can give.
Sideways sliding of tyres is therefore modelled as a capped force, not as slip at each wheel.
"""

import math
from collections.abc import Sequence
from math import asin, atan2
from typing import NamedTuple

from colonysim.physics.engine import Engine
from colonysim.physics.shapes import Pose, Quat, RobotSpec, Vec3, quaternion

WHEEL_RADIUS = 0.12
TRACK = 0.50
"""Distance of the left from the right wheels, metres."""
MAX_WHEEL_SPEED = 8.0
"""Radians per second."""
BUMPER = 0.36
"""The bumper stands this far ahead of the robot's origin, metres (and the tail as far behind)."""
REACH = BUMPER - 0.1
"""Nose and tail are looked at this far from the robot's origin, metres."""
HALF_WIDTH = 0.37
"""Half the width over the wheels, metres; the chassis itself is .305 m."""

_WHEELBASE_HALF = 0.22
_CHASSIS_LOW, _CHASSIS_HIGH = 0.05, 0.34
_CENTRE = (_CHASSIS_LOW + _CHASSIS_HIGH) / 2
_CHASSIS_HALF = (BUMPER, 0.305, (_CHASSIS_HIGH - _CHASSIS_LOW) / 2)
_CHASSIS_MASS, _WHEEL_MASS = 42.0, 2.0
_MASS = _CHASSIS_MASS + 4 * _WHEEL_MASS
_BUMPER_FRICTION = 1.0
_GRIP = 0.8
"""Friction between tyres and ground."""
_WEIGHT = _MASS * 9.81
_SERVO = 60.0
"""Velocity errors are corrected at this rate, 1/s."""
_YAW_INERTIA = 3.7
_MAX_TORQUE = 100.0
_UPRIGHT = 0.8
"""Below this cosine of the tilt the wheels have lost the ground."""
_AT_REST = 1e-3
_STILL = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
_DROWSY = 1e-3
"""Above this sum of squared speeds no body falls asleep (the engine's threshold is far lower)."""
_LOOK_TICKS = 5
_FALLING = 0.05
_FORCE_AT = (0.0, 0.0, -0.19)
_make = tuple.__new__
# What others import is an object for Python; these are plain numbers once compiled.
_RADIUS, _HALF_TRACK, _FASTEST, _REACH = WHEEL_RADIUS, TRACK / 2, MAX_WHEEL_SPEED, REACH
_AHEAD_PER_WHEELS, _TURN_PER_WHEELS = WHEEL_RADIUS / 2, WHEEL_RADIUS / TRACK


class WheelSpeeds(NamedTuple):
    """Left and right wheel speed, radians per second."""

    left: float
    right: float


def wheel_speeds(forward: float, turn: float) -> WheelSpeeds:
    """Wheel speeds of a differential drive, the pair scaled down to what the motors reach.

    Args:
        forward: Speed ahead, m/s.
        turn: Turn rate to the left, rad/s.
    """
    left = (forward - turn * _HALF_TRACK) / _RADIUS
    right = (forward + turn * _HALF_TRACK) / _RADIUS
    if abs(left) > _FASTEST or abs(right) > _FASTEST:
        fastest = max(abs(left), abs(right))
        left, right = left * _FASTEST / fastest, right * _FASTEST / fastest
    # Made for every moving robot in every tick: half the time of WheelSpeeds(left, right).
    return _make(WheelSpeeds, (left, right))


def origin_pose(position: Vec3, rotation: Quat) -> Pose:
    """The robot's pose, its origin on the ground, from the pose of its chassis."""
    # Asked for by every robot that is looked at: `euler` is written out here.
    px, py, pz = position
    x, y, z, w = rotation
    upright = 1 - 2 * (x * x + y * y)
    lean, tip = 2 * (w * x + y * z), 2 * (w * y - z * x)
    return _make(
        Pose,
        (
            px - _CENTRE * (2 * (x * z + w * y)),
            py - _CENTRE * (2 * (y * z - w * x)),
            pz - _CENTRE * upright,
            atan2(lean, upright),
            asin(tip if -1.0 <= tip <= 1.0 else max(-1.0, min(1.0, tip))),
            atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
        ),
    )


def chassis_place(x: float, y: float, z: float, yaw: float) -> tuple[Vec3, Quat]:
    """Position and rotation of the chassis of a robot that stands level at a place."""
    return (x, y, z + _CENTRE), quaternion(yaw)


def build_robot(engine: Engine, spec: RobotSpec) -> int:
    """Create a robot's body."""
    position, rotation = chassis_place(spec.x, spec.y, spec.z, spec.yaw)
    axle = WHEEL_RADIUS - _CENTRE
    return engine.add_robot(
        _CHASSIS_HALF,
        _CHASSIS_MASS,
        _BUMPER_FRICTION,
        [(x, y, axle) for x in (_WHEELBASE_HALF, -_WHEELBASE_HALF) for y in (TRACK / 2, -TRACK / 2)],
        WHEEL_RADIUS,
        _WHEEL_MASS,
        position,
        rotation,
    )


class Traction:
    """Drives one robot's body; called once for every physics step.

    Attributes:
        body: The engine's name of the robot.
        left: Left wheel speed asked for, rad/s.
        right: Right wheel speed asked for, rad/s.
        grounded: Whether a wheel stood on something at the last look.
        upright: Cosine of the tilt at the last step (not a number when the pose is not).
        resting: Whether the last step needed no force at all.
    """

    __slots__ = (
        "_countdown", "_engine", "_frame", "_lift", "_pose", "_slow",
        "body", "grounded", "left", "resting", "right", "upright",
    )  # fmt: skip

    def __init__(self, engine: Engine, body: int) -> None:
        self._engine = engine
        self.body = body
        self.left = self.right = 0.0
        self.grounded = True
        self.resting = False
        self.upright = 1.0
        self._lift = 0.0
        self._slow = True
        self._countdown = 0
        # The chassis's place is read from the engine, and the robot's pose worked out, once between two steps.
        self._frame: tuple[Vec3, Quat] | None = None
        self._pose: Pose | None = None

    def pose(self) -> Pose:
        """The robot's pose, its origin on the ground."""
        pose = self._pose
        if pose is None:
            frame = self._frame
            if frame is None:
                frame = self._frame = self._engine.pose(self.body)
            pose = self._pose = origin_pose(*frame)
        return pose

    def course(self) -> tuple[float, float, float]:
        """x, y and yaw of the pose, bit for bit, at less than half its price."""
        if self._pose is not None:
            return self._pose.x, self._pose.y, self._pose.yaw
        frame = self._frame
        if frame is None:
            frame = self._frame = self._engine.pose(self.body)
        (px, py, _), (x, y, z, w) = frame
        return (
            px - _CENTRE * (2 * (x * z + w * y)),
            py - _CENTRE * (2 * (y * z - w * x)),
            atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
        )

    def lowest(self) -> float:
        """Height of the nose or the tail, whichever is lower; no finite number if the pose is none."""
        frame = self._frame
        if frame is None:
            frame = self._frame = self._engine.pose(self.body)
        (px, py, pz), (x, y, z, w) = frame
        height = pz - _CENTRE * (1 - 2 * (x * x + y * y)) - _REACH * abs(2 * (w * y - z * x))
        return height + 0.0 * (px + py)  # which says so if x or y are none

    def ask(self, left: float, right: float) -> None:
        """Set the wheel speeds, rad/s, each cut off at the motors' limit."""
        left = max(-_FASTEST, min(_FASTEST, left))
        right = max(-_FASTEST, min(_FASTEST, right))
        if left != self.left or right != self.right:
            self.left, self.right = left, right
            self.resting = False
            if self._slow:
                # Forces do not wake a sleeping body, and a robot that pushes in vain may have fallen asleep.
                self._engine.wake(self.body)

    def settle(self) -> None:
        """Forget the past after the robot was put somewhere; its wheels stop."""
        self.left = self.right = 0.0
        # There is no contact until the next step: without this the first tick would have no brakes.
        self.grounded, self.resting, self.upright = True, False, 1.0
        self._lift, self._slow, self._countdown = 0.0, True, _LOOK_TICKS
        self._frame = self._pose = None

    def state(self) -> tuple[float, ...]:
        """What it remembers from one step to the next, as plain numbers for `resume`."""
        return (
            self.left, self.right, float(self.grounded), float(self.resting), self.upright,
            self._lift, float(self._slow), float(self._countdown),
        )  # fmt: skip

    def resume(self, state: Sequence[float]) -> None:
        """Go on from a state; the body has been brought back by the engine.

        Raises:
            ValueError: It is no such state.
        """
        left, right, grounded, resting, upright, lift, slow, countdown = map(float, state)
        self.left, self.right, self.upright, self._lift = left, right, upright, lift
        self.grounded, self.resting, self._slow = grounded != 0.0, resting != 0.0, slow != 0.0
        self._countdown = int(countdown)
        self._frame = self._pose = None

    def look(self) -> None:
        """Find out whether the wheels stand on something; called before every tick.

        Asking the engine for contacts costs more than the rest of the servo, so it is done when the body
        moves along its own vertical, as in a fall, and otherwise ten times a second.
        """
        if self.resting:
            return
        self._countdown -= 1
        if self._countdown < 0 or not self.grounded or abs(self._lift) > _FALLING:
            self.grounded = self._engine.stands(self.body)
            self._countdown = _LOOK_TICKS

    def apply(self) -> None:
        """Push the body towards the speeds its wheels ask for, as far as the ground's grip allows."""
        engine, body = self._engine, self.body
        frame = self._frame
        self._frame = self._pose = None
        velocity = engine.velocity(body)
        if self.resting and velocity == _STILL:
            return
        _, (x, y, z, w) = frame or engine.pose(body)
        self.upright = r22 = 1 - 2 * (x * x + y * y)
        if not (self.grounded and r22 >= _UPRIGHT):
            self.resting, self._slow = False, True
            return
        (vx, vy, vz), (wx, wy, wz) = velocity
        r20, r21 = 2 * (x * z - w * y), 2 * (y * z + w * x)
        r02, r12 = 2 * (x * z + w * y), 2 * (y * z - w * x)
        left, right = self.left, self.right
        if (
            left == 0.0 == right
            and abs(r20) < _AT_REST
            and abs(r21) < _AT_REST
            and abs(vx) + abs(vy) + abs(wz) < _AT_REST
        ):
            # A parked robot on level ground is left alone, so that the engine can let it sleep.
            self.resting = self._slow = True
            return
        self.resting = False
        self._slow = vx * vx + vy * vy + wz * wz < _DROWSY
        self._lift = vx * r02 + vy * r12 + vz * r22
        ahead = vx * (1 - 2 * (y * y + z * z)) + vy * 2 * (x * y + w * z) + vz * r20
        aside = vx * 2 * (x * y - w * z) + vy * (1 - 2 * (x * x + z * z)) + vz * r21
        turning = wx * r02 + wy * r12 + wz * r22
        fx = _SERVO * _MASS * ((left + right) * _AHEAD_PER_WHEELS - ahead) + _WEIGHT * r20
        fy = -_SERVO * _MASS * aside + _WEIGHT * r21
        most = _GRIP * _WEIGHT * r22
        asked = math.hypot(fx, fy)
        if asked > most:
            fx, fy = fx * most / asked, fy * most / asked
        torque = _YAW_INERTIA * _SERVO * ((right - left) * _TURN_PER_WHEELS - turning)
        torque = max(-_MAX_TORQUE, min(_MAX_TORQUE, torque))
        engine.push(body, (fx, fy, 0.0), _FORCE_AT, (0.0, 0.0, torque))
