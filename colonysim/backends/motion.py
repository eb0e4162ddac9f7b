"""A backend as the simulation calls it: in bare numbers, without objects for intents and outcomes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.world.intents import Push, Travel

if TYPE_CHECKING:
    from collections.abc import Iterable

    from colonysim.backends.protocol import Backend
    from colonysim.world.intents import Move, Outcome
    from colonysim.world.state import Place

__all__ = ["ByProtocol", "Motion", "move"]


class Motion:
    """What moves the agents.

    A backend of this package may derive from this class; any other is called by its protocol, see `ByProtocol`.

    Attributes:
        outcome: What will come of the action that `undertake` has just begun; None if the agent will come to `ends_at`,
            and the box that it pushes, if any, to the node that it makes for.
        ends_at: Where the agent will stand then.
    """

    def __init__(self) -> None:
        self.outcome: Outcome | None = None
        self.ends_at = -1

    def needs(self, agent: int, node: int, box: int, hole: int) -> Iterable[Place] | None:
        """What a move needs besides the agent's own node, see `Backend.footprint`; None for `node` alone.

        Args:
            agent: Who moves.
            node: Where to.
            box: The box that it pushes, or to whose node it steps; -1 if it travels.
            hole: The hole (key) which that box is meant for, or -1.
        """
        raise NotImplementedError

    def undertake(self, agent: int, node: int, box: int, hole: int, now: float) -> float:
        """Begins a move, see `Backend.start`; returns how many seconds it takes, or -1 if a tick will tell."""
        raise NotImplementedError


class ByProtocol(Motion):
    """Calls a backend by its protocol.

    Args:
        backend: The backend.
    """

    def __init__(self, backend: Backend) -> None:
        super().__init__()
        self._backend = backend

    def needs(self, agent: int, node: int, box: int, hole: int) -> Iterable[Place]:
        """Its footprint."""
        return self._backend.footprint(agent, move(node, box, hole))

    def undertake(self, agent: int, node: int, box: int, hole: int, now: float) -> float:
        """What it starts."""
        done = self._backend.start(agent, move(node, box, hole), now)
        if done is None:
            return -1.0
        self.outcome = done.outcome
        return done.seconds


def move(node: int, box: int, hole: int) -> Move:
    """The intent to move to a node, with a box if that is not -1."""
    return Travel(node) if box < 0 else Push(box, node, hole)
