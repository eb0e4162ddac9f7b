"""Changes that are made by hand while a colony is under way: each becomes one of the scenario's timeline."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from colonysim.backends.changes import ANYWHERE, refuse_changes
from colonysim.errors import ColonysimError
from colonysim.scenario.changes import refuse_unknown_marks
from colonysim.scenario.loading import with_changes
from colonysim.simulation.adopting import adopt
from colonysim.simulation.colony_state import check_plain, replays
from colonysim.simulation.foreign.answers import SHOWN
from colonysim.simulation.tuning import check_tunings
from colonysim.trace.writer import TraceWriter

if TYPE_CHECKING:
    from colonysim.scenario.changes import Change
    from colonysim.scenario.scenario import Scenario
    from colonysim.simulation.colony import Colony

__all__ = ["change_by_hand", "kinds_by_hand"]

SOURCE = "by hand"
"""How messages name what was not read from a file."""
_MOMENT = 1000.0
"""Changes by hand come at whole moments, so many a second."""


def kinds_by_hand(colony: Colony) -> tuple[str, ...]:
    """The kinds of changes that can be made by hand; see `Colony.changeable`."""
    more = () if replays(colony._body) else getattr(colony._body, "changes", ())
    return tuple(dict.fromkeys(kind for kind in (*ANYWHERE, *more) if kind != "add_agent"))


def change_by_hand(colony: Colony, item: Mapping[str, Any]) -> Change:
    """Adds a change to the timeline of a colony under way; see `Colony.change`.

    Everything is checked before anything is changed.
    """
    if colony._closed or (colony.completed and not colony._rows.events):
        raise ColonysimError("a colony that is closed, or has come to its end, cannot be changed")
    if not isinstance(item, Mapping):
        raise ColonysimError(f"change: {SHOWN.repr(item)}, expected a mapping, as an entry of `changes:`")
    given, now = _placed(colony, item), colony.scenario
    scenario = with_changes(now, [given], SOURCE)
    change = scenario.changes[-1]
    asked = replace(scenario, source=SOURCE, positions={}, overrides={})
    _refuse_past(colony, asked, change)
    _refuse_newcomers(now, asked, change)
    refuse_changes(asked, str(colony._body.name), getattr(colony._body, "changes", ()))
    _refuse_bodies(colony, asked, change)
    refuse_unknown_marks(asked, colony._fields)
    check_tunings(asked, colony._asked, colony._world, colony._rows, colony._fields, change.number)
    check_plain(colony)
    # The place is the same, so that what is known of it need not be found out again.
    scenario = replace(scenario, topology=now.topology)
    due = change.time if _under_way(colony) and change.happens_in(colony._number) else None
    colony._course.note_change(colony, by_hand=given)
    try:
        adopt(colony, scenario, due)
        if isinstance(colony._sink, TraceWriter):
            colony._sink.note_change(scenario)
    except BaseException:
        colony._fail()
        raise
    return change


def _placed(colony: Colony, item: Mapping[str, Any]) -> dict[str, Any]:
    """A change with its episode and time."""
    given = dict(item)
    if not {"episode", "from_episode", "to_episode"} & given.keys():
        given["episode"] = colony._number if _under_way(colony) else colony._number + 1
        if _under_way(colony):
            given.setdefault("time", _next_moment(colony))
    return given


def _under_way(colony: Colony) -> bool:
    """Whether there is an episode in which something can still happen; one that is to end has its last events out."""
    episode = colony._episode
    ends = colony._running and (episode.stuck or episode.over or len(episode.finished) == len(episode.views))
    return colony._running and not ends


def _present(colony: Colony) -> float:
    """Up to when things have happened in the episode under way, simulated seconds.

    The clock of a backend with ticks may be ahead of the last event: nothing can happen to bodies before its time.
    """
    clock = colony._episode.clock
    return max(colony.now, colony._episode.now, clock.due if clock.scheduled else 0.0)


def _next_moment(colony: Colony) -> float:
    present = _present(colony)
    count = math.floor(present * _MOMENT) + 1
    while count / _MOMENT <= present:
        count += 1
    return count / _MOMENT


def _refuse_past(colony: Colony, scenario: Scenario, change: Change) -> None:
    """Refuses a change that would have come already if the timeline had had it from the beginning."""
    number, running, path = colony._number, _under_way(colony), f"changes.{change.number}"
    if change.first > colony._count:
        raise scenario.fault(path, f"would come in episode {change.first}, and the last one is {colony._count}")
    if change.first < number or (change.first == number and not running):
        raise scenario.fault(path, f"would have come in episode {change.first}, which is over")
    if change.first == number and change.time <= (present := _present(colony)):
        why = f"{change.time:g} s of this episode is past, expected more than {present:g}"
        raise scenario.fault(f"{path}.time", why)


def _refuse_newcomers(before: Scenario, scenario: Scenario, change: Change) -> None:
    """Refuses what a place must have been made for: agents, edges and goals that the scenario does not speak of."""
    path = f"changes.{change.number}.{change.kind}"
    if change.kind == "add_agent":
        raise scenario.fault(path, "an agent cannot join by hand, it has to stand in the scenario from the beginning")
    if scenario.topology.neighbours != before.topology.neighbours:
        raise scenario.fault(path, "by hand no edge can come that the scenario has not had before")
    if change.kind == "move_goal" and change.node not in before.goals:
        raise scenario.fault(path, "by hand the goal can only move to a node that the scenario's own changes name")


def _refuse_bodies(colony: Colony, scenario: Scenario, change: Change) -> None:
    """Refuses bodies that come or go on backends that build them all before: one more would change what was before."""
    if replays(colony._body) and change.kind not in ANYWHERE:
        why = f"backend {colony._body.name!r} builds all bodies from the beginning: by hand none can come or go"
        raise scenario.fault(f"changes.{change.number}.{change.kind}", f"{why}, expected {', '.join(ANYWHERE)}")
