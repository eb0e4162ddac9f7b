"""Decisions per second with the whole trace on disk, against bare SimPy timeouts with as many processes.

Each round times the three one after the other, so that a machine that slows down slows all of them; the medians
over the rounds are compared.

Run with: python benchmarks/speed.py [rounds]
"""

from __future__ import annotations

import random
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import simpy

import colonysim

if TYPE_CHECKING:
    from colonysim.world.scenario import Scenario

SIDE = 100
AGENTS = 1000
NEEDED = 0.10
"""Least share of SimPy's own speed on the grid."""


def large_grid(max_steps: int = 50) -> Scenario:
    """A grid of 100 x 100 nodes with 1,000 agents and nothing in their way but each other."""
    goal = SIDE * SIDE - 1
    agents = random.Random(0).sample(range(goal), AGENTS)
    return colonysim.scenario_from_document(
        {
            "name": "grid",
            "topology": {"kind": "grid", "columns": SIDE, "rows": SIDE},
            "agents": agents,
            "goal": goal,
            "max_steps": max_steps,
            "episodes": 1,
        }
    )


def decisions_per_second(scenario: Scenario, episodes: int) -> float:
    """Choices recorded per second of wall clock; choices without an alternative (waits) count for nothing."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        run = colonysim.run(scenario, episodes=episodes, seed=1, out=Path(folder) / "run")
        took = time.perf_counter() - began
    decisions: int = run.manifest["rows"]["decisions"]
    return decisions / took


def timeouts_per_second(processes: int, count: int) -> float:
    """`count` timeouts, spread over processes that do nothing else."""
    each = count // processes

    def sleeper(env: simpy.Environment, stream: random.Random) -> Iterator[simpy.Event]:
        for _ in range(each):
            yield env.timeout(0.9 + 0.2 * stream.random())

    env = simpy.Environment()
    for number in range(processes):
        env.process(sleeper(env, random.Random(number)))  # type: ignore[arg-type]
    began = time.perf_counter()
    env.run()
    return each * processes / (time.perf_counter() - began)


def main() -> int:
    import pyarrow.parquet  # noqa: F401  (its import is no cost of a decision)

    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    hard, grid = colonysim.load_scenario("hard"), large_grid()
    times: dict[str, list[float]] = {"hard": [], "simpy 4": [], "grid": [], f"simpy {AGENTS}": []}
    for _ in range(rounds):
        times["hard"].append(decisions_per_second(hard, 30))
        times["simpy 4"].append(timeouts_per_second(len(hard.agents), 100_000))
        times["grid"].append(decisions_per_second(grid, 1))
        times[f"simpy {AGENTS}"].append(timeouts_per_second(AGENTS, 100_000))
    median = {name: statistics.median(values) for name, values in times.items()}
    print(f"median of {rounds} rounds, a second of wall clock each:")
    print(f"hard, 4 agents:    {median['hard']:9.0f} decisions {median['simpy 4']:9.0f} timeouts "
          f"ratio {median['hard'] / median['simpy 4']:.3f}")  # fmt: skip
    ratio = median["grid"] / median[f"simpy {AGENTS}"]
    print(f"grid, {AGENTS} agents: {median['grid']:9.0f} decisions {median[f'simpy {AGENTS}']:9.0f} timeouts "
          f"ratio {ratio:.3f} (needed: {NEEDED:.2f})")  # fmt: skip
    return 0 if ratio >= NEEDED else 1


if __name__ == "__main__":
    sys.exit(main())
