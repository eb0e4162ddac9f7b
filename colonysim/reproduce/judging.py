"""When a result agrees with the paper, and when not: one rule for all, computed from intervals."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt
from statistics import fmean
from typing import TYPE_CHECKING, Literal, get_args

from colonysim.intervals import of_mean, wilson

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["RULE", "WITHIN", "WORDS", "Expected", "Figure", "Reported", "Verdict", "direction", "level", "share"]

Expected = Literal["more", "less", "same"]
Word = Literal["agrees", "better", "disagrees", "undecided"]
WORDS: tuple[Word, ...] = get_args(Word)

NEGLIGIBLE = 0.10
"""A difference within this share of the two means' average is none worth the name."""
COARSE = {"steps": 0.25, "success": 0.10, "reward": 1.0}
"""Half of an interval wider than this says nothing; of steps relative to the paper's figure."""
WITHIN = {"success": (0.0, 1.0)}
"""What a measure can be at all."""

RULE = f"""\
Intervals are of 95 %: over seeds, since the episodes of a run depend on each other; by bootstrap (2,000 resamples) from
8 seeds on, Student's for fewer, none for one; seeds that all give the same leave it without width. Shares of runs have
Wilson's. An *undecided* verdict comes with the number of seeds that would decide it if the means stayed as they are and
the interval narrowed with the root of that number, which is rough where there are few seeds.

Where few seeds left a verdict open, more were run, mostly as many as it asked for. That, and the number of comparisons,
let some verdicts come about by chance: of a hundred true equalities about five are found to differ.

- **A figure of the paper** is compared by the difference, ours less the paper's; its interval joins ours with that \
of the paper's mean (its standard deviation over the root of its episodes). It *disagrees* if the interval leaves out \
0, but is *better* if it lies where fewer steps, more success or more reward are; it *agrees* if the interval holds 0 \
and reaches no further from its middle than \
{COARSE["steps"]:.0%} of the paper's steps, {COARSE["success"]:g} of success or {COARSE["reward"]:g} of reward; else \
it is *undecided*.
- **A claim of a difference** is tested on the difference of two settings, paired by seed. It *agrees* if the interval \
lies wholly on the claimed side of 0, however small the difference is; if not, it *disagrees* if the interval lies \
wholly on the other side, or wholly within the negligible, which is {NEGLIGIBLE:.0%} of the average of the two means; \
else it is *undecided*.
- **A claim of no difference** *agrees* if the interval lies within the negligible, *disagrees* if it lies outside, \
else it is *undecided*.
- **A claim about what happens** in a run is tested on the share of runs in which it does: it *agrees* if the interval \
lies above one half, *disagrees* if below, else it is *undecided*.
"""


@dataclass(frozen=True)
class Figure:
    """A mean with its 95 % interval; `low` and `high` are None where there are too few values for one.

    Attributes:
        mean: Of the values.
        low: Lower end.
        high: Upper end.
        count: Number of values.
    """

    mean: float
    low: float | None
    high: float | None
    count: int

    @classmethod
    def of(cls, values: Sequence[float], within: tuple[float, float] | None = None) -> Figure | None:
        """The mean of values, None of none; `within` is what they can be at all."""
        if not values:
            return None
        low, high = of_mean(values, within=within) or (None, None)
        return cls(fmean(values), low, high, len(values))

    def shown(self, digits: int, sign: bool = False) -> str:
        """As text: `mean [low, high]`."""
        form = f"{{:{'+' if sign else ''}.{digits}f}}"
        if self.low is None or self.high is None:
            return form.format(self.mean)
        return f"{form.format(self.mean)} [{form.format(self.low)}, {form.format(self.high)}]"


@dataclass(frozen=True)
class Reported:
    """A figure of the paper: mean and standard deviation over so many episodes."""

    mean: float
    sd: float
    count: int

    @property
    def half(self) -> float:
        """Half of the 95 % interval of the mean."""
        return 1.959964 * self.sd / sqrt(self.count)


@dataclass(frozen=True)
class Verdict:
    """What the rule says.

    Attributes:
        word: One of `WORDS`.
        difference: Ours less the paper's, or one setting's less the other's; None where nothing could be compared.
        takes: How many values would decide what is undecided, if the mean stayed; None if it is decided, if there is no
            interval yet, or if no number would.
    """

    word: Word
    difference: Figure | None
    takes: int | None = None

    @property
    def wanting(self) -> str:
        """What it would take to decide what is undecided; empty if it is decided."""
        d = self.difference
        if self.word != "undecided":
            return ""
        if d is None or d.low is None:
            return "two seeds at least, for an interval"
        if self.takes is None:
            return "no number of seeds would do: the paper's own interval is too wide, or ours meets the limit exactly"
        return f"about {self.takes:,} seeds would do, there are {d.count}"

    @property
    def side(self) -> Literal["above", "below"] | None:
        """Where the difference lies, if its interval leaves out 0."""
        d = self.difference
        if d is None or d.low is None or d.high is None or d.low <= 0.0 <= d.high:
            return None
        return "above" if d.low > 0.0 else "below"


def level(ours: Figure | None, paper: Reported, measure: str) -> Verdict:
    """Whether a figure is that of the paper."""
    if ours is None:
        return Verdict("undecided", None)
    difference = ours.mean - paper.mean
    if ours.low is None or ours.high is None:
        return Verdict("undecided", Figure(difference, None, None, ours.count))
    low = difference - sqrt((ours.mean - ours.low) ** 2 + paper.half**2)
    high = difference + sqrt((ours.high - ours.mean) ** 2 + paper.half**2)
    found = Figure(difference, low, high, ours.count)
    if low > 0.0 or high < 0.0:
        return Verdict("better" if (high < 0.0) == (measure == "steps") else "disagrees", found)
    widest = COARSE[measure] * (paper.mean if measure == "steps" else 1.0)
    if (high - low) / 2.0 <= widest:
        return Verdict("agrees", found)
    # An interval that was cut at what the measure can be at all is as wide as its other half says.
    own, theirs = max(ours.mean - ours.low, ours.high - ours.mean), paper.half
    return Verdict("undecided", found, _takes(ours.count, own, max(abs(difference), widest), theirs))


def direction(
    one: Sequence[float], other: Sequence[float], expected: Expected, within: tuple[float, float] | None = None
) -> Verdict:
    """Whether `one` is more than, less than or the same as `other`, value by value of the same seed.

    `within` is what the values can be at all.
    """
    widest = None if within is None else (within[0] - within[1], within[1] - within[0])
    found = Figure.of([a - b for a, b in zip(one, other, strict=True)], widest)
    if found is None or found.low is None or found.high is None:
        return Verdict("undecided", found)
    slack = NEGLIGIBLE * abs(fmean(one) + fmean(other)) / 2.0
    half = (found.high - found.low) / 2.0
    negligible = -slack <= found.low and found.high <= slack
    if expected == "same":
        outside = found.low > slack or found.high < -slack
        if negligible or outside:
            return Verdict("agrees" if negligible else "disagrees", found)
        return Verdict("undecided", found, _takes(found.count, half, abs(slack - abs(found.mean))))
    claimed, against = found.low > 0.0, found.high < 0.0
    if expected == "less":
        claimed, against = against, claimed
    if claimed or against or negligible:
        return Verdict("agrees" if claimed else "disagrees", found)
    return Verdict("undecided", found, _takes(found.count, half, max(abs(found.mean), slack - abs(found.mean))))


def share(there: int, runs: int) -> Verdict:
    """Whether something happens in most runs, by Wilson's interval of its share."""
    low, high = wilson(there, runs)
    found = Figure(there / runs, low, high, runs)
    if low > 0.5 or high < 0.5:
        return Verdict("agrees" if low > 0.5 else "disagrees", found)
    # Wilson's interval leaves out one half as soon as the normal test of one half does.
    away = abs(found.mean - 0.5)
    return Verdict("undecided", found, ceil((1.959964 * 0.5 / away) ** 2) + 1 if away else None)


def _takes(count: int, half: float, reach: float, theirs: float = 0.0) -> int | None:
    """How many values would bring half of an interval to `reach`.

    Args:
        count: Values there are.
        half: Half of their interval, which narrows with the root of their number.
        reach: What half of the joint interval must come down to.
        theirs: Half of the paper's interval, which stays.
    """
    room = reach**2 - theirs**2
    return max(count + 1, ceil(count * half**2 / room)) if room > 0.0 else None
