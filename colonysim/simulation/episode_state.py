"""An episode under way as plain data, and one that goes on from it."""

from __future__ import annotations

import time
from array import array
from itertools import chain
from typing import TYPE_CHECKING, Any

from colonysim.simulation.episode import DOING
from colonysim.simulation.order import LAST
from colonysim.states import LARGEST, MOST, Stored
from colonysim.world.plain import STATUSES, move_of, move_state, outcome_of, outcome_state

if TYPE_CHECKING:
    from colonysim.randomness import Streams
    from colonysim.simulation.episode import Episode
    from colonysim.states import State

__all__ = ["episode_state", "restore_episode", "resume_streams"]

_, ACTING, STANDING = DOING
GENERATOR, WORDS = 3, 625
"""Version of the states of Python's generators, and how many numbers one holds."""
_COLUMNS = {
    "steps": ("q", 0), "since": ("d", -1.0), "short_waits": ("i", 0), "spins": ("i", 0), "target": ("i", -1),
    "box": ("i", -1), "hole": ("i", -1), "ends_at": ("i", -1), "asks": ("i", -1), "began": ("d", 0.0),
    "still_until": ("d", 0.0), "leaves": ("d", 0.0),
}  # fmt: skip
"""What an episode has one number of for each agent: its type and its least value."""


def episode_state(episode: Episode) -> State:
    """All that the episode is between two events, besides world, fields, backend and what the agents remember."""
    views, alarms = episode.views, episode.processes
    generators = [stream.generator.getstate() for stream in episode.random]
    state: State = {name: array(kind, bytes(getattr(episode, name))) for name, (kind, _) in _COLUMNS.items()}
    return state | {
        "now": episode.now, "due": episode.due, "last_outcome": episode.last_outcome, "stuck": episode.stuck,
        "over": episode.over,
        "wall": time.perf_counter() - episode.wall, "stepped": episode.stepped,
        "doing": bytes(episode.doing), "expires": bytes(episode.expires),
        "outcomes": [outcome_state(outcome) for outcome in episode.outcomes],
        "finished": sorted(episode.finished), "short": sorted(episode.short),
        "asked": episode.asked,
        "waited": array("d", [view.waited for view in views]), "failures": [view.failures for view in views],
        "refused": [move_state(view.refused) for view in views], "last": [view.outcome for view in views],
        "alarms": array("d", [alarm.due if alarm.scheduled else 0.0 for alarm in alarms]),
        "orders": array("d", [alarm.order for alarm in alarms]),
        "ticks": episode.ticks.state(), "timers": episode.timers.state(), "clock": episode.clock.state(),
        "waiting": episode.waiting.state(),
        "faults": None if episode.faults is None else episode.faults.state(),
        "timeline": episode.timeline.state(), "ties": episode.ties.numbers(),
        "generators": array("I", chain.from_iterable(words for _, words, _ in generators)),
        "gauss": [gauss for _, _, gauss in generators],
    }  # fmt: skip


def restore_episode(
    episode: Episode,
    state: State,
    number: int,
    memories: list[Any],
    streams: Streams,
    *,
    synchronous: bool,
    under_way: bool,
) -> None:
    """Takes over the state of an episode; of one that is over, moves that its end has cut off stay so.

    World, fields and backend are in their states already, and the backend has been reset with the same streams;
    the other arguments are those of `begin`.

    Raises:
        ColonysimError: It is no such state.
    """
    told, world, agents = Stored(state, "episode"), episode.world, len(episode.views)
    nodes, boxes, holes = len(world.topology), len(world.box_node), len(world.hole_node)
    episode.timeline.enter(number)
    episode.prepare(number, memories, streams, synchronous)
    episode.now, episode.due = told.real("now", 0.0, LARGEST), told.real("due", 0.0)
    episode.last_outcome, episode.stuck, episode.over = (
        told.real("last_outcome", 0.0),
        told.flag("stuck"),
        told.flag("over"),
    )
    episode.wall, episode.stepped = time.perf_counter() - told.real("wall", 0.0), told.whole("stepped")
    episode.pause_at = min(MOST, episode.stepped + episode.slice)
    most = {"target": nodes, "ends_at": nodes, "asks": nodes, "box": boxes, "hole": holes}
    columns = {n: told.column(n, k, agents, least, most.get(n, MOST) - 1) for n, (k, least) in _COLUMNS.items()}
    doing, expires = told.octets("doing", agents, STANDING), told.octets("expires", agents, 1)
    outcomes = [outcome_of(each, world, "an outcome") for each in told.listed("outcomes", agents)]
    episode.finished = set(told.wholes("finished", None, 0, agents - 1))
    episode.short = set(told.wholes("short", None, 0, agents - 1))
    episode.asked = told.whole("asked", -1, agents - 1)
    episode.ticks.restore(told.part("ticks"))
    if episode.asked >= 0 and not episode.outside:
        raise told.fault("asked", episode.asked, "an agent whose decisions come from outside")
    waited, failures = told.column("waited", "d", agents, 0.0, LARGEST), told.wholes("failures", agents, 0, 2**31 - 1)
    refused = [move_of(each, world, "a refused move") for each in told.listed("refused", agents)]
    last = told.listed("last", agents)
    if not all(each == "" or each in STATUSES for each in last):
        raise told.fault("last", last, f"one of {', '.join(STATUSES)}, or nothing")
    if episode.faults is not None:
        episode.faults.restore(told.part("faults"))
    for agent, view in enumerate(episode.views):
        view.waited, view.failures, view.refused = waited[agent], failures[agent], refused[agent]
        view.outcome, view.steps = last[agent], columns["steps"][agent]
        view.look()
    episode.waiting.restore(told.part("waiting"))
    episode.clock.restore(told.part("clock"), world, episode.now)
    episode.timers.restore(told.part("timers"), episode.env, episode.now)
    episode.timeline.restore(told.part("timeline"), episode.now)
    _restore_alarms(episode, told)
    resume_streams(episode, told)
    for name, column in columns.items():
        for agent in range(agents):
            getattr(episode, name)[agent] = column[agent]
    for agent in range(agents):
        episode.doing[agent], episode.expires[agent], episode.outcomes[agent] = (
            doing[agent],
            expires[agent],
            outcomes[agent],
        )
    acts = [agent for agent in range(agents) if doing[agent] == ACTING] if under_way else []
    moving = [agent for agent, moves, _ in episode.ticks.turns if moves]
    if any(episode.target[agent] < 0 for agent in (*acts, *moving)):
        raise told.fault("target", columns["target"], "a node for each agent that acts")
    timed = [agent for agent in acts if not episode.clock.expects(agent)]
    if any(outcomes[agent] is None and episode.ends_at[agent] < 0 for agent in timed):
        raise told.fault("ends_at", columns["ends_at"], "a node for each agent that acts")
    if any(not episode.processes[agent].scheduled for agent in timed):
        raise told.fault("doing", list(doing), "an alarm, or the clock, for each agent that acts")
    episode.timed, episode.acting = sum(expires), len(timed)
    episode.standing = sum(each == STANDING for each in doing)
    if episode.asked >= 0 and episode.now > 0.0:
        episode.env.run(until=episode.now)  # whatever is due now comes after; the answer counts its times from here


def _restore_alarms(episode: Episode, told: Stored) -> None:
    """Schedules the agents' alarms in the new environment."""
    agents = len(episode.processes)
    due, orders = told.column("alarms", "d", agents), told.column("orders", "d", agents, -1.0, LAST)
    for alarm, at, order in zip(episode.processes, due, orders, strict=True):
        if order >= 0.0:
            if not episode.now <= at <= LARGEST:
                raise told.fault("alarms", at, "times that are still to come")
            alarm.arm(episode.env, 0.0, at, order)
    episode.armed = sum(order >= 0.0 for order in orders)


def resume_streams(episode: Episode, told: Stored) -> None:
    """Puts the random streams to where they had come to."""
    agents = len(episode.views)
    episode.ties.resume(told.column("ties", "Q", agents, 0, 2**64 - 1))
    words, gauss = told.column("generators", "I", agents * WORDS, 0), told.listed("gauss", agents)
    for agent, stream in enumerate(episode.random):
        own = tuple(words[agent * WORDS : (agent + 1) * WORDS])
        try:
            stream.generator.setstate((GENERATOR, own, gauss[agent]))
        except (TypeError, ValueError) as error:
            raise told.fault("generators", str(error), "states of Python's generator") from None
