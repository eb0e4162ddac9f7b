"""Robots that die one by one on hard, with six: how many of the others still reach the goal.

    python benchmarks/dying_robots.py run --backend nodeworld --seeds 20
    python benchmarks/dying_robots.py run --backend mujoco --seeds 5
    python benchmarks/dying_robots.py table

In every episode the robots that die, and when each does, are drawn anew: any time within the first 25 edges' time,
which is about as long as an episode takes in which nobody dies. A robot that dies stays where it is, in the way,
with its box. One line of JSON a run; what is there already is skipped. Episodes 11 to 20 count; intervals are 95 %
over seeds.
"""

import argparse
import random
from pathlib import Path
from typing import Any

import colonysim
from colonysim.intervals import of_mean
from colonysim.jsonlines import append_line, read_lines
from colonysim.processes import results

RESULTS = Path(__file__).parent.parent / "docs" / "results" / "dying_robots.jsonl"
SCENARIO, VARIANT, AGENTS, EPISODES, COUNTED = "hard", "r5-6", 6, 20, 10
EDGES = 25
SECONDS = {"nodeworld": 1.0, "bullet": 4.0, "mujoco": 4.0}
"""Of a travelled edge, about."""


def timeline(seed: int, lost: int, backend: str) -> list[dict[str, Any]]:
    """Who fails when, in each episode."""
    rng, changes = random.Random(f"dying/{seed}"), []
    for episode in range(1, EPISODES + 1):
        order, times = rng.sample(range(AGENTS), AGENTS), [rng.random() for _ in range(AGENTS)]
        for agent, share in list(zip(order, times, strict=True))[:lost]:
            time = round(share * EDGES * SECONDS[backend], 2)
            changes.append({"episode": episode, "time": time, "fail": {"agents": [agent]}})
    return changes


def play(task: tuple[str, int, int]) -> dict[str, Any]:
    """One run: for each episode how many are at the goal, how many died before, seconds, and how it ended."""
    backend, lost, seed = task
    scenario = colonysim.load_scenario(SCENARIO, VARIANT, {"changes": timeline(seed, lost, backend)})
    episodes: list[list[Any]] = []
    home = died = 0
    for event in colonysim.simulate(
        scenario, backend=backend, episodes=EPISODES, seed=seed, kinds=["goal", "lost", "episode"]
    ):
        home, died = home + (event.kind == "goal"), died + (event.kind == "lost")
        if event.kind == "episode":
            episodes.append([home, died, round(event.time, 1), event.status])
            home = died = 0
    return {"backend": backend, "lost": lost, "seed": seed, "episodes": episodes}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["run", "table"])
    parser.add_argument("--backend", default="nodeworld", choices=SECONDS)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=3000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--results", type=Path, default=RESULTS)
    asked = parser.parse_args()
    done = {(row["backend"], row["lost"], row["seed"]): row for row in _stored(asked.results)}
    if asked.what == "run":
        seeds = range(asked.first, asked.first + asked.seeds)
        tasks = [(asked.backend, lost, seed) for seed in seeds for lost in range(AGENTS)]
        for _, row in results(play, [task for task in tasks if task not in done], asked.workers):
            append_line(asked.results, row)
            print(row["backend"], row["lost"], row["seed"], flush=True)
        return
    print("| backend | robots that are to die | die before they are at the goal | seeds | share of all six at the goal | of those that live | episodes in which all of these are |")  # noqa: E501
    print("|---|---|---|---|---|---|---|")
    for backend in sorted({backend for backend, _, _ in done}):
        for lost in range(AGENTS):
            rows = [row["episodes"][-COUNTED:] for key, row in done.items() if key[:2] == (backend, lost)]
            dead = [sum(died for _, died, *_ in each) / COUNTED for each in rows]
            every = [sum(home for home, *_ in each) / (COUNTED * AGENTS) for each in rows]
            living = [sum(home / (AGENTS - died) for home, died, *_ in each) / COUNTED for each in rows]
            whole = [sum(home == AGENTS - died for home, died, *_ in each) / COUNTED for each in rows]
            told = [f"{sum(dead) / len(dead):.1f}", str(len(rows)), *map(_interval, (every, living, whole))]
            print(f"| {backend} | {lost} | {' | '.join(told)} |")


def _stored(path: Path) -> list[dict[str, Any]]:
    return read_lines(path, lambda row: None)[0] if path.exists() else []


def _interval(values: list[float]) -> str:
    low, high = of_mean(values, within=(0.0, 1.0)) or (float("nan"), float("nan"))
    return f"{sum(values) / len(values):.2f} [{low:.2f}, {high:.2f}]"


if __name__ == "__main__":
    main()
