"""What a stigmergic agent remembers, and what it has made up its mind to do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from colonysim.policies.policy import Choice
from colonysim.world.intents import Push, Travel

if TYPE_CHECKING:
    from array import array

    from colonysim.policies.paths import Way
    from colonysim.world.intents import Intent, Wait

__all__ = ["Memory", "Thought", "remembering", "thinking"]


@dataclass
class Memory:
    """What an agent remembers from one decision to the next; not to be changed.

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


def remembering(
    epsilon: float, box: int, hole: int, way: Way, sought: int, shunned: int, shunned_at: int
) -> Memory:
    """`Memory(...)`, which compiled code cannot call without making objects of all numbers."""
    memory = Memory.__new__(Memory)
    memory.epsilon, memory.box, memory.hole, memory.way = epsilon, box, hole, way
    memory.sought, memory.shunned, memory.shunned_at = sought, shunned, shunned_at
    return memory


class Thought:
    """A decision before it is put into words: `choice` says it as other policies do.

    Args:
        memory: What the agent will remember.

    Attributes:
        memory: The same.
        wait: The wait that it has decided on, or None.
        node: Where it wants to go otherwise.
        box: The box it wants to take or push there, or -1.
        hole: The hole (key) which that box is meant for, or -1.
        explored: Whether it followed E.
        count: How many nodes it chose between; 0 if there was no choice. What follows is the policy's own and good
            until its next decision.
        nodes: The nodes, from the first on.
        boxes: For each of them the box meant, or -1.
        chances: For each of them its chance.
    """

    __slots__ = ("box", "boxes", "chances", "count", "explored", "hole", "memory", "node", "nodes", "wait")

    nodes: array[int]
    boxes: array[int]
    chances: array[float]

    def __init__(self, memory: Memory) -> None:
        self.memory = memory
        self.wait: Wait | None = None
        self.node = self.box = self.hole = -1
        self.explored = False
        self.count = 0

    def intent(self) -> Intent:
        """The decision as an intent."""
        if self.wait is not None:
            return self.wait
        return Travel(self.node) if self.box < 0 else Push(self.box, self.node, self.hole)

    def choice(self) -> Choice:
        """The decision with what it was taken from."""
        if self.count == 0:
            return Choice(self.intent(), self.memory, self.explored)
        nodes, boxes = tuple(self.nodes[: self.count]), tuple(self.boxes[: self.count])
        chances = tuple(self.chances[: self.count])
        return Choice(self.intent(), self.memory, self.explored, nodes, boxes, chances)


def thinking(memory: Memory) -> Thought:
    """`Thought(memory)`, a little faster where it is compiled."""
    thought = Thought.__new__(Thought)
    thought.memory, thought.wait, thought.explored, thought.count = memory, None, False, 0
    thought.node = thought.box = thought.hole = -1
    return thought
