"""Poses and the bodies a scene is built from. Metres, radians, kilograms throughout."""

import math
from dataclasses import dataclass
from typing import NamedTuple

Vec3 = tuple[float, float, float]
Quat = tuple[float, float, float, float]
"""A rotation as x, y, z, w."""
_HALF_TURN, _FULL_TURN = math.pi, 2.0 * math.pi


class Pose(NamedTuple):
    """Where a body is.

    A robot's origin lies on the ground between its wheels; a box's is its centre.
    """

    x: float
    y: float
    z: float
    roll: float
    pitch: float
    yaw: float


@dataclass(frozen=True, slots=True)
class BoxSpec:
    """A square box to be created; `z` is the height of its underside."""

    x: float
    y: float
    z: float
    yaw: float
    length: float = 1.0
    height: float = 0.25
    mass: float = 12.0
    friction: float = 0.5


@dataclass(frozen=True, slots=True)
class RobotSpec:
    """A robot to be created; `z` is the height of the ground under its wheels."""

    x: float
    y: float
    z: float
    yaw: float


@dataclass(frozen=True, slots=True)
class Slab:
    """A fixed box of the ground: its centre, half sizes, heading and slope (positive: rises ahead)."""

    centre: Vec3
    half: Vec3
    yaw: float = 0.0
    slope: float = 0.0


def wrap(angle: float) -> float:
    """The angle brought into [-pi, pi)."""
    return (angle + _HALF_TURN) % _FULL_TURN - _HALF_TURN


def quaternion(yaw: float, slope: float = 0.0) -> Quat:
    """The rotation that raises the x axis by `slope` and then turns it to `yaw`."""
    sy, cy = math.sin(yaw / 2), math.cos(yaw / 2)
    sp, cp = math.sin(-slope / 2), math.cos(-slope / 2)
    return (-sy * sp, cy * sp, sy * cp, cy * cp)


def euler(q: Quat) -> Vec3:
    """Roll, pitch and yaw of a rotation (pitch is positive nose down)."""
    x, y, z, w = q
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return roll, pitch, yaw
