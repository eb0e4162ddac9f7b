# cython: auto_pickle=False
"""What drives a robot: how its body is made in an engine, and the traction of its wheels.

Sphere wheels with engine friction grip differently in every world direction, so the wheels here are
frictionless and traction is a servo on the body: every physics step it pulls the body's forward,
sideways and turning speed towards what the wheels ask for, within the friction the ground can give.
Sideways sliding of tyres is therefore modelled as a capped force, not as slip at each wheel.

Everything here is in units of the robot (`robot.Robot`), and wheel speeds are those that the standard robot's wheels
would turn at: whoever drives says how fast the robot shall go and turn, whatever its wheels are like.
"""

import math
from collections.abc import Sequence
from math import asin, atan2
from typing import NamedTuple

from colonysim.physics.engine import GRAVITY, Engine
from colonysim.physics.robot import STANDARD, Robot
from colonysim.physics.shapes import Pose, Quat, RobotSpec, Vec3, quaternion

_LOOK_BACK = 0.1
"""Nose and tail are looked at this far behind the bumper and before the tail."""
_SERVO = 60.0
"""Velocity errors are corrected at this rate."""
_YAW_INERTIA = 3.7
"""What turning the standard robot takes, without what its tyres and the ground take away."""
_MAX_TORQUE = 100.0
"""With which the standard robot's tyres can turn it, about its grip times half its track."""
UPRIGHT = 0.8
"""Below this cosine of the tilt the wheels have lost the ground."""
_AT_REST = 1e-3
_STILL = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
_ENDLESS = math.inf
_REMEMBERED = 8
"""Numbers in the state of a robot's traction."""
_DROWSY = 1e-3
"""Above this sum of squared speeds no body falls asleep (the engine's threshold is far lower)."""
_LOOK_TICKS = 5
_FALLING = 0.05
_FORCE_BELOW = 0.19
"""The ground pulls at the standard robot this far below its chassis' centre."""
_GRAVITY = GRAVITY
_make = tuple.__new__
# What others import is an object for Python; these are plain numbers once compiled.
_UPRIGHT = UPRIGHT
_RADIUS, _HALF_TRACK, _FASTEST = STANDARD.wheel_radius, STANDARD.track / 2, STANDARD.wheel_speed
_AHEAD_PER_WHEELS, _TURN_PER_WHEELS = STANDARD.wheel_radius / 2, STANDARD.wheel_radius / STANDARD.track


class WheelSpeeds(NamedTuple):
    """Left and right wheel speed of the standard robot, radians in a unit of time."""

    left: float
    right: float


def wheel_speeds(forward: float, turn: float) -> WheelSpeeds:
    """Wheel speeds of a differential drive, the pair scaled down to what the standard robot's motors reach.

    Args:
        forward: Speed ahead.
        turn: Turn rate to the left.
    """
    left = (forward - turn * _HALF_TRACK) / _RADIUS
    right = (forward + turn * _HALF_TRACK) / _RADIUS
    if abs(left) > _FASTEST or abs(right) > _FASTEST:
        fastest = max(abs(left), abs(right))
        left, right = left * _FASTEST / fastest, right * _FASTEST / fastest
    # Made for every moving robot in every tick: half the time of WheelSpeeds(left, right).
    return _make(WheelSpeeds, (left, right))


def origin_pose(position: Vec3, rotation: Quat, centre: float) -> Pose:
    """A robot's pose, its origin on the ground, from the pose of its chassis, whose centre is so high above it."""
    # Asked for by every robot that is looked at: `euler` is written out here.
    px, py, pz = position
    x, y, z, w = rotation
    upright = 1 - 2 * (x * x + y * y)
    lean, tip = 2 * (w * x + y * z), 2 * (w * y - z * x)
    return _make(
        Pose,
        (
            px - centre * (2 * (x * z + w * y)),
            py - centre * (2 * (y * z - w * x)),
            pz - centre * upright,
            atan2(lean, upright),
            asin(tip if -1.0 <= tip <= 1.0 else max(-1.0, min(1.0, tip))),
            atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
        ),
    )


def chassis_place(model: Robot, x: float, y: float, z: float, yaw: float) -> tuple[Vec3, Quat]:
    """Position and rotation of the chassis of a robot that stands level at a place."""
    return (x, y, z + model.centre), quaternion(yaw)


def build_robot(engine: Engine, model: Robot, spec: RobotSpec) -> int:
    """Create a robot's body."""
    position, rotation = chassis_place(model, spec.x, spec.y, spec.z, spec.yaw)
    axle = model.wheel_radius - model.centre
    ahead, aside = model.wheelbase / 2, model.track / 2
    return engine.add_robot(
        (model.bumper, model.width / 2, (model.height - model.clearance) / 2),
        model.chassis_mass,
        model.bumper_friction,
        [(x, y, axle) for x in (ahead, -ahead) for y in (aside, -aside)],
        model.wheel_radius,
        model.wheel_mass,
        position,
        rotation,
    )


class Traction:
    """Drives one robot's body; called once for every physics step.

    Args:
        engine: The engine that the body is in.
        body: The engine's name of the robot.
        model: What robot it is, in its own units.

    Attributes:
        body: The engine's name of the robot.
        left: Left wheel speed asked for.
        right: Right wheel speed asked for.
        grounded: Whether a wheel stood on something at the last look.
        upright: Cosine of the tilt at the last step (not a number when the pose is not).
        resting: Whether the last step needed no force at all.
        reach: Its nose and its tail are looked at this far from its origin.
    """

    __slots__ = (
        "_centre", "_countdown", "_engine", "_fastest", "_force_at", "_frame", "_lift", "_most", "_most_torque",
        "_pose", "_pull", "_slow", "_spread", "_twist", "_weight",
        "body", "grounded", "left", "reach", "resting", "right", "upright",
    )  # fmt: skip

    def __init__(self, engine: Engine, body: int, model: Robot) -> None:
        self._engine = engine
        self.body = body
        mass, wheels, track = model.mass, model.wheel_radius / STANDARD.wheel_radius, model.track / STANDARD.track
        self._centre, self.reach = model.centre, model.bumper - _LOOK_BACK
        self._weight, self._pull = mass * _GRAVITY, _SERVO * mass
        self._most = model.grip * self._weight
        self._twist = _YAW_INERTIA * (model.yaw_inertia / STANDARD.yaw_inertia) * _SERVO
        gripped = (model.grip / STANDARD.grip) * (mass / STANDARD.mass) * track
        self._most_torque = _MAX_TORQUE * gripped
        self._force_at = (0.0, 0.0, -_FORCE_BELOW * (model.centre / STANDARD.centre))
        # The controls were not tuned for more than the standard robot's motors give.
        self._fastest = min(_FASTEST, model.wheel_speed * wheels)
        self._spread = (track - 1.0) / 2
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
            pose = self._pose = origin_pose(frame[0], frame[1], self._centre)
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
            px - self._centre * (2 * (x * z + w * y)),
            py - self._centre * (2 * (y * z - w * x)),
            atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
        )

    def lowest(self) -> float:
        """Height of the nose or the tail, whichever is lower; no finite number if the pose is none."""
        frame = self._frame
        if frame is None:
            frame = self._frame = self._engine.pose(self.body)
        (px, py, pz), (x, y, z, w) = frame
        height = pz - self._centre * (1 - 2 * (x * x + y * y)) - self.reach * abs(2 * (w * y - z * x))
        return height + 0.0 * (px + py)  # which says so if x or y are none

    def ask(self, left: float, right: float) -> None:
        """Set the wheel speeds, the pair scaled down to what the motors reach."""
        # A wider track asks more of the outer wheel.
        turn = (right - left) * self._spread
        asked, most = max(abs(left - turn), abs(right + turn)), self._fastest
        if not asked < _ENDLESS:
            raise ValueError(f"wheel speeds {left} and {right}, expected finite numbers")
        if asked > most:
            left, right = left * most / asked, right * most / asked
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

    @staticmethod
    def read(state: Sequence[float]) -> tuple[float, ...]:
        """What `state` has answered, after it was stored.

        Raises:
            ValueError: It is no such state.
            TypeError: It is none either.
        """
        numbers = tuple(map(float, state))
        if len(numbers) != _REMEMBERED or not all(map(math.isfinite, (*numbers[:4], *numbers[6:]))):
            raise ValueError(f"expected {_REMEMBERED} numbers")
        return numbers

    def resume(self, state: tuple[float, ...]) -> None:
        """Go on from what `state` has answered; the body has been brought back by the engine."""
        left, right, grounded, resting, upright, lift, slow, countdown = state
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
        fx = self._pull * ((left + right) * _AHEAD_PER_WHEELS - ahead) + self._weight * r20
        fy = -self._pull * aside + self._weight * r21
        most = self._most * r22
        asked = math.hypot(fx, fy)
        if asked > most:
            fx, fy = fx * most / asked, fy * most / asked
        torque = self._twist * ((right - left) * _TURN_PER_WHEELS - turning)
        torque = max(-self._most_torque, min(self._most_torque, torque))
        engine.push(body, (fx, fy, 0.0), self._force_at, (0.0, 0.0, torque))
