"""Worlds that `colonysim new` makes, on the node world and on both engines: how many robots reach the goal.

    python benchmarks/generated_worlds.py run --first 5000 --worlds 100 --backends nodeworld bullet mujoco
    python benchmarks/generated_worlds.py table

Kinds and sizes are mixed, each drawn from its seed. A world is run with its own seed, and one line of JSON is written
when it has ended; what is there already is skipped. Episodes 4 to 6 count. Intervals are Wilson's, 95 %, over robots
of different episodes as if they were independent, so that they are rather too narrow.
"""

import argparse
import os
import random
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import colonysim
from colonysim.errors import ColonysimError
from colonysim.intervals import wilson
from colonysim.jsonlines import append_line, read_lines
from colonysim.processes import results
from colonysim.scenario.invent import Kind, invent

RESULTS = Path(__file__).parent.parent / "docs" / "results" / "generated_worlds.jsonl"
EPISODES = 6


def world(seed: int) -> dict[str, Any]:
    """The document of one world; its size is drawn again until `new` accepts it."""
    rng = random.Random(f"generated/{seed}")
    kinds: tuple[Kind, ...] = ("grid", "rooms", "platforms", "geometric")
    kind = kinds[seed % 4]
    while True:
        asked: dict[str, Any] = {"agents": rng.randint(3, 6), "seed": seed}
        if kind == "grid":
            asked |= {"columns": rng.randint(5, 10), "rows": rng.randint(4, 8), "holes": rng.randint(1, 3)}
        elif kind == "rooms":
            asked |= {"columns": rng.randint(1, 2), "rows": 2, "size": rng.randint(3, 5), "holes": rng.randint(1, 2)}
        elif kind == "platforms":
            asked |= {"columns": rng.randint(1, 2), "rows": 2, "size": rng.randint(3, 5)}
        else:
            asked |= {"columns": rng.randint(4, 6), "rows": rng.randint(4, 6)}
        if kind != "geometric":
            asked |= {"spare": rng.randint(0, 2), "depth": rng.randint(1, 2)}
        try:
            return invent(kind, **asked)
        except ColonysimError:
            continue


def play(task: tuple[int, str]) -> dict[str, Any]:
    """One run: success and reason of each episode, and what its failures were."""
    seed, backend = task
    scenario = colonysim.scenario_from_document(world(seed))
    began = time.perf_counter()
    told: dict[str, Any] = {"seed": seed, "backend": backend, "world": scenario.name, "agents": len(scenario.agents)}
    failures: Counter[str] = Counter()

    def count(event: Any, run: Any) -> None:
        if event.kind == "end" and event.status != "arrived":
            failures[f"{event.action}: {event.reason}"] += 1

    try:
        run = colonysim.run(scenario, backend=backend, episodes=EPISODES, seed=seed, trace=False, on_event=count)
    except ColonysimError as error:
        return {**told, "refused": str(error)}
    told["episodes"] = [[e.success, e.steps, e.ended] for e in run.episodes]
    return {**told, "failures": dict(failures.most_common(6)), "wall_seconds": round(time.perf_counter() - began, 1)}


def run(options: argparse.Namespace) -> None:
    done = {(row["seed"], row["backend"]) for row in stored(options.results)}
    seeds = range(options.first, options.first + options.worlds)
    tasks = [(seed, backend) for seed in seeds for backend in options.backends if (seed, backend) not in done]
    print(f"{len(tasks)} runs to go, {len(done)} done", file=sys.stderr, flush=True)
    for _, row in results(play, tasks, options.workers):
        append_line(options.results, row)


def stored(path: Path) -> list[dict[str, Any]]:
    return read_lines(path, lambda row: None)[0] if path.exists() else []


def table(options: argparse.Namespace) -> None:
    rows = stored(options.results)
    print("| backend | worlds | refused | robots at the goal, episodes 4-6 | 95 % | worlds with less than all |")
    print("|---|---|---|---|---|---|")
    short: list[str] = []
    for backend in dict.fromkeys(row["backend"] for row in rows):
        runs = [row for row in rows if row["backend"] == backend]
        played = [row for row in runs if "episodes" in row]
        there = sum(round(e[0] * row["agents"]) for row in played for e in row["episodes"][3:])
        of = sum(row["agents"] for row in played for _ in row["episodes"][3:])
        less = [row for row in played if any(e[0] < 1.0 for e in row["episodes"][3:])]
        low, high = wilson(there, of)
        print(
            f"| {backend} | {len(runs)} | {len(runs) - len(played)} | {there / of:.4f} ({there} of {of}) "
            f"| {low:.4f} to {high:.4f} | {len(less)} |"
        )
        for row in less:
            ends = ", ".join(f"{e[0]:.2f} {e[2]}" for e in row["episodes"][3:])
            short.append(f"- {backend}, {row['world']} (seed {row['seed']}): {ends}; {row['failures']}")
        short += [f"- {backend}, seed {row['seed']}: refused, {row['refused']}" for row in runs if "refused" in row]
    print("\n" + "\n".join(short))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", type=Path, default=RESULTS)
    parts = parser.add_subparsers(required=True)
    one = parts.add_parser("run")
    one.add_argument("--first", type=int, default=5000)
    one.add_argument("--worlds", type=int, default=100)
    one.add_argument("--backends", nargs="+", default=["nodeworld", "bullet", "mujoco"])
    one.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    one.set_defaults(call=run)
    two = parts.add_parser("table")
    two.set_defaults(call=table)
    options = parser.parse_args()
    options.call(options)


if __name__ == "__main__":
    main()
