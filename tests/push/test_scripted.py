import hashlib
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

from colonysim.physics import BoxSpec, Ground, Pit, Pose, Ramp, RobotSpec, Scene, Terrain
from colonysim.push import (
    PushSettings,
    PushTask,
    Surroundings,
    drive_to,
    everything_else,
    face_for,
    plan_push,
    run_alone,
    scripted_push,
    stage,
)
from colonysim.push.staging import first_legs, legs_for

pytestmark = pytest.mark.usefixtures("engine")

GROUND = Ground(-6, -6, 6, 6, 0.0)
FLAT = Terrain((GROUND,))


def push(scene, task, **settings):
    chosen = PushSettings(**settings)
    return run_alone(scene, 0, scripted_push(scene, 0, task, everything_else(scene, 0), settings=chosen))


@pytest.mark.parametrize(("line", "heading"), [(0.0, 0.3), (0.6, 3.0), (-2.2, -1.0)])
def test_straight_push_on_level_ground(line, heading):
    c, s = math.cos(line), math.sin(line)
    robot = RobotSpec(-2 * c, -2 * s, 0, heading)
    with Scene(FLAT, [BoxSpec(0.02, -0.02, 0, line + 0.04)], [robot]) as scene:
        log = []
        task = PushTask(0, (0, 0), (2.5 * c, 2.5 * s), "flat", 0.0)
        manoeuvre = scripted_push(
            scene, 0, task, everything_else(scene, 0), lambda who, what, ticks: log.append((who, what, ticks))
        )
        result = run_alone(scene, 0, manoeuvre)
        box = scene.box(0)
        assert (result.success, result.reason, result.tries) == (True, "done", 1)
        assert math.dist((box.x, box.y), task.goal) < 0.08
        assert sum(ticks for _, _, ticks in log) == scene.ticks
        assert {who for who, _, _ in log} == {"script"}
        assert log[-1][1] == "push"


@pytest.mark.parametrize("degrees", [6.5, 8.0])
def test_push_up_a_ramp(degrees):
    rise = 2.5 * math.tan(math.radians(degrees))
    low, top = Ground(-6, -3, 0, 3, 0.0), Ground(2.5, -3, 7, 3, rise)
    terrain = Terrain((low, top), ramps=(Ramp(0, 0, 0, 2.5, 0, rise),))
    with Scene(terrain, [BoxSpec(-0.1, 0.03, 0, 0.05)], [RobotSpec(-2.4, 0.1, 0, 2.0)]) as scene:
        result = push(scene, PushTask(0, (0, 0), (2.5, 0), "slope", rise))
        assert result.reason == "done"
        result = push(scene, PushTask(0, (2.5, 0), (4.5, 0), "flat", rise))
        assert result.reason == "done"
        assert scene.box(0).z == pytest.approx(rise + 0.125, abs=0.01)


def test_chain_with_a_corner_then_a_hole_then_across():
    pit = Pit(2.4, 2.4, math.pi / 2)
    terrain = Terrain((GROUND,), (pit,))
    with Scene(terrain, [BoxSpec(0, 0.03, 0, -0.04)], [RobotSpec(-2, 0, 0, 1.0)]) as scene:
        assert push(scene, PushTask(0, (0, 0), (2.4, 0), "flat", 0.0)).success
        assert not scene.pit_filled(pit)
        assert push(scene, PushTask(0, (2.4, 0), (2.4, 2.4), "hole", 0.0, 0)).success
        assert scene.box_seated(0, pit)
        assert scene.pit_filled(pit)
        across = run_alone(scene, 0, drive_to(scene, 0, 2.4, 4.4, everything_else(scene, 0)))
        assert across.success
        assert scene.robot_fault(0) is None
        assert scene.box_seated(0, pit)


def test_straight_on_needs_no_staging():
    with Scene(FLAT, [BoxSpec(0, 0, 0, 0)], [RobotSpec(-2, 0, 0, 0)]) as scene:
        assert push(scene, PushTask(0, (0, 0), (1.5, 0), "flat", 0.0)).success
        controls = []
        task = PushTask(0, (1.5, 0), (3.0, 0.1), "flat", 0.0)
        manoeuvre = scripted_push(
            scene, 0, task, everything_else(scene, 0), lambda who, what, ticks: controls.append(what)
        )
        assert run_alone(scene, 0, manoeuvre).success
        assert controls == ["push"]


def test_diagonal_is_split_and_the_box_keeps_its_yaw():
    with Scene(FLAT, [BoxSpec(0, 0, 0, 0)], [RobotSpec(-2, 0, 0, 0)]) as scene:
        task = PushTask(0, (0, 0), (2.2, 1.2), "flat", 0.0)
        plan = plan_push(scene, 0, task, Surroundings())
        assert [leg.goal for leg in plan.legs] == [pytest.approx((0, 1.2)), pytest.approx((2.2, 1.2))]
        assert plan.margin > 0
        assert push(scene, task).success
        assert abs(scene.box(0).yaw) < 0.05


def test_a_box_that_hangs_at_the_edge_is_pressed_in_from_where_it_came():
    pit = Pit(2.0, 1.0, 0.1)
    task = PushTask(0, (0, 1), (2.0, 1.0), "hole", 0.0, 0)
    (leg,) = legs_for(Pose(2.05, 1.08, 0.0, 0.0, 0.25, 0.02), task, pit)
    assert leg.hole
    assert leg.heading == pytest.approx(0.0)


def test_an_askew_box_straightens_on_its_way_to_the_pit():
    pit = Pit(2.4, 0.0, 0.0)
    with Scene(Terrain((GROUND,), (pit,)), [BoxSpec(0, 0, 0, 0.5)], [RobotSpec(-2, 0, 0, 0)]) as scene:
        assert push(scene, PushTask(0, (0, 0), (2.4, 0), "hole", 0.0, 0)).success


def test_an_askew_box_straightens_round_a_corner():
    pit = Pit(1.4, 1.4, 0.0)
    with Scene(Terrain((GROUND,), (pit,)), [BoxSpec(0, 0, 0, 0.5)], [RobotSpec(-2, 0, 0, 0)]) as scene:
        assert push(scene, PushTask(0, (0, 0), (1.4, 1.4), "hole", 0.0, 0)).success


def test_a_push_is_split_so_that_no_leg_is_staged_in_a_pit():
    # Upwards first, then to the left, would be staged in the pit on the right.
    pit = Pit(1.45, 1.3, 0.0)
    with Scene(Terrain((GROUND,), (pit,)), [BoxSpec(0, 0, 0, 0)], [RobotSpec(-1.5, -1.5, 0, 0)]) as scene:
        task = PushTask(0, (0, 0), (-1.4, 1.3), "flat", 0.0)
        around = everything_else(scene, 0)()
        first = legs_for(scene.box(0), task, None)[0]
        assert first.goal == pytest.approx((0, 1.3))
        plan = plan_push(scene, 0, task, around)
        assert plan.legs[0].goal == pytest.approx((-1.4, 0))
        assert plan.margin >= 0.0
        assert push(scene, task).success


def test_a_push_at_an_askew_face_may_be_split_either_way_or_not_at_all():
    with Scene(FLAT, [BoxSpec(0, 0, 0, 0.5)], [RobotSpec(-2, 0, 0, 0)]) as scene:
        around = everything_else(scene, 0)()
        askew = PushTask(0, (0, 0), (2.0, 0.0), "flat", 0.0)
        one, other, straight = first_legs(scene, askew, around)
        assert one.length < other.length
        assert straight.goal == askew.goal
        square = PushTask(0, (0, 0), (2.0, 1.0), "flat", 0.0)
        assert [leg.goal for leg in first_legs(scene, square, around)] == [square.goal]


def test_no_room_behind_the_box_is_a_reason_not_a_hang():
    terrain = Terrain((Ground(-0.9, -6, 6, 6, 0.0),))
    with Scene(terrain, [BoxSpec(0, 0, 0, 0)], [RobotSpec(1.5, 2, 0, 0)]) as scene:
        task = PushTask(0, (0, 0), (2, 0), "flat", 0.0)
        plan = plan_push(scene, 0, task, Surroundings())
        assert plan.margin < 0
        assert plan.reason == "no staging pose"
        result = push(scene, task)
        assert (result.success, result.reason) == (False, "no staging pose")
        assert result.seconds < 1.0


def test_a_robot_standing_at_the_staging_pose_blocks_for_a_bounded_time():
    robots = [RobotSpec(0, 3, 0, 0), RobotSpec(-1.2, 0, 0, 0)]
    with Scene(FLAT, [BoxSpec(0, 0, 0, 0)], robots) as scene:
        result = push(scene, PushTask(0, (0, 0), (2, 0), "flat", 0.0))
        assert result.reason in ("no staging pose", "blocked")
        assert result.seconds < 40
        assert math.dist(scene.robot(1)[:2], (-1.2, 0)) < 0.01


def test_empty_pits_are_walls_to_plans_and_boxes_stray_into_them():
    terrain = Terrain((GROUND,), (Pit(2.0, 0.0, 0.0), Pit(-1.3, 4, 0)))
    with Scene(terrain, [BoxSpec(0, 0, 0, 0), BoxSpec(0, 4, 0, 0)], [RobotSpec(-3, 0, 0, 0)]) as scene:
        around = everything_else(scene, 0)()
        assert around.open_pits == (0, 1)
        plan = plan_push(scene, 0, PushTask(0, (0, 0), (4, 0), "flat", 0.0), around)
        assert plan.reason == "way of the box blocked"
        plan = plan_push(scene, 1, PushTask(1, (0, 4), (2, 4), "flat", 0.0), around)
        assert plan.reason == "no staging pose"
        result = push(scene, PushTask(0, (0, 0), (4, 0), "flat", 0.0))
        assert result.reason == "box stray"
        assert scene.robot_fault(0) is None


def test_timeout_is_kept():
    with Scene(FLAT, [BoxSpec(0, 0, 0, 0)], [RobotSpec(-2, 0, 0, 0)]) as scene:
        result = push(scene, PushTask(0, (0, 0), (3, 0), "flat", 0.0), limit=5.0)
        assert result.reason == "timeout"
        assert result.seconds == pytest.approx(5.0, abs=0.05)


@pytest.mark.parametrize("heading", [0.0, 2.5, -1.6])
def test_coarse_staging_leaves_the_robot_in_its_region(heading):
    robot = RobotSpec(1.8, 1.5, 0, heading)
    with Scene(FLAT, [BoxSpec(0, 0, 0, 0.1)], [robot]) as scene:
        before = scene.box(0)
        result = run_alone(scene, 0, stage(scene, 0, 0, 0.1, everything_else(scene, 0), coarse=True))
        assert result.success
        pose, box = scene.robot(0), scene.box(0)
        assert math.dist(before[:2], box[:2]) < 1e-3
        assert 1.14 <= math.dist(pose[:2], box[:2]) <= 1.61
        bearing = math.atan2(box.y - pose.y, box.x - pose.x)
        assert abs(bearing - 0.1) < 0.36
        assert abs(pose.yaw - 0.1) < 0.82


def test_faces():
    with Scene(FLAT, [BoxSpec(0, 0, 0, 0.2)], []) as scene:
        box = scene.box(0)
    heading, mismatch = face_for(box, 0.3)
    assert (heading, mismatch) == (pytest.approx(0.2), pytest.approx(0.1))
    heading, mismatch = face_for(box, math.pi)
    assert heading == pytest.approx(0.2 + math.pi - 2 * math.pi)
    assert mismatch == pytest.approx(-0.2)


def run_together(scene, running):
    """Step several robots' manoeuvres on one clock; returns their results in the robots' order."""
    results = {}
    while len(results) < len(running):
        for i, manoeuvre in enumerate(running):
            if i in results:
                continue
            try:
                scene.drive(i, *next(manoeuvre))
            except StopIteration as end:
                results[i] = end.value
                scene.drive(i, 0.0, 0.0)
        scene.tick()
        assert scene.time < 60
    return [results[i] for i in range(len(running))]


def test_two_robots_push_at_once():
    robots = [RobotSpec(-2, 0, 0, 1), RobotSpec(-2, 3, 0, 2)]
    with Scene(FLAT, [BoxSpec(0, 0, 0, 0), BoxSpec(0, 3, 0, 0)], robots) as scene:
        tasks = [PushTask(i, (0, 3.0 * i), (2, 3.0 * i), "flat", 0.0) for i in range(2)]
        pushes = [scripted_push(scene, i, task, everything_else(scene, i)) for i, task in enumerate(tasks)]
        assert [result.reason for result in run_together(scene, pushes)] == ["done", "done"]


def test_two_robots_that_swap_places_go_round_each_other():
    with Scene(FLAT, [], [RobotSpec(-3, 0, 0, 0), RobotSpec(3, 0, 0, math.pi)]) as scene:
        ways = [drive_to(scene, i, 3.0 - 6 * i, 0.0, everything_else(scene, i)) for i in range(2)]
        assert [result.reason for result in run_together(scene, ways)] == ["done", "done"]


def test_a_robot_on_its_way_chooses_its_wheel_speeds_15_times_a_second():
    with Scene(FLAT, [], [RobotSpec(0, 0, 0, 0.1)]) as scene:
        told = []
        way = drive_to(scene, 0, 3.0, 0.5, log=lambda _, control, ticks: told.append((control, ticks)))
        speeds = []
        for wheels in way:
            speeds.append(wheels)
            scene.drive(0, *wheels)
            scene.tick()
        assert math.dist(scene.robot(0)[:2], (3.0, 0.5)) < 0.1
        choices = [set(speeds[k : k + 4]) for k in range(0, len(speeds), 4)]
        assert all(len(choice) == 1 for choice in choices) and len(set().union(*choices)) > len(choices) // 2
        assert sum(ticks for _, ticks in told) == len(speeds)


def fingerprint():
    """Hash of all poses of a push into a rotated pit, with a resting box and a robot that wakes late."""
    pit = Pit(2.0, 1.0, math.atan2(1.0, 2.0))
    boxes = [BoxSpec(0, 0, 0, pit.yaw), BoxSpec(0, 3, 0, 0.3)]
    robots = [RobotSpec(-1.8, -0.9, 0, 2.0), RobotSpec(4, -3, 0, 0)]
    digest = hashlib.sha256()
    with Scene(Terrain((GROUND,), (pit,)), boxes, robots) as scene:

        def look():
            digest.update(repr([scene.box(i) for i in (0, 1)] + [scene.robot(i) for i in (0, 1)]).encode())

        task = PushTask(0, (0, 0), (2, 1), "hole", 0.0, 0)
        around = everything_else(scene, 0)
        assert run_alone(scene, 0, scripted_push(scene, 0, task, around), look).success
        late = drive_to(scene, 1, 4, 4, everything_else(scene, 1))
        assert run_alone(scene, 1, late, look).success
    return digest.hexdigest()


def test_same_poses_in_another_process(engine):
    here = str(Path(__file__).parent)
    code = f"import sys; sys.path.insert(0, {here!r}); import colonysim.physics.engine as e; "
    code += f"e.ENGINES = ({engine!r},); import test_scripted; print(test_scripted.fingerprint())"
    other = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONHASHSEED": "7"},
    )
    assert other.stdout.split()[-1] == fingerprint()
