"""What is due comes in the order of time, and at one time in the order that it was given."""

from __future__ import annotations

import random
from heapq import heappop, heappush

import simpy

from colonysim.simulation.moments import Moments


def test_it_is_the_order_of_a_heap_of_tuples():
    rng, moments, heap = random.Random(1), Moments(), []
    for number in range(3000):
        time, order = float(rng.randrange(50)), rng.random()  # many at one time
        moments.put(time, order, -number)
        heappush(heap, (time, order, -number))
        while heap and rng.random() < 0.48:
            assert moments.time == heap[0][0]
            assert moments.take() == heappop(heap)[2]
    while heap:
        assert moments.take() == heappop(heap)[2]
    assert moments.time == float("inf")


def test_cleared_it_is_as_new():
    moments = Moments()
    for number in range(200):
        moments.put(1.0, 0.5, number)
    moments.clear()
    assert moments.time == float("inf")
    moments.put(2.0, 0.5, 7)
    assert (moments.time, moments.take()) == (2.0, 7)


def test_who_peeks_sees_what_is_due_in_either_queue():
    """The clock of a backend advances up to the next event, and a wait that ends is one."""
    from colonysim.simulation.episode import _Environment

    env = _Environment()
    assert env.peek() == simpy.core.Infinity
    env.timeout(3.0)
    env.moments.put(2.0, 0.5, 0)
    assert env.peek() == 2.0
    env.moments.take()
    assert env.peek() == 3.0
