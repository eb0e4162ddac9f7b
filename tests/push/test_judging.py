"""The paper's table of success and failure, the guards, and the reward of Eq. 8."""

import dataclasses
import math

import pytest

from colonysim.physics import BoxSpec, Ground, Pose, RobotSpec, Terrain
from colonysim.push.choosing import constant
from colonysim.push.controls import Control
from colonysim.push.driving import Pilot
from colonysim.push.judging import PAPER_RULES, Rules, guard, judge, reward, short_of_node
from colonysim.push.learned import ControlLoop, StagedSettings
from colonysim.push.state import State, observe
from colonysim.push.task import PushTask, run_alone
from colonysim.push.training.episode import Episode
from colonysim.push.training.starts import Start

pytestmark = pytest.mark.usefixtures("engine")

FLAT = PushTask(0, (0.0, 0.0), (2.0, 0.0), "flat", 0.0)
SLOPE = PushTask(0, (0.0, 0.0), (3.0, 0.0), "slope", 0.25)
HOLE = PushTask(0, (0.0, 0.0), (2.0, 0.0), "hole", 0.0, 0)


def verdict(
    task: PushTask, x: float, y: float = 0.0, z: float = 0.125, yaw: float = 0.0, robot_z: float = 0.0
) -> object:
    robot, box = Pose(x - 1, y, robot_z, 0, 0, 0), Pose(x, y, z, 0, 0, yaw)
    return judge(task, observe(robot, box, task), robot, box)


@pytest.mark.parametrize(
    ("x", "yaw", "wanted"),
    [
        (1.5, 0.0, None),
        (1.81, 0.0, "success"),
        (1.81, 0.19, "success"),
        (1.81, 0.25, None),
        (1.81, -0.31, "failure"),
        (1.0, 0.31, "failure"),
        (-2.9, 0.0, None),
        (-3.1, 0.0, "failure"),
    ],
)
def test_level_ground(x: float, yaw: float, wanted: str | None) -> None:
    assert verdict(FLAT, x, yaw=yaw) == wanted


@pytest.mark.parametrize(
    ("x", "z", "robot_z", "wanted"),
    [
        (1.95, -0.125, 0.0, "success"),
        (1.95, 0.125, 0.0, None),
        (1.95, -0.125, -0.1, "failure"),
        (1.5, -0.125, 0.0, "failure"),
        (1.0, 0.125, -0.2, "failure"),
    ],
)
def test_hole(x: float, z: float, robot_z: float, wanted: str | None) -> None:
    assert verdict(HOLE, x, z=z, robot_z=robot_z) == wanted


def test_step_limits_keep_the_paper_s_simulated_time() -> None:
    assert [PAPER_RULES.step_limit(kind) for kind in ("flat", "slope", "hole")] == [50, 100, 50]
    assert [Rules(ticks=25).step_limit(kind) for kind in ("flat", "slope", "hole")] == [100, 200, 100]


def state(box_x: float, box_y: float = 0.0, turn: float = 0.0) -> State:
    return observe(Pose(box_x - 0.9, box_y, 0, 0, 0, 0), Pose(box_x, box_y, 0.125, 0, 0, turn), FLAT)


def test_reward_is_equation_8() -> None:
    before, after = state(0.0, 0.1, turn=0.2), state(0.4, 0.05, turn=0.1)
    d = math.hypot(2.0, 0.1) - math.hypot(1.6, 0.05)
    beta = abs(math.atan2(-0.1, 2.0) - 0.2) - abs(math.atan2(-0.05, 1.6) - 0.1)
    assert reward(PAPER_RULES, before, after, None) == pytest.approx(5 * d + 2 * beta - 0.1)


def test_the_heading_term_is_held_near_the_goal_where_the_direction_flips() -> None:
    before, after = state(1.85), state(2.05)
    assert reward(PAPER_RULES, before, after, "success") == pytest.approx(5 * 0.1 - 2 * math.pi - 0.1)
    held = dataclasses.replace(PAPER_RULES, hold_heading=True)
    assert reward(held, before, after, "success") == pytest.approx(5 * 0.1 - 0.1)


def test_what_the_improved_rules_add() -> None:
    rules = Rules()
    before, after = state(0.0, 0.1), state(0.0, 0.05)
    plain = dataclasses.replace(rules, cross_track_gain=0.0)
    gained = reward(rules, before, after, None) - reward(plain, before, after, None)
    assert gained == pytest.approx(4 * 0.05)
    assert reward(rules, before, before, None) == pytest.approx(-0.05)
    assert reward(rules, before, before, "success") == pytest.approx(4.95)
    assert reward(rules, before, before, "failure") == pytest.approx(-2.05)


@pytest.mark.parametrize(
    ("task", "x", "y", "started", "why"),
    [
        (FLAT, 1.0, 0.14, 0.0, None),
        (FLAT, 1.0, 0.16, 0.0, "off_line"),
        (FLAT, 1.0, 0.16, 0.1, None),
        (SLOPE, 1.0, 0.29, 0.0, None),
        (SLOPE, 1.0, 0.31, 0.0, "off_line"),
        (SLOPE, 2.5, 0.16, 0.0, "off_line"),
        (FLAT, 1.995, 0.0, 0.0, None),
        (FLAT, 1.995, 0.22, 0.2, "past_goal"),
        (HOLE, 1.3, 0.09, 0.0, "off_line_at_edge"),
        (HOLE, 1.3, 0.07, 0.0, None),
        (HOLE, 1.0, 0.09, 0.0, None),
    ],
)
def test_guards(task: PushTask, x: float, y: float, started: float, why: str | None) -> None:
    seen = observe(Pose(x - 0.9, y, 0, 0, 0, 0), Pose(x, y, 0.125, 0, 0, 0), task)
    assert guard(task, seen, started) == why


def test_a_box_that_has_arrived_may_still_be_short_of_its_node() -> None:
    assert short_of_node(state(1.85))
    assert not short_of_node(state(1.98))


def start(x: float, y: float = 0.0, turn: float = 0.0) -> Start:
    """A box somewhere on level ground, and a robot 1.3 m behind it."""
    ground = Terrain((Ground(-9.0, -9.0, 9.0, 9.0, 0.0),))
    return Start(ground, BoxSpec(x, y, 0.0, turn), RobotSpec(x - 1.3, y, 0.0, 0.0), FLAT)


@pytest.mark.parametrize(
    ("begin", "reason"),
    [
        (start(1.99, 0.11), "done"),
        (start(1.99, 0.13), "off_node"),
        (start(1.85), ""),
        (start(1.0, turn=0.35), ""),
    ],
)
def test_a_push_is_judged_alike_when_it_runs_and_when_it_is_trained(begin: Start, reason: str) -> None:
    rules = dataclasses.replace(Rules(), ticks=3)
    episode = Episode(begin, rules)
    step = episode.step(Control.BACK)
    episode.close()
    assert step.reason == ("success" if reason == "done" else reason)
    staged = dataclasses.replace(StagedSettings().rules, ticks=3)
    with begin.scene() as scene:
        loop = ControlLoop(Pilot(scene, 0), begin.task, staged)
        assert run_alone(scene, 0, loop.run(constant(Control.BACK), 1)) == (reason or "slow")


def test_without_guards_the_paper_s_table_gives_a_push_up() -> None:
    episode = Episode(start(1.0, turn=0.35), dataclasses.replace(Rules(), guards=False))
    assert episode.step(Control.BACK).reason == "failure"
    episode.close()


def test_the_push_is_tested_when_the_control_looks_at_the_state() -> None:
    with pytest.raises(ValueError, match="check_every: 10, expected a multiple of 3, or at least 25"):
        Rules(check_every=10)
    assert Rules(ticks=5, check_every=5).check_every == 5
