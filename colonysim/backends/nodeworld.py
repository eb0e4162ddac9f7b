"""The node world: agents and boxes jump along the graph, each edge in its own time."""

from __future__ import annotations

from functools import cache, partial
from typing import TYPE_CHECKING

from colonysim.backends.protocol import Done
from colonysim.world.intents import BoxPlace, Outcome, Travel, Wait

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from colonysim.backends.protocol import Finished, TraceRow
    from colonysim.draws import Draws
    from colonysim.randomness import Streams
    from colonysim.world.intents import Intent
    from colonysim.world.state import Place, World

__all__ = ["NodeWorld", "what_can_be_pushed", "what_comes_of"]

NOWHERE: frozenset[Place] = frozenset()


@cache
def _arrival(node: int) -> Outcome:
    """By far the most frequent outcome; it cannot change, so one of each is enough."""
    return Outcome("arrived", node)


def what_comes_of(world: World, agent: int, intent: Intent) -> Outcome:
    """What the rules of the place make of an intent: done as it was meant, or blocked."""
    at = world.agent_node[agent]
    if isinstance(intent, Wait) or intent.node not in world.topology.neighbours[at]:
        return Outcome("blocked", at, reason="no such move")
    node = intent.node
    if isinstance(intent, Travel):
        if not world.passable(world.level(agent), at, node):
            return Outcome("blocked", at, reason="unreachable")
        return _arrival(node)
    box = intent.box
    if not 0 <= box < len(world.box_node):
        return Outcome("blocked", at, reason="no such box")
    stands, base = world.box_node[box], world.box_base[box]
    if stands == node:
        if not world.graspable(agent, box, world.level(agent), at):
            return Outcome("blocked", at, reason="out of reach")
        return _arrival(node)
    if stands != at or world.top_box(at) != box or not world.can_slide(base, at, node):
        return Outcome("blocked", at, reason="cannot be pushed")
    pusher = at if world.falls(base, at, node) else node
    return Outcome("arrived", pusher, (BoxPlace(box, node),))


def what_can_be_pushed(world: World, box: int, targets: Sequence[int]) -> list[float]:
    """1 for each target to which the rules of the place let the box be pushed, else 0."""
    at, base = world.box_node[box], world.box_base[box]
    found = []
    for j in targets:
        found.append(1.0 if world.can_slide(base, at, j) else 0.0)
    return found


class NodeWorld:
    """Answers every action at once with the time it takes; nothing fails that the place allows.

    Durations come from the scenario's `timing:`, so that measured ones can be given.

    Attributes:
        edge_seconds: Simulated seconds of a travelled edge of mean length.
        draws: What each agent's durations vary with; None if they do not.
    """

    name = "nodeworld"
    tick = None

    def __init__(self) -> None:
        self.edge_seconds = 1.0
        self.draws: Draws | None = None
        self._world: World | None = None

    def reset(self, world: World, streams: Streams) -> None:
        """Begins an episode."""
        timing = world.scenario.timing
        self._world = world
        self._timing = timing
        # One stream an agent: with one for all, an agent more would change how long the others take.
        self.draws = streams.draws("timing", len(world.agent_node)) if timing.jitter else None
        self.edge_seconds = timing.travel_fixed + timing.travel * world.topology.mean_length or 1.0

    @property
    def jitters(self) -> list[Callable[[], float]]:
        """For each agent the next number of its stream, which its durations vary with; empty if they do not."""
        draws, world = self.draws, self._world
        if draws is None or world is None:
            return []
        return [partial(draws.draw, agent) for agent in range(len(world.agent_node))]

    def _seconds(self, agent: int, i: int, j: int, pushed: bool) -> float:
        timing = self._timing
        measured = (timing.pushes if pushed else timing.travels).get((i, j))
        if measured is None:
            world = self._world
            length = world.topology.length(i, j) if world else 0.0
            measured = (
                timing.push_fixed + timing.push * length if pushed else timing.travel_fixed + timing.travel * length
            )
        if self.draws is not None:
            return measured * (1.0 + timing.jitter * (2.0 * self.draws.draw(agent) - 1.0))
        return measured

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
