import math

import pytest

pytest.importorskip("pybullet")

from colonysim.physics import BoxSpec, Ground, RobotSpec, Scene, Terrain, wheel_speeds

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
