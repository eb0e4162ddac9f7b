"""An agent that stands still: `Episode.stand_still`, on which failures for a while and random stops are built."""

from __future__ import annotations

import pytest
from small_worlds import Script, line

import colonysim
from colonysim.world.intents import Travel, Wait


def onwards(agent, view, count):
    return Travel(view.node + 1)


def held(act, scenario, *stops, mode=None):
    """The events of a colony in which agents are told to stand still: (now, agent, until)."""
    colony = colonysim.Colony(scenario, policy=Script(act), episodes=1, mode=mode)
    events = [colony.step()]
    for now, agent, until in stops:
        while colony.now < now and (event := colony._next(now)):
            events.append(event)
        colony._reach(now)
        colony._episode.now = now
        colony._episode.stand_still(agent, until)
    return events + list(colony)


def times(events, kind, agent=0):
    return [(event.time, event.reason) for event in events if event.kind == kind and event.agent == agent]


def test_the_move_under_way_ends_first_and_the_next_begins_afterwards():
    events = held(onwards, line(5, agents=[0], goal=4), (0.5, 0, 3.25))
    assert times(events, "wait") == [(1.0, "stopped")]
    assert [(e.began, e.time) for e in events if e.kind == "end"] == [(0, 1), (3.25, 4.25), (4.25, 5.25), (5.25, 6.25)]


def test_who_waits_is_woken_to_stand_still():
    """Nothing changes around it; a stop that ends lets it look again."""
    events = held(lambda agent, view, n: Wait((3,)) if agent == n == 0 else onwards(agent, view, n),
                  line(6, agents=[0, 4], goal=5), (0.5, 0, 2.0))  # fmt: skip
    assert (0.5, "stopped") in times(events, "wait")
    assert [e.began for e in events if e.kind == "end" and e.agent == 0][:1] == [2.0]


def test_a_stop_that_outlasts_the_stall_is_no_deadlock():
    events = held(onwards, line(4, agents=[0], goal=3, stall_seconds=10.0), (0.5, 0, 100.0))
    assert events[-1].status == "goal" and events[-1].time == 102.0


def test_a_longer_stop_counts_and_a_shorter_one_changes_nothing():
    events = held(onwards, line(4, agents=[0], goal=3), (0.5, 0, 4.0), (0.6, 0, 2.0), (2.0, 0, 6.0))
    assert times(events, "wait") == [(1.0, "stopped"), (4.0, "stopped")]
    assert [e.began for e in events if e.kind == "end"] == [0.0, 6.0, 7.0]


@pytest.mark.parametrize("until", [2.0, 2.5])
def test_in_synchronous_mode_it_lasts_for_whole_ticks(until):
    scenario = line(6, agents=[0, 2], goal=5)
    events = held(onwards, scenario, (0.5, 0, until), mode="synchronous")
    assert [reason for _, reason in times(events, "wait")] == ["stopped"] * (1 if until == 2.0 else 2)
    assert events[-1].status == "goal"
