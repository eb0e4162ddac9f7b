"""What manoeuvres need of the place, and that robots do not touch."""

from __future__ import annotations

import itertools
import math

import pytest
from backends.places import FORK, LANE, place, started

from colonysim.backends.traffic import CLEARANCE, Traffic, closing_in, segment_distance, ticks_until_close
from colonysim.geometry.layout import lay_out
from colonysim.physics import WheelSpeeds
from colonysim.push.staging import staging_points
from colonysim.scenario.loading import load_scenario
from colonysim.world.intents import Outcome, Push, Travel, Wait

CROSSING = {
    "nodes": [[0, 0, 0], [1, 2, 2], [2, 2, 0], [3, 0, 2], [4, 4, 0], [5, 4, 2]],
    "edges": [[0, 1], [2, 3], [2, 4], [4, 5], [1, 5]],
    "agents": [0, 2],
    "goal": 5,
}


def test_edges_that_cross_exclude_each_other() -> None:
    backend, world = started(place(CROSSING))
    try:
        one, other = backend.footprint(0, Travel(1)), backend.footprint(1, Travel(3))
        assert {1, (0, 1), (2, 3)} <= one
        assert {3, (2, 3), (0, 1)} <= other
        assert world.reserve(0, one)
        assert not world.reserve(1, other)
        assert world.reserve(1, backend.footprint(1, Travel(4)))
        assert backend.footprint(0, Wait()) == frozenset()
    finally:
        backend.close()


@pytest.mark.parametrize(("one", "other"), [((0, 7), (1, 2)), ((21, 23), (22, 27))])
def test_the_crossing_edges_of_hard_exclude_each_other(one: tuple[int, int], other: tuple[int, int]) -> None:
    scenario = load_scenario("hard")
    index = scenario.topology.index
    traffic = Traffic(scenario.topology, lay_out(scenario).places)
    for (i, j), (a, b) in (((one), (other)), ((other), (one))):
        assert tuple(sorted((index[a], index[b]))) in traffic.travel(index[i], index[j])


@pytest.mark.parametrize("name", ["easy", "medium", "hard"])
def test_two_travels_that_may_run_at_once_keep_their_distance(name: str) -> None:
    scenario = load_scenario(name)
    layout, topology = lay_out(scenario), scenario.topology
    traffic = Traffic(topology, layout.places)
    edges = [(i, j) for i, others in enumerate(topology.neighbours) for j in others]
    for (i, j), (a, b) in itertools.combinations(edges, 2):
        if {i, j} & {a, b}:
            continue
        if not traffic.travel(i, j) & traffic.travel(a, b):
            places = [layout.places[n] for n in (i, j, a, b)]
            assert segment_distance(*places) >= CLEARANCE


def test_a_push_reserves_what_its_staging_sweeps_over() -> None:
    backend, world = started(place(FORK))
    try:
        world.apply(0, Push(0, 1, -1), Outcome("arrived", 1))
        needed = backend.footprint(0, Push(0, 2, -1))
        # The box is pushed towards 2; the robot comes from behind, from the side of node 0, which is close by.
        layout = lay_out(world.scenario)
        scene = backend._open()
        stage = staging_points(scene, 0, layout.places[1], 0.0)[0]
        swept = {n for n, p in enumerate(layout.places) if n != 1 and math.dist(p, stage) < CLEARANCE}
        assert {2, (1, 2)} <= needed
        assert swept <= needed
        assert (0, 1) in needed
        assert 1 not in needed
        assert world.reserve(0, needed)
        assert not world.reserve(1, backend.footprint(1, Travel(0))) or 0 not in swept
    finally:
        backend.close()


def test_taking_hold_of_a_box_needs_no_more_than_travelling() -> None:
    backend, _ = started(place(FORK))
    try:
        assert backend.footprint(0, Push(0, 1, -1)) == backend.footprint(0, Travel(1))
    finally:
        backend.close()


def test_a_footprint_never_contains_what_cannot_be_reserved() -> None:
    scenario = load_scenario("hard")
    backend, world = started(scenario)
    try:
        edges = {tuple(sorted((i, j))) for i, others in enumerate(scenario.topology.neighbours) for j in others}
        for agent, node in enumerate(world.agent_node):
            for j in scenario.topology.neighbours[node]:
                for needed in backend.footprint(agent, Travel(j)):
                    assert needed in edges or needed in range(len(scenario.topology))
    finally:
        backend.close()


def test_segments() -> None:
    assert segment_distance((0, 0), (2, 2), (0, 2), (2, 0)) == 0.0
    assert segment_distance((0, 0), (1, 0), (0, 1), (1, 1)) == pytest.approx(1.0)
    assert segment_distance((0, 0), (1, 0), (2, 1), (2, -1)) == pytest.approx(1.0)
    assert segment_distance((0, 0), (0, 0), (3, 4), (3, 4)) == pytest.approx(5.0)


def test_lane_has_room_for_its_push() -> None:
    backend, _ = started(place(LANE))
    try:
        assert list(backend.feasible(0, 0, [2])) == [1.0]
        assert list(backend.feasible(0, 0, [])) == []
    finally:
        backend.close()


@pytest.mark.parametrize("yaw", [0.0, 1.0, 2.5, -2.0])
@pytest.mark.parametrize(
    ("ahead", "aside", "speed", "stops"),
    [
        (0.9, 0.0, 3.0, True),
        (0.9, 0.0, -3.0, False),
        (-0.9, 0.3, -3.0, True),
        (0.9, 0.0, 0.0, False),
        (0.2, 0.95, 3.0, False),
        (1.02, 0.0, 7.0, True),
        (1.02, 0.0, 2.0, False),
        (0.5, 0.95, 7.0, False),
    ],
)
def test_a_robot_stops_before_it_runs_into_another(
    yaw: float, ahead: float, aside: float, speed: float, stops: bool
) -> None:
    c, s = math.cos(yaw), math.sin(yaw)
    robot = (3.0, -2.0, yaw)
    other = (3.0 + c * ahead - s * aside, -2.0 + s * ahead + c * aside, 0.7)
    far = (9.0, 9.0, 0.0)
    assert closing_in(robot, WheelSpeeds(speed, speed), [far, other]) == stops
    assert not closing_in(robot, WheelSpeeds(speed, speed), [far])


def test_a_robot_that_backs_towards_another_stops_short_of_it() -> None:
    backend, _ = started(place(FORK, boxes=[]))
    try:
        scene = backend._open()
        scene.place_robot(1, 0.0, 1.6, 0.0, -math.pi / 2)
        assert backend.start(0, Travel(5), 0.0) is None

        def forwards():  # type: ignore[no-untyped-def]
            while True:
                yield WheelSpeeds(5.0, 5.0)

        scene.place_robot(0, 0.0, 0.0, 0.0, math.pi / 2)
        action = backend._actions.get(0)
        assert action is not None
        action.manoeuvre = forwards()
        for tick in range(240):
            backend.advance(tick / 60)
            assert not scene.robots_touch(0, 1)
        assert scene.robot(0).y == pytest.approx(0.65, abs=0.15)
    finally:
        backend.close()


def test_a_robot_looks_again_before_another_can_have_come_close() -> None:
    robot = (0.0, 0.0, 0.0)
    for away in (0.8, 1.1, 1.5, 2.5, 4.0, 40.0):
        ticks = ticks_until_close(robot, [(away, 0.0, 0.0)])
        # Both at full speed towards each other.
        left = away - ticks / 60 * 2 * 0.96
        assert ticks == 0 or left >= 1.05
    assert ticks_until_close(robot, []) > 0
    assert ticks_until_close(robot, [(math.nan, 0.0, 0.0)]) == 0
