"""What a colony gains by foreseeing whole ways: the same maps and seeds with one estimate or another.

Every run is one unit: it is written to the results file when it has ended, and skipped when it is already there. Some
maps are run without the pushes that their files forbid by hand (`no_push=[]`), or with less ground around
(`physics.margin=1.5`).

    python benchmarks/feasibility_gain.py run --maps tests/push/maps/hairpin.yaml --set 'no_push=[]' --seeds 10 11
    python benchmarks/feasibility_gain.py table
"""

import argparse
import math
from collections import Counter
from pathlib import Path
from typing import Any

from colonysim.intervals import wilson
from colonysim.jsonlines import append_line, read_lines, warn_of

RESULTS = Path(__file__).parent.parent / "docs" / "results" / "feasibility.jsonl"
ESTIMATES = ("geometry", "geometry of the way", "way", "forest")


class Episodes:
    """A sink that keeps only how episodes went."""

    def __init__(self) -> None:
        self.rows: list[Any] = []

    def write(self, table: str, row: tuple[object, ...]) -> None:
        if table == "episodes":
            self.rows.append(row)


def measure(name: str, settings: list[str], estimate: str, seed: int, episodes: int) -> dict[str, Any]:
    """One run: its episodes, each with the pushes that arrived and that failed."""
    from colonysim.scenario.loading import load_scenario
    from colonysim.simulation import simulate

    base, _, variant = name.partition(":")
    scenario, sink = load_scenario(base, variant or None, settings or None), Episodes()
    ends: list[Counter[str]] = [Counter()]
    for event in simulate(scenario, backend=body(estimate), episodes=episodes, seed=seed, sink=sink, decisions=False):
        if event.kind == "episode":
            ends.append(Counter())
        elif event.kind == "end" and event.action == "push":
            ends[-1]["arrived" if event.status == "arrived" else "failed"] += 1
    return {
        "map": Path(name).stem, "set": settings, "feasibility": estimate, "seed": seed,
        "episodes": [
            {"steps": row.steps, "success": row.success, "ended": row.ended, "sim_seconds": round(row.sim_seconds, 1),
             "pushed": end["arrived"], "failed": end["failed"]}
            for row, end in zip(sink.rows, ends, strict=False)
        ],
    }  # fmt: skip


def body(estimate: str) -> Any:
    """Bullet with an estimate; "geometry of the way" asks the planner's yes or no of every push along it."""
    from colonysim.backends import bullet
    from colonysim.push.foresight import Features
    from colonysim.push.way import WayChance

    if estimate != "geometry of the way":
        return bullet.Bullet(feasibility=estimate)
    made = bullet.Bullet(feasibility="way")
    made._way_chance = WayChance((1e6, *[0.0] * (len(Features._fields) - 1)), 50.0)
    return made


def run(given: argparse.Namespace) -> None:
    done = [(row["map"], row["set"], row["feasibility"], row["seed"]) for row in read()]
    for seed in given.seeds:
        for name in given.maps:
            for estimate in given.feasibility:
                if (Path(name).stem, given.set, estimate, seed) in done:
                    continue
                row = measure(name, given.set, estimate, seed, given.episodes)
                append_line(RESULTS, row)
                print(line([row]), flush=True)


def read() -> list[dict[str, Any]]:
    if not RESULTS.exists():
        return []
    names = {"map", "set", "feasibility", "seed", "episodes"}
    rows, faults = read_lines(RESULTS, lambda row: None if names <= row.keys() else "no run")
    warn_of(RESULTS, faults, "these runs are made again")
    return rows


def line(rows: list[dict[str, Any]]) -> str:
    """A row of the table: all runs of one map with one estimate."""
    first, episodes = rows[0], [episode for row in rows for episode in row["episodes"]]
    n, wins = len(episodes), sum(episode["success"] == 1.0 for episode in episodes)
    low, high = wilson(wins, n)
    about = ", ".join([first["map"], *first["set"]])
    seeds = ", ".join(str(row["seed"]) for row in sorted(rows, key=lambda row: int(row["seed"])))
    return (
        f"| {about} | {first['feasibility']} | {seeds} | {n} | {wins / n:.2f} [{low:.2f}, {high:.2f}] "
        f"| {sum(e['success'] for e in episodes) / n:.2f} | {mean(e['steps'] for e in episodes)} "
        f"| {mean(e['failed'] for e in episodes)} | {mean(e['pushed'] for e in episodes)} |"
    )


def mean(values: Any) -> str:
    """Mean and the half width of its 95 % interval (normal), if there are enough for one."""
    numbers = list(values)
    middle = sum(numbers) / len(numbers)
    if len(numbers) < 4:
        return f"{middle:.1f}"
    spread = math.sqrt(sum((v - middle) ** 2 for v in numbers) / max(1, len(numbers) - 1))
    return f"{middle:.1f} ± {1.96 * spread / math.sqrt(len(numbers)):.1f}"


def table() -> None:
    groups: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for row in read():
        groups.setdefault((row["map"], *row["set"], row["feasibility"]), []).append(row)
    print(
        "| map | estimate | seeds | episodes | all robots at the goal [Wilson 95 %] | success | steps | failed pushes "
        "| arrived pushes |\n|---|---|---|---|---|---|---|---|---|"
    )
    order = sorted(groups, key=lambda key: (key[:-1], ESTIMATES.index(key[-1])))
    for key in order:
        print(line(groups[key]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    runs = commands.add_parser("run")
    runs.add_argument("--maps", nargs="+", required=True)
    runs.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    runs.add_argument("--feasibility", nargs="+", default=["geometry", "way"], choices=ESTIMATES)
    runs.add_argument("--seeds", nargs="+", type=int, default=[10])
    runs.add_argument("--episodes", type=int, default=4)
    commands.add_parser("table")
    given = parser.parse_args()
    if given.command == "run":
        run(given)
    else:
        table()


if __name__ == "__main__":
    main()
