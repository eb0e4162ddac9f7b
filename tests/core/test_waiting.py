"""Who waits for what: called after a change on one of its nodes, once, and not after it has gone on."""

from __future__ import annotations

import pytest

from colonysim.simulation.waiting import FEW, Waiting

NODES = 10


@pytest.fixture
def called() -> list[int]:
    """The agents that were called, in order."""
    return []


def test_a_change_calls_who_waits_for_it_and_nobody_else(called: list[int]):
    waits = Waiting(3, NODES, called.append)
    waits.begin(0, (4, 5))
    waits.begin(2, (5, 6))
    assert not waits.wake((7,)) and not called
    assert waits.wake((4, 7)) and called == [0]
    assert waits.wake((4,)), "until it has gone on, an agent that was called still waits"
    assert called == [0], "but it is called once"


def test_a_wait_that_is_over_calls_nobody_even_if_the_agent_waits_elsewhere(called: list[int]):
    waits = Waiting(2, NODES, called.append)
    waits.begin(1, (4,))
    waits.end(1)
    assert not waits.waits(1) and not waits.wake((4,))
    waits.begin(1, (9,))
    assert waits.waits(1) and not waits.wake((4,)) and not called
    assert waits.wake((9,)) and called == [1]


def test_time_that_is_up_calls_only_who_still_waits_that_same_wait(called: list[int]):
    waits = Waiting(2, NODES, called.append)
    first = waits.begin(1, (4,))
    waits.end(1)
    second = waits.begin(1, (4,))
    waits.expire(first)
    assert not called
    waits.expire(second)
    waits.expire(second)
    assert called == [1]


def test_who_waited_first_is_called_first_after_any_number_of_waits(called: list[int]):
    waits = Waiting(4, NODES, called.append)
    for _ in range(3 * FEW):
        waits.begin(0, (1,))
        waits.end(0)
    for agent in (3, 0, 2):
        waits.begin(agent, (1,))
    waits.wake((1,))
    assert called == [3, 0, 2]


def test_a_crowd_at_one_node_is_kept_whole_however_often_its_list_is_cleared(called: list[int]):
    agents = 3 * FEW - 2
    waits = Waiting(agents, NODES, called.append)
    for agent in range(agents):
        waits.begin(agent, (1,))
    for turn in range(5 * agents):
        agent = turn * 7 % agents
        waits.end(agent)
        waits.begin(agent, (1,))
    assert waits.wake((1,)) and sorted(called) == list(range(agents))


def test_an_agent_can_be_called_by_name(called: list[int]):
    waits = Waiting(2, NODES, called.append)
    waits.begin(1, (4,))
    waits.call(0)
    waits.call(-1)
    assert not called
    waits.call(1)
    waits.call(1)
    assert called == [1]


def test_nodes_that_do_not_exist_are_waited_for_in_vain(called: list[int]):
    waits = Waiting(1, NODES, called.append)
    waits.begin(0, (-1, NODES, 3))
    assert not waits.wake((NODES - 1,))
    assert waits.wake((3,)) and called == [0]
