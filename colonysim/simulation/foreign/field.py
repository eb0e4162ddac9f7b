"""The adapter that checks the answers of third parties' fields."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from colonysim.errors import PASSED_ON
from colonysim.pheromones.field import Visit, Write
from colonysim.pheromones.marks import Marks, each_node
from colonysim.simulation.foreign.answers import SHOWN, Foreign, real, truth, whole

if TYPE_CHECKING:
    from colonysim.pheromones.field import Field
    from colonysim.states import State
    from colonysim.trace.rows import Rows
    from colonysim.world.state import World

__all__ = ["ForeignField"]


class ForeignField(Foreign, Marks):
    """A third party's field; each deposit is one call, and each answer is checked against the protocol."""

    def __init__(self, field: Field, world: World, rows: Rows) -> None:
        super().__init__(field, "field", world, rows)
        by_box = truth(field.by_box)
        if by_box is None:
            raise self._fault(f"by_box is {SHOWN.repr(field.by_box)}, expected True or False")
        self.by_box = by_box
        self._written: list[Write] = []
        self._visit = Visit()

    def at(self, node: int, key: int = -1) -> float:
        """A finite number."""
        value = self._call("at", node, key)
        number = real(value)
        if number is None:
            raise self._fault(f"at({node}, {key}) returns {SHOWN.repr(value)}, expected a finite number")
        return number

    def keys(self, node: int) -> Sequence[int]:
        """Whole numbers; those that are no hole are nobody's."""
        found = [whole(key) for key in self._listed("keys", self._call("keys", node))]
        if None in found:
            raise self._fault(f"keys({node}) returns {SHOWN.repr(found)}, expected whole numbers")
        return [key for key in found if key is not None and -1 <= key < self._holes]

    def mark(self, visit: Visit) -> int:
        """Finite values at what exists."""
        told = self._visit  # one of its own: what it changes there no other field shall read
        told.moment, told.agent, told.node, told.level = visit.moment, visit.agent, visit.node, visit.level
        told.box, told.hole, told.left, told.before = visit.box, visit.hole, visit.left, visit.before
        told.mark = visit.mark
        try:
            given = self._part.deposit(told)
        except PASSED_ON:
            raise
        except BaseException as error:
            raise self._raised("deposit", error, visit.agent) from error
        empty = type(given) is tuple and not given
        self._written = [] if empty else self._writes("deposit", self.by_box, visit.agent, given)
        return len(self._written)

    def place(self, i: int) -> int:
        """Of what the last `mark` wrote."""
        return self._written[i].node

    def key(self, i: int) -> int:
        """Of what the last `mark` wrote."""
        return self._written[i].key

    def value(self, i: int) -> float:
        """Of what the last `mark` wrote."""
        return self._written[i].value

    def end_episode(self) -> None:
        """It may raise."""
        self._call("end_episode")

    def frame(self) -> Iterable[Write]:
        """Finite values at what exists."""
        return self._writes("frame", self.by_box, None, self._call("frame"))

    def state(self) -> State:
        """What the field says, if it can say it."""
        self.check_savable()
        state: State = self._copied("state", self._call("state"))
        return state

    def restore(self, state: State) -> None:
        """It may raise."""
        self.check_savable()
        self._call("restore", state)

    def load(self, frame: Iterable[Write]) -> None:
        """It may raise."""
        self._call("load", frame)

    def wipe(self, nodes: Iterable[int]) -> None:
        """It may raise, or not be there.

        Raises:
            PluginError: The field has no such method.
        """
        if getattr(self._part, "wipe", None) is None:
            raise self._fault("marks are to be wiped, but it has no method wipe(nodes); see docs/extending.md")
        self._call("wipe", each_node(nodes, self._nodes))

    def settle(self) -> None:
        """It may raise, or not be there."""
        if getattr(self._part, "settle", None) is not None:
            self._call("settle")
