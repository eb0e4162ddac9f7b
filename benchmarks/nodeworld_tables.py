"""Steps and success on the node world: both presets, every map, beside the paper's figures.

Means over seeds of runs of 30 episodes, with 95 % bootstrap intervals over seeds.

    python benchmarks/nodeworld_tables.py --seeds 20 --first-seed 1000
"""

import argparse
import os
import random
import statistics
from concurrent.futures import ProcessPoolExecutor
from typing import Any

MAPS = ("sanity", "easy", "medium", "hard:r20-4", "hard:r5-4", "hard:r5-6")
PAPER = {
    "easy": "22.36 / .9125", "medium": "27.43 / .8125", "hard:r20-4": "28.25 / .7875",
    "hard:r5-4": "80 / .50", "hard:r5-6": "55.83 / .73",
}  # fmt: skip
"""Steps and success reported in the paper, with controls, all episodes."""
PROTOTYPE = {
    "paper": {
        "easy": "27.4 / .94", "medium": "31.1 / .97", "hard:r20-4": "53.7 / .84", "hard:r5-4": "74.2 / .62",
        "hard:r5-6": "76.0 / .47",
    },
    "colony": {
        "easy": "14.2 / 1.00", "medium": "16.1 / 1.00", "hard:r20-4": "23.1 / 1.00", "hard:r5-4": "25.3 / 1.00",
        "hard:r5-6": "31.7 / 1.00",
    },
}  # fmt: skip
"""A prototype's figures, its steps counted as makespan over mean edge time: `paper` all episodes, `colony` 21-30."""


class Episodes:
    """A sink that keeps only how episodes went."""

    def __init__(self) -> None:
        self.rows: list[Any] = []

    def write(self, table: str, row: tuple[object, ...]) -> None:
        if table == "episodes":
            self.rows.append(row)


def measure(job: tuple[str, str, int, int]) -> list[tuple[int, float, str]]:
    """Steps, success and end of each episode of one run."""
    from colonysim.simulation import simulate
    from colonysim.world.loading import load_scenario

    name, policy, seed, episodes = job
    base, _, variant = name.partition(":")
    sink = Episodes()
    scenario = load_scenario(base, variant or None)
    for _ in simulate(scenario, policy=policy, seed=seed, episodes=episodes, sink=sink, decisions=False):
        pass
    return [(e.steps, e.success, e.ended) for e in sink.rows]


def interval(values: list[float], draws: int = 2000) -> str:
    """Mean and 95 % bootstrap interval of one value a seed."""
    dice = random.Random(0)
    means = sorted(statistics.fmean(dice.choices(values, k=len(values))) for _ in range(draws))
    return f"{statistics.fmean(values):.3f} [{means[int(0.025 * draws)]:.3f}, {means[int(0.975 * draws) - 1]:.3f}]"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first-seed", type=int, default=1000)
    parser.add_argument("--episodes", type=int, default=30)
    parser.add_argument("--policy", nargs="+", default=["colony", "paper"])
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args()
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    late = min(20, options.episodes - 1)
    print(f"Seeds {seeds.start}-{seeds.stop - 1}, {options.episodes} episodes a run.\n")
    print(
        f"| map | policy | steps, all | success, all [95 %] | steps, {late + 1}- | success, {late + 1}- [95 %] "
        "| ends, all | paper: steps / success | prototype |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    with ProcessPoolExecutor(options.workers) as pool:
        for policy in options.policy:
            for name in MAPS:
                runs = list(pool.map(measure, [(name, policy, seed, options.episodes) for seed in seeds]))
                ends: dict[str, int] = {}
                for run in runs:
                    for _, _, ended in run:
                        ends[ended] = ends.get(ended, 0) + 1
                print(
                    f"| {name} | {policy} "
                    f"| {statistics.fmean(e[0] for r in runs for e in r):.1f} "
                    f"| {interval([statistics.fmean(e[1] for e in r) for r in runs])} "
                    f"| {statistics.fmean(e[0] for r in runs for e in r[late:]):.1f} "
                    f"| {interval([statistics.fmean(e[1] for e in r[late:]) for r in runs])} "
                    f"| {', '.join(f'{n} {end}' for end, n in sorted(ends.items(), key=lambda x: -x[1]))} "
                    f"| {PAPER.get(name, '-')} | {PROTOTYPE[policy].get(name, '-') if policy in PROTOTYPE else '-'} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
