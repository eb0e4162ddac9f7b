"""Colonies are kept for later: what is saved of one, and another one made the same."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

from colonysim import __version__
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.provenance import files_of, other_file
from colonysim.simulation.colony_state import state_of, take_over
from colonysim.simulation.course import go_through
from colonysim.simulation.origins import backend_of, policy_of, scenario_of
from colonysim.simulation.saving import Saved
from colonysim.states import Stored
from colonysim.trace.schema import Measurement

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Mapping
    from pathlib import Path

    from colonysim.backends.protocol import Backend
    from colonysim.policies.policy import Policy
    from colonysim.scenario.scenario import Scenario
    from colonysim.simulation.colony import Colony
    from colonysim.states import State
    from colonysim.trace.schema import Sink

__all__ = ["closed_on_error", "loaded", "refuse_other_files", "restore", "saved_of"]

C = TypeVar("C", bound="Colony")


def saved_of(colony: Colony, extra: Mapping[str, Any] | None = None) -> Saved:
    """All that a colony is now.

    Args:
        colony: The colony.
        extra: What else to write down.

    Raises:
        ColonysimError: It is closed, or a part of others cannot say its state.
    """
    if colony._closed:
        raise ColonysimError("a colony that is closed, or has come to its end, has no future to save")
    if colony._measuring:
        raise ColonysimError("a colony cannot be saved in the middle of a measurement")
    state = state_of(colony)
    scenario = colony._course.scenario if state["course"] else colony.scenario
    return Saved(
        scenario.document, scenario.digest, colony._origin, colony.mode, colony._count, state, __version__, extra or {},
        colony._files,
    )  # fmt: skip


def restore(colony: Colony, state: State) -> None:
    """Makes a colony that has not begun the same as that of a state.

    Raises:
        ColonysimError: It is no state of such a colony.
    """
    told = Stored(state, "colony")
    course = told.take("course")
    if course is not None:
        go_through(colony, told, Stored(course, "course"))
    else:
        take_over(colony, told)
    colony._rows.restore(told.take("rows"), colony._number, colony._world.now)
    colony._measures.restore(told.take("measures"))
    rows = [_measurement(row) for row in told.listed("measured")]
    colony._measured[:] = rows


def _measurement(row: Any) -> Measurement:
    each = Stored(dict(zip(Measurement._fields, row if isinstance(row, list) else (), strict=False)), "a measurement")
    value = each.take("value")
    if type(value) is not float:
        raise each.fault("value", value, "a number")
    return Measurement(each.whole("episode", 1), each.real("time", 0.0), each.text("name"), value)


def refuse_other_files(saved: Saved, scenario: Scenario, options: Mapping[str, Any] | None) -> None:
    """Refuses to go on with a file of a model that is another one than when the colony was made.

    Raises:
        ColonysimError: One is.
    """
    if other := other_file(saved.files, files_of(scenario.parameters, options, scenario.parts_of_groups)):
        raise ColonysimError(f"saved with {other}")


@contextmanager
def closed_on_error(colony: Colony) -> Iterator[None]:
    """Closes a colony that does not come to be what it should."""
    try:
        yield
    except BaseException:
        colony._fail()
        raise


def loaded(
    kind: type[C],
    path: Path,
    saved: Saved,
    *,
    scenario: Scenario | str | Path | None = None,
    backend: str | Backend | None = None,
    backend_options: Mapping[str, Any] | None = None,
    policy: str | Policy | Callable[[Scenario], Policy] | None = None,
    sink: Sink | None = None,
    decisions: bool = True,
    kinds: Collection[str] | None = None,
) -> C:
    """A colony that goes on where a saved one has come to; see `Colony.load`.

    Args:
        kind: Its class.
        path: Where it was read, for messages.
        saved: What was read there.
        scenario: See `Colony.load`, as all others.
        backend: The same.
        backend_options: The same.
        policy: The same.
        sink: The same.
        decisions: The same.
        kinds: The same.
    """
    place = scenario_of(saved, path, scenario)
    try:
        mover, options = backend_of(saved, backend, backend_options)
        refuse_other_files(saved, place, options)
        colony = kind(
            place, backend=mover, backend_options=options, policy=policy_of(saved, policy), mode=saved.mode, sink=sink,
            episodes=saved.episodes, decisions=decisions, kinds=kinds,
        )  # fmt: skip
        with closed_on_error(colony):
            restore(colony, saved.state)
    except ScenarioError:
        raise
    except ColonysimError as error:
        raise type(error)(f"{path}: {error}") from None
    return colony
