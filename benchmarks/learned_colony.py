"""The learned policy beside the rules, on places that it has never seen: success and makespan, and how it learned.

    python benchmarks/learned_colony.py train --seeds 0 1 2
    python benchmarks/learned_colony.py train --seeds 0 --critic local
    python benchmarks/learned_colony.py run
    python benchmarks/learned_colony.py table
    python benchmarks/learned_colony.py plot --out docs/images
    python benchmarks/learned_colony.py film --out docs/images

`train` trains with the preset `small`, goes on from checkpoints, and adds the curve of each training to the results;
`run` plays each policy at each place with each seed and adds a line a run; what is there already is skipped. Marks last
over the six episodes of a run, for every policy. The makespan is the simulated time until all agents are at the goal;
an episode that fails counts with the place's time limit, whyever it ended. Intervals are bootstraps over the means of
the places (95 %); ratios are those of a place's means.

Places are those of `colonysim.rl.training.places` for judging, none of which training or tests of it have seen. Their
first twenty were played before it was settled that learned policies draw their actions; those that count are the next
twenty, and nothing was chosen by looking at them. `MAPS` come with the package and are quite unlike the places.
"""

import argparse
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import colonysim
from colonysim.intervals import of_mean
from colonysim.jsonlines import append_line, read_lines
from colonysim.learning.seeds import Purpose
from colonysim.plots.sheet import SCREEN
from colonysim.processes import results
from colonysim.rl.training.places import KINDS, place
from colonysim.rl.training.presets import PRESETS
from colonysim.rl.training.trainer import Progress, train_policy
from colonysim.scenario.scenario import Scenario
from colonysim.video.film import Film

RESULTS = Path(__file__).parent.parent / "docs" / "results" / "learned_colony.jsonl"
MODELS = Path("runs/learned_colony")
PLACES, SEEDS, EPISODES = range(20, 40), 5, 6
FPS = 8
MAPS = ("easy", "medium", "hard")
RULES: dict[str, dict[str, Any]] = {
    "random": {"name": "random"}, "paper": {"name": "paper"}, "colony": {"name": "colony"},
    "colony, decided": {"name": "colony", "beta": 16.0, "epsilon": 0.0, "epsilon_floor": 0.0},
}  # fmt: skip
"""The rules by name; "decided" is `colony` that never explores and nearly always takes what is best."""
LEARNED = {
    "imitated": "central-{}/policy-imitated.json", "learned": "central-{}/policy.json", "IPPO": "local-{}/policy.json",
}  # fmt: skip
"""Where the networks are of the policies that learned, by the seed of the training: after the imitation, with a critic
that knows the team's state, and with one that knows what the agent is told."""


@dataclass(frozen=True, slots=True)
class Unit:
    """One run.

    Attributes:
        policy: A name of `RULES` or `LEARNED`.
        training: Seed of the training; -1 of a rule.
        place: Number of the place, or name of a map.
        seed: Seed of the run.
    """

    policy: str
    training: int
    place: int | str
    seed: int


def scenario_of(unit: Unit, models: Path) -> Scenario:
    if isinstance(unit.place, int):
        document = place(Purpose.JUDGE, unit.place).document
    else:
        # Several times what the rule needs there.
        document = {**colonysim.load_scenario(unit.place).document, "time_limit": 600.0}
    policy = RULES.get(unit.policy) or {
        "name": "learned", "model": str((models / LEARNED[unit.policy].format(unit.training)).resolve())
    }  # fmt: skip
    return colonysim.scenario_from_document({**document, "policy": policy})


def play(task: tuple[Unit, Path]) -> dict[str, Any]:
    unit, models = task
    scenario = scenario_of(unit, models)
    run = colonysim.run(scenario, episodes=EPISODES, seed=unit.seed, trace=False)
    return {
        "policy": unit.policy, "training": unit.training, "place": unit.place, "world": scenario.name,
        "seed": unit.seed, "episodes": told_of(run, scenario),
    }  # fmt: skip


def told_of(run: colonysim.Run, scenario: Scenario) -> list[list[Any]]:
    """Success and seconds of each episode, and why it ended where not all were at the goal."""
    limit = scenario.time_limit
    assert limit is not None
    return [
        [1, round(min(e.sim_seconds, limit), 2)] if e.success == 1.0 else [round(e.success, 4), limit, e.ended]
        for e in run.episodes
    ]


def train(options: argparse.Namespace) -> None:
    done = {(row["critic"], row["curve"]) for row in stored(options.results) if "curve" in row}
    config = PRESETS["small"]
    config = replace(config, ppo=replace(config.ppo, critic=options.critic))
    for seed in options.seeds:
        if (options.critic, seed) in done:
            continue

        def told(progress: Progress, seed: int = seed) -> None:
            if progress.tested is not None:
                print(
                    f"seed {seed}, {progress.phase} {progress.round}, {progress.decisions} decisions: "
                    f"success {progress.tested.success:.3f}, makespan {progress.tested.seconds:.1f} s",
                    flush=True,
                )

        folder = options.models / f"{options.critic}-{seed}"
        trained = train_policy(config, folder, seed, resume=True, on_progress=told)
        assert trained is not None
        tests = [
            [each.phase, each.round, each.decisions, round(each.tested.success, 4), round(each.tested.seconds, 2)]
            for each in trained.history
            if each.tested is not None
        ]
        how = json.loads(trained.card.read_text())["how"]
        agreement = [round(e.told["agreement"], 4) for e in trained.history if e.phase == "imitation"][-1:]
        append_line(options.results, {
            "curve": seed, "critic": options.critic, "rule": round(rule_on_tests(seed), 2),
            "best_round": trained.best_round, "cpu_seconds": how["cpu_seconds"], "agreement": agreement,
            "kept": how["test"], "tests": tests,
        })  # fmt: skip


def rule_on_tests(seed: int) -> float:
    """The makespan of `colony` at the places of the tests of a training."""
    config = PRESETS["small"]
    seconds = []
    for number in range(config.test_places):
        document = {**place(Purpose.TUNE, number).document, "policy": RULES["colony"]}
        scenario = colonysim.scenario_from_document(document)
        run = colonysim.run(scenario, episodes=config.episodes, seed=seed, trace=False)
        seconds += [episode[1] for episode in told_of(run, scenario)]
    return fmean(seconds)


def run(options: argparse.Namespace) -> None:
    rows = stored(options.results)
    done = {(row["policy"], row["training"], row["place"], row["seed"]) for row in rows if "policy" in row}
    policies = [(name, -1) for name in RULES]
    policies += [
        (name, seed) for seed in options.seeds for name, file in LEARNED.items()
        if (options.models / file.format(seed)).exists()
    ]  # fmt: skip
    where: list[int | str] = [*PLACES, *MAPS]
    units = [Unit(name, training, at, seed) for name, training in policies for at in where for seed in range(SEEDS)]
    tasks = [(unit, options.models) for unit in units
             if (unit.policy, unit.training, unit.place, unit.seed) not in done]  # fmt: skip
    print(f"{len(tasks)} runs to go, {len(done)} done", flush=True)
    for _, row in results(play, tasks, options.workers):
        append_line(options.results, row)


def stored(path: Path) -> list[dict[str, Any]]:
    return read_lines(path, lambda row: None)[0] if path.exists() else []


Episodes = Sequence[list[Any]]
Measure = Callable[[Episodes], float]


def success(episodes: Episodes) -> float:
    return fmean(episode[0] for episode in episodes)


def makespan(episodes: Episodes) -> float:
    return fmean(episode[1] for episode in episodes)


def by_place(rows: Sequence[dict[str, Any]], measure: Measure, which: slice = slice(None)) -> dict[int | str, float]:
    """The mean of a measure at each place, over seeds, episodes and trainings."""
    found: dict[int | str, list[float]] = {}
    for row in rows:
        found.setdefault(row["place"], []).append(measure(row["episodes"][which]))
    return {at: fmean(values) for at, values in sorted(found.items(), key=lambda item: str(item[0]))}


def shown(values: Sequence[float], digits: int, within: tuple[float, float] | None = None) -> str:
    """A mean with its interval."""
    interval = of_mean(values, within=within)
    told = "" if interval is None else f" ({interval[0]:.{digits}f} to {interval[1]:.{digits}f})"
    return f"{fmean(values):.{digits}f}{told}"


def ratios(rows: Sequence[dict[str, Any]], base: Sequence[dict[str, Any]], which: slice = slice(None)) -> list[float]:
    """The ratio of the makespans at each place."""
    own, other = by_place(rows, makespan, which), by_place(base, makespan, which)
    return [own[at] / other[at] for at in own if at in other]


def table(options: argparse.Namespace) -> None:
    rows = [row for row in stored(options.results) if "policy" in row]
    places = [row for row in rows if isinstance(row["place"], int)]
    base = [row for row in places if row["policy"] == "colony"]
    print("| policy | runs | success | makespan, s | of `colony`'s | in episode 1, of `colony`'s |")
    print("|---|---|---|---|---|---|")
    for label, some in groups(places):
        print(
            f"| {label} | {len(some)} | {shown([*by_place(some, success).values()], 3, (0.0, 1.0))} "
            f"| {shown([*by_place(some, makespan).values()], 1)} | {shown(ratios(some, base), 2)} "
            f"| {shown(ratios(some, base, slice(0, 1)), 2)} |"
        )
    kinds = [f"{kind}, {what}" for kind in KINDS for what in ("success", "s")]
    print(f"\n| policy | {' | '.join(kinds)} |\n|{'---|' * (1 + len(kinds))}")
    for label, some in groups(places):
        cells = []
        for kind in KINDS:
            there = [row for row in some if row["world"].startswith(kind)]
            cells += [f"{fmean(by_place(there, success).values()):.3f}",
                      f"{fmean(by_place(there, makespan).values()):.1f}"]  # fmt: skip
        print(f"| {label} | {' | '.join(cells)} |")
    maps = [row for row in rows if isinstance(row["place"], str)]
    if maps:
        print(f"\n| policy | {' | '.join(f'{name}, {what}' for name in MAPS for what in ('success', 's'))} |")
        print(f"|{'---|' * (1 + 2 * len(MAPS))}")
    for label, some in groups(maps):
        good, long = by_place(some, success), by_place(some, makespan)
        print(f"| {label} | {' | '.join(f'{good[name]:.3f} | {long[name]:.1f}' for name in MAPS if name in good)} |")
    for row in stored(options.results):
        if "curve" in row:
            print(
                f"\n{row['critic']} critic, training {row['curve']}: agreement of the imitation "
                f"{row['agreement'][0]:.3f}, best after {row['best_round']} iterations, "
                f"{row['tests'][-1][2]} decisions, {row['cpu_seconds']} s of CPU, tested {row['kept']}"
            )


def groups(rows: Sequence[dict[str, Any]]) -> list[tuple[str, list[dict[str, Any]]]]:
    """Rows of each policy; of learned ones those of each training, and those of all of them."""
    found = []
    for name in (*RULES, *LEARNED):
        of_name = [row for row in rows if row["policy"] == name]
        trainings = sorted({row["training"] for row in of_name})
        if len(trainings) > 1:
            found += [(f"{name}, training {n}", [row for row in of_name if row["training"] == n]) for n in trainings]
            found.append((f"{name}, all {len(trainings)} trainings", of_name))
        elif of_name:
            found.append((name, of_name))
    return found


def plot(options: argparse.Namespace) -> None:
    from colonysim.plots.policy_learning import policy_curves_figure

    rows = [row for row in stored(options.results) if "curve" in row and row["critic"] == "central"]
    curves = {f"training {row['curve']}": [test[2:] for test in row["tests"]] for row in rows}
    options.out.mkdir(parents=True, exist_ok=True)
    with SCREEN.drawing():
        figure = policy_curves_figure(curves, SCREEN, fmean(row["rule"] for row in rows))
        figure.savefig(options.out / "learned-curves.svg", metadata={"Date": None})


class Beside:
    """Two films beside each other, at the same pace; the shorter one rests on its last image."""

    def __init__(self, left: Film, right: Film) -> None:
        self.films, self.fps = (left, right), left.fps
        self.size = (left.size[0] + right.size[0], left.size[1])

    def __len__(self) -> int:
        return max(map(len, self.films))

    def __getitem__(self, number: int) -> Any:
        return np.concatenate([film[min(number, len(film) - 1)] for film in self.films], axis=1)


def film(options: argparse.Namespace) -> None:
    from colonysim.video.encode import encode

    films = []
    with TemporaryDirectory() as folder:
        for name, training in (("colony", -1), ("learned", options.training)):
            scenario = scenario_of(Unit(name, training, options.place, 0), options.models)
            short = colonysim.scenario_from_document({**scenario.document, "name": scenario.name.partition("-")[0]})
            run = colonysim.run(short, episodes=1, seed=options.seed, out=Path(folder) / name)
            result = run.episodes[0]
            print(f"{name}: success {result.success}, {result.sim_seconds:.1f} s")
            frames = max(2, round(result.sim_seconds / options.pace * FPS))
            films.append(Film(run, result, frames=frames, fps=FPS, size=(360, 270)))
        options.out.mkdir(parents=True, exist_ok=True)
        encode(Beside(*films), options.out / "learned-beside.gif", ".gif", lambda done, total: None)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", type=Path, default=RESULTS)
    parser.add_argument("--models", type=Path, default=MODELS)
    parts = parser.add_subparsers(required=True)
    for name, call in (("train", train), ("run", run)):
        part = parts.add_parser(name)
        part.add_argument("--seeds", type=int, nargs="*", default=[0, 1, 2], help="seeds of the trainings")
        part.set_defaults(call=call)
        if name == "run":
            part.add_argument("--workers", type=int, default=1)
        else:
            part.add_argument("--critic", choices=["central", "local"], default="central")
    parts.add_parser("table").set_defaults(call=table)
    part = parts.add_parser("plot")
    part.add_argument("--out", type=Path, default=Path("docs/images"))
    part.set_defaults(call=plot)
    part = parts.add_parser("film")
    part.add_argument("--out", type=Path, default=Path("docs/images"))
    part.add_argument("--place", type=int, default=29)
    part.add_argument("--seed", type=int, default=0)
    part.add_argument("--training", type=int, default=0)
    part.add_argument("--pace", type=float, default=2.5, help="simulated seconds that pass in a second of the film")
    part.set_defaults(call=film)
    options = parser.parse_args()
    options.call(options)


if __name__ == "__main__":
    main()
