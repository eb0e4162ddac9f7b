# cython: initializedcheck=False
"""The base class of fields in this package: values are written into typed arrays instead of `Write` objects."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

from colonysim.arguments import real
from colonysim.exact import exp
from colonysim.pheromones.field import Write
from colonysim.states import LARGEST

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.pheromones.field import Visit
    from colonysim.states import State, Stored
    from colonysim.world.state import World

__all__ = ["Fading", "Marks", "each_node", "gather_keys"]

LN2 = 0.6931471805599453
SHORTEST_HALF_LIFE, LONGEST_HALF_LIFE = 1e-6, 1e9
LEAST_LEFT = 1e-9
"""When less is left of the values of a time, they are written anew."""


class Fading:
    """Evaporation in time: what is left of a mark halves with every half-life.

    All marks of a field fade alike, so that one factor tells what is left of every value; nothing is done to a mark
    that nobody looks at, and a value does not depend on when it was looked at before.

    Args:
        world: Whose time it is.
        half_life: Simulated seconds, from a millionth on; None for marks that stay.

    Raises:
        ColonysimError: It is no such time.

    Attributes:
        on: Whether marks fade.
        half_life: As given.
        rate: How much -ln of what is left grows in a second.
        since: The simulated second of the episode whose values the field holds.
    """

    def __init__(self, world: World, half_life: float | None = None) -> None:
        if half_life is not None:
            half_life = real("half_life", half_life, SHORTEST_HALF_LIFE, LONGEST_HALF_LIFE)
        self._world, self.on, self.half_life = world, half_life is not None, half_life
        self.rate, self.since = 0.0 if half_life is None else LN2 / half_life, 0.0
        # What was left when it was last asked for: agents look at many nodes at one time.
        self._asked, self._answer = -1.0, 1.0

    def age(self) -> float:
        """-ln of what is left now."""
        return self.rate * (self._world.now - self.since)

    def left(self) -> float:
        """The share that is left now of the values that the field holds."""
        now = self._world.now
        if now != self._asked:
            self._asked, self._answer = now, exp(-self.rate * (now - self.since))
        return self._answer

    def left_at(self, second: float) -> float:
        """The share that is left of them at a second of the episode."""
        return exp(-self.rate * (second - self.since))

    def faint(self) -> bool:
        """Whether the values that the field holds should be written anew, before too few of their digits are left."""
        return self.on and self.left() < LEAST_LEFT

    def faint_at(self, second: float) -> bool:
        """Whether they should be at a second of the episode."""
        return self.on and self.left_at(second) < LEAST_LEFT

    def restart(self, second: float) -> None:
        """The field holds values of now; what comes counts from a second of the episode: now, or 0 at its end."""
        self.since, self._asked = second, -1.0

    def restore(self, state: Stored) -> None:
        """Takes the second from the state of a field."""
        self.restart(state.real("since", 0.0, LARGEST))


class Marks:
    """A field as the simulation calls it: `mark` does what `Field.deposit` does, and returns only a count.

    The values that it wrote are read by index with `place`, `key` and `value`; the other methods are those of `Field`.
    A field of this package derives from this class; any other is called through an adapter that does
    (`simulation/foreign`).
    """

    name = ""
    by_box = by_hole = False
    """Whether its values belong to boxes instead of nodes; whether there is one for each hole."""

    def __repr__(self) -> str:
        return f"<field {self.name}>"

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

    def goal_moved(self, goal: int) -> None:
        """Another node is the goal from now on; marks stay as they are, unless the field says otherwise."""

    def frame(self) -> Iterable[Write]:
        """Every value that was ever written and still counts."""
        raise NotImplementedError

    def load(self, frame: Iterable[Write]) -> None:
        """Takes over the values of another run."""
        raise NotImplementedError

    def state(self) -> State:
        """All that the field is now, as plain data."""
        raise NotImplementedError

    def restore(self, state: State) -> None:
        """Takes over the state of such a field in such a world.

        Raises:
            ColonysimError: It is none.
        """
        raise NotImplementedError

    def wipe(self, nodes: Iterable[int]) -> None:
        """Takes away all marks on some nodes, as if nobody had been there; of a field of boxes, those of boxes there.

        Raises:
            IndexError: There is no such node.
        """
        raise NotImplementedError

    def settle(self) -> None:
        """Brings marks that spread up to now, along the edges that are there; changes no value that is read now.

        Must be called before edges come or go, and before `end_episode` if they are as at first in the next episode.
        """

    def refresh(self) -> None:
        """Takes what has faded by now into the values: from now on they may fade by another half-life."""

    def _note(self, place: int, key: int, value: float) -> None:
        """Adds a value to those that this `mark` has written; every `mark` begins with `_wrote` = 0."""
        i = self._wrote
        if i == len(self._places):
            # Not in place: compiled code looks at the old arrays.
            self._places, self._keys = array("i", bytes(self._places) * 2), array("i", bytes(self._keys) * 2)
            self._values = array("d", bytes(self._values) * 2)
        self._places[i], self._keys[i], self._values[i] = place, key, value
        self._wrote = i + 1


def each_node(nodes: Iterable[int], size: int) -> list[int]:
    """Nodes as a list, of a place that has so many.

    Raises:
        IndexError: There is no such node.
    """
    found = list(nodes)
    for node in found:
        if not 0 <= node < size:
            raise IndexError(f"there is no node {node}")
    return found


def gather_keys(keys: Iterable[int], found: array[int], count: int, marked: bytearray) -> int:
    """`Marks.gather` for given keys; one that is no hole's is left out."""
    for key in keys:
        if 0 <= key < len(marked) and not marked[key]:
            marked[key], found[count] = 1, key
            count += 1
    return count
