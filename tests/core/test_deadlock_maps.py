"""Two carriers face to face: what acting in one's own time solves, and what only reservations solve."""

from __future__ import annotations

import pytest
from small_worlds import play

from colonysim import load_scenario

SEEDS = range(4)


def outcomes(name: str, episodes: int, overrides: dict[str, object], **options):
    scenario = load_scenario(name, None, overrides)
    return [play(scenario, episodes=episodes, seed=seed, decisions=False, **options)[1].episodes for seed in SEEDS]


def test_synchronous_two_node_exclusion_never_ends():
    for ends in outcomes("deadlock", 5, {"policy.collision": "two_node"}, policy="paper", mode="synchronous"):
        assert [(end.ended, end.success) for end in ends] == [("deadlock", 0.0)] * 5


def test_in_their_own_time_they_get_through():
    for ends in outcomes("deadlock", 5, {"policy.collision": "two_node"}, policy="paper", mode="asynchronous"):
        assert [end.success for end in ends] == [1.0] * 5


@pytest.mark.parametrize("name", ["deadlock", "junction"])
@pytest.mark.parametrize("mode", ["synchronous", "asynchronous"])
def test_reservations_remove_the_deadlock_in_both_modes(name, mode):
    ends = [end for run in outcomes(name, 12, {}, policy="colony", mode=mode) for end in run[1:]]
    assert sum(end.success for end in ends) / len(ends) >= 0.99


def test_at_the_junction_two_node_exclusion_fails_in_both_modes():
    overrides = {"policy.collision": "two_node"}
    for run in outcomes("junction", 4, overrides, policy="paper", mode="synchronous"):
        assert all(end.success < 1.0 for end in run)
    later = [end for run in outcomes("junction", 6, overrides, policy="paper", mode="asynchronous") for end in run[1:]]
    assert sum(end.ended == "goal" for end in later) / len(later) <= 0.2


def test_reservations_keep_carriers_apart_on_every_backend(backend):
    scenario = load_scenario("deadlock")
    _, rows = play(scenario, policy="colony", backend=backend, episodes=4, seed=0, decisions=False)
    assert [end.ended for end in rows.episodes[1:]] == ["goal"] * 3
