"""The adapter that checks the answers of third parties' policies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

from colonysim.errors import PASSED_ON, ColonysimError, UnsavableError
from colonysim.policies.decision import Decider, new_decision
from colonysim.policies.outside import Outside
from colonysim.policies.policy import Choice
from colonysim.simulation.foreign.answers import SHOWN, Foreign, listed, real, truth, whole
from colonysim.states import copied
from colonysim.world.intents import Push, Travel, Wait

if TYPE_CHECKING:
    from colonysim.pheromones.field import Field
    from colonysim.policies.decision import Decision, Stream
    from colonysim.policies.policy import Policy
    from colonysim.policies.view import LocalView
    from colonysim.trace.rows import Rows
    from colonysim.world.intents import Intent
    from colonysim.world.state import World

__all__ = ["ForeignPolicy"]

ROUNDING = 1e-6
"""A probability may be above 1 by this much."""


class ForeignPolicy(Foreign, Decider):
    """A third party's policy; each decision is one call, and each answer is checked against the protocol."""

    def __init__(self, policy: Policy, world: World, rows: Rows) -> None:
        super().__init__(policy, "policy", world, rows)
        self.outside = getattr(policy, "outside", False) is True

    def fields(self, world: World) -> Mapping[str, Field]:
        """It may raise; `checked_fields` looks at what it gives."""
        return cast("Mapping[str, Field]", self._call("fields", world))

    def begin(self, agent: int, memory: Any) -> Any:
        """It may raise."""
        return self._call("begin", agent, memory, agent=agent)

    def state(self, agent: int, memory: Any) -> Any:
        """Plain data: of the memory itself, if the policy does not say it otherwise."""
        if self.savable:
            return self._copied("state", self._call("state", agent, memory, agent=agent), agent)
        try:
            return copied(memory, "its memory")
        except ColonysimError as error:
            why = f"{error}; a policy with other memories needs methods 'state' and 'restore' to be saved"
            raise self._fault(why, agent, UnsavableError) from None

    def restore(self, agent: int, state: Any) -> Any:
        """The memory; the policy's method may raise."""
        if self.savable:
            return self._call("restore", agent, state, agent=agent)
        return copied(state, "a memory")

    def take_over(self, memory: Any, before: Decider) -> Any:
        """The memory as it is; of decisions from outside what the policy says whose memory it is."""
        if isinstance(self._part, Outside) and isinstance(before, ForeignPolicy):
            return self._part.take_over(memory, before._part)
        return memory

    def think(self, view: LocalView, memory: Any, stream: Stream) -> Decision:
        """An intent that speaks of what exists, and a choice that fits the trace."""
        return self.taken(view.agent, self.choose(view, memory, stream))

    def choose(self, view: LocalView, memory: Any, stream: Stream) -> Choice:
        """What the policy answers.

        Raises:
            PluginError: It is no choice.
        """
        try:
            choice = self._part.decide(view, memory, stream.generator)
        except PASSED_ON:
            raise
        except BaseException as error:
            raise self._raised("decide", error, view.agent) from error
        if not isinstance(choice, Choice):
            raise self._fault(f"decide returns {SHOWN.repr(choice)}, expected a Choice", view.agent)
        return choice

    def taken(self, agent: int, choice: Choice) -> Decision:
        """The decision that a choice comes to.

        Raises:
            PluginError: It speaks of what does not exist, or does not fit the trace.
        """
        decision, intent = new_decision(choice.memory), choice.intent
        mark = choice.mark
        bare = type(choice.targets) is tuple and not choice.targets and choice.explored is False and mark == 0.0
        if bare and type(intent) is Travel:  # most are no more than that
            node = intent.node
            if type(node) is int and 0 <= node < self._nodes and self._leads(agent, node):
                decision.choice, decision.node = choice, node
                return decision
        found, why = self._intent(agent, intent)
        if not why:
            choice, why = self._options(choice)
        left = real(mark)
        if not why and (left is None or not 0.0 <= left <= 1.0):
            why = f"its mark is {SHOWN.repr(mark)}, expected a number from 0 to 1"
        if why or found is None:
            raise self._fault(f"it wants {SHOWN.repr(intent)}: {why}", agent)
        decision.choice, decision.mark = choice if found is intent else choice._replace(intent=found), left or 0.0
        if isinstance(found, Wait):
            decision.wait = found
        else:
            decision.node = found.node
            if isinstance(found, Push):
                decision.box, decision.hole = found.box, found.hole
        return decision

    def _leads(self, agent: int, node: int) -> bool:
        """Whether there is an edge from where the agent stands to a node."""
        return self._world.adjacent(self._world.agent_node[agent], node)

    def _intent(self, agent: int, intent: Any) -> tuple[Intent | None, str]:
        """The intent with plain numbers, and what is wrong with it."""
        if isinstance(intent, Wait):
            return self._wait(intent)
        if not isinstance(intent, Travel | Push):
            return None, "expected a Travel, a Push or a Wait"
        node = whole(intent.node)
        if node is None or not 0 <= node < self._nodes:
            return None, "there is no such node"
        if not self._leads(agent, node):
            return None, self._astray(self._world.agent_node[agent], node)
        if isinstance(intent, Travel):
            return (intent if type(intent.node) is int else Travel(node)), ""
        box, hole = whole(intent.box), whole(intent.hole)
        if box is None or not 0 <= box < self._boxes:
            return None, "there is no such box"
        if hole is None or not -1 <= hole < self._holes:
            return None, "there is no such hole"
        plain = type(intent.node) is type(intent.box) is type(intent.hole) is int
        return (intent if plain else Push(box, node, hole)), ""

    def _astray(self, here: int, there: int) -> str:
        """What to say of a node that no edge leads to."""
        why, ids = f"no edge leads there from node {here}", self._world.topology.ids
        if (ids[here], ids[there]) == (here, there):
            return why
        return f"{why} (these are indices: in the scenario's file it stands on node {ids[here]} and wants {ids[there]})"

    def _wait(self, wait: Wait) -> tuple[Wait | None, str]:
        try:
            nodes = tuple([whole(node) for node in listed(wait.nodes)])
        except Exception:  # whatever goes wrong in going through them
            return None, "expected nodes to wait for"
        if not all(node is not None and 0 <= node < self._nodes for node in nodes):
            return None, "there is no such node to wait for"
        seconds, clear = None if wait.seconds is None else real(wait.seconds), whole(wait.clear)
        if wait.seconds is not None and (seconds is None or seconds <= 0.0):
            return None, "expected a time above 0 that has an end, or None to wait for a change"
        if clear is None or not -1 <= clear < self._nodes:
            return None, "there is no such node to be cleared"
        return Wait(nodes, seconds, clear), ""  # type: ignore[arg-type]

    def _options(self, choice: Choice) -> tuple[Choice, str]:
        """The choice with what it was made from as plain numbers, and what is wrong with it."""
        explored = truth(choice.explored)
        if explored is None:
            return choice, f"explored is {SHOWN.repr(choice.explored)}, expected True or False"
        try:
            targets, boxes = listed(choice.targets), listed(choice.boxes)
            chances = listed(choice.probabilities)
            boxes = boxes or [-1] * len(targets)
        except Exception:
            return choice, "expected targets, boxes and probabilities of the choice"
        if not len(targets) == len(boxes) == len(chances):
            why = f"its choice has {len(targets)} targets, {len(boxes)} boxes and {len(chances)} probabilities"
            return choice, why
        for target, box, chance in zip(targets, boxes, chances, strict=True):
            node, given_box = whole(target), whole(box)
            if node is None or not 0 <= node < self._nodes:
                return choice, f"one of its targets is {SHOWN.repr(target)}, expected a node"
            if given_box is None or not -1 <= given_box < self._boxes:
                return choice, f"one of the boxes of its choice is {SHOWN.repr(box)}, expected a box or -1"
            share = real(chance)
            if share is None or not 0.0 <= share <= 1.0 + ROUNDING:
                return choice, f"one of its probabilities is {SHOWN.repr(chance)}, expected a number from 0 to 1"
        options = (tuple(map(int, targets)), tuple(map(int, boxes)), tuple(map(float, chances)))
        return Choice(choice.intent, choice.memory, explored, *options, mark=choice.mark), ""
