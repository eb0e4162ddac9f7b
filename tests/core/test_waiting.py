"""Who waits for what: woken by a change on one of its nodes, once, and not after it has gone on."""

from __future__ import annotations

import simpy

from colonysim.simulation.waiting import FEW, Waiting


def waiting_on(waits: Waiting, env: simpy.Environment, agent: int, *nodes: int) -> simpy.Event:
    event = env.event()
    waits.begin(agent, nodes, event)
    return event


def test_a_change_wakes_who_waits_for_it_and_nobody_else():
    env, waits = simpy.Environment(), Waiting(3)
    first, second = waiting_on(waits, env, 0, 4, 5), waiting_on(waits, env, 2, 5, 6)
    assert not waits.wake((7,))
    assert waits.wake((4, 7))
    assert first.triggered and not second.triggered
    assert waits.wake((4,)), "until it has gone on, an agent that was woken still waits"


def test_a_wait_that_is_over_wakes_nobody_even_if_the_agent_waits_elsewhere():
    env, waits = simpy.Environment(), Waiting(2)
    waiting_on(waits, env, 1, 4)
    waits.end(1)
    assert not waits.wake((4,))
    again = waiting_on(waits, env, 1, 9)
    assert not waits.wake((4,)) and not again.triggered
    assert waits.wake((9,)) and again.triggered


def test_who_waited_first_wakes_first_after_any_number_of_waits():
    env, waits = simpy.Environment(), Waiting(4)
    order: list[int] = []
    for _ in range(3 * FEW):
        waiting_on(waits, env, 0, 1)
        waits.end(0)
    for agent in (3, 0, 2):
        waiting_on(waits, env, agent, 1).callbacks.append(lambda _, agent=agent: order.append(agent))
    waits.wake((1,))
    env.run()
    assert order == [3, 0, 2]


def test_a_crowd_at_one_node_is_kept_whole_however_often_its_list_is_cleared():
    env, agents = simpy.Environment(), 3 * FEW - 2
    waits = Waiting(agents)
    events = {agent: waiting_on(waits, env, agent, 1) for agent in range(agents)}
    for turn in range(5 * agents):
        agent = turn * 7 % agents
        waits.end(agent)
        events[agent] = waiting_on(waits, env, agent, 1)
    assert waits.wake((1,)) and all(event.triggered for event in events.values())


def test_an_agent_can_be_called_by_name():
    env, waits = simpy.Environment(), Waiting(2)
    event = waiting_on(waits, env, 1, 4)
    waits.call(0)
    assert not event.triggered
    waits.call(1)
    waits.call(1)
    assert event.triggered
