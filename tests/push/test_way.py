"""The calibrated chance of a whole way: what is foreseen, the regression, its log and its figures."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from colonysim.errors import ColonysimError
from colonysim.learning.cards import ModelError, save_model
from colonysim.learning.seeds import Purpose, episode_rng
from colonysim.physics import STANDARD, BoxSpec, Ground, Pit, RobotSpec, Scene, Terrain
from colonysim.push import PushTask, Surroundings
from colonysim.push.foresight import Features, foresee
from colonysim.push.training.calibration import calibration_curve, false_accepts, fit_way_chance, judge_folds
from colonysim.push.training.cramped import draw_way
from colonysim.push.training.waylogs import LoggedPush, LoggedWay, gather_ways
from colonysim.push.way import WayChance, chances_along, load_way_chance

pytestmark = pytest.mark.usefixtures("engine")

OPEN = Ground(-9.0, -9.0, 9.0, 9.0, 0.0)
EASY = Features(0.5, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)


def tasks(*places: tuple[float, float]) -> list[PushTask]:
    return [PushTask(0, start, goal, "flat", 0.0) for start, goal in pairwise(places)]


def look(
    ground: Ground, way: Sequence[PushTask], robot: tuple[float, float] = (-1.5, 0.0), *others: tuple[float, float]
) -> list[Features]:
    """What is foreseen with the box at the origin, and other boxes."""
    boxes = [BoxSpec(0.0, 0.0, 0.0, 0.0), *(BoxSpec(x, y, 0.0, 0.0) for x, y in others)]
    with Scene(Terrain((ground,)), boxes, [RobotSpec(*robot, 0.0, 0.0)]) as scene:
        return list(foresee(scene, 0, way, Surroundings((), scene.standing_boxes())))


# -- what is foreseen ------------------------------------------------------------------------------------------------


def test_in_the_open_only_a_turn_needs_the_robot_to_go_round_the_box() -> None:
    straight, on, turned = look(OPEN, tasks((0, 0), (2, 0), (4, 0), (4, 2)))
    assert straight == EASY
    assert on == EASY._replace(staged=0.0)
    assert turned == EASY


def test_a_push_is_foreseen_as_it_is_once_the_box_is_there() -> None:
    way, ground = tasks((0, 0), (2, 0), (2, -2)), Ground(-4.0, -4.0, 4.0, 1.7, 0.0)
    foreseen = look(ground, way, (-1.5, 0.0), (3.3, -1.0))[1]
    boxes = [BoxSpec(2.0, 0.0, 0.0, 0.0), BoxSpec(3.3, -1.0, 0.0, 0.0)]
    with Scene(Terrain((ground,)), boxes, [RobotSpec(2.0 - 0.5 - STANDARD.bumper, 0.0, 0.0, 0.0)]) as scene:
        [seen] = foresee(scene, 0, way[1:], Surroundings((), (0, 1)))
    assert foreseen.room < 0.5
    assert foreseen == pytest.approx(seen, abs=1e-6)


def test_nothing_moves_while_it_is_looked_at() -> None:
    with Scene(Terrain((OPEN,)), [BoxSpec(0, 0, 0, 0)], [RobotSpec(-1.5, 0, 0, 0)]) as scene:
        before = scene.box(0), scene.robot(0), scene.ticks
        list(foresee(scene, 0, tasks((0, 0), (2, 0), (2, 2)), Surroundings()))
        assert (scene.box(0), scene.robot(0), scene.ticks) == before


def test_a_box_on_the_line_blocks_and_one_beside_it_takes_room() -> None:
    [blocked] = look(OPEN, tasks((0, 0), (2, 0)), (-1.5, 0.0), (2.4, 0.0))
    [beside] = look(OPEN, tasks((0, 0), (2, 0)), (-1.5, 0.0), (1.6, 1.3))
    assert (blocked.blocked, beside.blocked) == (1.0, 0.0)
    assert blocked.room < 0.0 < beside.room < 0.5


def test_a_robot_that_cannot_get_round_the_box_is_cut_off() -> None:
    lane = Ground(-6.0, -1.3, 6.0, 1.3, 0.0)
    [wrong_side] = look(lane, tasks((0, 0), (-2, 0)))
    [right_side] = look(lane, tasks((0, 0), (2, 0)))
    assert (wrong_side.cut_off, right_side.cut_off) == (1.0, 0.0)


# -- the regression --------------------------------------------------------------------------------------------------


def test_the_shipped_chance_falls_with_the_room_and_where_there_is_no_place_to_push_from() -> None:
    chance = load_way_chance()
    assert chance(EASY) > 0.9
    rooms = [chance(EASY._replace(room=room, staging=room)) for room in (0.5, 0.3, 0.1, 0.0, -0.2)]
    assert rooms == sorted(rooms, reverse=True)
    for fault in ({"room": -0.15, "staging": -0.15, "no_place": 1.0}, {"cut_off": 1.0}, {"room": -0.5, "blocked": 1.0}):
        assert chance(EASY._replace(**fault)) < 0.5


def test_the_chance_of_a_way_sees_what_comes_after_the_next_push() -> None:
    # At the second node a border leaves no room to stage for the turn.
    chance, way = load_way_chance(), tasks((0, 0), (2, 0), (2, -2))
    for ground, likely in ((OPEN, True), (Ground(-9.0, -9.0, 9.0, 0.9, 0.0), False)):
        with Scene(Terrain((ground,)), [BoxSpec(0, 0, 0, 0)], [RobotSpec(-1.5, 0, 0, 0)]) as scene:
            chances = chances_along(scene, 0, way, Surroundings(), chance)
        assert len(chances) == 2
        assert chances[0] > 0.9
        assert (math.prod(chances) >= 0.5) == likely


def test_a_chance_is_one_however_long_the_odds() -> None:
    chance = WayChance((1000.0, *[0.0] * 9), 0.0)
    assert [chance(EASY._replace(room=room)) for room in (-5.0, 0.0, 5.0)] == [0.0, 0.5, 1.0]


def test_a_card_of_other_features_or_of_another_kind_is_refused(tmp_path: Path) -> None:
    arrays = {"weights": np.zeros(10), "bias": np.zeros(1)}
    save_model(tmp_path / "old.npz", "logistic", arrays, {"features": ["room"]})
    with pytest.raises(ModelError, match="other features"):
        load_way_chance(tmp_path / "old.json")
    save_model(tmp_path / "short.npz", "logistic", arrays | {"weights": np.zeros(9)}, {"features": Features._fields})
    with pytest.raises(ModelError, match="10 weights"):
        load_way_chance(tmp_path / "short.json")
    with pytest.raises(ModelError, match="'logistic'"):
        load_way_chance("feasibility")


# -- the log and the fit ---------------------------------------------------------------------------------------------


def invented(count: int) -> list[LoggedWay]:
    """Ways of two pushes that succeed by chance, the more room the likelier."""
    rng = np.random.default_rng(0)
    ways = []
    for _ in range(count):
        seen = tuple(EASY._replace(room=float(rng.uniform(-0.5, 0.5))) for _ in range(2))
        pushes = []
        for features in seen:
            won = bool(rng.random() < 1 / (1 + math.exp(-8 * features.room)))
            pushes.append(LoggedPush(features, 0.7, won, "done" if won else "stuck", 1.0))
            if not won:
                break
        ways.append(LoggedWay(seen, tuple(pushes)))
    return ways


def test_the_fit_finds_the_chances_that_made_the_log_and_its_product_is_calibrated() -> None:
    pytest.importorskip("sklearn")
    ways = invented(1500)
    fitted = fit_way_chance(ways)
    assert fitted.weights[0] == pytest.approx(8.0, rel=0.15)
    judged = judge_folds(ways)["ways"]
    assert judged["n"] == 1500
    for part in judged["curve"]:
        if part["n"] >= 50:
            assert part["success"] == pytest.approx(part["chance"], abs=0.1)
    accepts = judged["accepts"]
    assert accepts["way"]["false_accept"] < accepts["geometry of all pushes"]["false_accept"] + 0.05
    assert accepts["geometry of all pushes"]["false_accept"] < accepts["geometry"]["false_accept"]
    with pytest.raises(ValueError, match="ended alike"):
        fit_way_chance([way for way in ways if way.success])


def test_curve_and_false_accepts_count_what_they_say() -> None:
    chances, won = np.array([0.01, 0.02, 0.6, 0.7, 0.99, 1.0]), np.array([False, True, True, False, True, True])
    curve = calibration_curve(chances, won)
    assert [(part["n"], part["success"]) for part in curve] == [(2, 0.5), (2, 0.5), (2, 1.0)]
    assert curve[0]["success_low"] < 0.5 < curve[0]["success_high"]
    counted = false_accepts(chances >= 0.5, won)
    assert (counted["failed"], counted["succeeded"], counted["accepted"]) == (2, 4, 4)
    assert (counted["false_accept"], counted["false_refuse"], counted["accepted_success"]) == (0.5, 0.25, 0.75)
    assert false_accepts(won, np.array([True] * 6))["false_accept"] is None


def test_a_log_goes_on_where_it_was_stopped(tmp_path: Path) -> None:
    whole = gather_ways(tmp_path / "whole.jsonl", 90, ways=3)
    broken = tmp_path / "broken.jsonl"
    gather_ways(broken, 90, ways=2)
    with broken.open("a") as file:
        file.write('{"foreseen": [[0.5,')
    assert gather_ways(broken, 90, ways=3) == whole
    assert broken.read_bytes() == (tmp_path / "whole.jsonl").read_bytes()
    with pytest.raises(ColonysimError, match="seed, engine and network"):
        gather_ways(broken, 91, ways=3)


def test_cramped_ways_can_be_built_and_begin_with_room_for_the_robot() -> None:
    kinds = set()
    for number in range(40):
        way = draw_way(episode_rng(Purpose.WAYS, 91, number))
        kinds |= {task.kind for task in way.tasks}
        assert way.boxes[0] == replace(way.boxes[0], x=way.tasks[0].start[0], y=way.tasks[0].start[1])
        assert all(before.goal == after.start for before, after in pairwise(way.tasks))
        if way.tasks[-1].kind == "hole":
            assert isinstance(way.terrain.pits[0], Pit)
            assert (way.terrain.pits[0].x, way.terrain.pits[0].y) == way.tasks[-1].goal
    assert kinds == {"flat", "slope", "hole"}
