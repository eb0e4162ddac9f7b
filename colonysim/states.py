"""States of parts: plain data that can be written, copied, and checked when it comes back.

Every part of a colony that changes has two methods. `state()` returns all that it is between two events as plain data;
`restore(state)` makes another part of the same kind the same. Plain data is None, truth values, numbers, text, bytes,
lists, tuples, mappings, and arrays of numbers (`array.array`, NumPy).

What comes back may come from a damaged or a foreign file. Compiled code does not check indices, so `restore` takes
every value by way of `Stored`, which does.
"""

from __future__ import annotations

import math
import sys
from array import array
from typing import TYPE_CHECKING, Any, TypeAlias

from colonysim.arguments import shown
from colonysim.errors import ColonysimError

if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = ["ARRAY_KINDS", "LARGEST", "MOST", "NUMPY_KINDS", "State", "Stored", "copied", "number_kind", "says"]

State: TypeAlias = "dict[str, Any]"
"""The state of a part, by names of its own."""

MOST = 2**62
"""Whole numbers in a state are smaller than this, unless a part says otherwise."""
LARGEST = 1e300
"""The same of other numbers, such as times."""
DEEPEST = 40
"""Levels within levels that plain data may have."""
ARRAY_KINDS = "bBhHiIqQfd"
"""Type codes of Python's arrays that are plain data: those of one size everywhere."""
MOST_BITS = 10_000
"""Bits of a whole number: Python does not write much larger ones as text."""
NUMPY_KINDS = "biufc"
"""Kinds of NumPy's arrays that are plain data: truth values and numbers."""


class Stored:
    """A state as it is read: each value is checked when it is taken.

    Args:
        state: What `state()` has returned, perhaps by way of a file.
        what: Whose state it is, for messages.

    Raises:
        ColonysimError: It is no state at all; every method raises it of a value that cannot be.
    """

    def __init__(self, state: Any, what: str) -> None:
        self._what = what
        if not isinstance(state, dict):
            raise self.fault("", state, "a state")
        self._state = state

    def fault(self, name: str, found: object, expected: str) -> ColonysimError:
        """The error of a value that cannot be."""
        where = f"{self._what}, {name!r}" if name else self._what
        return ColonysimError(f"{where}: {shown(found)}, expected {expected}")

    def take(self, name: str) -> Any:
        """A value that the caller checks."""
        if name not in self._state:
            raise ColonysimError(f"{self._what}: has no {name!r}")
        return self._state[name]

    def part(self, name: str) -> Stored:
        """The state of a part."""
        return Stored(self.take(name), f"{self._what}, {name!r}")

    def whole(self, name: str, least: int = 0, most: int = MOST) -> int:
        """A whole number within bounds."""
        value = self.take(name)
        if type(value) is not int or not least <= value <= most:
            raise self.fault(name, value, f"a whole number from {least} to {most}")
        return value

    def real(self, name: str, least: float = -math.inf, most: float = math.inf) -> float:
        """A number within bounds, not nan."""
        value = self.take(name)
        if type(value) not in (int, float) or not least <= value <= most:
            raise self.fault(name, value, f"a number from {least:g} to {most:g}")
        return float(value)

    def text(self, name: str, longest: int = 1000) -> str:
        """Text that can be written, of at most so many characters."""
        value = self.take(name)
        if type(value) is not str or len(value) > longest or any("\ud800" <= letter <= "\udfff" for letter in value):
            raise self.fault(name, value, f"text of at most {longest} characters")
        return value

    def flag(self, name: str) -> bool:
        """True or False."""
        value = self.take(name)
        if type(value) is not bool:
            raise self.fault(name, value, "True or False")
        return value

    def listed(self, name: str, count: int | None = None) -> list[Any]:
        """A list, of so many items."""
        value = self.take(name)
        if not isinstance(value, list) or (count is not None and len(value) != count):
            raise self.fault(name, value, "a list" if count is None else f"a list of {count}")
        return value

    def wholes(self, name: str, count: int | None = None, least: int = 0, most: int = MOST) -> list[int]:
        """A list of whole numbers within bounds."""
        values = self.listed(name, count)
        for value in values:
            if type(value) is not int or not least <= value <= most:
                raise self.fault(name, value, f"whole numbers from {least} to {most}")
        return values

    def column(
        self, name: str, kind: str, count: int | None = None, least: float = -MOST, most: float = MOST
    ) -> array[Any]:
        """An array of numbers within bounds.

        Args:
            name: Its name.
            kind: Its type code.
            count: How many numbers it must have; None for any number.
            least: The least of them.
            most: The greatest of them; an infinite bound lets infinities in, nothing lets nan in.
        """
        value = self.take(name)
        if not isinstance(value, array) or value.typecode != kind:
            raise self.fault(name, value, f"an array of type {kind!r}")
        if count is not None and len(value) != count:
            raise ColonysimError(f"{self._what}, {name!r}: holds {len(value)} numbers, expected {count}")
        # Of an array with nan neither least nor greatest mean anything; nan differs from itself.
        if value and not (least <= min(value) and max(value) <= most and (kind not in "fd" or _no_nan(value))):
            wrong = next(number for number in value if not least <= number <= most)
            raise self.fault(name, wrong, f"numbers from {least:g} to {most:g}")
        return value

    def octets(self, name: str, count: int | None = None, most: int = 255) -> bytes:
        """Small numbers, 0 to `most`, as bytes."""
        value = self.take(name)
        if not isinstance(value, bytes) or (count is not None and len(value) != count):
            raise self.fault(name, value, "bytes" if count is None else f"{count} bytes")
        if value and max(value) > most:
            raise self.fault(name, max(value), f"bytes from 0 to {most}")
        return value


def _no_nan(numbers: Iterable[float]) -> bool:
    return not any(map(math.isnan, numbers))


def says(part: object, name: str) -> bool:
    """Whether a part has a method, and none of its classes that derive from the method's own adds others.

    What a class adds to the state of the one that it derives from, the inherited method cannot know.
    """
    for kind in type(part).__mro__:
        if name in vars(kind):
            return callable(getattr(part, name, None))
        if any(callable(value) and not own.startswith("__") for own, value in vars(kind).items()):
            return False
    return callable(getattr(part, name, None))


def number_kind(value: Any) -> str:
    """The kind of an array or a number of NumPy ("f" for floats), "" of anything else."""
    numpy = sys.modules.get("numpy")
    # Not what derives from arrays: a mask, for one, would be lost.
    if numpy is None or not (type(value) is numpy.ndarray or isinstance(value, numpy.generic)):
        return ""
    return str(value.dtype.kind)


def copied(value: Any, what: str, depth: int = 0) -> Any:
    """A copy of plain data that shares nothing with it.

    Args:
        value: The data.
        what: Whose it is, for messages.
        depth: How deep within other data it lies.

    Raises:
        ColonysimError: Something in it is no plain data, or it is nested too deeply.
    """
    if value is None or type(value) in (bool, float, bytes):
        return value
    if type(value) is int and value.bit_length() <= MOST_BITS:
        return value
    if type(value) is str and not any("\ud800" <= letter <= "\udfff" for letter in value):
        return value
    if depth > DEEPEST:
        raise ColonysimError(f"{what}: is nested deeper than {DEEPEST} levels, or contains itself")
    if type(value) in (list, tuple):
        return type(value)([copied(item, what, depth + 1) for item in value])
    if type(value) is dict:
        return {copied(key, what, depth + 1): copied(item, what, depth + 1) for key, item in value.items()}
    if type(value) is array and value.typecode in ARRAY_KINDS:
        return value[:]
    if number_kind(value) and number_kind(value) in NUMPY_KINDS:
        return value.copy()
    raise ColonysimError(
        f"{what}: holds {shown(value)}, a value of type {type(value).__name__}, expected plain data: None, numbers, "
        "text, lists, tuples, mappings and arrays (docs/saving.md)"
    )
