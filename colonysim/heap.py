# cython: boundscheck=False, wraparound=False, initializedcheck=False
"""A binary heap of bare numbers over flat arrays: what `heapq` does with tuples, without making any."""

from __future__ import annotations

from array import array

__all__ = ["Heap"]

FEW = 64
LAST = float("inf")


class Heap:
    """Items in the order of their keys, those of one key in the order of their ties.

    Attributes:
        count: How many items there are.
        key: The first one's key; infinity if there is none.
        tie: The first one's tie.
    """

    __slots__ = ("_items", "_keys", "_ties", "count", "key", "tie")

    def __init__(self) -> None:
        self.count = 0
        self._keys = array("d", bytes(8 * FEW))
        self._ties, self._items = array("q", bytes(8 * FEW)), array("q", bytes(8 * FEW))
        self.key, self.tie = LAST, -1

    def clear(self) -> None:
        """Takes all out."""
        self.count, self.key, self.tie = 0, LAST, -1

    def put(self, key: float, tie: int, item: int) -> None:
        """Puts an item in.

        Args:
            key: The smaller, the sooner it comes.
            tie: The smaller, the sooner it comes among those of its key.
            item: What `take` will return.
        """
        if self.count == len(self._keys):
            self._grow()
        keys, ties, items, place = self._keys, self._ties, self._items, self.count
        self.count += 1
        while place > 0:
            above = (place - 1) // 2
            if keys[above] < key or (keys[above] == key and ties[above] < tie):
                break
            keys[place], ties[place], items[place] = keys[above], ties[above], items[above]
            place = above
        keys[place], ties[place], items[place] = key, tie, item
        self.key, self.tie = keys[0], ties[0]

    def take(self) -> int:
        """Takes out the first item; there must be one."""
        keys, ties, items, place = self._keys, self._ties, self._items, 0
        first = items[0]
        self.count -= 1
        count = self.count
        if count == 0:
            self.key, self.tie = LAST, -1
            return first
        key, tie = keys[count], ties[count]
        below = 1
        while below < count:
            if below + 1 < count and (
                keys[below + 1] < keys[below] or (keys[below + 1] == keys[below] and ties[below + 1] < ties[below])
            ):
                below += 1
            if key < keys[below] or (key == keys[below] and tie < ties[below]):
                break
            keys[place], ties[place], items[place] = keys[below], ties[below], items[below]
            place = below
            below = 2 * place + 1
        keys[place], ties[place], items[place] = key, tie, items[count]
        self.key, self.tie = keys[0], ties[0]
        return first

    def _grow(self) -> None:
        # Not in place: compiled code looks at the old arrays.
        self._keys = array("d", bytes(self._keys) * 2)
        self._ties, self._items = array("q", bytes(self._ties) * 2), array("q", bytes(self._items) * 2)
