"""How figures of many runs arrange them: by what varies, along an axis or as lines."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import fmean
from typing import TYPE_CHECKING, Any

from colonysim.characters import printable
from colonysim.errors import ColonysimError
from colonysim.intervals import of_mean
from colonysim.suggest import nearest
from colonysim.sweep.played import AS_IT_WAS, varying

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.sweep.played import Played

__all__ = [
    "MOST_LINES", "Arrangement", "Point", "arranged", "labels", "number_of", "point", "short", "value_of", "word",
]  # fmt: skip

MOST_LINES = 42
"""Lines of one diagram that can be told apart."""
_LONGEST = 26
"""Characters of a name or a value in a figure."""
_LINES_FIRST = ("policy", "backend")
"""Columns that are told apart by lines rather than along the axis, and compared before others."""


@dataclass(frozen=True)
class Arrangement:
    """Which columns a figure shows, and how.

    Attributes:
        x: The column along the axis; None where nothing varies but the seed.
        by: The columns that are told apart by lines.
        averaged: The columns that vary besides: their values are averaged over, as seeds are.
        numeric: Whether the values of `x` are numbers.
    """

    x: str | None
    by: tuple[str, ...]
    averaged: tuple[str, ...]
    numeric: bool

    def lines(self, played: Sequence[Played]) -> dict[tuple[Any, ...], list[Played]]:
        """The runs of each line, in the order of their values."""
        return _grouped(played, self.by)

    def along(self, played: Sequence[Played]) -> dict[Any, list[Played]]:
        """The runs at each value of `x`, in its order."""
        return {key[0]: group for key, group in _grouped(played, (self.x or "",)).items()}


@dataclass(frozen=True, slots=True)
class Point:
    """A mean with its 95 % interval, None of one value, and how many values it is of."""

    mean: float
    interval: tuple[float, float] | None
    count: int

    @property
    def reach(self) -> tuple[float, float]:
        """How far the interval goes below the mean and above it; 0 without one."""
        low, high = self.interval or (self.mean, self.mean)
        return max(0.0, self.mean - low), max(0.0, high - self.mean)


def point(values: Sequence[float], measure: str, resamples: int = 2000) -> Point:
    """The mean of a measure over runs."""
    within = (0.0, 1.0) if measure == "success" else None
    return Point(fmean(values), of_mean(values, resamples, within), len(values))


def arranged(played: Sequence[Played], x: str | None, by: Sequence[str] | None) -> Arrangement:
    """Chooses what is not asked for by what varies.

    Along the axis goes the number with the most values, else the first column that varies and is neither policy nor
    backend; all others become lines, but for numbers that were drawn at random together with it, and for what would
    be more lines than can be told apart.

    Raises:
        ColonysimError: There is no such column, or more lines are asked for than can be told apart.
    """
    columns = list(dict.fromkeys(name for each in played for name in each.about))
    for name in (x, *(by or ())):
        if name is not None and name not in columns:
            raise ColonysimError(f"no column {name!r} to plot by; {nearest(name, columns)}")
    if x is not None and by is not None and x in by:
        raise ColonysimError(f"{x}: expected along the axis or as lines, not both")
    vary = [name for name in varying(played) if name not in (by or ())]
    numbers = {name: _count(played, (name,)) for name in vary if _numeric(played, name)}
    if x is None and vary:
        others = [name for name in vary if name not in _LINES_FIRST]
        x = max(numbers, key=lambda name: numbers[name]) if numbers else (others or vary)[0]
    rest = [name for name in vary if name != x]
    lines = list(by) if by is not None else _lines(played, x, rest)
    if by is not None and _count(played, lines) > MOST_LINES:
        asked = _count(played, lines)
        raise ColonysimError(f"{', '.join(lines)}: {asked} lines, of which {MOST_LINES} can be told apart")
    averaged = tuple(name for name in rest if name not in lines)
    return Arrangement(x, tuple(lines), averaged, x is not None and _numeric(played, x))


def _lines(played: Sequence[Played], x: str | None, rest: Sequence[str]) -> list[str]:
    """Of the columns that vary beside `x` those that become lines."""
    lines = sorted(rest, key=lambda name: name not in _LINES_FIRST)
    for name in rest:
        # Of numbers drawn together each value has hardly more than one of the other's.
        if x and _numeric(played, name) and _numeric(played, x):
            pairs, both = _count(played, (x, name)), _count(played, (x,)) * _count(played, (name,))
            if 2 * pairs < both:
                lines.remove(name)
    while lines and _count(played, lines) > MOST_LINES:
        lines.remove(max(lines, key=lambda name: _count(played, (name,))))
    return lines


def value_of(played: Played, name: str) -> Any:
    """The value of a column; of a text that is a number, as overrides of a run are, the number."""
    value = played.about.get(name)
    number = number_of(value)
    return value if number is None or not isinstance(value, str) else number


def number_of(value: Any) -> float | None:
    """A value as a finite number; None of anything else, truth values too."""
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        return None
    try:
        number = float(value)
    except (ValueError, OverflowError):
        return None
    return number if math.isfinite(number) else None


def _numeric(played: Sequence[Played], name: str) -> bool:
    return all(number_of(each.about.get(name)) is not None for each in played)


def _count(played: Sequence[Played], names: Sequence[str]) -> int:
    return len({tuple(value_of(each, name) for name in names) for each in played})


def _grouped(played: Sequence[Played], names: Sequence[str]) -> dict[tuple[Any, ...], list[Played]]:
    """Runs by the values of some columns: numbers in their order, others in that in which they come."""
    groups: dict[tuple[Any, ...], list[Played]] = {}
    for each in played:
        groups.setdefault(tuple(value_of(each, name) for name in names), []).append(each)
    seen = [list(dict.fromkeys(key[i] for key in groups)) for i in range(len(names))]
    ranks = [
        {value: place for place, value in enumerate(sorted(values) if _numeric(played, name) else values)}
        for name, values in zip(names, seen, strict=True)
    ]  # fmt: skip
    order = sorted(groups, key=lambda key: [rank[value] for rank, value in zip(ranks, key, strict=True)])
    return {key: groups[key] for key in order}


def labels(keys: Iterable[tuple[Any, ...]]) -> list[str]:
    """What each line is called: its values, and a number where what is left of long ones is the same."""
    found: list[str] = []
    for key in keys:
        label = ", ".join(word(value) for value in key)
        twins = sum(each == label or each.startswith(f"{label} (") for each in found)
        found.append(f"{label} ({twins + 1})" if twins else label)
    return found


def word(value: Any) -> str:
    """A value as a figure shows it."""
    if value is None:
        return AS_IT_WAS
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else short(str(value))


def short(text: str, most: int = _LONGEST) -> str:
    """A text with its middle left out where it is long: names of files and parameters differ at their ends."""
    text = printable(text, 1000)
    head = (most - 1) // 3
    return text if len(text) <= most else f"{text[:head]}…{text[head + 1 - most :]}"
