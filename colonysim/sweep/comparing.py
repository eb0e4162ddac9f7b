"""The difference that a policy, a backend, a version or any other setting makes, seed by seed."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Any

from colonysim.arguments import as_span
from colonysim.errors import ColonysimError
from colonysim.intervals import of_mean
from colonysim.suggest import nearest
from colonysim.sweep.groups import read_by_group
from colonysim.sweep.tables import read_tables, settings
from colonysim.trace.manifest import is_run
from colonysim.trace.reader import Run

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["MEASURES", "Difference", "compare"]

MEASURES = ("success", "steps", "sim_seconds")
Key = tuple[Any, ...]


@dataclass(frozen=True)
class Difference:
    """What it makes that one column has another value, everything else being equal.

    Attributes:
        where: The columns that vary besides, with their values.
        by: The column.
        reference: Its value that is compared with.
        other: Its other value.
        measure: One of `MEASURES`.
        means: Of the reference and of the other, over the seeds that both have.
        difference: The other's less the reference's.
        interval: Its 95 % interval over seeds (bootstrap from 8 on, Student's for fewer); None with one seed.
        seeds: How many both have.
    """

    where: Mapping[str, Any]
    by: str
    reference: Any
    other: Any
    measure: str
    means: tuple[float, float]
    difference: float
    interval: tuple[float, float] | None
    seeds: int


def compare(
    paths: Sequence[str | Path],
    *,
    by: str | None = None,
    episodes: tuple[int, int] | None = None,
    by_group: bool = False,
) -> list[Difference]:
    """Compares runs and trials that differ in one column, paired by seed.

    Args:
        paths: Directories of runs and sweeps.
        by: The column whose values are compared, the first that comes being the reference: one of the settings,
            `version` (runs only), `group` (groups of agents with each other), or `source`, the directory. By default
            the only setting that varies, or `source` where that does not tell the directories apart.
        episodes: First and last episode that count; None for all.
        by_group: Whether each group of agents is compared for itself: success and steps, for time is that of all.

    Raises:
        ColonysimError: A path holds neither, or no groups where they are asked for; there is no such column, or nothing
            can be compared.
    """
    if episodes is not None:
        episodes = as_span("episodes", episodes)
    grouped = by_group or by == "group"
    rows = [row for path in paths for row in _rows(Path(path), episodes, grouped)]
    if not rows:
        raise ColonysimError("nothing to compare: no run or trial has finished these episodes")
    names = list(dict.fromkeys(name for row in rows for name in row["about"]))
    by = _column(rows, names, by)
    groups: dict[Any, list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault(row["about"].get(by), []).append(row)
    if len(groups) < 2:
        raise ColonysimError(f"{by} is {next(iter(groups))!r} everywhere: there is nothing to compare it with")
    # What is the same throughout a group belongs to what is compared; what varies within it has to be the same.
    varying = {
        name for rows in groups.values() for name in names if len({str(row["about"].get(name)) for row in rows}) > 1
    }
    free = [n for n in names if n not in (by, "source", "version") and (n in varying or n == "group")]
    reference, *others = groups
    found = []
    first = _by_place(groups[reference], free)
    for other in others:
        second = _by_place(groups[other], free)
        for place in dict.fromkeys(place for place in first if place in second):
            where = dict(zip(free, place, strict=True))
            found += _differences(where, by, reference, other, first[place], second[place])
    if not found:
        raise ColonysimError(f"no seed and settings that two values of {by!r} have in common")
    return found


def _differences(
    where: dict[str, Any], by: str, reference: Any, other: Any, one: dict[int, Any], two: dict[int, Any]
) -> list[Difference]:
    seeds = sorted(one.keys() & two.keys())
    found = []
    measures = [measure for measure in MEASURES if seeds and measure in one[seeds[0]]]
    for measure in measures:
        pairs = [(one[seed][measure], two[seed][measure]) for seed in seeds]
        values = [second - first for first, second in pairs]
        means = fmean(first for first, _ in pairs), fmean(second for _, second in pairs)
        interval = of_mean(values, within=(-1.0, 1.0) if measure == "success" else None)
        found.append(Difference(where, by, reference, other, measure, means, fmean(values), interval, len(seeds)))
    return found


def _by_place(rows: Sequence[dict[str, Any]], free: Sequence[str]) -> dict[Key, dict[int, Any]]:
    places: dict[Key, dict[int, Any]] = {}
    for row in rows:
        seeds = places.setdefault(tuple(row["about"].get(name) for name in free), {})
        if row["seed"] in seeds:
            raise ColonysimError(
                f"{row['about']['source']}: seed {row['seed']} is there twice with the same settings; --by source or "
                "fewer directories tell them apart"
            )
        seeds[row["seed"]] = row
    return places


def _column(rows: Sequence[dict[str, Any]], names: Sequence[str], by: str | None) -> str:
    if by is not None:
        if by not in names:
            raise ColonysimError(f"no column {by!r} to compare by; {nearest(by, names)}")
        return by
    varying = [n for n in names if n not in ("source", "group") and len({str(row["about"].get(n)) for row in rows}) > 1]
    several = len({row["about"]["source"] for row in rows}) > 1
    if len(varying) == 1 and not (several and _twice(rows)):
        return varying[0]
    if several:
        return "source"
    raise ColonysimError(f"expected --by, one of {', '.join(varying)}" if varying else "only the seed varies")


def _twice(rows: Sequence[dict[str, Any]]) -> bool:
    """Whether two rows have the same settings, version and seed: nothing but their directories tells them apart."""
    keys = [(row["seed"], str(sorted((n, v) for n, v in row["about"].items() if n != "source"))) for row in rows]
    return len(set(keys)) < len(keys)


def _rows(path: Path, episodes: tuple[int, int] | None, grouped: bool) -> list[dict[str, Any]]:
    """For each run, or each group of its agents, its columns ("about"), its seed and the means of the measures."""
    first, last = episodes or (1, 10**9)
    rows = []
    for about, seed, played in (_of_run if is_run(path) else _of_sweep)(path, grouped):
        counted = [episode for episode in played if first <= episode["episode"] <= last]
        if counted:
            there = [measure for measure in MEASURES if measure in counted[0]]
            means = {measure: fmean(float(episode[measure]) for episode in counted) for measure in there}
            rows.append({"about": {"source": str(path), **about}, "seed": seed, **means})
    return rows


_Played = list[tuple[dict[str, Any], int, list[dict[str, Any]]]]
"""Columns, seed and episodes of each run or trial, or of each group in it."""


def _of_run(path: Path, grouped: bool) -> _Played:
    run = Run.open(path)
    about, seed = _about(run.manifest), int(run.manifest["seed"])
    if not grouped:
        return [(about, seed, [episode._asdict() for episode in run.episodes])]
    found: dict[str, list[dict[str, Any]]] = {}
    for result in run.groups:
        found.setdefault(result.group, []).append(result._asdict())
    if run.manifest.get("scenario") is None or not run.scenario.groups:
        raise ColonysimError(f"{path}: its scenario has no groups of agents")
    return [({**about, "group": name}, seed, episodes) for name, episodes in found.items()]


def _of_sweep(path: Path, grouped: bool) -> _Played:
    trials, episodes_of = read_by_group(path) if grouped else read_tables(path)
    names = settings(trials)
    played: dict[str, list[dict[str, Any]]] = {}
    for episode in episodes_of.to_pylist():
        played.setdefault(episode["trial"], []).append(episode)
    done = [row for row in trials.to_pylist() if row["status"] == "succeeded"]
    return [({name: row[name] for name in names}, int(row["seed"]), played.get(row["trial"], [])) for row in done]


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
