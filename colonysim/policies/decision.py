"""What an agent has decided, as the simulation reads it, and what a stigmergic agent remembers."""

from __future__ import annotations

from array import array
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from colonysim.policies.policy import Choice
from colonysim.world.intents import Push, Travel, Wait

if TYPE_CHECKING:
    import random
    from collections.abc import Mapping

    from colonysim.pheromones.field import Field
    from colonysim.policies.paths import Way
    from colonysim.policies.view import LocalView
    from colonysim.world.intents import Intent
    from colonysim.world.state import World

__all__ = ["Decider", "Decision", "Memory", "Options", "new_decision", "new_memory"]


@dataclass(unsafe_hash=True)
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
        vain: How often it has had no box to go for, though one was in sight, since it last filled a hole.
    """

    epsilon: float
    box: int = -1
    hole: int = -1
    way: Way = ()
    sought: int = -1
    shunned: int = -1
    shunned_at: int = -1
    vain: int = 0


def new_memory(
    epsilon: float, box: int, hole: int, way: Way, sought: int, shunned: int, shunned_at: int, vain: int
) -> Memory:
    """`Memory(...)`, which compiled code cannot call without making objects of all numbers."""
    memory = Memory.__new__(Memory)
    memory.epsilon, memory.box, memory.hole, memory.way = epsilon, box, hole, way
    memory.sought, memory.shunned, memory.shunned_at, memory.vain = sought, shunned, shunned_at, vain
    return memory


class Options:
    """What a choice is between; a policy has one, which is good until its next decision.

    Args:
        room: How many there can be.

    Attributes:
        nodes: The nodes to go to.
        boxes: For each of them the box meant, or -1.
        chances: For each of them first what speaks for it, then its chance.
    """

    __slots__ = ("boxes", "chances", "nodes")

    def __init__(self, room: int) -> None:
        self.nodes, self.boxes = array("i", [0]) * room, array("i", [0]) * room
        self.chances = array("d", [0.0]) * room


class Decision:
    """What an agent has decided, as the simulation reads it; `intent` says it in the words of the protocol.

    Args:
        memory: What the agent will remember.

    Attributes:
        memory: The same.
        idle: Whether it waits for whatever could give it something to do by changing.
        wait: Another wait that it has decided on, or None.
        node: Where it wants to go otherwise.
        box: The box it wants to take or push there, or -1.
        hole: The hole (key) which that box is meant for, or -1.
        explored: Whether it followed E.
        count: How many nodes it chose between; 0 if there was no choice.
        options: These nodes, from the first on.
        choice: What another's policy has returned, or None.
    """

    __slots__ = ("box", "choice", "count", "explored", "hole", "idle", "memory", "node", "options", "wait")

    def __init__(self, memory: Any) -> None:
        self.memory = memory
        self.wait: Wait | None = None
        self.node = self.box = self.hole = -1
        self.explored = self.idle = False
        self.count = 0
        self.options: Options | None = None
        self.choice: Choice | None = None

    def intent(self, view: LocalView) -> Intent:
        """The decision as an intent, given what the agent sees."""
        if self.choice is not None:
            return self.choice.intent
        if self.node < 0:
            return self.waits(view)
        return Travel(self.node) if self.box < 0 else Push(self.box, self.node, self.hole)

    def waits(self, view: LocalView) -> Wait:
        """The wait that was decided on."""
        return self.wait if self.wait is not None else Wait(view.around())

    def as_choice(self, view: LocalView) -> Choice:
        """The decision with what it was taken from."""
        if self.choice is not None:
            return self.choice
        options = self.options
        if options is None:
            return Choice(self.intent(view), self.memory, self.explored)
        nodes, boxes = tuple(options.nodes[: self.count]), tuple(options.boxes[: self.count])
        chances = tuple(options.chances[: self.count])
        return Choice(self.intent(view), self.memory, self.explored, nodes, boxes, chances)


def new_decision(memory: Any) -> Decision:
    """`Decision(memory)`, a little faster where it is compiled."""
    decision = Decision.__new__(Decision)
    decision.memory, decision.count = memory, 0
    decision.explored = decision.idle = False
    decision.wait = decision.options = decision.choice = None
    decision.node = decision.box = decision.hole = -1
    return decision


class Decider:
    """A policy as the simulation calls it: `think` is `Policy.decide` without objects for numbers.

    A policy of this package may derive from this class; one that does not is called through an adapter that does
    (`simulation/foreign`).
    """

    name = ""

    def fields(self, world: World) -> Mapping[str, Field]:
        """See `Policy.fields`."""
        raise NotImplementedError

    def begin(self, agent: int, memory: Any) -> Any:
        """See `Policy.begin`."""
        raise NotImplementedError

    def think(self, view: LocalView, memory: Any, random: random.Random) -> Decision:
        """What the agent does next; see `Policy.decide`."""
        raise NotImplementedError

    def decide(self, view: LocalView, memory: Any, random: random.Random) -> Choice:
        """`think`, in the words of the protocol."""
        return self.think(view, memory, random).as_choice(view)
