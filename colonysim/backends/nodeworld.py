"""The node world: agents and boxes jump along the graph, each edge in its own time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.backends.motion import Motion
from colonysim.backends.protocol import Done
from colonysim.scenario.changes import CHANGES
from colonysim.states import Stored
from colonysim.world.intents import BoxPlace, Outcome, Push, Wait
from colonysim.world.state import BARRED

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.backends.protocol import Finished, TraceRow
    from colonysim.draws import Draws
    from colonysim.randomness import Streams
    from colonysim.states import State
    from colonysim.world.intents import Intent
    from colonysim.world.state import Place, World

__all__ = ["NodeWorld", "what_can_be_pushed", "what_comes_of"]

NOWHERE: frozenset[Place] = frozenset()


def what_comes_of(world: World, agent: int, intent: Intent) -> Outcome:
    """What the rules of the place make of an intent: done as it was meant, or blocked."""
    at = world.agent_node[agent]
    if isinstance(intent, Wait):
        return blocked(at, -1)
    box = -1
    if isinstance(intent, Push):
        box = intent.box if 0 <= intent.box < len(world.box_node) else len(world.box_node)  # there is no such box
    pushed = 0 <= box < len(world.box_node) and world.box_node[box] == at
    node = world.prospect(agent, intent.node, box)
    if node < 0:
        return blocked(at, node)
    return Outcome("arrived", node, (BoxPlace(box, intent.node),) if pushed else ())


def blocked(at: int, barred: int) -> Outcome:
    """The outcome of what the place does not allow, `barred` being what `World.prospect` says."""
    return Outcome("blocked", at, reason=BARRED[-1 - barred])


def what_can_be_pushed(world: World, box: int, targets: Sequence[int]) -> list[float]:
    """1 for each target to which the rules of the place let the box be pushed, else 0."""
    at, base = world.box_node[box], world.box_base[box]
    found = []
    for j in targets:
        found.append(1.0 if world.can_slide(base, at, j) else 0.0)
    return found


class NodeWorld(Motion):
    """Answers every action at once with the time it takes; nothing fails that the place allows.

    Durations come from the scenario's `timing:`, so that measured ones can be given.

    Attributes:
        edge_seconds: Simulated seconds of a travelled edge of mean length.
        draws: What each agent's durations vary with; None if they do not.
    """

    name = "nodeworld"
    tick = None
    changes = CHANGES

    def __init__(self) -> None:
        super().__init__()
        self.edge_seconds = 1.0
        self.draws: Draws | None = None
        self._world: World | None = None

    def reset(self, world: World, streams: Streams) -> None:
        """Begins an episode."""
        timing = world.scenario.timing
        self._world = world
        self._travels, self._pushes = timing.travels, timing.pushes
        self._fixed, self._pace, self._jitter = timing.travel_fixed, timing.travel, timing.jitter
        self._push_fixed, self._push_pace = timing.push_fixed, timing.push
        # One stream an agent: with one for all, an agent more would change how long the others take.
        self.draws = streams.draws("timing", len(world.agent_node)) if timing.jitter else None
        self.edge_seconds = timing.travel_fixed + timing.travel * world.topology.mean_length or 1.0

    def state(self) -> State:
        """Where the random durations have come to."""
        return {"draws": None if self.draws is None else self.draws.numbers()}

    def restore(self, state: State) -> None:
        """Goes on with the random durations of a state; called after `reset`.

        Raises:
            ColonysimError: It is none.
        """
        told = Stored(state, "backend 'nodeworld'")
        if self.draws is not None and self._world is not None and told.take("draws") is not None:
            self.draws.resume(told.column("draws", "Q", len(self._world.agent_node), 0, 2**64 - 1))

    def reseed(self, streams: Streams) -> None:
        """Draws the durations from other streams."""
        if self.draws is not None and self._world is not None:
            self.draws = streams.draws("timing", len(self._world.agent_node))

    def _seconds(self, agent: int, i: int, j: int, pushed: bool) -> float:
        """How long a move takes."""
        assert self._world is not None
        terrain, measured = self._world.terrain, self._pushes if pushed else self._travels
        length = terrain.lengths[terrain.edge(i, j)]
        took = self._push_fixed + self._push_pace * length if pushed else self._fixed + self._pace * length
        if measured:
            took = measured.get((i, j), took)
        if self.draws is not None:
            took *= 1.0 + self._jitter * (2.0 * self.draws.draw(agent) - 1.0)
        return took

    def feasible(self, agent: int, box: int, targets: Sequence[int]) -> Sequence[float]:
        """1 for each push that the place allows, else 0."""
        return [0.0] * len(targets) if self._world is None else what_can_be_pushed(self._world, box, targets)

    def footprint(self, agent: int, intent: Intent) -> frozenset[Place]:
        """The target alone."""
        return NOWHERE if isinstance(intent, Wait) else frozenset((intent.node,))

    def start(self, agent: int, intent: Intent, now: float) -> Done | None:
        """How long it takes and where everything is then."""
        world = self._world
        if world is None:
            return Done(0.0, Outcome("failed", -1, reason="closed"))
        outcome = what_comes_of(world, agent, intent)
        if isinstance(intent, Wait) or outcome.status != "arrived":
            return Done(0.0, outcome)
        pushed = bool(outcome.boxes)
        return Done(self._seconds(agent, world.agent_node[agent], intent.node, pushed), outcome)

    def needs(self, agent: int, node: int, box: int, hole: int) -> None:
        """The target alone."""

    def undertake(self, agent: int, node: int, box: int, hole: int, now: float) -> float:
        """`start` in bare numbers."""
        world = self._world
        if world is None:
            raise RuntimeError("the backend has not been reset")
        at = world.agent_node[agent]
        self.outcome, self.ends_at = None, world.prospect(agent, node, box)
        if self.ends_at < 0:
            self.outcome = blocked(at, self.ends_at)
            return 0.0
        return self._seconds(agent, at, node, box >= 0 and world.box_node[box] == at)

    def advance(self, now: float) -> Sequence[Finished]:
        """Nothing is ever pending."""
        return ()

    def cancel(self, agent: int) -> None:
        """Nothing is ever pending."""

    def leave(self, agent: int) -> None:
        """There is no body to take away."""

    def rows(self) -> Iterable[TraceRow]:
        """There are no poses."""
        return ()

    def close(self) -> None:
        """Lets go of the world."""
        self._world = None
