"""The eight controls of the paper (its table of controls), each a feedback law for the two wheel speeds.

The paper measures its angle from the robot's left axis; here `b` is the bearing of the reference point,
zero straight ahead and positive to the left, so the paper's theta is b + pi/2.
"""

import math
from collections.abc import Callable
from enum import IntEnum

from colonysim.physics.robot import STANDARD
from colonysim.physics.shapes import wrap
from colonysim.physics.traction import WheelSpeeds
from colonysim.push.state import State

__all__ = [
    "CONTROLS", "CONTROL_TICKS", "GAIN_ALIGN", "GAIN_ROTATE", "GAIN_TRAVEL", "NAMES", "Control", "control_speeds",
]  # fmt: skip

CONTROL_TICKS = 3
"""A control looks at the state 20 times a second, and holds its wheel speeds for this many control ticks."""
GAIN_ROTATE = 3.0
GAIN_TRAVEL = 2.5
GAIN_ALIGN = 8.0
SIDE = 0.6
"""Points L and R lie this far to the left and right of the box's centre, metres."""
_NO_LINE = 0.05
"""With the box this close to the goal, metres, the two no longer define a line."""
_QUARTER_TURN, _FASTEST = math.pi / 2, STANDARD.wheel_speed


class Control(IntEnum):
    """One row of the paper's table of controls."""

    BACK = 0
    APPROACH = 1
    ANGLE_BOX = 2
    ALIGN = 3
    PUSH_IN = 4
    PUSH_LEFT = 5
    PUSH_RIGHT = 6
    ANGLE_GOAL = 7


CONTROLS = len(Control)
NAMES = tuple(control.name.lower() for control in Control)
"""What the controls are called in traces."""


def control_speeds(control: Control, state: State) -> WheelSpeeds:
    """Wheel speeds that a control asks for in a state, rad/s, the pair scaled down to at most 8.

    `ANGLE_GOAL` turns on the spot (paper Eq. 5): the equation number in the paper's table is wrong.
    """
    return _LAWS[control](state)


def _rotate(x: float, y: float) -> WheelSpeeds:
    """Paper Eq. 5: turn towards a point. Saturated behind the robot, where the plain sine stalls."""
    bearing = math.atan2(y, x)
    turn = math.sin(bearing) if abs(bearing) <= _QUARTER_TURN else math.copysign(1.0, bearing)
    return WheelSpeeds(-GAIN_ROTATE * turn, GAIN_ROTATE * turn)


def _travel(x: float, y: float, gain: float = GAIN_TRAVEL) -> WheelSpeeds:
    """Paper Eq. 6: drive to a point; backwards to points behind the robot."""
    bearing = math.atan2(y, x)
    left, right = gain * wrap(_QUARTER_TURN - bearing), gain * wrap(_QUARTER_TURN + bearing)
    fastest = max(abs(left), abs(right))
    if fastest > _FASTEST:
        left, right = left * _FASTEST / fastest, right * _FASTEST / fastest
    return WheelSpeeds(left, right)


def _align(state: State) -> WheelSpeeds:
    """Paper Eq. 7: drive to the nearest point of the line through box and goal, slower when close."""
    dx, dy = state.x_node - state.x_box, state.y_node - state.y_box
    length = math.hypot(dx, dy)
    if length < _NO_LINE:
        dx, dy, length = math.cos(state.yaw_agent), -math.sin(state.yaw_agent), 1.0
    dx, dy = dx / length, dy / length
    along = state.x_box * dx + state.y_box * dy
    x, y = state.x_box - along * dx, state.y_box - along * dy
    return _travel(x, y, GAIN_ALIGN * min(1.0, math.hypot(x, y)))


def _beside(state: State, side: float) -> WheelSpeeds:
    """Drive to point L (`side` positive) or R: beside the box, across its heading."""
    return _travel(
        state.x_box - side * math.sin(state.yaw_box),
        state.y_box + side * math.cos(state.yaw_box),
    )


_LAW: dict[Control, Callable[[State], WheelSpeeds]] = {
    Control.BACK: lambda state: WheelSpeeds(-GAIN_TRAVEL, -GAIN_TRAVEL),
    Control.APPROACH: lambda state: _travel(state.x_box, state.y_box),
    Control.ANGLE_BOX: lambda state: _rotate(state.x_box, state.y_box),
    Control.ALIGN: _align,
    Control.PUSH_IN: lambda state: _travel(state.x_node, state.y_node),
    Control.PUSH_LEFT: lambda state: _beside(state, SIDE),
    Control.PUSH_RIGHT: lambda state: _beside(state, -SIDE),
    Control.ANGLE_GOAL: lambda state: _rotate(state.x_node, state.y_node),
}
# By number: a dictionary would ask an enumeration's member for its hash, which is Python.
_LAWS = tuple(_LAW[control] for control in Control)
