# cython: initializedcheck=False
"""The base class of fields in this package: values are written into typed arrays instead of `Write` objects."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

from colonysim.pheromones.field import Write

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.pheromones.field import Visit

__all__ = ["Marks", "gather_keys"]


class Marks:
    """A field as the simulation calls it: `mark` does what `Field.deposit` does, and returns only a count.

    The values that it wrote are read by index with `place`, `key` and `value`; the other methods are those of `Field`.
    A field of this package derives from this class; any other is called through an adapter that does
    (`simulation/foreign`).
    """

    name = ""
    by_box = False

    def __init__(self) -> None:
        self._wrote = 0
        self._places, self._keys, self._values = array("i", [0]), array("i", [0]), array("d", [0.0])

    def at(self, node: int, key: int = -1) -> float:
        """The value at a node, or of a box."""
        raise NotImplementedError

    def keys(self, node: int) -> Sequence[int]:
        """The keys that have a value at a node, ascending; empty for a field without keys."""
        raise NotImplementedError

    def gather(self, node: int, found: array[int], count: int, marked: bytearray) -> int:
        """Writes the keys at a node that are not marked into `found` and marks them.

        Args:
            node: The node.
            found: Has room for all keys; its first `count` are taken.
            count: How many keys stand in `found` already.
            marked: For each key 1 if it is to be left out.

        Returns:
            How many keys stand in `found` then.
        """
        return gather_keys(self.keys(node), found, count, marked)

    def mark(self, visit: Visit) -> int:
        """Lets an agent leave its marks; returns the number of values written."""
        raise NotImplementedError

    def deposit(self, visit: Visit) -> Sequence[Write]:
        """`mark`, returning the values that it wrote."""
        return tuple([Write(self.place(i), self.key(i), self.value(i)) for i in range(self.mark(visit))])

    def place(self, i: int) -> int:
        """The node, or the box, of the i-th value that the last `mark` wrote."""
        return self._places[i]

    def key(self, i: int) -> int:
        """The key of that value (a hole), or -1."""
        return self._keys[i]

    def value(self, i: int) -> float:
        """The i-th value that the last `mark` wrote."""
        return self._values[i]

    def end_episode(self) -> None:
        """What the end of an episode does to every value."""
        raise NotImplementedError

    def frame(self) -> Iterable[Write]:
        """Every value that was ever written and still counts."""
        raise NotImplementedError

    def load(self, frame: Iterable[Write]) -> None:
        """Takes over the values of another run."""
        raise NotImplementedError

    def _note(self, place: int, key: int, value: float) -> None:
        """Adds a value to those that this `mark` has written; every `mark` begins with `_wrote` = 0."""
        i = self._wrote
        if i == len(self._places):
            # Not in place: compiled code looks at the old arrays.
            self._places, self._keys = array("i", bytes(self._places) * 2), array("i", bytes(self._keys) * 2)
            self._values = array("d", bytes(self._values) * 2)
        self._places[i], self._keys[i], self._values[i] = place, key, value
        self._wrote = i + 1


def gather_keys(keys: Iterable[int], found: array[int], count: int, marked: bytearray) -> int:
    """`Marks.gather` for given keys; one that is no hole's is left out."""
    for key in keys:
        if 0 <= key < len(marked) and not marked[key]:
            marked[key], found[count] = 1, key
            count += 1
    return count
