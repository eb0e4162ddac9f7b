"""Moves and outcomes as plain data, for states."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.states import Stored
from colonysim.world.intents import BoxPlace, Outcome, Push, Travel

if TYPE_CHECKING:
    from colonysim.world.intents import Intent, Move
    from colonysim.world.state import World

__all__ = ["STATUSES", "move_of", "move_state", "outcome_of", "outcome_state"]

STATUSES = ("arrived", "blocked", "failed")


def move_state(move: Intent | None) -> dict[str, int] | None:
    """A move as plain data; one without a box is a travel, and anything else is none."""
    if isinstance(move, Push):
        return {"node": move.node, "box": move.box, "hole": move.hole}
    return {"node": move.node} if isinstance(move, Travel) else None


def move_of(state: Any, world: World, what: str) -> Move | None:
    """The move of `move_state`.

    Raises:
        ColonysimError: It is none, or names what does not exist.
    """
    if state is None:
        return None
    told = Stored(state, what)
    node = told.whole("node", 0, len(world.topology) - 1)
    if "box" not in state:
        return Travel(node)
    return Push(
        told.whole("box", 0, len(world.box_node) - 1), node, told.whole("hole", -1, len(world.scenario.holes) - 1)
    )


def outcome_state(outcome: Outcome | None) -> dict[str, Any] | None:
    """An outcome as plain data."""
    if outcome is None:
        return None
    return {
        "status": outcome.status, "node": outcome.node, "boxes": [list(place) for place in outcome.boxes],
        "reason": outcome.reason, "lost": outcome.lost, "keeps": list(outcome.keeps),
    }  # fmt: skip


def outcome_of(state: Any, world: World, what: str) -> Outcome | None:
    """The outcome of `outcome_state`.

    Raises:
        ColonysimError: It is none, or names what does not exist.
    """
    if state is None:
        return None
    told, last = Stored(state, what), len(world.topology) - 1
    status, reason = told.take("status"), told.text("reason")
    if status not in STATUSES:
        raise told.fault("status", status, f"one of {', '.join(STATUSES)}")
    boxes = []
    for place in told.listed("boxes"):
        if not isinstance(place, list) or len(place) != 3:
            raise told.fault("boxes", place, "box, node and whether it is stray")
        each = Stored(dict(zip(("box", "node", "stray"), place, strict=True)), what)
        boxes.append(
            BoxPlace(each.whole("box", 0, len(world.box_node) - 1), each.whole("node", 0, last), each.flag("stray"))
        )
    keeps = tuple(told.wholes("keeps", None, 0, last))
    return Outcome(status, told.whole("node", 0, last), tuple(boxes), reason, told.flag("lost"), keeps)
