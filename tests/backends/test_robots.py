"""Colonies of robots of half the size: what they do, when, and what a trace keeps of it."""

import math

import pytest

import colonysim
from colonysim.backends.physics import Physics
from colonysim.physics import TICK_SECONDS, engine_trouble
from colonysim.randomness import Streams
from colonysim.scenario.loading import scenario_from_document
from colonysim.world.state import World

LANE = {
    "nodes": [[0, 0, 0], [1, 1, 0], [2, 2, 0], [3, 3, 0], [4, 4, 0], [5, 5, 0]],
    "edges": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5]],
    "holes": [{"node": 3, "depth": 1.0}], "boxes": [[2, 1.0]], "agents": [0], "goal": 5,
}  # fmt: skip
LONG = math.sqrt(0.5)


def lane(robot):
    return scenario_from_document({**LANE, "physics": {"robot": robot}})


@pytest.mark.parametrize("engine", ["bullet", "mujoco"])
def test_half_the_size_does_the_same_in_less_time_and_space(engine, tmp_path):
    if engine_trouble(engine):
        pytest.skip("not installed")
    half, standard = (
        colonysim.run(lane(robot), backend=engine, episodes=1, seed=1, out=tmp_path / robot)
        for robot in ("half", "standard")
    )
    assert half.episodes[0].ended == "goal"
    done, expected = ([(e.kind, e.node, e.status) for e in run.events()] for run in (half, standard))
    assert done == expected
    assert half.episodes[0].sim_seconds == pytest.approx(LONG * standard.episodes[0].sim_seconds, rel=1e-6)
    last, full = (run.table("poses").to_pylist()[-1] for run in (half, standard))
    for name in ("x", "y", "z"):
        assert last[name] == pytest.approx(full[name] / 2, abs=1e-6)


@pytest.mark.parametrize("engine", ["bullet", "mujoco"])
def test_groups_have_robots_of_their_own(engine):
    """Two lanes of one length: who has the faster motors is there sooner."""
    if engine_trouble(engine):
        pytest.skip("not installed")
    lanes = {
        "topology": {"kind": "grid", "columns": 5, "rows": 3, "spacing": 1.5, "without": [5, 6, 7, 8]}, "goal": 9,
        "policy": {"epsilon": 0, "epsilon_floor": 0, "beta": 50},
    }  # fmt: skip
    times = {}
    for slow in (0, 1):
        groups = [{"name": f"lane {n}", "agents": [start]} for n, start in enumerate((0, 10))]
        groups[slow]["robot"] = {"wheel_speed": 4.0}
        colony = colonysim.Colony(scenario_from_document({**lanes, "groups": groups}), backend=engine, episodes=1)
        there = {event.agent: event.time for event in colony if event.kind == "goal"}
        assert there[1 - slow] < 0.8 * there[slow]
        times[slow] = there
    assert times[0][0] == pytest.approx(times[1][1], rel=0.1) and times[0][1] == pytest.approx(times[1][0], rel=0.1)


def test_ticks_are_as_long_as_the_robot_is_small():
    pytest.importorskip("pybullet")
    backend = Physics(engine="bullet", push="scripted")
    assert backend.tick == TICK_SECONDS
    backend.reset(World(lane("half")), Streams(0))
    quick = backend.edge_seconds
    assert backend.tick == pytest.approx(LONG * TICK_SECONDS)
    backend.reset(World(lane("standard")), Streams(0))
    assert (backend.tick, backend.edge_seconds) == (TICK_SECONDS, pytest.approx(quick / LONG))
    backend.close()
