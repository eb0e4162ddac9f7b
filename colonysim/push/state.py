"""What a pushing robot knows: the nine numbers of paper Eq. 4, and features made from nothing else."""

import math
from collections.abc import Sequence
from math import atan2, cos, hypot, sin
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from colonysim.physics.robot import STANDARD
from colonysim.physics.shapes import Pose, wrap
from colonysim.push.task import PushTask

__all__ = ["FEATURES", "PIT_DEPTH", "State", "features", "fold", "observe"]

FEATURES = 23
PIT_DEPTH = 0.25
"""A hole's node lies this far below its rim in the state, metres, whatever the pit's real depth: the
network was trained with pits one box deep, and only the topmost free place of a deeper one matters."""
HOLD = 0.3
"""Closer to the goal than this, metres, the direction from box to goal says nothing any more."""
_BUMPER = STANDARD.bumper
_QUARTER_TURN, _EIGHTH_TURN = math.pi / 2, math.pi / 4
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
    return (angle + _EIGHTH_TURN) % _QUARTER_TURN - _EIGHTH_TURN


def observe(robot: Pose, box: Pose, task: PushTask, bumper: float = STANDARD.bumper) -> State:
    """The state of paper Eq. 4 for one robot, one box and one push.

    Args:
        robot: Where the robot is.
        box: Where the box is.
        task: The push.
        bumper: How far ahead of the robot's origin its bumper stands. The state is that of a standard robot whose
            bumper were there: the network has learned at what distance it touches a box.
    """
    x, y, z, _, _, yaw = robot
    box_x, box_y, box_z, box_roll, box_pitch, box_yaw = box
    goal_x, goal_y = task.goal
    c, s, line = cos(yaw), sin(yaw), task.line
    bx, by = box_x - x, box_y - y
    gx, gy = goal_x - x, goal_y - y
    beyond = bumper - _BUMPER
    node = task.rim - (PIT_DEPTH if task.kind == "hole" else 0.0)
    yaw_agent = wrap(yaw - line)
    # Made in every tick of a push: half the time of State(...).
    return _make(
        State,
        (
            c * bx + s * by - beyond,
            -s * bx + c * by,
            box_z - z,
            _tilt(box_roll, box_pitch, box_yaw, line),
            wrap(fold(box_yaw - line) - yaw_agent),
            c * gx + s * gy - beyond,
            -s * gx + c * gy,
            node - z,
            yaw_agent,
        ),
    )


def _tilt(roll: float, pitch: float, yaw: float, line: float) -> float:
    """Rise of the box's own up axis against the push line; Euler angles of a box turned 90 degrees swap."""
    sr, cr = sin(roll), cos(roll)
    sp, cp = sin(pitch), cos(pitch)
    sy, cy = sin(yaw), cos(yaw)
    up_x = cy * sp * cr + sy * sr
    up_y = sy * sp * cr - cy * sr
    return atan2(-(up_x * cos(line) + up_y * sin(line)), cp * cr)


def features(states: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """The nine numbers expressed in the frame of the push line, scaled to about one.

    Args:
        states: Shape (9,) or (n, 9), paper Eq. 4.

    Returns:
        Shape (23,) or (n, 23).
    """
    if isinstance(states, State):  # what every action of a push is chosen from
        return np.array(_features(states), dtype=np.float32)
    given = np.asarray(states, dtype=np.float64)
    made = [_features(state) for state in given.reshape(-1, len(State._fields)).tolist()]
    return np.array(made, dtype=np.float32).reshape(*given.shape[:-1], FEATURES)


def _features(state: Sequence[float]) -> tuple[float, ...]:
    bx, by, bz, pitch, yw, gx, gy, gz, ps = state
    # Direction of the push line and its left normal, seen from the robot.
    ux, uy = cos(ps), -sin(ps)
    reach, far = hypot(bx, by), hypot(gx, gy)
    safe_reach, safe_far = max(reach, 1e-6), max(far, 1e-6)
    dx, dy = gx - bx, gy - by
    distance, cross_track = hypot(dx, dy), dx * uy - dy * ux
    return (
        bx,
        by,
        3 * bz,
        3 * pitch,
        2 * sin(yw),
        cos(yw),
        gx / 2,
        gy / 2,
        3 * gz,
        reach,
        by / safe_reach,
        bx / safe_reach,
        gy / safe_far,
        gx / safe_far,
        distance,
        dx * ux + dy * uy,
        min(max(5 * cross_track, -2.0), 2.0),
        bx * ux + by * uy,
        2 * (bx * uy - by * ux),
        3 * fold(yw + ps),
        -uy,
        ux,
        float(distance < HOLD),
    )
