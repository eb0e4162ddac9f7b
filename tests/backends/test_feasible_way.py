"""What the physics backend says about a whole way, and which estimate it asks."""

from __future__ import annotations

import math

import pytest
from backends.places import LANE, place

from colonysim.backends.physics import Physics
from colonysim.errors import ColonysimError
from colonysim.randomness import Streams
from colonysim.scenario.scenario import Scenario
from colonysim.world.state import World

pytestmark = pytest.mark.usefixtures("engine")

CORNER = LANE | {
    "name": "corner",
    "nodes": [[0, 0, 0], [1, 1.5, 0], [2, 3, 0], [3, 3, 1.5], [4, 3, 3]],
    "holes": [{"node": 3, "depth": 0.35}],
}
"""The box goes on to 2 and turns left into the hole: for that a robot has to stand below 2."""


def begun(scenario: Scenario, feasibility: str | None) -> Physics:
    backend = Physics(push="scripted", feasibility=feasibility)
    backend.reset(World(scenario), Streams(0))
    return backend


def along(scenario: Scenario, way: tuple[int, ...] = (1, 2, 3)) -> list[float]:
    backend = begun(scenario, "way")
    try:
        assert backend.feasible_way is not None
        told = list(backend.feasible_way(0, 0, way))
        assert list(backend.feasible(0, 0, way[1:2])) == told[:1]
        return told
    finally:
        backend.close()


def test_a_turn_without_room_behind_it_is_foreseen_before_the_first_push() -> None:
    roomy, cramped = along(place(CORNER)), along(place(CORNER, physics={"margin": 1.1}))
    assert math.prod(roomy) > 0.9
    assert cramped[1] < 0.5


def test_nothing_is_likely_from_where_the_place_forbids_a_push() -> None:
    first, second, third = along(place(CORNER, no_push=[[2, 3]]), (1, 2, 3, 4))
    assert first > 0.9
    assert (second, third) == (0.0, 0.0)


def test_only_the_chance_of_a_way_speaks_of_ways() -> None:
    for feasibility, chances in (("geometry", {0.0, 1.0}), ("forest", None), (None, {0.0, 1.0})):
        backend = begun(place(CORNER), feasibility)
        try:
            assert backend.feasible_way is None
            [chance] = backend.feasible(0, 0, [2])
            assert chance in chances if chances else 0.0 < chance < 1.0
        finally:
            backend.close()


def test_each_executor_has_the_estimate_that_was_made_for_it() -> None:
    suited = {push: Physics(push=push).feasibility for push in ("staged", "rl", "scripted")}
    assert suited == {"staged": "way", "rl": "forest", "scripted": "geometry"}
    assert Physics(push="rl", feasibility="geometry").feasibility == "geometry"


def test_an_unknown_estimate_is_refused_with_the_nearest_one() -> None:
    with pytest.raises(ColonysimError, match=r"no feasibility 'ways'.*way"):
        Physics(feasibility="ways")
