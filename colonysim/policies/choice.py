"""Choosing by chance: softmax and sampling that give the same bits on every machine."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.exact import exp

if TYPE_CHECKING:
    import random
    from collections.abc import Sequence

__all__ = ["sample", "softmax"]


def softmax(values: Sequence[float], beta: float = 1.0) -> list[float]:
    """Probabilities proportional to exp(beta * value), the maximum subtracted first (paper Eq. 11).

    Args:
        values: At least one value.
        beta: The Boltzmann constant: 0 gives equal chances, large values the maximum.
    """
    top = max(values) if beta >= 0.0 else min(values)
    weights = [1.0 if value == top else exp(beta * (value - top)) for value in values]
    total = 0.0
    for weight in weights:  # sum() adds in another way from Python 3.12 on
        total += weight
    return [weight / total for weight in weights]


def sample(probabilities: Sequence[float], random: random.Random) -> int:
    """The index of one of the probabilities, drawn with one number of the stream."""
    rest = random.random()
    last = 0
    for i, probability in enumerate(probabilities):
        if probability > 0.0:
            rest -= probability
            if rest < 0.0:
                return i
            last = i
    return last
