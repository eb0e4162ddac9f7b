"""Runs and trials of sweeps on one footing: with which settings each was played, and how its episodes went."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Any

from colonysim.arguments import MAX_COUNT
from colonysim.errors import ColonysimError
from colonysim.sweep.groups import read_by_group
from colonysim.sweep.tables import read_tables, settings
from colonysim.trace.manifest import is_run
from colonysim.trace.reader import Run

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["AS_IT_WAS", "MEASURES", "Played", "Source", "read_source", "varying"]

MEASURES = ("success", "steps", "sim_seconds")
AS_IT_WAS = "as it was"
"""The word for a setting that somebody left as the scenario, the policy or the run that goes on has it."""


@dataclass(frozen=True)
class Played:
    """A run, or a trial of a sweep that has succeeded; or one group of agents in it.

    Attributes:
        about: What was played, by column: `source` (the directory), then the settings; of a run `version` too, and of a
            group of agents `group`, its name.
        seed: Its seed.
        episodes: For each complete episode its number (`episode`) and each of `MEASURES`; of a group no `sim_seconds`,
            for time is that of all agents.
    """

    about: Mapping[str, Any]
    seed: int
    episodes: Sequence[Mapping[str, Any]]

    def means(self, episodes: tuple[int, int] | None = None) -> dict[str, float]:
        """The mean of each of `MEASURES` that it has over its episodes; empty without any.

        Args:
            episodes: First and last that count; None for all.
        """
        first, last = episodes or (1, MAX_COUNT)
        counted = [each for each in self.episodes if first <= each["episode"] <= last]
        there = [name for name in MEASURES if counted and name in counted[0]]
        return {name: fmean(float(each[name]) for each in counted) for name in there}


@dataclass(frozen=True)
class Source:
    """What a directory holds.

    Attributes:
        path: A run's or a sweep's.
        played: The run, or the trials that have succeeded; by group, as many times as there are groups.
        shortfall: What is not among them, such as "2 of 40 trials: 1 failed, 1 pending"; empty if nothing is missing.
    """

    path: Path
    played: Sequence[Played]
    shortfall: str


def read_source(path: str | Path, *, grouped: bool = False) -> Source:
    """Reads the directory of a run or of a sweep.

    Args:
        path: The directory.
        grouped: Whether each group of agents is read for itself.

    Raises:
        ColonysimError: It holds neither, or no groups where they are asked for, or is damaged.
    """
    path = Path(path)
    return (_of_run if is_run(path) else _of_sweep)(path, grouped)


def _of_run(path: Path, grouped: bool) -> Source:
    run = Run.open(path)
    about, seed = {"source": str(path), **_about(run.manifest)}, int(run.manifest["seed"])
    if not grouped:
        return Source(path, [Played(about, seed, [each._asdict() for each in run.episodes])], run.shortfall)
    if run.manifest.get("scenario") is None or not run.scenario.groups:
        raise ColonysimError(f"{path}: its scenario has no groups of agents")
    found: dict[str, list[dict[str, Any]]] = {}
    for result in run.groups:
        found.setdefault(result.group, []).append(result._asdict())
    played = [Played({**about, "group": name}, seed, episodes) for name, episodes in found.items()]
    return Source(path, played, run.shortfall)


def _of_sweep(path: Path, grouped: bool) -> Source:
    trials, episodes = read_tables(path)
    others = Counter(status for status in trials["status"].to_pylist() if status != "succeeded")
    told = ", ".join(f"{count} {status}" for status, count in others.items())
    shortfall = f"{sum(others.values())} of {trials.num_rows} trials: {told}" if others else ""
    if grouped:
        trials, episodes = read_by_group(path)
    names, by_trial = settings(trials), dict[str, list[dict[str, Any]]]()
    for episode in episodes.to_pylist():
        by_trial.setdefault(episode["trial"], []).append(episode)
    played = [
        Played(
            {"source": str(path), **{name: row[name] for name in names}}, int(row["seed"]),
            by_trial.get(row["trial"], []),
        )
        for row in trials.to_pylist() if row["status"] == "succeeded"
    ]  # fmt: skip
    return Source(path, played, shortfall)


def varying(played: Sequence[Played]) -> list[str]:
    """The columns that tell runs and trials apart, beside their seeds.

    `source` is one of them only where nothing else tells two of the same seed apart.
    """
    names = dict.fromkeys(name for each in played for name in each.about)
    found = [
        name for name in names if name != "source" and len({str(each.about.get(name)) for each in played}) > 1
    ]  # fmt: skip
    keys = {(each.seed, str([each.about.get(name) for name in found])) for each in played}
    return found if len(keys) == len(played) else ["source", *found]


def _about(manifest: Mapping[str, Any]) -> dict[str, Any]:
    """The columns of a run, named as those of a trial."""
    options = manifest["options"]
    about = {"scenario": manifest["name"], **{n: manifest.get(n) for n in ("variant", "backend", "policy", "mode")}}
    about |= {f"backend.{name}": value for name, value in sorted(dict(options.get("backend") or {}).items())}
    overrides = options.get("overrides") or {}
    if not isinstance(overrides, dict):
        overrides = dict(str(word).split("=", 1) for word in overrides)
    return {**about, **{n: v if isinstance(v, str) else json.dumps(v) for n, v in overrides.items()},
            "version": manifest["versions"].get("colonysim")}  # fmt: skip
