import base64
import json
import math
import os
import re
import subprocess
import sys

import pytest

from colonysim.installing import install_command
from colonysim.physics import (
    STANDARD,
    TICK_SECONDS,
    BoxSpec,
    Ground,
    MissingEngineError,
    Pit,
    Ramp,
    RobotSpec,
    Scene,
    Terrain,
    make_engine,
    wheel_speeds,
)
from colonysim.physics.engine import STEP_SECONDS, default_engine
from colonysim.physics.traction import Traction

pytestmark = pytest.mark.usefixtures("engine")

FLAT = Terrain((Ground(-5, -5, 5, 5, 0.0),))


@pytest.mark.parametrize("yaw", [0.0, 0.1, 0.785, 2.0])
def test_robot_follows_wheel_speeds_in_every_direction(yaw):
    with Scene(FLAT, [], [RobotSpec(0, 0, 0, yaw)]) as scene:
        for _ in range(30):
            scene.tick()
        scene.drive(0, *wheel_speeds(0.5, 0.0))
        for _ in range(120):
            scene.tick()
        pose = scene.robot(0)
        assert math.hypot(pose.x, pose.y) == pytest.approx(1.0, abs=0.03)
        assert math.atan2(pose.y, pose.x) == pytest.approx(yaw, abs=0.01)
        assert pose.z == pytest.approx(0.0, abs=0.005)
        scene.drive(0, *wheel_speeds(0.0, 0.5))
        for _ in range(60):
            scene.tick()
        assert scene.robot(0).yaw - yaw == pytest.approx(0.5, abs=0.03)


def test_robot_pushes_a_box_straight():
    with Scene(FLAT, [BoxSpec(1.0, 0, 0, 0)], [RobotSpec(0, 0, 0, 0)]) as scene:
        scene.drive(0, *wheel_speeds(0.36, 0.0))
        for _ in range(60 * 5):
            scene.tick()
        box, robot = scene.box(0), scene.robot(0)
        assert box.x - robot.x == pytest.approx(0.86, abs=0.02)
        assert box.x > 2.4
        assert abs(box.y) < 0.05
        assert abs(box.yaw) < 0.05


def test_an_engine_can_be_derived_from():
    """What a derived class replaces is called: so pushes are recorded, or a wind is added."""
    plain = make_engine(default_engine())
    plain.close()

    class Counted(type(plain)):
        steps = 0

        def step(self):
            self.steps += 1
            super().step()

    engine = Counted(dt=STEP_SECONDS)
    with Scene(FLAT, [], [RobotSpec(0, 0, 0, 0)], engine=engine) as scene:
        scene.drive(0, *wheel_speeds(0.5, 0.0))
        for _ in range(60):
            scene.tick()
        assert engine.steps == 60 * round(TICK_SECONDS / STEP_SECONDS)
        assert scene.robot(0).x > 0.3


def test_sleeping_bodies_wake_when_driven_or_bumped():
    robots = [RobotSpec(0, 0, 0, 0), RobotSpec(3.2, 0, 0, math.pi / 2)]
    with Scene(FLAT, [BoxSpec(1.5, 0, 0, 0)], robots) as scene:
        for _ in range(300):
            scene.tick()
        scene.drive(0, *wheel_speeds(0.05, 0.0))
        for _ in range(300):
            scene.tick()
        assert scene.robot(0).x == pytest.approx(0.25, abs=0.02)
        scene.drive(0, *wheel_speeds(0.4, 0.0))
        for _ in range(300):
            scene.tick()
        assert scene.box(0).x > 1.7
        scene.drive(0, 0.0, 0.0)
        for _ in range(300):
            scene.tick()
        scene.drive(0, *wheel_speeds(-0.4, 0.0))
        before = scene.robot(0).x
        for _ in range(60):
            scene.tick()
        assert scene.robot(0).x == pytest.approx(before - 0.4, abs=0.03)


def run(scene, seconds, robot=0, speeds=(0.0, 0.0)):
    scene.drive(robot, *speeds)
    for _ in range(round(seconds * 60)):
        scene.tick()


def test_a_robot_in_a_pit_is_found_out():
    pit = Pit(1.5, 0, 0, depth=0.5)
    with Scene(Terrain((FLAT.grounds[0],), (pit,)), [], [RobotSpec(0, 0, 0, 0)]) as scene:
        run(scene, 0.5)
        assert scene.robot_fault(0) is None
        run(scene, 4.0, 0, wheel_speeds(0.6, 0.0))
        assert scene.robot_fault(0) in ("in_pit", "flipped")


def test_a_flipped_robot_has_no_traction_and_is_found_out():
    with Scene(FLAT, [], [RobotSpec(0, 0, 0, 0)]) as scene:
        body = scene._tractions[0].body
        scene._engine.place(body, (0, 0, 0.4), (1.0, 0.0, 0.0, 0.0))
        run(scene, 2.0, 0, wheel_speeds(0.5, 0.0))
        assert scene.robot_fault(0) == "flipped"
        assert math.hypot(*scene.robot(0)[:2]) < 0.05


def test_an_airborne_robot_has_no_traction():
    with Scene(FLAT, [], [RobotSpec(0, 0, 0, 0)]) as scene:
        scene.place_robot(0, 0, 0, 1.0, 0)
        run(scene, 0.3, 0, wheel_speeds(0.8, 0.8))
        assert scene.robot(0).z > 0.3
        assert scene.robot(0).x < 0.1


def test_a_robot_that_leaves_the_ground_or_has_no_pose_is_found_out():
    with Scene(FLAT, [], [RobotSpec(6.0, 0, 0, 0), RobotSpec(0, 0, 0, 0)]) as scene:
        run(scene, 1.0)
        assert scene.robot_fault(0) == "fallen"
        assert scene.robot_fault(1) is None
        scene.place_robot(1, math.nan, 0, 0, 0)
        assert scene.robot_fault(1) == "nan"


class Told:
    """An engine that says where the body is."""

    def __init__(self, *place: float) -> None:
        self.place = place

    def pose(self, body):
        return self.place[:3], self.place[3:]


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("part", range(7))
def test_a_pose_that_is_no_number_in_any_of_its_parts_is_found_out(part, wrong):
    place = [0.0, 0.0, 0.2, 0.1, 0.1, 0.1, 1.0]
    assert math.isfinite(Traction(Told(*place), 0, STANDARD).lowest())
    place[part] = wrong
    assert not math.isfinite(Traction(Told(*place), 0, STANDARD).lowest())


def test_a_robot_on_low_ground_beside_a_higher_pit_is_well():
    low, high = Ground(-3, -3, 3, 3, 0.0), Ground(4, -3, 10, 3, 1.0)
    with Scene(Terrain((low, high), (Pit(7, 0, 0, rim=1.0),)), [], [RobotSpec(0, 0, 0, 0)]) as scene:
        run(scene, 0.5)
        assert scene.robot_fault(0) is None


def test_placed_bodies_are_at_rest_and_removed_ones_are_gone():
    with Scene(FLAT, [BoxSpec(1.5, 0, 0, 0)], [RobotSpec(0, 0, 0, 0), RobotSpec(0, 2, 0, 0)]) as scene:
        run(scene, 2.5, 0, wheel_speeds(0.6, 0.0))
        scene.place_robot(0, -2, 0, 0, 1.0)
        scene.place_box(0, 3, 1, 0, 0.2)
        run(scene, 0.5)
        assert scene.robot(0)[:2] == pytest.approx((-2, 0), abs=1e-3)
        assert scene.robot(0).yaw == pytest.approx(1.0, abs=1e-3)
        assert scene.box(0)[:3] == pytest.approx((3, 1, 0.125), abs=2e-3)
        scene.remove_robot(1)
        assert not scene.has_robot(1)
        with pytest.raises(LookupError, match="robot 1 has left"):
            scene.robot(1)
        run(scene, 0.1)


def test_a_half_filled_pit_is_not_filled():
    pit = Pit(0, 0, 0, depth=0.5)
    terrain = Terrain(FLAT.grounds, (pit,))
    with Scene(terrain, [BoxSpec(0, 0, -0.5, 0), BoxSpec(3, 0, 0, 0)], []) as scene:
        for _ in range(60):
            scene.tick()
        assert scene.box_seated(0, pit)
        assert not scene.pit_filled(pit)
        assert not scene.box_seated(1, pit)
        scene.place_box(1, 0, 0, -0.25, 0.02)
        for _ in range(60):
            scene.tick()
        assert scene.box_seated(1, pit)
        assert scene.pit_filled(pit)


def test_a_missing_engine_says_how_to_get_one(engine, monkeypatch):
    monkeypatch.setitem(sys.modules, {"bullet": "pybullet", "mujoco": "mujoco"}[engine], None)
    with pytest.raises(MissingEngineError, match=re.escape(install_command(engine))):
        Scene(FLAT, [], [])


def test_an_engine_that_there_is_not_is_refused():
    with pytest.raises(ValueError, match="no engine 'ode', expected one of bullet, mujoco"):
        Scene(FLAT, [], [], engine="ode")


@pytest.mark.parametrize(("friction", "slides"), [(0.35, True), (0.65, False)])
def test_friction_is_the_product_of_both_coefficients(friction, slides):
    # Ground has .8: on a slope of 20 degrees (tangent .364) a box slides with .8 x .35 and stays with .8 x .65.
    rise = 4 * math.tan(math.radians(20))
    terrain = Terrain((Ground(-4, -3, 0, 3, 0.0), Ground(4, -3, 8, 3, rise)), ramps=(Ramp(0, 0, 0, 4, 0, rise),))
    with Scene(terrain, [BoxSpec(2.0, 0.0, rise / 2 + 0.25, 0.0, friction=friction)], []) as scene:
        for _ in range(180):
            scene.tick()
        assert (scene.box(0).x < 1.5) is slides
        assert slides or scene.box(0).x > 1.8


def test_a_state_is_gone_on_from(engine):
    """Bit for bit where the engine says so, nearly so elsewhere; also by way of JSON."""

    def scene():
        robots = [RobotSpec(0, 0, 0, 0), RobotSpec(0, 2, 0, 0), RobotSpec(-3, -3, 0, 0)]
        return Scene(FLAT, [BoxSpec(1.0, 0.1, 0, 0.1), BoxSpec(1.0, 2.2, 0, 0)], robots)

    def places(scene):
        return [*scene.box(0), *scene.box(1), *scene.robot(0), *scene.robot(1)]

    with scene() as first, scene() as second:
        first.remove_robot(2)
        run(first, 3.0, 0, wheel_speeds(0.36, 0.05))
        first.drive(1, *wheel_speeds(0.4, -0.1))
        state = json.loads(json.dumps(first.save()))
        run(first, 2.0, 0, wheel_speeds(0.36, 0.0))
        second.load(state)
        assert (second.ticks, second.present_robots()) == (180, (0, 1))
        run(second, 2.0, 0, wheel_speeds(0.36, 0.0))
        assert second.engine.exact_state is (engine == "mujoco")
        if second.engine.exact_state:
            assert places(second) == places(first)
        else:
            assert places(second) == pytest.approx(places(first), abs=0.1)


@pytest.mark.parametrize("damage", ["not", "of", "another", "lower", "longer"])
def test_what_is_no_state_of_the_scene_is_refused(damage):
    with (
        Scene(FLAT, [BoxSpec(1, 0, 0, 0)], [RobotSpec(0, 0, 0, 0)]) as one,
        Scene(FLAT, [], [RobotSpec(0, 0, 0, 0), RobotSpec(0, 3, 0, 0)]) as other,
        Scene(Terrain((Ground(-5, -5, 5, 5, -1.0),)), [BoxSpec(1, 0, 0, 0)], [RobotSpec(0, 0, 0, 0)]) as lower,
        Scene(FLAT, [BoxSpec(1, 0, 0, 0, length=0.8)], [RobotSpec(0, 0, 0, 0)]) as longer,
    ):
        broken = base64.b64encode(b"nothing").decode()
        states = {"not": {}, "of": {**one.save(), "engine": broken}, "another": other.save()} | {
            "lower": lower.save(), "longer": longer.save(),
        }  # fmt: skip
        state = states[damage]
        with pytest.raises(ValueError, match="saved state"):
            one.load(state)


STATE = """
import json, math, sys
from colonysim.physics import BoxSpec, Ground, RobotSpec, Scene, Terrain, make_engine, wheel_speeds
state = json.load(sys.stdin)
terrain = Terrain((Ground(-5, -5, 5, 5, 0.0),))
with Scene(terrain, [BoxSpec(1, 0, 0, 0.1)], [RobotSpec(0, 0, 0, 0)], engine="mujoco") as s:
    s.load(state)
    s.drive(0, *wheel_speeds(0.2, 0.02))
    for _ in range(500):
        s.tick()
    print(json.dumps([*s.box(0), *s.robot(0)]))
"""


def test_another_process_goes_on_with_the_same_bits_for_a_thousand_steps(engine):
    if engine != "mujoco":
        pytest.skip("Bullet's state is not exact")
    with Scene(FLAT, [BoxSpec(1, 0, 0, 0.1)], [RobotSpec(0, 0, 0, 0)]) as scene:
        run(scene, 2.0, 0, wheel_speeds(0.36, 0.0))
        state = scene.save()
        run(scene, 500 / 60, 0, wheel_speeds(0.2, 0.02))
        assert scene.box(0).x > 1.5
        here = [*scene.box(0), *scene.robot(0)]
    done = subprocess.run(
        [sys.executable, "-c", STATE], input=json.dumps(state), capture_output=True, text=True, check=True, timeout=120,
        env={**os.environ, "PYTHONHASHSEED": "7"},
    )  # fmt: skip
    assert json.loads(done.stdout) == here


def test_bodies_that_get_out_of_hand_are_told_and_leave_no_file(engine, tmp_path, monkeypatch):
    if engine != "mujoco":
        pytest.skip("about MuJoCo's own log")
    monkeypatch.chdir(tmp_path)
    made = make_engine("mujoco")
    with Scene(FLAT, [], [RobotSpec(0, 0, 0, 0)], engine=made) as scene, pytest.warns(RuntimeWarning, match="MuJoCo: "):
        for _ in range(10):
            made.push(scene._tractions[0].body, (1e30, 0.0, 1e30), (0.0, 0.0, 1e6), (0.0, 1e30, 0.0))
            scene.tick()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("speeds", [(math.nan, 1.0), (1.0, math.inf), (-math.inf, math.nan)])
def test_wheel_speeds_are_numbers(speeds):
    with Scene(FLAT, [], [RobotSpec(0, 0, 0, 0)]) as scene, pytest.raises(ValueError, match="expected finite numbers"):
        scene.drive(0, *speeds)


@pytest.mark.parametrize("keep", [0.5, 0.9, 0.99])
def test_a_damaged_state_is_refused_and_the_scene_stays_as_it_is(keep):
    with Scene(FLAT, [BoxSpec(2, 0, 0, 0)], [RobotSpec(0, 0, 0, 0), RobotSpec(0, 3, 0, 0)]) as scene:
        run(scene, 0.5, 0, wheel_speeds(0.3, 0.0))
        state, before = scene.save(), (scene.robot(0), scene.box(0), scene.ticks)
        raw = base64.b64decode(state["engine"])
        flipped = bytes([*raw[: len(raw) // 2], raw[len(raw) // 2] ^ 255, *raw[len(raw) // 2 + 1 :]])
        broken = [raw[: int(len(raw) * keep)], b"", raw + b"0"]
        broken += [flipped] if scene.engine.name == "bullet" else []
        states = [{**state, "engine": base64.b64encode(each).decode()} for each in broken]
        states += [{**state, "ticks": value} for value in (-1, math.inf, 10**400, "x")]
        states += [{**state, "tractions": value} for value in ([[], []], ["a", "b"], [[0.0] * 7] * 2, 5)]
        states += [{**state, "tractions": [[math.nan] * 8] * 2}, {**state, "tilted": []}, {**state, "engine": "%"}]
        for each in states:
            with pytest.raises(ValueError, match="saved state"):
                scene.load(each)
        assert (scene.robot(0), scene.box(0), scene.ticks) == before
        assert scene.present_robots() == (0, 1)


@pytest.mark.parametrize(
    ("box", "what"),
    [
        (BoxSpec(0, 0, 0, 0, mass=0.0), "box 0: mass 0.0"),
        (BoxSpec(0, 0, 0, 0, length=-1.0), "box 0: length -1.0"),
        (BoxSpec(0, 0, 0, 0, height=math.nan), "box 0: height nan"),
        (BoxSpec(0, 0, 0, 0, friction=-0.1), "box 0: friction -0.1"),
    ],
)
def test_boxes_and_ground_that_cannot_be_are_refused(box, what):
    with pytest.raises(ValueError, match=what):
        Scene(FLAT, [box], [])
    with pytest.raises(ValueError, match="no ground"):
        Scene(Terrain(()), [], [])
    with Scene(FLAT, [], [RobotSpec(0, 0, 0, 0)]) as scene, pytest.raises(LookupError):
        scene.remove_robot(-1)
