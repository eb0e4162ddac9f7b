"""What a backend is: it turns intents into motion and says what came of them. It knows no SimPy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeAlias

if TYPE_CHECKING:
    from colonysim.randomness import Streams
    from colonysim.world.intents import Intent, Outcome
    from colonysim.world.state import Place, World

__all__ = ["Backend", "Done", "FeasibleWay", "Finished", "TraceRow"]

FeasibleWay: TypeAlias = Callable[[int, int, Sequence[int]], Sequence[float]]
"""Of an agent, a box and the nodes to push it over, its own first: the chance of each push if those before succeed."""


class Done(NamedTuple):
    """An action whose end is known when it starts: it takes `seconds` and ends with `outcome`."""

    seconds: float
    outcome: Outcome


class Finished(NamedTuple):
    """An action that has just ended on a backend with a clock of its own."""

    agent: int
    outcome: Outcome


class TraceRow(NamedTuple):
    """A row for one of the trace's tables ("poses", "controls") in the order of its columns."""

    table: str
    row: tuple[object, ...]


class Backend(Protocol):
    """Makes intents happen.

    A backend reads the world and never writes it: all that it did is in the outcome. One action per agent is under
    way at a time. Whatever goes wrong is an outcome with a reason, never an exception and never a hang: one that is
    pending for longer than a hundred times its edge should take, and than the scenario's `stall_seconds`, is given up.

    Attributes:
        name: As results and traces call it.
        tick: Control period in simulated seconds, or None for a backend that answers every `start` at once.
        edge_seconds: Typical simulated seconds of a travelled edge, known after `reset`: the unit of patience.

    How long a tick is may change with a `reset`, too, but not whether there is one.

    Where a scenario has a timeline, `changes` says which kinds of changes (`colonysim.scenario.changes.CHANGES`) the
    backend can follow, those aside that concern no body (`colonysim.backends.changes.ANYWHERE`); without it, it follows
    only these. A method `changed` is then called with each change but agents' failures, right after the world has gone
    through it; not with what happens before an episode's first event, for that has happened before `reset`.

    Two more attributes may be there. `feasible_way` (a `FeasibleWay`) is for backends that can tell about pushes after
    the next one; it is asked about nodes within the agent's sight. Where it is absent or None, `feasible` is asked
    alone. `recording` (a bool) is set before `reset`, where it is there: False when nobody wants the `rows`.

    A backend takes part in saving and forking colonies in one of two ways. Either it has the methods
    `state(self) -> dict`, which says all that it is between two calls as plain data (`colonysim.states`), and
    `restore(self, state)`, which is called after `reset` of the same episode and makes it so again. Or it says
    `replayable = True`: the same calls in the same order come to the same outcomes, bit for bit; a new instance is then
    taken through the episode again. In both cases `reseed(self, streams)` gives it other random streams of the episode
    from now on. A colony on a backend without these cannot be saved.
    """

    name: str
    tick: float | None
    edge_seconds: float

    def reset(self, world: World, streams: Streams) -> None:
        """Begins an episode: everything stands where `world` says; randomness only from `streams`."""
        ...

    def feasible(self, agent: int, box: int, targets: Sequence[int]) -> Sequence[float]:
        """The chance, 0 to 1, that `agent` can push `box` to each of the neighbouring `targets`."""
        ...

    def footprint(self, agent: int, intent: Intent) -> frozenset[Place]:
        """What the manoeuvre needs besides the agent's own node: nodes, and edges (i, j), i < j, that it sweeps over.

        All of it is reserved, or nothing is and the agent waits.
        """
        ...

    def start(self, agent: int, intent: Intent, now: float) -> Done | None:
        """Begins an action; None if its outcome will come from `advance`."""
        ...

    def advance(self, now: float) -> Sequence[Finished]:
        """Moves the bodies on by one tick, which ends at `now`; called only while an action is pending."""
        ...

    def cancel(self, agent: int) -> None:
        """Gives up the agent's action, if one is pending; no outcome will come of it."""
        ...

    def leave(self, agent: int) -> None:
        """Takes the agent's body out of the world: it has reached the goal."""
        ...

    def rows(self) -> Iterable[TraceRow]:
        """Hands over what the trace should keep since the last call (poses of movers, control steps)."""
        ...

    def close(self) -> None:
        """Releases everything; may be called more than once."""
        ...
