"""What a pushing robot knows: the nine numbers of paper Eq. 4, and features made from nothing else."""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from colonysim.physics import Pose, wrap
from colonysim.push.task import PushTask

__all__ = ["FEATURES", "PIT_DEPTH", "State", "features", "fold", "observe"]

FEATURES = 23
PIT_DEPTH = 0.25
"""A hole's node lies this far below its rim in the state, metres, whatever the pit's real depth: the
network was trained with pits one box deep, and only the topmost free place of a deeper one matters."""
HOLD = 0.3
"""Closer to the goal than this, metres, the direction from box to goal says nothing any more."""
_make = tuple.__new__


class State(NamedTuple):
    """Paper Eq. 4, in the robot's frame (turned with its yaw only; x ahead, y to the left).

    Attributes:
        x_box: Box centre, metres.
        y_box: Box centre, metres.
        z_box: Height of the box's centre over the robot's origin, metres.
        pitch_box: Tilt of the box along the push line, radians, positive when its front points up.
        yaw_box: Heading of the box's face nearest to the push line, radians.
        x_node: Goal node, metres.
        y_node: Goal node, metres.
        z_node: Height of the goal node (a hole's floor) over the robot's origin, metres.
        yaw_agent: The robot's heading against the line from the start to the goal node, radians.
    """

    x_box: float
    y_box: float
    z_box: float
    pitch_box: float
    yaw_box: float
    x_node: float
    y_node: float
    z_node: float
    yaw_agent: float

    @property
    def distance(self) -> float:
        """D: how far the box is from the goal, metres."""
        return math.hypot(self.x_node - self.x_box, self.y_node - self.y_box)

    @property
    def box_turn(self) -> float:
        """Yaw of the box's nearest face against the push line, within a quarter turn's half, radians."""
        return fold(self.yaw_box + self.yaw_agent)

    @property
    def heading_error(self) -> float:
        """beta: direction from the box to the goal, against the box's own heading, radians."""
        there = math.atan2(self.y_node - self.y_box, self.x_node - self.x_box)
        return wrap(there - self.yaw_box)

    @property
    def remaining(self) -> float:
        """How far the goal is ahead of the box along the push line, metres."""
        c, s = math.cos(self.yaw_agent), math.sin(self.yaw_agent)
        return (self.x_node - self.x_box) * c - (self.y_node - self.y_box) * s

    @property
    def cross_track(self) -> float:
        """How far the box is to the left of the push line, metres."""
        c, s = math.cos(self.yaw_agent), math.sin(self.yaw_agent)
        return -((self.x_node - self.x_box) * s + (self.y_node - self.y_box) * c)

    @property
    def behind(self) -> float:
        """How far the robot is behind the box along the push line, metres."""
        return self.x_box * math.cos(self.yaw_agent) - self.y_box * math.sin(self.yaw_agent)

    @property
    def aside(self) -> float:
        """How far the robot is to the left of the box, across the push line, metres."""
        return -(self.x_box * math.sin(self.yaw_agent) + self.y_box * math.cos(self.yaw_agent))


def fold(angle: float) -> float:
    """An angle modulo 90 degrees, in [-pi/4, pi/4): a square box looks the same every quarter turn."""
    return (angle + math.pi / 4) % (math.pi / 2) - math.pi / 4


def observe(robot: Pose, box: Pose, task: PushTask) -> State:
    """The state of paper Eq. 4 for one robot, one box and one push."""
    c, s = math.cos(robot.yaw), math.sin(robot.yaw)
    line = task.line
    bx, by = box.x - robot.x, box.y - robot.y
    gx, gy = task.goal[0] - robot.x, task.goal[1] - robot.y
    node = task.rim - (PIT_DEPTH if task.kind == "hole" else 0.0)
    yaw_agent = wrap(robot.yaw - line)
    # Made in every tick of a push: half the time of State(...).
    return _make(
        State,
        (
            c * bx + s * by,
            -s * bx + c * by,
            box.z - robot.z,
            _tilt(box, line),
            wrap(fold(box.yaw - line) - yaw_agent),
            c * gx + s * gy,
            -s * gx + c * gy,
            node - robot.z,
            yaw_agent,
        ),
    )


def _tilt(box: Pose, line: float) -> float:
    """Rise of the box's own up axis against the push line; Euler angles of a box turned 90 degrees swap."""
    sr, cr = math.sin(box.roll), math.cos(box.roll)
    sp, cp = math.sin(box.pitch), math.cos(box.pitch)
    sy, cy = math.sin(box.yaw), math.cos(box.yaw)
    up_x = cy * sp * cr + sy * sr
    up_y = sy * sp * cr - cy * sr
    return math.atan2(-(up_x * math.cos(line) + up_y * math.sin(line)), cp * cr)


def features(states: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """The nine numbers expressed in the frame of the push line, scaled to about one.

    Args:
        states: Shape (9,) or (n, 9), paper Eq. 4.

    Returns:
        Shape (23,) or (n, 23).
    """
    bx, by, bz, pitch, yw, gx, gy, gz, ps = np.asarray(states, dtype=np.float64).T
    # Direction of the push line and its left normal, seen from the robot.
    ux, uy = np.cos(ps), -np.sin(ps)
    reach, far = np.hypot(bx, by), np.hypot(gx, gy)
    safe_reach, safe_far = np.maximum(reach, 1e-6), np.maximum(far, 1e-6)
    dx, dy = gx - bx, gy - by
    distance = np.hypot(dx, dy)
    remaining = dx * ux + dy * uy
    cross_track = dx * uy - dy * ux
    behind = bx * ux + by * uy
    aside = bx * uy - by * ux
    # One row for each feature: a single state's are plain numbers, for which `clip` and `stack` would be slow.
    made = np.array(
        [
            bx,
            by,
            3 * bz,
            3 * pitch,
            2 * np.sin(yw),
            np.cos(yw),
            gx / 2,
            gy / 2,
            3 * gz,
            reach,
            by / safe_reach,
            bx / safe_reach,
            gy / safe_far,
            gx / safe_far,
            distance,
            remaining,
            np.minimum(np.maximum(5 * cross_track, -2), 2),
            behind,
            2 * aside,
            3 * ((yw + ps + np.pi / 4) % (np.pi / 2) - np.pi / 4),
            -uy,
            ux,
            distance < HOLD,
        ],
        dtype=np.float32,
    )
    return np.ascontiguousarray(made.T)
