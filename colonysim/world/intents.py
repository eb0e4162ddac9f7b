"""What an agent wants (intent) and what came of it (outcome): the only words between policy, world and backend."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

__all__ = ["BoxPlace", "Intent", "Move", "Outcome", "Push", "Travel", "Wait"]


@dataclass(frozen=True, slots=True)
class Travel:
    """Go to a neighbouring node."""

    node: int


@dataclass(frozen=True, slots=True)
class Push:
    """Move a box over one edge, or take hold of it.

    An agent that does not yet share the box's node first takes hold of it: `node` is then the box's own
    node, and the agent's step leads there. Otherwise `node` is a neighbour of the node that both share.
    At a drop (a hole that the box falls into) the agent stays behind.

    Attributes:
        box: Number of the box.
        node: Where the edge leads.
        hole: The hole (its key) that the box is meant for; the pair is what B is kept for. -1: it is only passed by.
    """

    box: int
    node: int
    hole: int


@dataclass(frozen=True, slots=True)
class Wait:
    """Do nothing until one of `nodes` changes, or `seconds` have passed.

    A node changes when an agent arrives there or leaves it, a box moves, or a reservation is given up.

    Attributes:
        nodes: Nodes whose change wakes the agent.
        seconds: Longest wait in simulated seconds, above 0; None to wait for a change only.
        clear: A node whose occupant is asked to make way, or -1.
    """

    nodes: tuple[int, ...] = ()
    seconds: float | None = None
    clear: int = -1


Move: TypeAlias = Travel | Push
"""An intent that leads somewhere: what backends are asked to do."""

Intent: TypeAlias = Travel | Push | Wait


class BoxPlace(NamedTuple):
    """Where a box now is; `stray` if its centre is further than a quarter of an edge from the node."""

    box: int
    node: int
    stray: bool = False


@dataclass(frozen=True, slots=True)
class Outcome:
    """How an action ended and where everything it touched now is.

    Attributes:
        status: "arrived": as intended. "blocked": something was in the way. "failed": see `reason`.
        node: The node the agent now belongs to.
        boxes: Every box that the action moved.
        reason: Why, if it did not arrive; short, one word per cause ("stray", "timeout", "wedged", ...).
        lost: The agent cannot act again in this episode (in a pit, on its back).
        keeps: Nodes that the agent's body still needs besides `node`; reserved until its next action.
    """

    status: Literal["arrived", "blocked", "failed"]
    node: int
    boxes: tuple[BoxPlace, ...] = ()
    reason: str = ""
    lost: bool = False
    keeps: tuple[int, ...] = ()
