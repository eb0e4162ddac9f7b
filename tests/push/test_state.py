"""The nine numbers of paper Eq. 4, and the features made from them."""

import math

import numpy as np
import pytest

from colonysim.physics import Pose
from colonysim.push.state import FEATURES, State, features, fold, observe
from colonysim.push.task import PushTask

TASK = PushTask(0, (0.0, 0.0), (2.0, 0.0), "flat", 0.0)


def test_everything_is_seen_from_the_robot() -> None:
    state = observe(Pose(-1, 0.5, 0, 0, 0, math.pi / 2), Pose(0, 0.1, 0.125, 0, 0, 0.2), TASK)
    assert state[:3] == pytest.approx((-0.4, -1.0, 0.125))
    assert state[5:8] == pytest.approx((-0.5, -3.0, 0.0))
    assert state.yaw_agent == pytest.approx(math.pi / 2)
    assert state.box_turn == pytest.approx(0.2)
    assert state.cross_track == pytest.approx(0.1)
    assert state.remaining == pytest.approx(2.0)
    assert state.distance == pytest.approx(math.hypot(2.0, 0.1))
    assert state.behind == pytest.approx(1.0)
    assert state.aside == pytest.approx(0.4)
    assert state.heading_error == pytest.approx(math.atan2(-0.1, 2.0) - 0.2)


def test_a_hole_s_node_is_its_floor_which_tells_holes_from_nodes() -> None:
    hole = PushTask(0, (0.0, 0.0), (2.0, 0.0), "hole", 0.7, 0)
    assert observe(Pose(-1, 0, 0.7, 0, 0, 0), Pose(0, 0, 0.825, 0, 0, 0), hole).z_node == pytest.approx(-0.25)


@pytest.mark.parametrize("quarter", range(4))
def test_a_square_box_looks_the_same_after_a_quarter_turn(quarter: int) -> None:
    robot = Pose(-1, 0.2, 0, 0, 0, 0.3)
    plain = observe(robot, Pose(0, 0, 0.125, 0, 0, 0.1), TASK)
    turned = observe(robot, Pose(0, 0, 0.125, 0, 0, 0.1 + quarter * math.pi / 2), TASK)
    assert turned == pytest.approx(plain)


@pytest.mark.parametrize("quarter", range(4))
def test_the_box_s_tilt_is_along_the_line_whichever_face_is_pushed(quarter: int) -> None:
    # Nose up by .1 along x: euler pitch is positive nose down, and becomes roll after a quarter turn.
    roll, pitch = [(0, -0.1), (-0.1, 0), (0, 0.1), (0.1, 0)][quarter]
    state = observe(Pose(-1, 0, 0, 0, 0, 0), Pose(0, 0, 0.2, roll, pitch, quarter * math.pi / 2), TASK)
    assert state.pitch_box == pytest.approx(0.1)


def test_fold_stays_within_an_eighth_of_a_turn() -> None:
    assert fold(math.pi / 2 + 0.1) == pytest.approx(0.1)
    assert fold(math.pi / 4 + 0.01) == pytest.approx(-math.pi / 4 + 0.01)


def test_features_are_made_of_the_state_alone_and_agree_with_its_geometry() -> None:
    rng = np.random.default_rng(0)
    states = rng.uniform(-1.5, 1.5, (50, 9))
    made = features(states)
    assert made.shape == (50, FEATURES) and made.dtype == np.float32
    for row, given in zip(made, states, strict=True):
        state = State(*given)
        assert np.array_equal(row, features(given))
        assert row[14] == pytest.approx(state.distance, abs=1e-5)
        assert row[15] == pytest.approx(state.remaining, abs=1e-5)
        assert row[16] == pytest.approx(np.clip(5 * state.cross_track, -2, 2), abs=1e-4)
        assert row[17] == pytest.approx(state.behind, abs=1e-5)
        assert row[18] == pytest.approx(2 * state.aside, abs=1e-5)
        assert row[19] == pytest.approx(3 * state.box_turn, abs=1e-4)
        assert row[22] == (state.distance < 0.3)


def test_features_are_finite_when_robot_box_and_node_coincide() -> None:
    assert np.isfinite(features(np.zeros(9))).all()
