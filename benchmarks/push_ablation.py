"""The paper's ablations of the push: batch size, exploration steps, target update; one network or one a terrain.

As in the paper the first three are trained on holes alone, around b = 128, S = 1000, M = 300, 20 training and 20
testing episodes in turn, and tests during the exploration are left out. Of the values of M only the smallest is printed
there. "Individual" networks are trained on one terrain (that of the hole is the base of all other rows too),
"all-in-one" on all three. After every training the `rl` executor pushes from the frozen start distribution on each of
its terrains, with the best network and with the last. `--base` names the readings of Algorithm 1 that are trained:
`paper` is its letter.

Every training is one unit: its row is written to the results file when it has ended, a training that was stopped goes
on from its checkpoint, and what is there already is skipped. Seed by seed, so that a grid that was stopped early
compares equals.

    python benchmarks/push_ablation.py run --seeds 0 1 2 --workers 2
    python benchmarks/push_ablation.py table
    python benchmarks/push_ablation.py plot --out docs/images
"""

import argparse
import dataclasses
import os
import statistics
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from colonysim.arguments import as_seed, whole
from colonysim.errors import ColonysimError
from colonysim.jsonlines import append_line, read_lines, warn_of
from colonysim.learning.seeds import Purpose
from colonysim.physics import ENGINES, EngineName, default_engine
from colonysim.processes import results
from colonysim.push.task import Kind
from colonysim.push.training.evaluation import evaluate_push
from colonysim.push.training.presets import READINGS, TrainingConfig
from colonysim.push.training.starts import KINDS
from colonysim.push.training.trainer import train_push
from colonysim.reproduce.push import TRIAL
from colonysim.reproduce.stored import StoredTraining, fault_finder

RESULTS = Path(__file__).parent.parent / "docs" / "results" / "push_ablation.jsonl"
HOLE: tuple[tuple[Kind, float], ...] = (("hole", 1.0),)
GRID: dict[str, tuple[str, ...]] = {
    "batch size b": ("batch 64", "base", "batch 256"),
    "exploration steps S": ("base", "explore 3000", "explore 5000"),
    "target update M": ("base", "target 600", "target 1200"),
    "one network or three": ("individual flat", "individual slope", "base", "all-in-one", "preset"),
}
"""What is compared with what: names of settings, `base` being b = 128, S = 1000, M = 300 on holes, `preset` a reading's
own values of these on all terrains."""
LABELS = {"batch size b": "b = 128", "exploration steps S": "S = 1000", "target update M": "M = 300"}


@dataclass(frozen=True, slots=True)
class Unit:
    """One training.

    Attributes:
        setting: A name of `GRID`.
        base: The reading of Algorithm 1 that is changed, a name of `READINGS`.
        engine: The rigid-body engine.
        episodes: Training episodes, those of the exploration not counted.
        seed: Its seed.
    """

    setting: str
    base: str
    engine: EngineName
    episodes: int
    seed: int


def config_of(unit: Unit) -> TrainingConfig:
    """The reading `base` with the paper's b, S and M, but for what the setting says; 20 training and 20 tests in turn.

    `preset` leaves the reading's own b, S and M.
    """
    reading = READINGS[unit.base]
    own = dataclasses.replace(
        reading, name=f"{unit.base}, {unit.setting}", engine=unit.engine, actions=None, episodes=unit.episodes,
        train_block=20, test_block=20, candidates=1, score_blocks=3,
    )  # fmt: skip
    if unit.setting == "preset":
        return own
    learner = dataclasses.replace(reading.learner, target_every=300, average_share=None)
    config = dataclasses.replace(own, batch=128, explore=1000, kinds=HOLE, learner=learner)
    what, _, value = unit.setting.partition(" ")
    if what == "batch":
        return dataclasses.replace(config, batch=int(value))
    if what == "explore":
        return dataclasses.replace(config, explore=int(value))
    if what == "target":
        return dataclasses.replace(config, learner=dataclasses.replace(learner, target_every=int(value)))
    if what == "individual":
        only = next(kind for kind in KINDS if kind == value)
        return dataclasses.replace(config, kinds=((only, 1.0),))
    if what == "all-in-one":
        return dataclasses.replace(config, kinds=reading.kinds)
    return config


def measure(task: tuple[Unit, int, Path]) -> dict[str, Any]:
    """One training, taken up where it was left, and the pushes of its best and its last network.

    A task is the training, the pushes a terrain, and the folder for checkpoints.
    """
    unit, pushes, work = task
    began = time.process_time()
    config = config_of(unit)
    words = unit.base, unit.engine, str(unit.episodes), unit.setting, str(unit.seed)
    trained = train_push(config, work / "-".join(words).replace(" ", "-").replace(",", ""), unit.seed, resume=True)
    assert trained is not None
    explored = trained.history[-1].episodes - unit.episodes
    row: dict[str, Any] = {
        **dataclasses.asdict(unit), "pushes": pushes, "peak_episode": trained.peak_episode - explored,
        "explored": explored, "actions": trained.history[-1].actions,
        "tests": [[p.episodes - explored, p.actions, round(p.success, 4), round(p.reward, 4)] for p in trained.history],
        "losses": [round(p.loss, 3) for p in trained.history],
    }  # fmt: skip
    for name, card in (("pushed", trained.card), ("pushed_last", trained.last)):
        found = evaluate_push(
            "rl", episodes=pushes, seed=unit.seed, terrains=tuple(kind for kind, _ in config.kinds), model=card,
            testing=config.testing, purpose=Purpose.JUDGE, engine=unit.engine,
        )  # fmt: skip
        row[name] = {
            kind: [r["success"], round(r["reward_mean"], 4), round(r["reward_sd"], 4)] for kind, r in found.items()
        }
    return {**row, "cpu_seconds": round(time.process_time() - began, 1)}


def read(path: Path) -> list[dict[str, Any]]:
    if not path.exists():
        return []
    rows, faults = read_lines(path, fault_finder(StoredTraining))
    warn_of(path, faults, "left out")
    return rows


def unit_of(row: dict[str, Any]) -> Unit:
    return Unit(row["setting"], row["base"], row["engine"], row["episodes"], row["seed"])


def run(given: argparse.Namespace) -> None:
    done = {unit_of(row) for row in read(given.results)}
    wanted = [
        Unit(setting, base, given.engine, given.episodes, seed)
        for seed in given.seeds
        for base in given.base
        for setting in given.settings
    ]
    left = [unit for unit in dict.fromkeys(wanted) if unit not in done]
    print(f"{len(left)} of {len(wanted)} trainings to do", flush=True)
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    tasks = [(unit, given.pushes, given.work) for unit in left]
    for _, row in results(measure, tasks, given.workers, fresh=True):
        append_line(given.results, row)
        print(
            f"{row['base']}, {row['setting']}, {row['engine']}, seed {row['seed']}: peak {row['peak_episode']}, "
            f"best {row['pushed']}, last {row['pushed_last']}, {row['cpu_seconds']} s",
            flush=True,
        )


def spread(values: Iterable[float]) -> str:
    values = list(values)
    if len(values) < 2:
        return " ".join(f"{value:.2f}" for value in values) or "-"
    return f"{statistics.fmean(values):.2f} ({min(values):.2f} to {max(values):.2f})"


def end_of(row: dict[str, Any], column: int) -> float:
    """Mean of the last 150 test episodes, or of the last third of the tests if those are fewer."""
    tests = row["tests"]
    last = min(8, max(1, len(tests) // 3))
    return statistics.fmean(test[column] for test in tests[-last:])


def table(given: argparse.Namespace) -> None:
    for base in given.base:
        table_of(base, chosen(given, base), given)


def chosen(given: argparse.Namespace, base: str) -> list[dict[str, Any]]:
    """The trainings of a reading on the engine and of the length that were asked for."""
    asked = base, given.engine, given.episodes
    rows = [row for row in read(given.results) if (row["base"], row["engine"], row["episodes"]) == asked]
    # As in the report, trials count only where there is nothing else.
    real = {row["setting"] for row in rows if row["seed"] < TRIAL}
    return [row for row in rows if row["seed"] < TRIAL or row["setting"] not in real]


def table_of(base: str, rows: list[dict[str, Any]], given: argparse.Namespace) -> None:
    for title, names in GRID.items():
        about = f"{base}, {given.engine}, {given.episodes} training episodes"
        print(f"\n{title} ({about}; mean, least to largest of the seeds)\n")
        if title != "one network or three":
            print("| | seeds | reward of the tests, whole training | reward of the last tests | success of them |")
            print("|---|---|---|---|---|")
        else:
            print("| | seeds | flat | slope | hole | training actions |\n|---|---|---|---|---|---|")
        for name in names:
            here = [row for row in rows if row["setting"] == name]
            label = LABELS.get(title, "individual hole") if name == "base" else name
            if title != "one network or three":
                whole = spread(statistics.fmean(test[3] for test in row["tests"]) for row in here)
                print(
                    f"| {label} | {len(here)} | {whole} | {spread(end_of(r, 3) for r in here)} | "
                    f"{spread(end_of(r, 2) for r in here)} |"
                )
            else:
                cells = [spread(r["pushed"][kind][0] for r in here if kind in r["pushed"]) for kind in KINDS]
                mean = f"{statistics.fmean(r['actions'] for r in here):.0f}" if here else "-"
                print(f"| {label} | {len(here)} | {' | '.join(cells)} | {mean} |")


def plot(given: argparse.Namespace) -> None:
    from colonysim.plots.learning import ablation_figure

    given.out.mkdir(parents=True, exist_ok=True)
    for base in given.base:
        rows = chosen(given, base)
        if not rows:
            raise ColonysimError(f"{given.results}: no trainings of {base!r} on {given.engine}")
        panels = {
            title: {
                LABELS[title] if name == "base" else name: [row["tests"] for row in rows if row["setting"] == name]
                for name in names
            }
            for title, names in GRID.items()
            if title in LABELS
        }
        figure = ablation_figure(panels, f"{base}, {given.engine}, holes")
        figure.savefig(given.out / f"push-ablation-{base.replace(' ', '-').replace(',', '')}.png", dpi=120)


class Formatter(argparse.RawDescriptionHelpFormatter, argparse.ArgumentDefaultsHelpFormatter):
    """Help with the description as it is written, and with every default."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=Formatter)
    parser.add_argument("what", choices=["run", "table", "plot"])
    parser.add_argument(
        "--base", nargs="+", choices=list(READINGS), default=["paper"], help="readings of Algorithm 1 to train"
    )
    parser.add_argument("--engine", choices=ENGINES, default=default_engine(), help="what pushes run on")
    parser.add_argument("--episodes", type=int, default=400, help="training episodes, exploration not counted")
    parser.add_argument("--pushes", type=int, default=200, help="pushes a terrain after each training")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2], help="a training each; from 100 on: trials")
    every = sorted({name for names in GRID.values() for name in names})
    parser.add_argument("--settings", nargs="+", default=every, choices=every, help="what to train")
    parser.add_argument("--workers", type=int, default=2, help="trainings at a time")
    parser.add_argument("--results", type=Path, default=RESULTS, help="where rows are added")
    parser.add_argument("--work", type=Path, default=Path("runs/push-ablation"), help="checkpoints and networks")
    parser.add_argument("--out", type=Path, default=Path("docs/images"), help="where plots go")
    given = parser.parse_args()
    try:
        for name in ("episodes", "pushes", "workers"):
            whole(f"--{name}", getattr(given, name), 1)
        for seed in given.seeds:
            as_seed(seed, "--seeds")
        {"run": run, "table": table, "plot": plot}[given.what](given)
    except ColonysimError as error:
        parser.exit(1, f"Error: {error}\n")


if __name__ == "__main__":
    main()
