"""The speed of SimPy itself, with which the speed of a simulation is compared."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import simpy

if TYPE_CHECKING:
    from collections.abc import Iterator
    from random import Random

__all__ = ["timeouts_per_second"]


def timeouts_per_second(processes: int, count: int, random: Random) -> float:
    """Timeouts processed in a second of wall-clock time, by SimPy processes that do nothing else.

    Args:
        processes: The number of processes, as many as there would be agents.
        count: The number of timeouts of all processes together; each has at least one.
        random: Draws the duration of each timeout.
    """
    each = max(1, count // processes)

    def sleeper(env: simpy.Environment) -> Iterator[simpy.Event]:
        for _ in range(each):
            yield env.timeout(0.9 + 0.2 * random.random())

    env = simpy.Environment()
    for _ in range(processes):
        env.process(sleeper(env))  # type: ignore[arg-type]
    began = time.perf_counter()
    env.run()
    return each * processes / (time.perf_counter() - began)
