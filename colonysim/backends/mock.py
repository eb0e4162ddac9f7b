"""A backend for tests: it answers what it is told to answer, and remembers what it was asked."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from colonysim.backends.nodeworld import what_can_be_pushed, what_comes_of
from colonysim.backends.protocol import Done, Finished
from colonysim.states import Stored
from colonysim.world.intents import Intent, Outcome, Wait
from colonysim.world.plain import outcome_of, outcome_state

if TYPE_CHECKING:
    from collections.abc import Iterable

    from colonysim.backends.protocol import TraceRow
    from colonysim.randomness import Streams
    from colonysim.states import State
    from colonysim.world.state import Place, World

__all__ = ["Call", "Mock", "Script"]


class Call(NamedTuple):
    """Something that a `Mock` was asked to do."""

    method: str
    agent: int = -1
    intent: Intent | None = None
    now: float = 0.0


Script: TypeAlias = Callable[[int, Intent, "World"], Outcome | None] | Sequence[Outcome | None]
"""Outcomes in the order of actions, anew in each episode, or a function of agent, intent and world; None for the
outcome that the rules of the place give."""


class Mock:
    """Answers actions with scripted outcomes, or with those that the rules of the place give.

    Args:
        script: The answers; a sequence that is used up goes on with None.
        seconds: How long each action takes.
        tick: Its control period; outcomes then come from `advance`. None to answer at once.

    Attributes:
        calls: Every call in order, over all episodes.

    Example:
        ```python
        body = Mock(script=[None, Outcome("failed", 0, reason="wedged")])
        for event in colonysim.simulate(scenario, backend=body):
            ...
        assert [call.agent for call in body.calls if call.method == "start"] == [0, 0]
        ```
    """

    name = "mock"

    def __init__(self, script: Script = (), seconds: float = 1.0, tick: float | None = None) -> None:
        self.tick = tick
        self.edge_seconds = seconds or 1.0
        self.calls: list[Call] = []
        self._script = script
        self._seconds = seconds
        self._world: World | None = None
        self._started = 0
        self._pending: dict[int, tuple[float, Outcome]] = {}

    def reset(self, world: World, streams: Streams) -> None:
        """Begins an episode, and the script."""
        self.calls.append(Call("reset"))
        self._world = world
        self._started = 0
        self._pending.clear()

    def feasible(self, agent: int, box: int, targets: Sequence[int]) -> Sequence[float]:
        """1 for each push that the rules of the place allow, else 0."""
        return [0.0] * len(targets) if self._world is None else what_can_be_pushed(self._world, box, targets)

    def footprint(self, agent: int, intent: Intent) -> frozenset[Place]:
        """The target alone."""
        return frozenset() if isinstance(intent, Wait) else frozenset((intent.node,))

    def start(self, agent: int, intent: Intent, now: float) -> Done | None:
        """The next answer of the script."""
        self.calls.append(Call("start", agent, intent, now))
        world = self._world
        if world is None:
            return Done(0.0, Outcome("failed", -1, reason="closed"))
        if callable(self._script):
            scripted = self._script(agent, intent, world)
        else:
            scripted = self._script[self._started] if self._started < len(self._script) else None
        self._started += 1
        outcome = scripted or what_comes_of(world, agent, intent)
        if self.tick is None:
            return Done(self._seconds, outcome)
        self._pending[agent] = (now + self._seconds, outcome)
        return None

    def advance(self, now: float) -> Sequence[Finished]:
        """Delivers what is due."""
        self.calls.append(Call("advance", now=now))
        # Ticks add up with a rounding error that must not cost another tick.
        due = [agent for agent, (end, _) in self._pending.items() if end <= now + 1e-9]
        return [Finished(agent, self._pending.pop(agent)[1]) for agent in due]

    def cancel(self, agent: int) -> None:
        """Forgets the agent's action."""
        self.calls.append(Call("cancel", agent))
        self._pending.pop(agent, None)

    def leave(self, agent: int) -> None:
        """There is no body to take away, but perhaps an action."""
        self.calls.append(Call("leave", agent))
        self._pending.pop(agent, None)

    def state(self) -> State:
        """How many actions have begun, and those that are pending with their outcomes."""
        pending = [[agent, end, outcome_state(outcome)] for agent, (end, outcome) in self._pending.items()]
        return {"started": self._started, "pending": pending}

    def restore(self, state: State) -> None:
        """Goes on where another has come to; called after `reset`."""
        told = Stored(state, "backend 'mock'")
        self._started = told.whole("started")
        assert self._world is not None
        for each in told.listed("pending"):
            action = Stored(dict(zip(("agent", "end", "outcome"), each, strict=True)), "an action of the mock")
            outcome = outcome_of(action.take("outcome"), self._world, "an outcome of the mock")
            assert outcome is not None
            self._pending[action.whole("agent", 0, len(self._world.agent_node) - 1)] = action.real("end"), outcome

    def reseed(self, streams: Streams) -> None:
        """It draws nothing."""

    def rows(self) -> Iterable[TraceRow]:
        """There are no poses."""
        return ()

    def close(self) -> None:
        """Lets go of the world."""
        self.calls.append(Call("close"))
        self._world = None
        self._pending.clear()
