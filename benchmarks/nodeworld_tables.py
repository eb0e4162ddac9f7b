"""Both presets on all maps in the node world: steps and success, as a Markdown table.

Run with: python benchmarks/nodeworld_tables.py [--seeds 20] [--first-seed 1000] [--episodes 30] [--workers 2]
       [--set policy.deposit_at_start=false]

Intervals are 95 % by bootstrap over seeds (an episode depends on the episodes before it, seeds do not depend on each
other). Nothing was tuned on seeds from 1000 on.
"""

from __future__ import annotations

import argparse
import random
import statistics
from itertools import product
from typing import NamedTuple

from colonysim import load_scenario, simulate
from colonysim.processes import results

MAPS = [("sanity", None), ("easy", None), ("medium", None), ("hard", "r20-4"), ("hard", "r5-4"), ("hard", "r5-6")]
LATE = 21
PAPER = {
    "easy": "22.36 ± 16.07 / .9125",
    "medium": "27.43 ± 18.52 / .8125",
    "hard r20-4": "28.25 ± 17.98 / .7875",
    "hard r5-4": "80 ± 0 / .5",
    "hard r5-6": "55.83 ± 26.89 / .73",
}
"""What the paper reports, in rigid-body simulation: steps (mean ± sd) / share of agents at the goal."""


class Job(NamedTuple):
    name: str
    variant: str | None
    policy: str
    seed: int
    episodes: int
    overrides: tuple[str, ...] = ()


class Figure(NamedTuple):
    """A mean and its 95 % interval."""

    mean: float
    low: float
    high: float


def play(job: Job) -> list[tuple[int, float]]:
    """Steps and success of each episode."""
    scenario = load_scenario(job.name, job.variant, job.overrides)
    played, arrived = [], 0
    for event in simulate(scenario, policy=job.policy, episodes=job.episodes, seed=job.seed):
        if event.kind == "goal":
            arrived += 1
        elif event.kind == "episode":
            played.append((event.step, arrived / len(scenario.agents)))
            arrived = 0
    return played


def bootstrap(values: list[float], draws: int = 4000) -> Figure:
    """The mean over seeds, with the 95 % interval of means of resampled seeds."""
    stream = random.Random(0)
    means = sorted(statistics.fmean(stream.choices(values, k=len(values))) for _ in range(draws))
    return Figure(statistics.fmean(values), means[round(0.025 * draws)], means[round(0.975 * draws) - 1])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first-seed", type=int, default=1000)
    parser.add_argument("--episodes", type=int, default=30)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--set", action="append", default=[], metavar="FIELD=VALUE")
    args = parser.parse_args()
    overrides = tuple(args.set)
    seeds = range(args.first_seed, args.first_seed + args.seeds)
    jobs = [
        Job(name, variant, policy, seed, args.episodes, overrides)
        for (name, variant), policy, seed in product(MAPS, ("colony", "paper"), seeds)
    ]
    runs = dict(results(play, jobs, args.workers))
    late = f"episodes {LATE}-{args.episodes}"
    print(f"| map | preset | steps, all {args.episodes} | success, all | steps, {late} | success, {late} | the paper |")
    print("|---|---|---|---|---|---|---|")
    for (name, variant), policy in product(MAPS, ("colony", "paper")):
        mine = [runs[Job(name, variant, policy, seed, args.episodes, overrides)] for seed in seeds]
        cells = []
        for part in (slice(None), slice(LATE - 1, None)):
            steps = bootstrap([statistics.fmean(s for s, _ in run[part]) for run in mine])
            success = bootstrap([statistics.fmean(g for _, g in run[part]) for run in mine])
            cells.append(f"{steps.mean:.1f} [{steps.low:.1f}, {steps.high:.1f}]")
            cells.append(f"{success.mean:.3f} [{success.low:.3f}, {success.high:.3f}]")
        label = f"{name} {variant}" if variant else name
        print(f"| {label} | `{policy}` | {' | '.join(cells)} | {PAPER.get(label, '-')} |")


if __name__ == "__main__":
    main()
