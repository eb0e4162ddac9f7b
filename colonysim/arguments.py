"""Counts, seeds and other numbers that a caller hands over: checked by name, and made Python's own.

Whole numbers of NumPy and of anything else with `__index__` are welcome; true and false, text, None and numbers with
a point are no counts, even where they would be equal to one.
"""

from __future__ import annotations

import math
import operator
from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["MAX_COUNT", "MAX_SEED", "as_seed", "as_span", "plain", "real", "shown", "whole", "wholes"]

MAX_COUNT = 10**9
"""Largest count of anything; a scenario's counts end there too."""
MAX_SEED = 10**18 - 1
"""Largest seed: numbers in files have at most 18 digits."""
_LONGEST = 60


def whole(name: str, value: Any, least: int = 1, most: int = MAX_COUNT) -> int:
    """A whole number within bounds.

    Args:
        name: The argument's name, for the message.
        value: What was handed over.
        least: Smallest number that is accepted.
        most: Largest number that is accepted.

    Raises:
        ColonysimError: It is none.

    Example:
        >>> whole("episodes", 3)
        3
    """
    try:
        number = None if isinstance(value, bool) else operator.index(value)
    except TypeError:
        number = None
    if number is None or not least <= number <= most:
        raise ColonysimError(f"{name}: {shown(value)}, expected a whole number from {least} to {most}")
    return number


def as_seed(value: Any, name: str = "seed") -> int:
    """A seed: a whole number from 0 to `MAX_SEED`.

    Raises:
        ColonysimError: It is none.
    """
    return whole(name, value, 0, MAX_SEED)


def wholes(name: str, values: Any, least: int = 1) -> tuple[int, ...]:
    """Some whole numbers, such as those of episodes; at least one.

    Raises:
        ColonysimError: There is none, or one of them is no whole number of at least `least`.
    """
    try:
        items: Iterable[Any] = iter(values)
        numbers = tuple(whole(name, value, least) for value in items)
    except TypeError:
        raise ColonysimError(f"{name}: {shown(values)}, expected a list of whole numbers") from None
    if not numbers:
        raise ColonysimError(f"{name}: expected at least one")
    return numbers


def as_span(name: str, values: Any) -> tuple[int, int]:
    """First and last of something that is counted from 1.

    Raises:
        ColonysimError: These are not two whole numbers, the first at most the last.
    """
    numbers = wholes(name, values)
    if len(numbers) != 2 or numbers[0] > numbers[1]:
        raise ColonysimError(f"{name}: {'-'.join(map(str, numbers))}, expected the first and the last, such as 11-20")
    return numbers[0], numbers[1]


def real(name: str, value: Any, least: float, most: float) -> float:
    """A finite number within bounds.

    Raises:
        ColonysimError: It is none.
    """
    value = plain(value)
    number = math.nan
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
    if not least <= number <= most:
        raise ColonysimError(f"{name}: {shown(value)}, expected a number from {least:g} to {most:g}")
    return number


def plain(value: Any) -> Any:
    """The numbers, texts and lists of Python in place of a scalar or an array of NumPy; anything else as it is.

    Dates and spans of time are no numbers, though NumPy makes whole ones of some of them.
    """
    kind = getattr(getattr(value, "dtype", None), "kind", "M")
    return value.tolist() if hasattr(value, "tolist") and kind not in "mM" else value


def shown(value: Any) -> str:
    """A value as a message names it: what it would look like in a program, and not too long."""
    try:
        text = repr(value)
    except Exception:  # whole numbers of thousands of digits, and whatever else cannot be written
        text = f"a value of type {type(value).__name__}"
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."
