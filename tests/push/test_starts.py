"""The frozen start distributions."""

import math
from importlib.resources import files

import numpy as np
import pytest

from colonysim.push.task import Kind
from colonysim.push.training.starts import KINDS, distribution, draw, start_names


def test_the_distribution_of_the_quoted_results_is_frozen() -> None:
    push = distribution("push")
    assert push.goal == {"flat": (1.0, 2.0), "slope": (2.6, 3.6), "hole": (1.25, 2.0)}
    assert push.slope_angle == pytest.approx(math.radians(8.0))
    assert (push.box_offset, push.box_yaw) == ((0.0, 0.0), (-0.2, 0.2))
    assert (push.robot_distance, push.robot_bearing) == ((1.05, 1.7), (-0.7, 0.7))
    assert push.robot_heading == pytest.approx((-math.pi, math.pi))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", start_names())
def test_draws_stay_within_their_ranges(kind: Kind, name: str) -> None:
    starts = distribution(name)
    for i in range(30):
        start = draw(kind, starts, np.random.default_rng(i))
        task, box, robot = start.task, start.box, start.robot
        low, high = starts.goal[kind]
        assert low <= task.length <= high
        away = math.hypot(robot.x - box.x, robot.y - box.y)
        assert starts.robot_distance[0] <= away <= starts.robot_distance[1]
        across = -math.sin(task.line) * box.x + math.cos(task.line) * box.y
        assert starts.box_offset[0] - 1e-9 <= across <= starts.box_offset[1] + 1e-9
        assert start.terrain.height(robot.x, robot.y) == 0.0
        yaws = starts.pit_yaw if kind == "hole" and starts.pit_yaw else starts.box_yaw
        assert yaws[0] - 1e-9 <= box.yaw - task.line <= yaws[1] + 1e-9
        depths = [0.0] if kind != "hole" else [0.25, 0.5] if starts.deep else [0.25]
        assert task.rim - start.terrain.height(*task.goal) in [pytest.approx(depth) for depth in depths]


def test_only_training_meets_pits_two_boxes_deep() -> None:
    assert {name for name in start_names() if distribution(name).deep} == {"push_wide", "handover", "askew", "fine"}
    starts = distribution("push_wide")
    pits = [draw("hole", starts, np.random.default_rng(i)).terrain.pits[0] for i in range(200)]
    assert 0.3 < sum(pit.depth == 0.5 for pit in pits) / len(pits) < 0.5


def test_the_same_stream_gives_the_same_start() -> None:
    one, two = (draw("hole", distribution("push"), np.random.default_rng(3)) for _ in range(2))
    assert one == two


def test_an_unknown_name_is_answered_with_the_known_ones() -> None:
    with pytest.raises(ValueError, match="no start distribution 'puhs'; there are push"):
        distribution("puhs")


def test_the_file_says_what_each_distribution_is_for() -> None:
    text = files("colonysim.push.training").joinpath("starts.json").read_bytes()
    assert text.count(b'"about"') == len(start_names()) + 1
