"""The paper's performance tables with rigid bodies: steps and success by map, policy and executor, with intervals.

The paper's own system is `--policy paper --push rl --feasibility forest`. Every run is one unit: it is written to the
results file when it has ended, and skipped when it is already there, so that a stopped evaluation goes on where it was.
Beside each row stands the node world with the durations that the engine took on the same map. Each engine has a file of
its own, docs/results/{engine}.jsonl.

    python benchmarks/physics_tables.py run --engine bullet --maps easy medium hard --push staged --seeds 2000 2001 2002
    python benchmarks/physics_tables.py table --engine bullet
"""

import argparse
import os
import random
import statistics
import sys
import time
from collections import Counter, defaultdict
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import yaml

from colonysim.arguments import as_seed, whole
from colonysim.backends.physics import FEASIBILITIES, SUITED
from colonysim.errors import ColonysimError
from colonysim.jsonlines import append_line, read_lines, warn_of
from colonysim.physics import ENGINES, default_engine
from colonysim.processes import results
from colonysim.reproduce.stored import StoredRun, fault_finder

RESULTS = Path(__file__).parent.parent / "docs" / "results"
PAPER = {
    "easy": (22.36, 0.9125), "medium": (27.43, 0.8125), "hard": (28.25, 0.7875),
    "hard:r5-4": (80.0, 0.5), "hard:r5-6": (55.83, 0.73),
}  # fmt: skip
"""Steps and success reported in the paper (with controls)."""
NODE_WORLD_SEEDS = 100
"""More than in physics: they cost little, and five would leave the comparison to chance."""


class Episodes:
    """A sink that keeps only how episodes went."""

    def __init__(self) -> None:
        self.rows: list[Any] = []
        self.choosers: Counter[str] = Counter()

    def write(self, table: str, row: tuple[object, ...]) -> None:
        if table == "episodes":
            self.rows.append(row)
        elif table == "controls":
            self.choosers[f"{row[3]}"] += int(row[5])  # type: ignore[call-overload]


def scenario_of(name: str, overrides: dict[str, Any] | None = None) -> Any:
    from colonysim.scenario.loading import load_scenario

    base, _, variant = name.partition(":")
    return load_scenario(base, variant or None, overrides)


@dataclass(frozen=True, slots=True)
class Unit:
    """One run.

    Attributes:
        map: Name of a scenario, with its variant after a colon.
        policy: Name of a policy.
        push: Name of an executor.
        feasibility: Name of the estimate that says whether a push is tried.
        seed: Its seed.
        parameters: Fields of the scenario that are set, by path.
    """

    map: str
    policy: str
    push: str
    feasibility: str
    seed: int
    parameters: tuple[tuple[str, Any], ...] = ()

    def row(self) -> dict[str, Any]:
        """As it stands in a stored row; `parameters` only where there are some."""
        given = asdict(self)
        parameters = dict(given.pop("parameters"))
        return {**given, "parameters": parameters} if parameters else given


def unit_of(row: dict[str, Any]) -> Unit:
    """The unit of a stored row."""
    parameters = tuple(sorted(row.get("parameters", {}).items()))
    return Unit(row["map"], row["policy"], row["push"], row["feasibility"], row["seed"], parameters)


def measure(task: tuple[Unit, str, int]) -> dict[str, Any]:
    """One run (unit, engine, episodes): its episodes, durations by edge, and failures by reason."""
    from colonysim.simulation import simulate

    unit, engine, episodes = task
    name, push, seed = unit.map, unit.push, unit.seed
    scenario, sink, began = scenario_of(name, dict(unit.parameters)), Episodes(), time.perf_counter()
    failures: Counter[str] = Counter()
    travels: dict[str, list[float]] = {}
    pushes: dict[str, list[float]] = {}
    for event in simulate(
        scenario, backend=engine, backend_options={"push": push, "feasibility": unit.feasibility}, policy=unit.policy,
        episodes=episodes, seed=seed, sink=sink, decisions=False,
    ):  # fmt: skip
        if event.kind != "end":
            continue
        if event.status != "arrived":
            failures[f"{event.action}: {event.reason}"] += 1
        else:
            kept = pushes if event.action == "push" else travels
            kept.setdefault(f"{event.node}-{event.target}", []).append(round(event.time - event.began, 3))
    return {
        "engine": engine, **unit.row(),
        "episodes": [
            {"steps": e.steps, "success": e.success, "ended": e.ended, "seated": e.seated,
             "sim_seconds": round(e.sim_seconds, 2), "wall_seconds": round(e.wall_seconds, 2)}
            for e in sink.rows
        ],
        "failures": dict(failures.most_common()), "control_ticks": dict(sink.choosers),
        "travels": told(travels), "pushes": told(pushes), "wall_seconds": round(time.perf_counter() - began, 1),
    }  # fmt: skip


def told(durations: dict[str, list[float]]) -> dict[str, tuple[int, float]]:
    """For each edge how often it was done, and the mean of its seconds."""
    return {edge: (len(some), round(statistics.fmean(some), 3)) for edge, some in durations.items()}


def read(path: Path) -> list[dict[str, Any]]:
    if not path.exists():
        return []
    rows, faults = read_lines(path, fault_finder(StoredRun))
    warn_of(path, faults, "left out")
    return rows


def interval(by_seed: list[float], draws: int = 2000) -> tuple[float, float]:
    """A 95 % bootstrap interval over episodes."""
    dice = random.Random(0)
    means = sorted(statistics.fmean(dice.choices(by_seed, k=len(by_seed))) for _ in range(draws))
    return means[int(0.025 * draws)], means[int(0.975 * draws) - 1]


def with_measured_durations(
    name: str, policy: str, runs: list[dict[str, Any]], seeds: list[int], episodes: int
) -> list[Any]:
    """The node world on the same map, each edge as slow as in physics."""
    from colonysim.simulation import simulate

    timing: dict[str, Any] = {"jitter": 0.1}
    for kind in ("travels", "pushes"):
        counts: Counter[str] = Counter()
        seconds: defaultdict[str, float] = defaultdict(float)
        for run in runs:
            for edge, (count, mean_seconds) in run[kind].items():
                counts[edge] += count
                seconds[edge] += count * mean_seconds
        timing[kind] = [[*map(int, edge.split("-")), seconds[edge] / n] for edge, n in sorted(counts.items())]
        plain = scenario_of(name).topology
        ratios = sum(
            seconds[edge] / plain.length(plain.index[i], plain.index[j])
            for edge in counts
            for i, j in [map(int, edge.split("-"))]
        )
        timing["travel" if kind == "travels" else "push"] = ratios / counts.total() if counts else 1.0
    scenario = scenario_of(name, {"timing": timing})
    rows: list[Any] = []
    for seed in seeds:
        sink = Episodes()
        for _ in simulate(scenario, policy=policy, episodes=episodes, seed=seed, sink=sink, decisions=False):
            pass
        rows += sink.rows
    return rows


def run(options: argparse.Namespace) -> None:
    stored = read(options.results)
    done = {unit_of(r) for r in stored if (r["engine"], len(r["episodes"])) == (options.engine, options.episodes)}
    if other := len(stored) - len(done):
        print(f"{other} stored runs are on another engine or of another length", file=sys.stderr, flush=True)
    given = tuple(sorted((path, yaml.safe_load(value)) for path, _, value in (s.partition("=") for s in options.set)))
    asked = [
        Unit(name, policy, push, options.feasibility or SUITED[push], seed, given)
        for policy in options.policy
        for push in options.push
        for seed in options.seeds
        for name in options.maps
    ]
    for name in options.maps:
        scenario_of(name, dict(given))  # a wrong name is told before anything runs
    wanted = [unit for unit in dict.fromkeys(asked) if unit not in done]
    print(f"{len(wanted)} runs of {options.episodes} episodes to go, {len(done)} done", file=sys.stderr, flush=True)
    for _, row in results(measure, [(unit, options.engine, options.episodes) for unit in wanted], options.workers):
        append_line(options.results, row)
        late = row["episodes"][10:] or row["episodes"]
        print(
            f"{row['map']} {row['policy']} {row['push']} {row['feasibility']} seed {row['seed']}: "
            f"success {statistics.fmean(e['success'] for e in late):.3f}, "
            f"steps {statistics.fmean(e['steps'] for e in late):.1f} in the later half, "
            f"{row['wall_seconds']:.0f} s; {row['failures']}",
            file=sys.stderr, flush=True,
        )  # fmt: skip


def kind_of(row: dict[str, Any]) -> tuple[str, str, str, str]:
    """What a row is a run of, but for its seed: map, policy, executor and estimate."""
    unit = unit_of(row)
    return unit.map, unit.policy, unit.push, unit.feasibility


def table(options: argparse.Namespace) -> None:
    rows = [row for row in read(options.results) if row["engine"] == options.engine and not row.get("parameters")]
    print(
        "| map | policy | push | estimate | seeds | steps, episodes 1-10 | success 1-10 | steps 11- "
        "| success 11- [95 %] "
        f"| node world, durations of {options.engine}: steps / success 11- "
        "| paper: steps / success | wall s an episode |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    for kind in sorted({kind_of(row) for row in rows}):
        name, policy, push, feasibility = kind
        runs = [r for r in rows if kind_of(r) == kind]
        seeds = sorted(r["seed"] for r in runs)
        early = [e for r in runs for e in r["episodes"][:10]]
        late = [e for r in runs for e in r["episodes"][10:]]
        if not late:
            continue
        low, high = interval([e["success"] for e in late])
        beside = list(range(seeds[0], seeds[0] + NODE_WORLD_SEEDS))
        node = with_measured_durations(name, policy, runs, beside, len(runs[0]["episodes"]))
        node = [e for e in node if e.episode > 10]
        paper = PAPER.get(name)
        print(
            f"| {name} | {policy} | {push} | {feasibility} | {', '.join(map(str, seeds))} "
            f"| {mean(early, 'steps'):.1f} | {mean(early, 'success'):.3f} "
            f"| {mean(late, 'steps'):.1f} | {mean(late, 'success'):.3f} [{low:.3f}, {high:.3f}] "
            f"| {statistics.fmean(e.steps for e in node):.1f} / {statistics.fmean(e.success for e in node):.3f} "
            f"| {f'{paper[0]} / {paper[1]}' if paper else '-'} | {mean(early + late, 'wall_seconds'):.1f} |"
        )
    failures: Counter[str] = Counter()
    for r in rows:
        failures.update({f"{r['push']} {reason}": n for reason, n in r["failures"].items()})
    print(
        "\nActions that did not arrive, all runs: " + ", ".join(f"{n} x {why}" for why, n in failures.most_common(20))
    )


def mean(episodes: list[dict[str, Any]], key: str) -> float:
    return statistics.fmean(e[key] for e in episodes)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--engine", choices=ENGINES, default=default_engine())
    common.add_argument("--results", type=Path, help="default: docs/results/ENGINE.jsonl")
    parts = parser.add_subparsers(required=True)
    one = parts.add_parser("run", parents=[common])
    one.add_argument("--maps", nargs="+", default=["easy", "medium", "hard"])
    one.add_argument("--policy", nargs="+", default=["colony"], choices=["paper", "colony"])
    one.add_argument("--push", nargs="+", default=["staged"], choices=sorted(SUITED))
    one.add_argument("--feasibility", choices=FEASIBILITIES, help="estimate; default: the one that suits the executor")
    one.add_argument("--set", nargs="+", default=[], metavar="FIELD=VALUE", help="fields of the scenario to set")
    one.add_argument("--seeds", nargs="+", type=int, default=[2000, 2001, 2002])
    one.add_argument("--episodes", type=int, default=20)
    one.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    one.set_defaults(call=run)
    two = parts.add_parser("table", parents=[common])
    two.set_defaults(call=table)
    options = parser.parse_args()
    options.results = options.results or RESULTS / f"{options.engine}.jsonl"
    try:
        if options.call is run:
            whole("--episodes", options.episodes, 1)
            whole("--workers", options.workers, 1)
            for seed in options.seeds:
                as_seed(seed, "--seeds")
        options.call(options)
    except ColonysimError as error:
        parser.exit(1, f"Error: {error}\n")


if __name__ == "__main__":
    main()
