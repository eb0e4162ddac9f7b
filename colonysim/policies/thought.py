"""What a stigmergic agent remembers, and what it has made up its mind to do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from colonysim.policies.policy import Choice
from colonysim.world.intents import Push, Travel

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.policies.paths import Way
    from colonysim.world.intents import Intent, Wait

__all__ = ["Memory", "Thought"]


@dataclass(frozen=True, slots=True)
class Memory:
    """What an agent remembers from one decision to the next.

    Attributes:
        epsilon: Its chance to explore.
        box: The box it is committed to, or -1.
        hole: The hole (key) which that box is meant for, or -1.
        way: The box's way as last planned, with the hole in sight.
        sought: A box it is on its way to, or -1; `hole` and `way` are then those meant for it.
        shunned: A box it has just dropped, or -1; it will not take it again before it has moved.
        shunned_at: The node at which it dropped that box.
    """

    epsilon: float
    box: int = -1
    hole: int = -1
    way: Way = ()
    sought: int = -1
    shunned: int = -1
    shunned_at: int = -1


class Thought:
    """A decision before it is put into words: `choice` says it as other policies do.

    Attributes:
        memory: What the agent will remember.
        wait: The wait that it has decided on, or None.
        node: Where it wants to go otherwise.
        box: The box it wants to take or push there, or -1.
        hole: The hole (key) which that box is meant for, or -1.
        explored: Whether it followed E.
        nodes: What it chose between; empty if there was no choice.
        boxes: For each of them the box meant, or -1.
        chances: For each of them its chance.
    """

    __slots__ = ("box", "boxes", "chances", "explored", "hole", "memory", "node", "nodes", "wait")

    def __init__(self, memory: Memory) -> None:
        self.memory = memory
        self.wait: Wait | None = None
        self.node = self.box = self.hole = -1
        self.explored = False
        self.nodes: Sequence[int] = ()
        self.boxes: Sequence[int] = ()
        self.chances: Sequence[float] = ()

    def intent(self) -> Intent:
        """The decision as an intent."""
        if self.wait is not None:
            return self.wait
        return Travel(self.node) if self.box < 0 else Push(self.box, self.node, self.hole)

    def choice(self) -> Choice:
        """The decision with what it was taken from."""
        nodes, boxes, chances = tuple(self.nodes), tuple(self.boxes), tuple(self.chances)
        return Choice(self.intent(), self.memory, self.explored, nodes, boxes, chances)
