"""The two maps on which colonies can block themselves: collision rule and mode against success, as Markdown tables.

Run with: python benchmarks/deadlock.py [--seeds 100] [--first-seed 1000] [--episodes 10]

Exits with 1 if the synchronous two-node rule ever lets the deadlock map through, or reservation ever fails there.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from collections import Counter
from itertools import product
from typing import NamedTuple

from colonysim import load_scenario, simulate

MODES = ("synchronous", "asynchronous")
RULES = ("two_node", "reservation")


class Outcome(NamedTuple):
    """All episodes of one setting.

    Attributes:
        first: Success in episode 1, mean over seeds.
        later: Success in the other episodes.
        steps: Mean steps of the episodes that reached the goal, or None if none did.
        ends: How the episodes ended.
    """

    first: float
    later: float
    steps: float | None
    ends: Counter[str]


def play(name: str, policy: str, rule: str, mode: str, seeds: range, episodes: int) -> Outcome:
    scenario = load_scenario(name, overrides={"policy.collision": rule})
    success: dict[bool, list[float]] = {True: [], False: []}
    steps, ends = [], Counter[str]()
    for seed in seeds:
        arrived = 0
        for event in simulate(scenario, policy=policy, mode=mode, episodes=episodes, seed=seed):
            if event.kind == "goal":
                arrived += 1
            elif event.kind == "episode":
                success[event.episode == 1].append(arrived / len(scenario.agents))
                ends[event.status] += 1
                if event.status == "goal":
                    steps.append(event.step)
                arrived = 0
    mean = statistics.fmean
    return Outcome(mean(success[True]), mean(success[False]), mean(steps) if steps else None, ends)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--first-seed", type=int, default=1000)
    parser.add_argument("--episodes", type=int, default=10)
    args = parser.parse_args()
    seeds = range(args.first_seed, args.first_seed + args.seeds)
    as_expected = True
    for name in ("deadlock", "junction"):
        print(f"\n{name}, {args.seeds} seeds x {args.episodes} episodes:\n")
        print(f"| preset | collision rule | mode | success, episode 1 | success, 2-{args.episodes} | steps to the goal "
              "| episodes ended |")  # fmt: skip
        print("|---|---|---|---|---|---|---|")
        for policy, rule, mode in product(("paper", "colony"), RULES, MODES):
            got = play(name, policy, rule, mode, seeds, args.episodes)
            steps = "-" if got.steps is None else f"{got.steps:.1f}"
            ends = ", ".join(f"{count} `{end}`" for end, count in got.ends.most_common())
            print(f"| `{policy}` | {rule} | {mode} | {got.first:.2f} | {got.later:.2f} | {steps} | {ends} |")
            if name == "deadlock" and policy == "paper":
                stuck = rule == "two_node" and mode == "synchronous"
                as_expected &= set(got.ends) == {"deadlock"} if stuck else got.later == 1.0
    return 0 if as_expected else 1


if __name__ == "__main__":
    sys.exit(main())
