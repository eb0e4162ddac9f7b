"""Random numbers for many at once, from generators that cost nothing to seed."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["Draws", "Keyed"]

ALL = 0xFFFFFFFFFFFFFFFF
STEP = 0x9E3779B97F4A7C15
FIRST, SECOND = 0xBF58476D1CE4E5B9, 0x94D049BB133111EB
UNIT = 1.0 / 9007199254740992.0
"""2 to the power of -53."""


class Draws:
    """Uniform numbers from [0, 1), a sequence of its own for each of many: SplitMix64 (Steele, Lea and Flood, 2014).

    To seed a Mersenne Twister takes longer than a step of an agent. Where more than `random()` is asked for, as
    policies may, it is still the right one (`Streams.generator`).

    Args:
        seed: 64 bits. A number's own sequence depends on nothing else.
        count: How many sequences there are.
    """

    __slots__ = ("_states",)

    def __init__(self, seed: int, count: int) -> None:
        states = array("Q", [0]) * count
        for i in range(count):
            states[i] = _mixed((seed + i * STEP) & ALL)
        self._states = states

    def __reduce__(self) -> tuple[Callable[[bytes], Draws], tuple[bytes]]:
        return _resumed, (bytes(self._states),)

    def numbers(self) -> array[int]:
        """Where each sequence has come to."""
        return array("Q", bytes(self._states))

    def resume(self, numbers: array[int]) -> None:
        """Goes on where others have come to, of which there must be as many."""
        if len(numbers) != len(self._states):
            raise ValueError(f"{len(numbers)} sequences, expected {len(self._states)}")
        self._states = array("Q", numbers)

    def draw(self, i: int) -> float:
        """The next number of sequence `i`."""
        state = self._states[i] = (self._states[i] + STEP) & ALL
        return (_mixed(state) >> 11) * UNIT

    def ahead(self, i: int) -> float:
        """The number of sequence `i` that will be drawn next."""
        return (_mixed((self._states[i] + STEP) & ALL) >> 11) * UNIT


class Keyed:
    """Uniform numbers from [0, 1) that belong to three whole numbers from 0: a sequence of their own, by SplitMix64.

    Whoever asks for those of the same three gets the same, however often, and in whichever order.
    """

    __slots__ = ("_state",)

    def __init__(self) -> None:
        self._state = 0

    def begin(self, one: int, two: int, three: int) -> None:
        """From now on `draw` returns the numbers that belong to these three, from the first one on."""
        state = _mixed((one + STEP) & ALL)
        state = _mixed((state ^ ((two + 1) * STEP)) & ALL)
        self._state = _mixed((state ^ ((three + 2) * SECOND)) & ALL)

    def draw(self) -> float:
        """The next number."""
        self._state = (self._state + STEP) & ALL
        return (_mixed(self._state) >> 11) * UNIT


def _resumed(states: bytes) -> Draws:
    """Goes on where others have come to; for copies."""
    draws = Draws(0, 0)
    draws._states = array("Q", states)
    return draws


def _mixed(z: int) -> int:
    z = ((z ^ (z >> 30)) * FIRST) & ALL
    z = ((z ^ (z >> 27)) * SECOND) & ALL
    return z ^ (z >> 31)
