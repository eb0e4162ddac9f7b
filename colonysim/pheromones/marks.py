# cython: initializedcheck=False
"""What the fields of this package have in common: the simulation calls them without making objects of numbers."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

from colonysim.pheromones.field import Write

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.pheromones.field import Visit

__all__ = ["Marks", "gather_keys"]


class Marks:
    """A field as the simulation calls it: `mark` is `Field.deposit`; `place`, `key`, `value` tell what it wrote.

    See `Field` for what the rest of a field does. A field of this package derives from this class; one that does not
    is called through an adapter that does (`simulation/foreign`).
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
        """Writes `keys` into `found`, behind the first `count`, but for those marked; marks them.

        Returns how many there are now.
        """
        return gather_keys(self.keys(node), found, count, marked)

    def mark(self, visit: Visit) -> int:
        """Lets an agent leave its marks; returns how many values that wrote."""
        raise NotImplementedError

    def deposit(self, visit: Visit) -> Sequence[Write]:
        """`mark`, with what it wrote as objects."""
        return tuple([Write(self.place(i), self.key(i), self.value(i)) for i in range(self.mark(visit))])

    def place(self, i: int) -> int:
        """The node, or the box, of the i-th value that the last `mark` wrote."""
        return self._places[i]

    def key(self, i: int) -> int:
        """Its key, or -1."""
        return self._keys[i]

    def value(self, i: int) -> float:
        """The value itself."""
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
        """Adds a value to those that this `mark` has written; each begins with `_wrote` at 0."""
        i = self._wrote
        if i == len(self._places):
            # Not in place: compiled code looks at the old arrays.
            self._places, self._keys = array("i", bytes(self._places) * 2), array("i", bytes(self._keys) * 2)
            self._values = array("d", bytes(self._values) * 2)
        self._places[i], self._keys[i], self._values[i] = place, key, value
        self._wrote = i + 1


def gather_keys(keys: Iterable[int], found: array[int], count: int, marked: bytearray) -> int:
    """Writes keys into `found`, behind the first `count`, but for those marked and those of no hole; marks them."""
    for key in keys:
        if 0 <= key < len(marked) and not marked[key]:
            marked[key], found[count] = 1, key
            count += 1
    return count
