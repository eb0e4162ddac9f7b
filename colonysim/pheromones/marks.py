"""What the fields of this package have in common: compiled code reads them without detours (`marks.pxd`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from array import array
    from collections.abc import Iterable, Sequence

__all__ = ["Marks", "gather_keys"]


class Marks:
    """A field that can be read; see `Field` for what the rest of one does."""

    by_box = False

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


def gather_keys(keys: Iterable[int], found: array[int], count: int, marked: bytearray) -> int:
    """Writes keys into `found`, behind the first `count`, but for those marked and those of no hole; marks them."""
    for key in keys:
        if 0 <= key < len(marked) and not marked[key]:
            marked[key], found[count] = 1, key
            count += 1
    return count
