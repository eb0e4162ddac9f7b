"""`check_env` passes the package's environments and finds what is wrong with others."""

from __future__ import annotations

import pytest

pytest.importorskip("pettingzoo")

import faulty_environments as faulty

from colonysim import rl
from colonysim.testing import ConformanceError, check_env

OPTIONS = [
    {"mode": "asynchronous"}, {"mode": "synchronous"}, {"pheromones": "keep", "reward": "own_time"},
    {"hole": "action", "reward": "filled", "flat": True},
    {"policy": "random", "reward": "goal", "parts": ("self", "boxes")}, {"reward": "difference", "policy": "paper"},
]  # fmt: skip


@pytest.mark.parametrize("options", OPTIONS, ids=lambda options: "-".join(map(str, options)))
def test_aec_keeps_its_promises(options):
    check_env(lambda: rl.aec("hard", overrides={"max_steps": 25}, **options))


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_parallel_keeps_its_promises(mode):
    check_env(lambda: rl.parallel("hard", mode=mode, overrides={"max_steps": 25}))


FAULTS = [
    (faulty.StaleMask, None, "masks"),
    (faulty.Leaks, None, "locality"),
    (faulty.KeepsItsFirstSeed, None, "seeds"),
    (faulty.CountsFromTheLastQuestion, None, "time"),
    (None, faulty.PaysTwice, "rewards"),
    (faulty.AsksTheDead, None, "who is asked"),
    (None, faulty.OwnTies, "native run"),
    (None, faulty.SharesTimes, "copies"),
]


@pytest.mark.parametrize(("env", "turns", "promise"), FAULTS, ids=[(env or turns).__name__ for env, turns, _ in FAULTS])
def test_planted_faults_are_found(env, turns, promise):
    def make():
        mode = "synchronous" if turns is faulty.OwnTies else None  # where durations vary, ties are rare
        return (env or rl.ColonyAEC)((turns or rl.Turns)("medium", policy="random", mode=mode))

    with pytest.raises(ConformanceError) as found:
        check_env(make, episodes=2)
    assert found.value.promise == promise, str(found.value)
