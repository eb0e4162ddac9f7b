"""Our own policies keep the promises of the protocol, and the check catches those that do not."""

from __future__ import annotations

import pytest
from faulty_policies import FAULTS, KnowsTheMap

from colonysim import plugins
from colonysim.bench.brought import ExtraField, OwnRule
from colonysim.testing import ConformanceError, check_policy


@pytest.mark.parametrize(("name", "worlds"), [("colony", 500), ("paper", 500), ("random", 150)])
def test_our_own_keep_their_promises(name, worlds):
    check_policy(plugins.load("policies", name), worlds=worlds)


class _OwnField(OwnRule):
    """A rule of somebody's own, on a field of their own beside D and E."""

    def fields(self, world):
        return {**super().fields(world), "X": ExtraField(world)}

    def decide(self, view, memory, random):
        assert view.fields["X"].at(view.node) == 0.0
        return super().decide(view, memory, random)


def test_a_policy_with_a_field_of_its_own_keeps_them_too():
    check_policy(_OwnField, worlds=40, runs=2)


def test_the_oracle_is_a_yardstick_and_not_local():
    oracle = plugins.load("policies", "oracle")
    check_policy(oracle, local=False, worlds=100)
    with pytest.raises(ConformanceError, match="local marks"):
        check_policy(oracle)


@pytest.mark.parametrize(("factory", "promise"), FAULTS, ids=[factory.__name__ for factory, _ in FAULTS])
def test_a_broken_promise_is_named(factory, promise):
    with pytest.raises(ConformanceError) as caught:
        check_policy(factory, worlds=100, runs=3)
    assert caught.value.promise == promise, caught.value


def test_the_message_says_what_was_changed_out_of_sight():
    with pytest.raises(ConformanceError, match=r"agent \d+ on node \d+ \(R = .*height of \d+.*becomes"):
        check_policy(KnowsTheMap, worlds=100, runs=1)
