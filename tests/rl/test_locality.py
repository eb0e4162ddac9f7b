"""An observation holds nothing that its agent cannot know: the test for policies, run over one that decides from it."""

from __future__ import annotations

import hashlib

import pytest

pytest.importorskip("pettingzoo")

from colonysim.policies.policy import Choice
from colonysim.policies.stigmergy import Stigmergy
from colonysim.rl.spaces import Observer
from colonysim.testing import ConformanceError, check_policy


class FromObservation:
    """Takes an allowed action that every number of the observation, and the whole mask, has a say in."""

    name = "from-observation"

    def __init__(self, scenario):
        self._marks = Stigmergy(scenario)
        names = {"D": False, "B": True, "H": False, "E": False}
        self.observer = Observer(scenario, names, flat=True, boxes=3, holes=2)

    def fields(self, world):
        return self._marks.fields(world)

    def begin(self, agent, memory):
        return None

    def told(self, view):
        sight = self.observer.sight(view)
        return sight, self.observer.numbers(sight)

    def decide(self, view, memory, random):
        sight, numbers = self.told(view)
        mask = self.observer.mask(sight)
        assert self.observer.observation_space.contains(numbers)
        digest = hashlib.sha256(numbers.tobytes() + mask.tobytes()).digest()
        allowed = [action for action, can in enumerate(mask) if can]
        going = [action for action in allowed if action < self.observer.moves.wait] or allowed
        return Choice(sight.intent(going[int.from_bytes(digest[:8], "big") % len(going)]), memory)


class Leaking(FromObservation):
    """The same, with one number too much."""

    def told(self, view):
        sight, numbers = super().told(view)
        numbers[0] += sum(view._world.box_node) + sum(view._world.agent_node)
        return sight, numbers


def test_nothing_out_of_sight_is_told():
    check_policy(FromObservation, worlds=120, runs=2)


def test_one_number_too_much_is_found():
    with pytest.raises(ConformanceError, match="local decisions"):
        check_policy(Leaking, worlds=60, runs=0)


@pytest.mark.slow
def test_nothing_out_of_sight_is_told_in_many_worlds():
    check_policy(FromObservation, worlds=3000, runs=20, seed=10_000)
