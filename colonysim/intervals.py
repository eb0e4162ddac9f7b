"""How sure a measured share is."""

from __future__ import annotations

from math import sqrt
from random import Random
from statistics import fmean, stdev
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["FEWEST", "bootstrap", "of_mean", "student", "wilson"]

FEWEST = 8
"""Of fewer values a bootstrap is too narrow."""
# Two-sided 95 % points of Student's t for 1, 2, ... degrees of freedom.
_T95 = (12.706, 4.303, 3.182, 2.776, 2.571, 2.447)


def wilson(successes: int, trials: int, z: float = 1.959964) -> tuple[float, float]:
    """Wilson's interval of a success rate, 95 % by default; the whole range for no trials."""
    if trials == 0:
        return 0.0, 1.0
    share = successes / trials
    scale = 1 + z * z / trials
    middle = (share + z * z / (2 * trials)) / scale
    half = z * sqrt(share * (1 - share) / trials + z * z / (4 * trials * trials)) / scale
    return max(0.0, middle - half), min(1.0, middle + half)


def bootstrap(values: Sequence[float], resamples: int = 2000, share: float = 0.95) -> tuple[float, float]:
    """The percentile interval of a mean, by resampling with a fixed seed; the value itself if there is only one.

    Raises:
        ValueError: There are no values.
    """
    if not values:
        raise ValueError("no values to resample")
    draw, count = Random(0).random, len(values)
    means = sorted(sum(values[int(draw() * count)] for _ in values) / count for _ in range(resamples))
    cut = (1.0 - share) / 2.0
    return means[int(cut * resamples)], means[min(resamples - 1, int((1.0 - cut) * resamples))]


def student(values: Sequence[float]) -> tuple[float, float]:
    """Student's 95 % interval of a mean, for 2 to 7 values.

    Raises:
        ValueError: There are fewer or more.
    """
    if not 2 <= len(values) < FEWEST:
        raise ValueError(f"{len(values)} values, expected 2 to {FEWEST - 1}")
    half = _T95[len(values) - 2] * stdev(values) / sqrt(len(values))
    return fmean(values) - half, fmean(values) + half


def of_mean(
    values: Sequence[float], resamples: int = 2000, within: tuple[float, float] | None = None
) -> tuple[float, float] | None:
    """The 95 % interval of a mean: by bootstrap from 8 values on, Student's for fewer, None for one or none.

    Args:
        values: What the mean is of.
        resamples: Of the bootstrap.
        within: What the values can be at all, such as (0, 1) for shares and (-1, 1) for differences of shares. Their
            mean cannot be beyond, so that an interval that is cut off there holds it as surely.
    """
    if len(values) < 2:
        return None
    low, high = bootstrap(values, resamples) if len(values) >= FEWEST else student(values)
    return (low, high) if within is None else (max(low, within[0]), min(high, within[1]))
