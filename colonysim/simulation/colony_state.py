"""All that a colony is between two events, as plain data, and a colony put into such a state."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError, UnsavableError
from colonysim.randomness import Streams
from colonysim.simulation.episode_state import episode_state, restore_episode
from colonysim.states import Stored, copied

if TYPE_CHECKING:
    from colonysim.backends.protocol import Backend
    from colonysim.simulation.colony import Colony
    from colonysim.states import State

__all__ = ["check_plain", "check_savable", "memories_of", "replays", "says_state", "state_of", "take_over"]


def check_savable(colony: Colony) -> None:
    """Checks that every part of a colony can be saved.

    Raises:
        UnsavableError: One cannot.
    """
    for field in colony._fields.values():
        if hasattr(field, "check_savable"):
            field.check_savable()
    body = colony._body
    if not (says_state(body) or getattr(body, "replayable", False)):
        raise UnsavableError(
            f"backend {body.name!r} can neither say its state (methods 'state' and 'restore' of its own) nor go "
            "through an episode again exactly ('replayable'), without which a colony cannot be saved"
        )


def check_plain(colony: Colony) -> None:
    """Checks that fields and memories can be handed over to others.

    Raises:
        ColonysimError: One cannot say its state.
    """
    for field in colony._fields.values():
        field.state()
    memories_of(colony)


def says_state(body: Backend) -> bool:
    """Whether a backend has the methods by which it takes part in saving."""
    return bool(getattr(body, "savable", callable(getattr(body, "state", None))))


def replays(body: Backend) -> bool:
    """Whether a colony on this backend is brought to a moment by going through the episode again."""
    return not says_state(body) and bool(getattr(body, "replayable", False))


def state_of(colony: Colony) -> State:
    """All that a colony is between two events, as plain data.

    Raises:
        ColonysimError: A part of others cannot say it.
    """
    check_savable(colony)
    streams = colony._streams
    state: State = {
        "seed": streams.seed, "path": streams.path, "number": colony._number, "running": colony._running,
        "aged": colony._aged, "tuning": copied(colony._tuning, "tuning"), "world": colony._world.state(),
        "fields": {name: field.state() for name, field in colony._fields.items()},
        "memories": memories_of(colony),
        "rows": colony._rows.state(), "measures": colony._measures.state(),
        "measured": [list(row) for row in colony._measured],
        "episode": episode_state(colony._episode) if colony._number else None, "backend": None, "course": None,
    }  # fmt: skip
    if colony._running:
        if replays(colony._body):
            begun, changes, answers = colony._course.begun, colony._course.changes, colony._course.answers
            if begun is None:  # a part could not say it then, and most likely cannot now
                raise ColonysimError("this colony cannot be saved before its next episode: a part had no plain state")
            state["course"] = {
                "begun": copied(begun, "begun"), "changes": copied(changes, "changes"),
                "answers": copied(answers, "answers"),
            }  # fmt: skip
        else:
            state["backend"] = colony._body.state()  # type: ignore[attr-defined]
    return state


def memories_of(colony: Colony) -> list[Any] | None:
    """What each agent remembers, as plain data; None before the first episode."""
    if not colony._number:
        return None
    return [colony._policy.state(agent, memory) for agent, memory in enumerate(colony._memories)]


def take_over(colony: Colony, told: Stored) -> None:
    """Puts every part into its state."""
    path = told.text("path")
    _take_tuning(colony, told)
    colony._streams = Streams(told.whole("seed", 0, 10**18), path)
    colony._number, colony._aged = told.whole("number", 0, colony._count), told.flag("aged")
    running, world, body = told.flag("running"), colony._world, colony._body
    fields, given = colony._fields, told.part("fields")
    if missing := fields.keys() ^ told.take("fields").keys():  # a mapping, or it were no part
        names = ", ".join(sorted(missing))
        raise ColonysimError(f"the saved colony has other pheromone fields than this policy: {names}")
    for name, field in fields.items():
        field.restore(given.take(name))
    if colony._number:
        memories = told.listed("memories", len(colony._memories))
        colony._memories[:] = [colony._policy.restore(agent, memory) for agent, memory in enumerate(memories)]
    own = colony._streams.within(f"episode/{colony._number}")
    if running:
        body.reset(world, own)  # with everything where it starts: what has changed since is in the states
    world.restore(told.take("world"))
    if running:
        body.restore(told.take("backend"))  # type: ignore[attr-defined]
    if colony._number:
        restore_episode(
            colony._episode,
            told.take("episode"),
            colony._number,
            colony._memories,
            own,
            synchronous=colony.mode == "synchronous",
            under_way=running,
        )
    colony._running = running


def _take_tuning(colony: Colony, told: Stored) -> None:
    """Has the agents decide by the parameters that hold in a state."""
    tuning, groups = told.take("tuning"), {"", *(group.name for group in colony.scenario.groups)}
    if not (isinstance(tuning, dict) and tuning.keys() <= groups and all(type(own) is dict for own in tuning.values())):
        raise told.fault("tuning", tuning, "parameters by groups that there are")
    if tuning != colony._tuning:
        colony._tuning = tuning
        colony._take_policies(colony._make_policies())
        colony._set_up()
