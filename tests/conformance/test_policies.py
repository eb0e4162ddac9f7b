"""Our own policies keep the promises of the protocol, and the check catches those that do not."""

from __future__ import annotations

import pytest
from faulty_policies import FAULTS, KnowsTheMap

from colonysim import plugins
from colonysim.bench.brought import ExtraField, OwnRule
from colonysim.errors import ColonysimWarning
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


class _Forgets(OwnRule):
    """Its memory is no plain data; the way back that it offers is a wrong one."""

    name = "forgets"

    def begin(self, agent, memory):
        return {0}

    def state(self, agent, memory):
        return sorted(memory)

    def restore(self, agent, state):
        raise KeyError("nothing")


class _Unsavable(_Forgets):
    state = restore = None


class _BrokenField(ExtraField):
    def state(self):
        return {}

    def restore(self, state):
        return state.column("held")


class _WithBrokenField(OwnRule):
    name = "with-broken-field"

    def fields(self, world):
        return {**super().fields(world), "X": _BrokenField(world)}


@pytest.mark.parametrize("factory", [_Forgets, _WithBrokenField])
def test_what_cannot_be_restored_is_a_broken_promise(factory):
    with pytest.raises(ConformanceError, match="raises"):
        check_policy(factory, worlds=0, runs=1)


def test_what_takes_no_part_in_saving_is_told_so():
    with pytest.warns(ColonysimWarning, match=r"cannot be saved, forked or resumed: .*its memory"):
        check_policy(_Unsavable, worlds=0, runs=1)
