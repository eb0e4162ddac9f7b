"""What the trials of a reproduction have found, and runs that were stored before."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import fmean
from typing import TYPE_CHECKING, Any, Literal

from colonysim.errors import ColonysimError
from colonysim.reproduce.paper import the_paper
from colonysim.reproduce.stored import StoredRun, stored_rows
from colonysim.sweep.tables import EPISODE

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from pathlib import Path

    from colonysim.sweep import Store, Trial

__all__ = ["Evidence", "Measured", "found_by", "stored_in_physics"]

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

    Returns:
        The engine, the runs, and what of the file was left out and why, a text for each reason.

    Raises:
        ColonysimError: The file cannot be read, is none of these, or holds runs on several engines.
    """
    rows, gaps = stored_rows(path, StoredRun)
    engines = sorted({row.engine for row in rows})
    if len(engines) > 1:
        raise ColonysimError(f"{path}: holds runs on {', '.join(engines)}; expected a file of one engine")
    maps = {(row.map, row.variant): row.label for row in the_paper().performance}
    if strange := sorted({row.map for row in rows if row.place not in maps}):
        gaps.append(f"{path}: the paper has no map {', '.join(map(repr, strange))}; left out")
    measured = []
    for row in (row for row in rows if row.place in maps):
        name, variant = row.place
        settings = {
            "scenario": name, "variant": variant, "backend": row.engine, "policy": row.policy, "mode": "asynchronous",
            "backend.push": row.push, "backend.feasibility": row.feasibility,
        }  # fmt: skip
        episodes = tuple({"episode": number, **each.model_dump()} for number, each in enumerate(row.episodes, 1))
        measured.append(Measured(settings, row.parameters, row.seed, episodes))
    return engines[0], measured, gaps
