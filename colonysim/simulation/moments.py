# cython: boundscheck=False, wraparound=False, initializedcheck=False
"""What is due when, told by bare numbers: the part of an episode's queue that needs no events of SimPy."""

from __future__ import annotations

from array import array

__all__ = ["Moments"]

FEW = 64
NEVER = float("inf")


class Moments:
    """A binary heap over flat arrays. What is due at one time comes in the order that it was given.

    Attributes:
        time: When the first is due; infinity if there is none.
    """

    __slots__ = ("_count", "_orders", "_times", "_whats", "time")

    def __init__(self) -> None:
        self._count = 0
        self._times = array("d", bytes(8 * FEW))
        self._orders, self._whats = array("d", bytes(8 * FEW)), array("q", bytes(8 * FEW))
        self.time = NEVER

    def clear(self) -> None:
        """Nothing is due any more."""
        self._count, self.time = 0, NEVER

    def put(self, time: float, order: float, what: int) -> None:
        """Something will be due.

        Args:
            time: When.
            order: Its place among what is due then.
            what: What it is, as `take` will tell.
        """
        if self._count == len(self._times):
            self._grow()
        times, orders, whats, place = self._times, self._orders, self._whats, self._count
        self._count += 1
        while place > 0:
            above = (place - 1) // 2
            if times[above] < time or (times[above] == time and orders[above] < order):
                break
            times[place], orders[place], whats[place] = times[above], orders[above], whats[above]
            place = above
        times[place], orders[place], whats[place] = time, order, what
        self.time = times[0]

    def take(self) -> int:
        """Takes out what is due first; there must be something."""
        times, orders, whats, place = self._times, self._orders, self._whats, 0
        first = whats[0]
        self._count -= 1
        count = self._count
        if count == 0:
            self.time = NEVER
            return first
        time, order = times[count], orders[count]
        below = 1
        while below < count:
            if below + 1 < count and (
                times[below + 1] < times[below]
                or (times[below + 1] == times[below] and orders[below + 1] < orders[below])
            ):
                below += 1
            if time < times[below] or (time == times[below] and order < orders[below]):
                break
            times[place], orders[place], whats[place] = times[below], orders[below], whats[below]
            place = below
            below = 2 * place + 1
        times[place], orders[place], whats[place] = time, order, whats[count]
        self.time = times[0]
        return first

    def _grow(self) -> None:
        # Not in place: compiled code looks at the old arrays.
        self._times = array("d", bytes(self._times) * 2)
        self._orders, self._whats = array("d", bytes(self._orders) * 2), array("q", bytes(self._whats) * 2)
