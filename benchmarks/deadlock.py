"""Does asynchrony remove the deadlock of two carriers? Both small maps, both modes, both collision rules.

The rules are those of the preset `paper`, in which a carrier waits for as long as it takes.

    python benchmarks/deadlock.py --seeds 100
"""

import argparse
import os
import statistics
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from itertools import product

MAPS, MODES, RULES = ("deadlock", "junction"), ("synchronous", "asynchronous"), ("two_node", "reservation")


def measure(job: tuple[str, str, str, str, int, int]) -> list[tuple[int, float, str]]:
    """Steps, success and end of each episode of one run."""
    from colonysim.recording import run

    name, mode, rule, policy, seed, episodes = job
    done = run(
        name, policy=policy, mode=mode, seed=seed, episodes=episodes, trace=False, decisions=False,
        overrides={"policy.collision": rule},
    )  # fmt: skip
    return [(e.steps, e.success, e.ended) for e in done.episodes]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--first-seed", type=int, default=3000)
    parser.add_argument("--episodes", type=int, default=10)
    parser.add_argument("--policy", default="paper")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args()
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    print(f"Seeds {seeds.start}-{seeds.stop - 1}, {options.episodes} episodes a run, policy {options.policy}.\n")
    print("| map | mode | collision | success, episode 1 | success, episodes 2- | steps, 2- | ends, all episodes |")
    print("|---|---|---|---|---|---|---|")
    with ProcessPoolExecutor(options.workers) as pool:
        for name, mode, rule in product(MAPS, MODES, RULES):
            jobs = [(name, mode, rule, options.policy, seed, options.episodes) for seed in seeds]
            runs = list(pool.map(measure, jobs, chunksize=10))
            ends = Counter(ended for run in runs for _, _, ended in run)
            print(
                f"| {name} | {mode} | {rule} | {statistics.fmean(r[0][1] for r in runs):.3f} "
                f"| {statistics.fmean(e[1] for r in runs for e in r[1:]):.3f} "
                f"| {statistics.fmean(e[0] for r in runs for e in r[1:]):.1f} "
                f"| {', '.join(f'{n} {end}' for end, n in ends.most_common())} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
