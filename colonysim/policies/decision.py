"""Decisions as the simulation reads them, the memory of stigmergic agents, and the base class of own policies."""

from __future__ import annotations

from array import array
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from colonysim.policies.policy import Choice
from colonysim.states import Stored
from colonysim.world.intents import Push, Travel, Wait

if TYPE_CHECKING:
    import random
    from collections.abc import Mapping

    from colonysim.pheromones.field import Field
    from colonysim.policies.paths import Way
    from colonysim.policies.view import LocalView
    from colonysim.world.intents import Intent
    from colonysim.world.state import World

__all__ = [
    "Decider", "Decision", "Memory", "Options", "Stream", "decision_of", "decision_state", "new_decision", "new_memory",
]  # fmt: skip


@dataclass(unsafe_hash=True)
class Memory:
    """What a stigmergic agent remembers from one decision to the next; never changed, but replaced.

    Attributes:
        epsilon: Its chance to explore, 0 to 1.
        box: The box it is committed to, or -1.
        hole: The hole (key) which that box is meant for, or -1.
        way: The nodes of the box's way to the hole, as last planned while the hole was visible.
        sought: A box that it is going to take, or -1; `hole` and `way` are then those meant for it.
        shunned: A box that it has just dropped, or -1; it will not take it again before it has moved.
        shunned_at: The node at which it dropped that box.
        vain: Weighted count of decisions since it last filled a hole in which a box was visible but none was of use.
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
    """`Memory(...)`; compiled code calls this without making a Python object of each argument."""
    memory = Memory.__new__(Memory)
    memory.epsilon, memory.box, memory.hole, memory.way = epsilon, box, hole, way
    memory.sought, memory.shunned, memory.shunned_at, memory.vain = sought, shunned, shunned_at, vain
    return memory


class Options:
    """The options that a decision was drawn from; a policy reuses one object for all its decisions.

    Args:
        room: The largest number of options.

    Attributes:
        nodes: The nodes to go to.
        boxes: For each of them the box meant, or -1.
        chances: For each of them first its value, then, by `weigh`, its chance, 0 to 1.
    """

    __slots__ = ("boxes", "chances", "nodes")

    def __init__(self, room: int) -> None:
        self.nodes, self.boxes = array("i", [0]) * room, array("i", [0]) * room
        self.chances = array("d", [0.0]) * room


class Decision:
    """What an agent has decided, as plain numbers for the simulation; `as_choice` makes a `Choice` of it.

    Args:
        memory: What the agent will remember.

    Attributes:
        memory: What the agent will remember.
        idle: Whether it waits until anything around it changes that could give it something to do.
        wait: The wait that it has decided on instead, or None.
        node: The neighbour where it wants to go or push a box to, or -1 if it waits.
        box: The box it wants to take or push there, or -1.
        hole: The hole (key) which that box is meant for, or -1.
        explored: Whether it followed E.
        count: The number of options; 0 if there was no choice.
        options: The options; the first `count` are valid, until the policy's next decision.
        choice: What a policy of a third party has returned, or None.
        mark: What it wants to leave, see `Choice`.
    """

    __slots__ = ("box", "choice", "count", "explored", "hole", "idle", "mark", "memory", "node", "options", "wait")

    def __init__(self, memory: Any) -> None:
        self.memory = memory
        self.wait: Wait | None = None
        self.node = self.box = self.hole = -1
        self.explored = self.idle = False
        self.count, self.mark = 0, 0.0
        self.options: Options | None = None
        self.choice: Choice | None = None

    def intent(self, view: LocalView) -> Intent:
        """The decision as an intent."""
        if self.choice is not None:
            return self.choice.intent
        if self.node < 0:
            return self.waits(view)
        return Travel(self.node) if self.box < 0 else Push(self.box, self.node, self.hole)

    def waits(self, view: LocalView) -> Wait:
        """The wait that was decided on."""
        return self.wait if self.wait is not None else Wait(view.around())

    def as_choice(self, view: LocalView) -> Choice:
        """The decision as a `Choice`: intent, memory and options."""
        if self.choice is not None:
            return self.choice
        options = self.options
        if options is None:
            return Choice(self.intent(view), self.memory, self.explored)
        nodes, boxes = tuple(options.nodes[: self.count]), tuple(options.boxes[: self.count])
        chances = tuple(options.chances[: self.count])
        return Choice(self.intent(view), self.memory, self.explored, nodes, boxes, chances)


def new_decision(memory: Any) -> Decision:
    """`Decision(memory)`, a little faster when compiled."""
    decision = Decision.__new__(Decision)
    decision.memory, decision.count, decision.mark = memory, 0, 0.0
    decision.explored = decision.idle = False
    decision.wait = decision.options = decision.choice = None
    decision.node = decision.box = decision.hole = -1
    return decision


def decision_state(decision: Decision) -> dict[str, Any]:
    """What a decision comes to as plain data; what is remembered and what it was chosen from is not in it."""
    wait = decision.wait
    return {
        "node": decision.node, "box": decision.box, "hole": decision.hole, "idle": decision.idle,
        "mark": decision.mark,
        "wait": None if wait is None else {"nodes": list(wait.nodes), "seconds": wait.seconds, "clear": wait.clear},
    }  # fmt: skip


def decision_of(state: Any, world: World, what: str) -> Decision | None:
    """The decision of `decision_state`; None of None.

    Raises:
        ColonysimError: It is none, or names what does not exist.
    """
    if state is None:
        return None
    told, nodes = Stored(state, what), len(world.topology)
    decision = new_decision(None)
    decision.node, decision.box = told.whole("node", -1, nodes - 1), told.whole("box", -1, len(world.box_node) - 1)
    decision.hole, decision.idle = told.whole("hole", -1, len(world.scenario.holes) - 1), told.flag("idle")
    decision.mark = told.real("mark", 0.0, 1.0)
    if told.take("wait") is not None:
        wait = told.part("wait")
        seconds = None if wait.take("seconds") is None else wait.real("seconds", 0.0)
        causes = tuple(wait.wholes("nodes", None, 0, nodes - 1))
        decision.wait = Wait(causes, seconds, wait.whole("clear", -1, nodes - 1))
    if decision.node < 0 and decision.wait is None and not decision.idle:
        raise told.fault("node", decision.node, "a move or a wait")
    return decision


class Stream:
    """An agent's random stream; to look up `random` for each decision takes longer than to draw a number.

    Args:
        generator: What `Policy.decide` is given.

    Attributes:
        generator: The same.
        draw: Returns the next number, 0 <= draw() < 1.
    """

    __slots__ = ("draw", "generator")

    def __init__(self, generator: random.Random) -> None:
        self.generator, self.draw = generator, generator.random


class Decider:
    """A policy as the simulation calls it: `think` returns the raw decision, and `decide` wraps it in a `Choice`.

    A policy of this package may derive from this class; any other is called through an adapter that does
    (`simulation/foreign`).

    Attributes:
        name: As results and traces call it.
        outside: Whether its decisions come from outside: the simulation asks for them and does not call `think`.
    """

    name = ""
    outside = False

    def __repr__(self) -> str:
        return f"<policy {self.name}>"

    def fields(self, world: World) -> Mapping[str, Field]:
        """See `Policy.fields`."""
        raise NotImplementedError

    def begin(self, agent: int, memory: Any) -> Any:
        """See `Policy.begin`."""
        raise NotImplementedError

    def state(self, agent: int, memory: Any) -> Any:
        """The memory of an agent as plain data."""
        raise NotImplementedError

    def restore(self, agent: int, state: Any) -> Any:
        """The memory of an agent from plain data; only after `fields`.

        Raises:
            ColonysimError: It is none.
        """
        raise NotImplementedError

    def take_over(self, memory: Any, before: Decider) -> Any:
        """What an agent remembers from now on that has decided by other parameters of this policy until now.

        Args:
            memory: What it remembers, as `restore` has made it.
            before: The policy with those parameters.
        """
        return memory

    def think(self, view: LocalView, memory: Any, stream: Stream) -> Decision:
        """The raw decision of an agent; arguments as in `Policy.decide`."""
        raise NotImplementedError

    def decide(self, view: LocalView, memory: Any, random: random.Random) -> Choice:
        """See `Policy.decide`."""
        return self.think(view, memory, Stream(random)).as_choice(view)
