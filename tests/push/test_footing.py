"""Height of the ground and room to its border, and ways that keep that room."""

import math
import random

import pytest

from colonysim.physics import BoxSpec, Ground, Pit, Ramp, RobotSpec, Scene, Terrain
from colonysim.push.footing import AMPLE, BORDER_CLEARANCE, COMFORT, Footing, footing_on
from colonysim.push.paths import BOX_CLEARANCE, PIT_CLEARANCE, ROBOT_CLEARANCE, FreeSpace, Surroundings

pytestmark = pytest.mark.usefixtures("engine")

LOW, HIGH = Ground(-5.0, -5.0, 0.0, 5.0, 0.0), Ground(2.0, -5.0, 8.0, 5.0, 0.3)
RAMP = Ramp(0.0, 0.0, 0.0, 2.0, 0.0, 0.3, half_width=1.5)
PLACE = Footing(Terrain((LOW, HIGH), (), (RAMP,)))


@pytest.mark.parametrize(
    ("x", "y", "height"),
    [
        (-3.0, 1.0, 0.0), (4.0, 1.0, 0.3), (1.0, 1.0, 0.15), (2.0, 0.0, 0.3),
        (1.0, 1.6, -math.inf), (-5.1, 0.0, -math.inf),
    ],
)
def test_height_of_level_ground_of_a_ramp_and_beside_both(x, y, height):
    assert PLACE.height(x, y) == pytest.approx(height)


@pytest.mark.parametrize(
    ("x", "y", "slack"),
    [
        (-3.0, 0.0, AMPLE),
        (1.0, 0.0, AMPLE),  # amid the ramp, which is less steep than what wheels climb
        (0.0, 0.0, AMPLE),  # at its foot
        (-4.5, 0.0, 0.0),  # .50 m from the border: enough, but not ample
        (-4.7, 0.0, -COMFORT),
        (-5.2, 0.0, -BORDER_CLEARANCE),
        (1.5, 1.2, -COMFORT),  # on the ramp, beside a fall
    ],
)
def test_room_towards_borders_and_cliffs(x, y, slack):
    assert PLACE.slack(x, y) == slack


@pytest.mark.parametrize(("step", "slack"), [(0.03, AMPLE), (0.045, -COMFORT)])
def test_a_low_step_is_passed_over_and_a_higher_one_is_not(step, slack):
    grounds = Ground(-5.0, -5.0, 0.0, 5.0, 0.0), Ground(0.0, -5.0, 5.0, 5.0, step)
    assert Footing(Terrain(grounds)).slack(-0.25, 0.0) == slack


def test_two_grounds_of_one_level_that_meet_are_no_border():
    assert Footing(Terrain((LOW, Ground(0.0, -5.0, 5.0, 5.0, 0.0)))).slack(0.0, 0.0) == AMPLE


def test_the_footing_of_a_terrain_is_made_once():
    assert footing_on(Terrain((LOW,))) is footing_on(Terrain((LOW,)))


def test_slack_is_the_distance_to_the_nearest_obstacle_less_what_is_kept_from_it():
    pit = Pit(3.0, 0.0, 0.2)
    terrain = Terrain((Ground(-20.0, -20.0, 20.0, 20.0, 0.0),), (pit,))
    box = BoxSpec(-3.0, 0.5, 0.0, 0.4)
    rng = random.Random(5)
    with Scene(terrain, [box], [RobotSpec(0.0, 3.0, 0.0, 0.0)]) as scene:
        space = FreeSpace(scene, Surroundings((0,), (0,), (0,), ((0.0, -3.0, 0.7),)))
        for _ in range(500):
            x, y = rng.uniform(-6.0, 6.0), rng.uniform(-6.0, 6.0)
            c, s = math.cos(box.yaw), math.sin(box.yaw)
            dx, dy = x - box.x, y - box.y
            beside_box = [max(0.0, abs(a) - box.length / 2) for a in (c * dx + s * dy, c * dy - s * dx)]
            wanted = min(
                AMPLE,
                math.hypot(*beside_box) - BOX_CLEARANCE,
                pit.distance(x, y) - PIT_CLEARANCE,
                math.dist((x, y), (0.0, 3.0)) - ROBOT_CLEARANCE,
                math.dist((x, y), (0.0, -3.0)) - 0.7,
            )
            assert space.slack(x, y) == pytest.approx(wanted, abs=1e-6)


def test_a_way_is_clear_as_far_as_its_narrowest_place():
    terrain = Terrain((Ground(-20.0, -20.0, 20.0, 20.0, 0.0),))
    with Scene(terrain, [BoxSpec(0.0, 1.2, 0.0, 0.0)], []) as scene:
        space = FreeSpace(scene, Surroundings((), (0,)))
        assert space.slack(0.0, 0.0) == pytest.approx(0.2)
        assert space.clear((-4.0, 0.0), (4.0, 0.0), 0.19) and not space.clear((-4.0, 0.0), (4.0, 0.0), 0.21)
        assert space.path((-4.0, 0.0), (4.0, 0.0)) == [(4.0, 0.0)]
        around = space.path((-4.0, 1.2), (4.0, 1.2))
        assert around is not None and len(around) > 1
        assert all(space.clear(a, b, 0.05) for a, b in zip([(-4.0, 1.2), *around], around, strict=False))
        assert space.path((-4.0, 1.2), (0.0, 1.2)) is None
