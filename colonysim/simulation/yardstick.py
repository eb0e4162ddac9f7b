"""What SimPy itself can do: the yardstick that the speed of a simulation is measured by."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import simpy

if TYPE_CHECKING:
    from collections.abc import Iterator
    from random import Random

__all__ = ["timeouts_per_second"]


def timeouts_per_second(processes: int, count: int, random: Random) -> float:
    """Times bare timeouts, spread over processes that do nothing else.

    Args:
        processes: As many as there would be agents.
        count: Timeouts in all, at least one for each process.
        random: Draws how long each lasts, so that they come in another order every time.
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
