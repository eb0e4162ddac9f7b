"""What the trials of a reproduction have found, and results that were stored before."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from statistics import fmean
from typing import TYPE_CHECKING, Any, Literal

from colonysim.backends.physics import SUITED
from colonysim.errors import ColonysimError
from colonysim.jsonlines import described, read_lines
from colonysim.physics import ENGINES
from colonysim.suggest import nearest
from colonysim.sweep.tables import EPISODE

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from colonysim.sweep import Store, Trial

__all__ = ["Evidence", "Measured", "found_by", "stored_in_physics", "stored_lines"]

Measure = Literal["steps", "success", "sim_seconds"]


@dataclass(frozen=True)
class Measured:
    """A trial that has succeeded.

    Attributes:
        settings: Its columns: scenario, variant, backend, policy, mode and the backend's options.
        parameters: Fields of the scenario that were set.
        seed: Its seed.
        episodes: One mapping an episode, as in the table of episodes.
    """

    settings: Mapping[str, Any]
    parameters: Mapping[str, Any]
    seed: int
    episodes: tuple[Mapping[str, Any], ...]


class Evidence:
    """Trials, and questions to them."""

    def __init__(self, trials: Iterable[Measured]) -> None:
        self.trials = tuple(trials)

    def matching(self, settings: Mapping[str, Any]) -> Evidence:
        """The trials with these settings, and with no parameter set that is not among them."""
        return Evidence(
            trial
            for trial in self.trials
            if set(trial.parameters) <= set(settings)
            and all({**trial.settings, **trial.parameters}.get(name) == value for name, value in settings.items())
        )

    def by_seed(
        self, measure: Measure, span: tuple[int, int] | None = None, *, only_at_goal: bool = False
    ) -> dict[int, float]:
        """For each seed the mean of a measure over its episodes.

        Args:
            measure: Which.
            span: First and last episode that count; None for all.
            only_at_goal: Whether only episodes count in which all agents reached the goal.
        """
        first, last = span or (1, 10**9)
        found = {}
        for trial in self.trials:
            values = [
                float(episode[measure])
                for episode in trial.episodes
                if first <= episode["episode"] <= last and (episode["ended"] == "goal" or not only_at_goal)
            ]
            if values:
                found[trial.seed] = fmean(values)
        return found

    def pairs(
        self, one: Mapping[str, Any], other: Mapping[str, Any], measure: Measure, span: tuple[int, int] | None = None
    ) -> tuple[list[float], list[float]]:
        """A measure under two settings, for the seeds that both have."""
        left = self.matching(one).by_seed(measure, span)
        right = self.matching(other).by_seed(measure, span)
        both = sorted(left.keys() & right.keys())
        return [left[seed] for seed in both], [right[seed] for seed in both]


def found_by(trials: Iterable[Trial], store: Store) -> tuple[list[Measured], list[str]]:
    """The trials that have succeeded, and a line for each that has not."""
    measured, missing = [], []
    for trial in trials:
        entry = store.entries.get(trial.identity, {"status": "pending"})
        about = trial.described()
        if entry["status"] != "succeeded":
            reason = str(entry.get("error", "")).strip().splitlines()
            words = ", ".join(f"{name} {value}" for name, value in about.items() if value is not None)
            missing.append(f"{words}: {entry['status']}{f' ({reason[-1]})' if reason else ''}")
            continue
        settings = {name: value for name, value in about.items() if name not in trial.parameters and name != "seed"}
        episodes = tuple(dict(zip(EPISODE, row, strict=True)) for row in entry["episodes"])
        measured.append(Measured(settings, trial.parameters, trial.seed, episodes))
    return measured, missing


def stored_in_physics(path: Path) -> tuple[str, list[Measured], list[str]]:
    """Runs in physics that `benchmarks/physics_tables.py` has stored: one engine, several policies and executors.

    Rows that name no engine are of Bullet, those that name no policy of `colony`, and those that name no estimate have
    the one that suits the executor.

    Returns:
        The engine, the runs, and what is wrong with the lines that are damaged: nothing, or one text.

    Raises:
        ColonysimError: The file cannot be read, is none of these, or holds runs on several engines.
    """
    rows, gaps = stored_lines(
        path, {"map": str, "push": str, "seed": int, "episodes": [_EPISODE]},
        ("map", "policy", "push", "feasibility", "parameters", "seed"),
        "runs in physics as benchmarks/physics_tables.py stores them",
    )  # fmt: skip
    if unknown := sorted({row["push"] for row in rows} - SUITED.keys()):
        raise ColonysimError(f"{path}: there is no executor {unknown[0]!r}; {nearest(unknown[0], SUITED)}")
    engines = sorted({str(row.get("engine", "bullet")) for row in rows})
    if len(engines) > 1 or not set(engines) <= set(ENGINES):
        found = ", ".join(engines)
        raise ColonysimError(f"{path}: holds runs on {found}; expected a file of one engine, {' or '.join(ENGINES)}")
    measured = []
    for row in rows:
        name, _, variant = row["map"].partition(":")
        settings = {
            "scenario": name, "variant": variant or ("r20-4" if name == "hard" else None), "backend": engines[0],
            "policy": row.get("policy", "colony"), "mode": "asynchronous", "backend.push": row["push"],
            "backend.feasibility": row.get("feasibility", SUITED[row["push"]]),
        }  # fmt: skip
        episodes = tuple({"episode": number, **episode} for number, episode in enumerate(row["episodes"], 1))
        measured.append(Measured(settings, row.get("parameters", {}), row["seed"], episodes))
    return engines[0], measured, gaps


_EPISODE = {"steps": int, "success": float, "ended": str, "sim_seconds": float, "seated": int}


def stored_lines(
    path: Path, form: Mapping[str, Any], key: tuple[str, ...], what: str
) -> tuple[list[dict[str, Any]], list[str]]:
    """The rows of a file of results, and what is wrong with the lines that are damaged: nothing, or one text.

    Args:
        path: The file, a JSON object a line.
        form: What a row holds: types, or forms of types as `_fits` knows them.
        key: Names of the values by which a row is told from the others; not every row needs to have each.
        what: What the file should hold, for messages.

    Raises:
        ColonysimError: The file cannot be read, or no line of it is whole.
    """
    seen: set[str] = set()

    def fault_of(row: dict[str, Any]) -> str | None:
        wrong = next((name for name, part in form.items() if not _fits(row.get(name), part)), None)
        if wrong is not None:
            return f"its {wrong!r} is missing or not as it was written"
        named = tuple(row.get(name) for name in key)
        if str(named) in seen:
            return f"it is there twice ({', '.join(str(part) for part in named if part is not None)})"
        seen.add(str(named))
        return None

    rows, faults = read_lines(path, fault_of)
    if faults and not rows:
        raise ColonysimError(f"{path}: not {what}: {described(path, faults)}")
    return rows, [f"{described(path, faults)}; left out"] if faults else []


def _fits(value: Any, form: Any) -> bool:
    """Whether a value is of a type (whole numbers are floats too), a list of what fits, or a mapping with such values.

    A tuple stands for a list of as many values.
    """
    if isinstance(form, list):
        return isinstance(value, list) and all(_fits(item, form[0]) for item in value)
    if isinstance(form, tuple):
        return isinstance(value, list) and len(value) == len(form) and all(map(_fits, value, form))
    if isinstance(form, dict):
        return isinstance(value, dict) and all(_fits(value.get(name), part) for name, part in form.items())
    if form is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and isfinite(value)
    return isinstance(value, form) and not isinstance(value, bool)
