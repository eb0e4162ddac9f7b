"""The eight controls against the paper's formulas (its Eq. 5-7 and table of controls)."""

import math

import pytest

from colonysim.physics import STANDARD, Pose
from colonysim.push.controls import GAIN_ALIGN, GAIN_ROTATE, GAIN_TRAVEL, Control, control_speeds
from colonysim.push.state import State, observe
from colonysim.push.task import PushTask


def at(box: tuple[float, float], node: tuple[float, float], yaw_box: float = 0.0, yaw_agent: float = 0.0) -> State:
    return State(*box, 0.125, 0.0, yaw_box, *node, 0.0, yaw_agent)


def travel(x: float, y: float, gain: float = GAIN_TRAVEL) -> tuple[float, float]:
    """Paper Eq. 6 with theta = b + pi/2 and alpha = pi/2 - b, both wrapped."""
    b = math.atan2(y, x)
    alpha = math.remainder(math.pi / 2 - b, 2 * math.pi)
    theta = math.remainder(math.pi / 2 + b, 2 * math.pi)
    left, right = gain * alpha, gain * theta
    scale = min(1.0, STANDARD.wheel_speed / max(abs(left), abs(right)))
    return left * scale, right * scale


def test_back_drives_both_wheels_backwards() -> None:
    assert control_speeds(Control.BACK, at((1, 0), (2, 0))) == (-GAIN_TRAVEL, -GAIN_TRAVEL)


@pytest.mark.parametrize("point", [(1.0, 0.0), (1.0, 0.4), (0.5, -0.9), (-1.0, 0.2), (-0.3, -1.0)])
def test_approach_and_push_in_travel_to_box_and_node(point: tuple[float, float]) -> None:
    assert control_speeds(Control.APPROACH, at(point, (9, 9))) == pytest.approx(travel(*point))
    assert control_speeds(Control.PUSH_IN, at((9, 9), point)) == pytest.approx(travel(*point))


def test_straight_ahead_is_47_centimetres_a_second_and_points_behind_are_reached_backwards() -> None:
    left, right = control_speeds(Control.PUSH_IN, at((1, 0), (2, 0)))
    assert left == right
    assert left * 0.12 == pytest.approx(0.471, abs=1e-3)
    left, right = control_speeds(Control.PUSH_IN, at((1, 0), (-2, 0.1)))
    assert left < 0 and right < 0


@pytest.mark.parametrize("bearing", [0.0, 0.3, -0.7, 1.5])
def test_turning_towards_a_point_follows_the_cosine_of_theta(bearing: float) -> None:
    point = (math.cos(bearing), math.sin(bearing))
    theta = bearing + math.pi / 2
    wanted = (GAIN_ROTATE * math.cos(theta), -GAIN_ROTATE * math.cos(theta))
    assert control_speeds(Control.ANGLE_BOX, at(point, (9, 0))) == pytest.approx(wanted)
    assert control_speeds(Control.ANGLE_GOAL, at((9, 0), point)) == pytest.approx(wanted)


@pytest.mark.parametrize("bearing", [1.7, math.pi - 1e-3, -2.5])
def test_turning_does_not_stall_with_the_point_behind(bearing: float) -> None:
    left, right = control_speeds(Control.ANGLE_BOX, at((math.cos(bearing), math.sin(bearing)), (9, 0)))
    assert (left, right) == (-math.copysign(GAIN_ROTATE, bearing), math.copysign(GAIN_ROTATE, bearing))


def test_align_travels_to_the_foot_on_the_box_goal_line_and_slows_down_near_it() -> None:
    # The line runs nearly parallel to the robot's x axis, to its left.
    slope = 0.1
    foot = (-0.3 * slope / (1 + slope**2), 0.3 / (1 + slope**2))
    speeds = control_speeds(Control.ALIGN, at((1, 0.4), (3, 0.6)))
    assert speeds == pytest.approx(travel(*foot, GAIN_ALIGN * math.hypot(*foot)))
    near = control_speeds(Control.ALIGN, at((1, 0.01), (3, 0.01)))
    assert max(map(abs, near)) < 0.3


def test_points_l_and_r_lie_across_the_box() -> None:
    state = at((1.0, 0.2), (3.0, 0.0), yaw_box=0.3)
    across = (-0.6 * math.sin(0.3), 0.6 * math.cos(0.3))
    left = travel(1.0 + across[0], 0.2 + across[1])
    right = travel(1.0 - across[0], 0.2 - across[1])
    assert control_speeds(Control.PUSH_LEFT, state) == pytest.approx(left)
    assert control_speeds(Control.PUSH_RIGHT, state) == pytest.approx(right)


@pytest.mark.parametrize("control", list(Control))
def test_no_control_asks_for_more_than_the_motors_give(control: Control) -> None:
    for k in range(64):
        angle = 2 * math.pi * k / 64
        state = at(
            (2 * math.cos(angle), 2 * math.sin(angle)), (3 * math.cos(2 * angle), 3 * math.sin(2 * angle)), angle
        )
        assert max(map(abs, control_speeds(control, state))) <= STANDARD.wheel_speed + 1e-9


def test_controls_do_not_depend_on_where_in_the_world_the_push_is() -> None:
    def seen(turn: float) -> State:
        c, s = math.cos(turn), math.sin(turn)

        def moved(x: float, y: float) -> tuple[float, float]:
            return c * x - s * y + 3.0, s * x + c * y - 1.0

        robot = Pose(*moved(-1.2, 0.3), 0.0, 0.0, 0.0, turn + 0.4)
        box = Pose(*moved(0.0, 0.05), 0.125, 0.0, 0.0, turn + 0.1 + math.pi / 2)
        return observe(robot, box, PushTask(0, moved(0, 0), moved(1.5, 0), "flat", 0.0))

    for control in Control:
        assert control_speeds(control, seen(0.0)) == pytest.approx(control_speeds(control, seen(2.1)))
