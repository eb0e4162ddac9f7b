# cython: boundscheck=False, wraparound=False, initializedcheck=False
"""What is due when, told by bare numbers: the part of an episode's queue that needs no events of SimPy."""

from __future__ import annotations

from array import array

__all__ = ["Moments"]

FEW = 64
NEVER = float("inf")


class Moments:
    """A binary heap over flat arrays. What is due at one time comes in the order of its numbers.

    Attributes:
        time: When the first is due; infinity if there is none.
        number: Its number.
    """

    __slots__ = ("_count", "_numbers", "_times", "_whats", "number", "time")

    def __init__(self) -> None:
        self._count = 0
        self._times = array("d", bytes(8 * FEW))
        self._numbers, self._whats = array("q", bytes(8 * FEW)), array("q", bytes(8 * FEW))
        self.time, self.number = NEVER, -1

    def clear(self) -> None:
        """Nothing is due any more."""
        self._count, self.time, self.number = 0, NEVER, -1

    def put(self, time: float, number: int, what: int) -> None:
        """Something will be due.

        Args:
            time: When.
            number: Its place among what is due then; no two have the same.
            what: What it is, as `take` will tell.
        """
        if self._count == len(self._times):
            self._grow()
        times, numbers, whats, place = self._times, self._numbers, self._whats, self._count
        self._count += 1
        while place > 0:
            above = (place - 1) // 2
            if times[above] < time or (times[above] == time and numbers[above] < number):
                break
            times[place], numbers[place], whats[place] = times[above], numbers[above], whats[above]
            place = above
        times[place], numbers[place], whats[place] = time, number, what
        self.time, self.number = times[0], numbers[0]

    def take(self) -> int:
        """Takes out what is due first; there must be something."""
        times, numbers, whats, place = self._times, self._numbers, self._whats, 0
        first = whats[0]
        self._count -= 1
        count = self._count
        if count == 0:
            self.time, self.number = NEVER, -1
            return first
        time, number = times[count], numbers[count]
        below = 1
        while below < count:
            if below + 1 < count and (
                times[below + 1] < times[below]
                or (times[below + 1] == times[below] and numbers[below + 1] < numbers[below])
            ):
                below += 1
            if time < times[below] or (time == times[below] and number < numbers[below]):
                break
            times[place], numbers[place], whats[place] = times[below], numbers[below], whats[below]
            place = below
            below = 2 * place + 1
        times[place], numbers[place], whats[place] = time, number, whats[count]
        self.time, self.number = times[0], numbers[0]
        return first

    def _grow(self) -> None:
        # Not in place: compiled code looks at the old arrays.
        self._times = array("d", bytes(self._times) * 2)
        self._numbers, self._whats = array("q", bytes(self._numbers) * 2), array("q", bytes(self._whats) * 2)
