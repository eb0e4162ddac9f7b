"""Robots of other sizes: what similarity promises, on both engines, and which robots the controls refuse."""

import math
from dataclasses import replace

import pytest

from colonysim.physics import HALF, STANDARD, BoxSpec, Ground, Pit, Pose, RobotSpec, Scene, Terrain, engine_trouble
from colonysim.physics.robot import LIMITS, SCALES
from colonysim.push import PushTask, everything_else, run_alone
from colonysim.push.executors import make_executor
from colonysim.push.state import observe

ENGINES = [
    pytest.param(name, marks=pytest.mark.skipif(bool(engine_trouble(name)), reason="not installed"))
    for name in ("bullet", "mujoco")
]
PLACE = Terrain((Ground(-4.0, -4.0, 6.0, 4.0, 0.0),), (Pit(2.2, 0.0, 0.0),))
INTO_PIT = PushTask(0, (0.4, 0.0), (2.2, 0.0), "hole", 0.0, pit=0)


def pushed_into_the_pit(engine, robot, push):
    """How the push went, how often it ticked, and where box and robot are, in units of the robot."""
    start = [BoxSpec(0.4, 0.05, 0.0, 0.03)], [RobotSpec(-1.2, 0.3, 0.0, 0.2)]
    with Scene(PLACE, *start, robot=robot, engine=engine) as s:
        result = run_alone(s, 0, make_executor(push)(s, 0, INTO_PIT, everything_else(s, 0), seed=1))
        return result, s.ticks, (*s.box(0), *s.robot(0)), s.box_seated(0, PLACE.pits[0])


@pytest.mark.parametrize("push", ["staged", "scripted"])
@pytest.mark.parametrize("engine", ENGINES)
def test_a_robot_of_half_the_size_pushes_a_box_into_a_pit_as_the_standard_one_does(engine, push):
    half, standard = (pushed_into_the_pit(engine, robot, push) for robot in (HALF, STANDARD))
    assert half[0].success and half[3]
    assert half[:2] == standard[:2]
    assert half[2] == pytest.approx(standard[2], abs=1e-6)


@pytest.mark.parametrize("changes", [{"chassis_mass": 25.0}, {"wheel_speed": 5.0}, {"length": 0.6, "wheelbase": 0.32}])
def test_a_robot_of_other_numbers_pushes_a_box_into_a_pit(changes):
    pytest.importorskip("pybullet")
    assert pushed_into_the_pit("bullet", replace(STANDARD, **changes), "staged")[0].success


def test_a_robot_drives_no_faster_than_its_motors_turn_its_wheels():
    pytest.importorskip("pybullet")
    slow = replace(STANDARD, wheel_speed=5.0, wheel_radius=0.1)
    with Scene(PLACE, [], [RobotSpec(-3, 2, 0, 0)], robot=slow, engine="bullet") as scene:
        scene.drive(0, 8.0, 8.0)
        for _ in range(120):
            scene.tick()
        before = scene.robot(0).x
        for _ in range(60):
            scene.tick()
        assert scene.robot(0).x - before == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize("engine", ENGINES)
def test_each_robot_of_a_scene_is_what_it_is(engine):
    short, slow = replace(STANDARD, length=0.5, wheelbase=0.24), replace(STANDARD, wheel_speed=4.0)
    start = [BoxSpec(0.4, 0.05, 0.0, 0.03)], [RobotSpec(-3.0, 3.0, 0.0, 0.0), RobotSpec(-1.2, 0.3, 0.0, 0.2)]
    with Scene(PLACE, *start, robot=(slow, short), engine=engine) as scene:
        assert scene.models == (slow, short)
        result = run_alone(
            scene, 1, make_executor("staged")(scene, 1, INTO_PIT, everything_else(scene, 1), seed=1)
        )
        assert result.success and scene.box_seated(0, PLACE.pits[0])
        ends = scene.ticks, scene.robot(1)
        scene.drive(0, 8.0, 8.0)
        for _ in range(90):
            scene.tick()
        before = scene.robot(0).x
        for _ in range(60):
            scene.tick()
        assert scene.robot(0).x - before == pytest.approx(0.48, abs=0.02)
        scene.place_robot(1, -3.0, -3.0, 0.0, 0.0)
        assert scene.robot(1).z == pytest.approx(0.0)
    _, ticks, places, _ = pushed_into_the_pit(engine, short, "staged")
    assert ends[0] == ticks and ends[1] == pytest.approx(places[6:], abs=1e-3)


def test_robots_of_two_scales_make_no_scene():
    for robots in ([STANDARD, HALF], [STANDARD]):
        with pytest.raises(ValueError, match="expected 2 robots of one scale"):
            Scene(PLACE, [], [RobotSpec(0, 0, 0, 0), RobotSpec(0, 3, 0, 0)], robot=robots)


def test_what_is_alike_has_the_same_numbers_in_its_own_units():
    assert HALF.scale == 0.5 and HALF.length == 0.36 and HALF.mass == pytest.approx(50.0 / 8)
    assert HALF.wheel_speed == pytest.approx(8.0 * math.sqrt(2.0))
    units = HALF.in_units()
    assert [getattr(units, name) for name in LIMITS] == pytest.approx([getattr(STANDARD, name) for name in LIMITS])
    assert STANDARD.in_units() is STANDARD


@pytest.mark.parametrize("robot", [STANDARD, HALF, STANDARD.scaled(SCALES[0]), STANDARD.scaled(SCALES[1])])
def test_robots_that_are_alike_are_no_trouble(robot):
    assert robot.trouble() is None


@pytest.mark.parametrize("field", LIMITS)
@pytest.mark.parametrize(("side", "factor"), [(0, 0.99), (1, 1.01)])
def test_what_the_controls_cannot_handle_is_told_with_its_bounds_at_every_scale(field, side, factor):
    wrong = replace(STANDARD, **{field: factor * LIMITS[field][side]})
    for scale in (1.0, 0.5, 2.0):
        trouble = wrong.scaled(scale).trouble()
        assert trouble is not None
        found, message = trouble
        assert found == field and "expected" in message and ("at scale" in message) == (scale != 1.0)


@pytest.mark.parametrize(
    ("changes", "field", "message"),
    [
        ({"length": 0.66}, "wheelbase", "got 0.44, expected at most 0.4, so that the wheels are behind the bumper"),
        ({"length": 0.8}, "length", "turns in a disc of 0.503 m, expected at most 0.4813 m"),
    ],
)
def test_numbers_that_do_not_go_together_are_refused(changes, field, message):
    trouble = replace(STANDARD, **changes).trouble()
    assert trouble is not None and trouble[0] == field and message in trouble[1]


def test_the_network_sees_a_box_from_behind_the_bumper():
    task = PushTask(0, (0.0, 0.0), (1.0, 0.0), "flat", 0.0)
    box = Pose(0.0, 0.0, 0.125, 0.0, 0.0, 0.0)
    standard = observe(Pose(-0.86, 0.0, 0.0, 0.0, 0.0, 0.0), box, task)
    short = observe(Pose(-0.80, 0.0, 0.0, 0.0, 0.0, 0.0), box, task, STANDARD.bumper - 0.06)
    assert short == pytest.approx(standard)


def test_motors_may_be_as_fast_as_the_controls_ask_for():
    small = replace(STANDARD, wheel_radius=0.08, wheel_speed=12.0)
    assert small.trouble() is None and replace(STANDARD, wheel_radius=0.13, wheelbase=0.42).trouble() is None
    for scale in (0.5, 2.0):
        assert small.scaled(scale).trouble() is None
