"""A script over the eight controls that pushes fairly well: the learner's first teacher."""

import math

from colonysim.push.controls import Control
from colonysim.push.state import HOLD, State

__all__ = ["demonstrate"]

_ROOM = 1.1
"""Behind the box by this much, metres, the robot can turn and move sideways without touching it."""
_TOUCHING = 0.97
_ALIGNED, _DRIFTED = 0.05, 0.14
_FACING, _ROUGHLY = 0.1, 0.8


def demonstrate(state: State) -> Control:
    """The control a sensible driver would pick; it needs no memory, so any state can be shown to it."""
    toward = -state.yaw_agent
    if state.distance > HOLD:
        toward = math.atan2(state.y_node - state.y_box, state.x_node - state.x_box)
    c, s = math.cos(toward), math.sin(toward)
    behind = state.x_box * c + state.y_box * s
    aside = state.x_box * s - state.y_box * c
    facing = abs(math.atan2(state.y_node, state.x_node))
    touching = behind < _TOUCHING
    if abs(aside) > (_DRIFTED if touching else _ALIGNED):
        if behind >= _ROOM:
            return Control.ALIGN
        return Control.BACK if facing < _ROUGHLY else Control.ANGLE_GOAL
    if facing > (_ROUGHLY / 2 if touching else _FACING):
        return Control.ANGLE_GOAL
    return Control.PUSH_IN
