# cython: boundscheck=False, wraparound=False, initializedcheck=False
"""Random choice: softmax and sampling whose results are the same, bit for bit, on every machine."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

from colonysim.errors import ColonysimError
from colonysim.exact import exp

if TYPE_CHECKING:
    import random
    from collections.abc import Sequence

__all__ = ["pick", "sample", "softmax", "weigh"]


def softmax(values: Sequence[float], beta: float = 1.0) -> list[float]:
    """Probabilities proportional to exp(beta * value), the maximum subtracted first (paper Eq. 11).

    Args:
        values: At least one value.
        beta: The Boltzmann constant: 0 gives equal chances, large values the maximum.

    Raises:
        ColonysimError: One of them is NaN.
        ValueError: There are no values.
    """
    chances = array("d", values)
    if not chances:
        raise ValueError("softmax of no values")
    weigh(chances, len(chances), beta)
    return chances.tolist()


def sample(probabilities: Sequence[float], random: random.Random) -> int:
    """An index drawn with the given probabilities, by one draw from the stream."""
    return pick(array("d", probabilities), len(probabilities), random.random())


def weigh(values: array[float], count: int, beta: float) -> None:
    """`softmax` in place: replaces the first `count` values by their probabilities."""
    top, numbers = values[0], beta == beta
    for i in range(1, count):
        if (values[i] > top) if beta >= 0.0 else (values[i] < top):
            top = values[i]
    total = 0.0
    for i in range(count):  # sum() adds in another way from Python 3.12 on
        if values[i] != values[i]:
            numbers = False
            break
        values[i] = 1.0 if values[i] == top else exp(beta * (values[i] - top))
        total += values[i]
    if not numbers:
        raise ColonysimError("a choice cannot be made among values that are no numbers")
    for i in range(count):
        values[i] = values[i] / total


def pick(chances: array[float], count: int, rest: float) -> int:
    """`sample` among the first `count` probabilities; `rest` is the draw, 0 <= rest < 1."""
    last = 0
    for i in range(count):
        if chances[i] > 0.0:
            rest -= chances[i]
            if rest < 0.0:
                return i
            last = i
    return last
