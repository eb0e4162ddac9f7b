"""The difference that a policy, a backend, a version or any other setting makes, seed by seed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Any

from colonysim.arguments import as_span
from colonysim.errors import ColonysimError
from colonysim.intervals import of_mean
from colonysim.suggest import nearest
from colonysim.sweep.played import AS_IT_WAS, MEASURES, read_source

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["DIGITS", "MEASURES", "Difference", "Pooled", "compare", "pooled"]

DIGITS = {"success": 3, "steps": 1, "sim_seconds": 1}
"""Digits behind the point with which a measure is told to people."""
_NOUNS = {"success": "Success", "steps": "The number of steps", "sim_seconds": "The simulated time in seconds"}
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
        by_seed: The difference for each of them.
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
    by_seed: Mapping[int, float]


@dataclass(frozen=True)
class Pooled:
    """One effect over all pairs of seeds and settings, each pair counting the same.

    Attributes:
        where: The `group` of agents whose effect it is, if each is compared for itself; else empty.
        by: The column, as of a `Difference`.
        reference: Its value that is compared with.
        other: Its other value.
        measure: One of `MEASURES`.
        means: Of the reference and of the other, over the pairs.
        difference: The other's less the reference's, the mean over the pairs.
        interval: Its 95 % interval over pairs, as of a `Difference`; None with one pair.
        pairs: How many pairs there are, each two runs of the same seed and settings.
        settings: How many settings they are of.
    """

    where: Mapping[str, Any]
    by: str
    reference: Any
    other: Any
    measure: str
    means: tuple[float, float]
    difference: float
    interval: tuple[float, float] | None
    pairs: int
    settings: int

    @property
    def sentence(self) -> str:
        """What the effect means, in one sentence."""
        digits, noun = DIGITS[self.measure], _NOUNS[self.measure]
        if self.where.get("group") is not None:
            noun = f"{noun} of group {self.where['group']}"
        values = (AS_IT_WAS if value is None else value for value in (self.other, self.reference))
        here, there = (f"with {self.by} {value}" for value in values)
        over = "one pair of runs" if self.pairs == 1 else f"{self.pairs} pairs of runs"
        size = f"{abs(self.difference):.{digits}f} {'higher' if self.difference > 0 else 'lower'}"
        told = f"{noun} is {size} {here} than {there}, over {over}"
        if not self.difference:
            told = f"{noun} is on average the same {here} as {there}, over {over}"
        if self.interval is None:
            return f"{told}: too few to tell a difference from chance."
        low, high = self.interval
        span = f"the 95 % interval of the difference, {low:+.{digits}f} to {high:+.{digits}f}"
        if low == high == 0.0:
            return f"{told}: no pair differs."
        if low <= 0.0 <= high:
            return f"{told}, but {span}, holds 0: this may be chance." if self.difference else f"{told}: {span}."
        return f"{told}: {span}, leaves 0 out, so this is more than chance."


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
        seeds = [{row["seed"] for row in rows} for rows in groups.values()]
        if not seeds[0].intersection(*seeds[1:]):
            raise ColonysimError(f"no seed was played with each {by}: what is compared are runs of the same seed")
        raise ColonysimError(f"no seed and settings that two values of {by!r} have in common")
    return found


def pooled(differences: Sequence[Difference]) -> list[Pooled]:
    """The effect of each other value on each measure over all pairs of seeds and settings, or those of each group.

    Pairs count as independent of each other: so they are if a seed draws nothing that two settings share.

    Args:
        differences: What `compare` found.
    """
    alike: dict[tuple[str, str, str], list[Difference]] = {}
    for each in differences:
        alike.setdefault((repr(each.where.get("group")), repr(each.other), each.measure), []).append(each)
    found = []
    for (*_, measure), group in alike.items():
        first, values = group[0], [value for each in group for value in each.by_seed.values()]
        one, two = (sum(each.means[side] * each.seeds for each in group) / len(values) for side in (0, 1))
        interval = of_mean(values, within=_within(measure))
        where = {name: value for name, value in first.where.items() if name == "group"}
        about = where, first.by, first.reference, first.other, measure
        found.append(Pooled(*about, (one, two), fmean(values), interval, len(values), len(group)))
    return found


def _within(measure: str) -> tuple[float, float] | None:
    """What a difference can be at all."""
    return (-1.0, 1.0) if measure == "success" else None


def _differences(
    where: dict[str, Any], by: str, reference: Any, other: Any, one: dict[int, Any], two: dict[int, Any]
) -> list[Difference]:
    seeds = sorted(one.keys() & two.keys())
    found = []
    measures = [measure for measure in MEASURES if seeds and measure in one[seeds[0]]]
    for measure in measures:
        pairs = [(one[seed][measure], two[seed][measure]) for seed in seeds]
        by_seed = {seed: second - first for seed, (first, second) in zip(seeds, pairs, strict=True)}
        values = [*by_seed.values()]
        means = fmean(first for first, _ in pairs), fmean(second for _, second in pairs)
        interval = of_mean(values, within=_within(measure))
        found.append(
            Difference(where, by, reference, other, measure, means, fmean(values), interval, len(seeds), by_seed)
        )
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
    found = [(each, each.means(episodes)) for each in read_source(path, grouped=grouped).played]
    return [{"about": each.about, "seed": each.seed, **means} for each, means in found if means]
