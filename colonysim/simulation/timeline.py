"""The timeline of a scenario under way: each change happens when its time has come and what it waits for is so."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

import simpy

from colonysim.simulation.alarms import Alarm
from colonysim.simulation.order import CHANGE_STEP, CHANGES, LAST
from colonysim.states import LARGEST
from colonysim.world.changing import make, possible
from colonysim.world.state import AgentStatus

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.backends.protocol import Backend
    from colonysim.scenario.changes import Change
    from colonysim.simulation.episode import Episode
    from colonysim.states import State, Stored

__all__ = ["Timeline"]

_OF_PLACE = ("add_edge", "remove_edge", "set_surface", "add_box", "remove_box", "move_goal")
"""Kinds of changes that happen before a backend builds the place, if they happen at the very start of an episode."""


class _Due(Alarm):
    """A change whose time comes."""

    def __init__(self, first_env: simpy.Environment, timeline: Timeline, change: Change) -> None:
        super().__init__(first_env)
        self._timeline, self.change = timeline, change

    def come(self, event: simpy.Event) -> None:
        """The time has come."""
        self._timeline.come(self, self.due)


class Timeline:
    """Makes the changes of a scenario happen, each at most once an episode.

    What cannot be yet waits: a box appears on a node once no agent is there, one that is held disappears when it is let
    go of, an agent joins once its node is free, and a condition is looked at after whatever may have made it true.

    Args:
        episode: The episode under way, with its world, fields and rows.
        backend: What moves the agents; told of what has changed if it wants to know.

    Attributes:
        armed: How many changes have a time that will come.
        waiting: Changes whose time has come and that wait for something else.
        tunings: Changes of policies' parameters that have come, and that the colony has not put into effect yet.
    """

    def __init__(self, episode: Episode, backend: Backend) -> None:
        self._episode, self._world, self._changed = episode, episode.world, getattr(backend, "changed", None)
        self._starters = len(episode.world.scenario.agents_at_start)
        first_env = simpy.Environment()
        self._alarms = [_Due(first_env, self, change) for change in episode.world.scenario.changes]
        first_env.run()
        self._moves_goal = len(episode.world.scenario.goals) > 1
        self._of_now: list[_Due] = []
        self._joining = frozenset[int]()
        self._begun: list[tuple[Change, int]] = []
        self.armed, self.waiting = 0, list[_Due]()
        self.tunings: list[Change] = []

    def prepare(self, number: int) -> None:
        """Lets happen to the place what happens at the very start of an episode; the world has just been reset.

        Args:
            number: The episode's number.
        """
        self.enter(number)
        for alarm in self._of_now:
            change = alarm.change
            at_once = change.time == 0.0 and change.condition is None and change.kind in _OF_PLACE
            if at_once and possible(self._world, change):
                self._begun.append((change, self._make(change)))

    def enter(self, number: int) -> None:
        """Nothing has happened yet in the episode of a number."""
        self.armed = 0
        self.waiting.clear()
        self.tunings.clear()
        self._episode.awaited = False
        self._begun.clear()
        for alarm in self._alarms:
            alarm.reset()
        self._of_now = [alarm for alarm in self._alarms if alarm.change.happens_in(number)]
        self._joining = frozenset(alarm.change.agents[0] for alarm in self._of_now if alarm.change.kind == "add_agent")

    def begin(self) -> None:
        """The episode has begun: what has changed is written down, and the rest gets its time."""
        if self._moves_goal:
            self._tell_goal()
        for change, at in self._begun:
            self._tell(change, at)
        begun = {change.number for change, _ in self._begun}
        for alarm in self._of_now:
            if alarm.change.number not in begun:
                self._arm(alarm, 0.0, alarm.change.time)

    def takes_part(self, agent: int) -> bool:
        """Whether an agent is there when the episode begins or joins later in it."""
        return agent < self._starters or agent in self._joining

    def _arm(self, alarm: _Due, now: float, seconds: float) -> None:
        alarm.arm(self._episode.env, now, seconds, CHANGES + CHANGE_STEP * alarm.change.number)
        self.armed += 1

    def come(self, alarm: _Due, due: float) -> None:
        """The time of a change has come."""
        going_on = self._episode.goes_on(due)  # while a change is to come nothing has stalled
        self.armed -= 1
        if not going_on:
            return
        if not self._ready(alarm.change):
            self.waiting.append(alarm)
            self._episode.awaited = True
            return
        self._episode.last_outcome = due
        at = self._make(alarm.change)
        if self._changed is not None and alarm.change.kind not in ("fail", "policy"):
            self._changed(alarm.change)
        self._tell(alarm.change, at)

    def notice(self) -> bool:
        """Something has happened: what waits for it has its time now. Returns whether there is such a change."""
        ready = [alarm for alarm in self.waiting if self._ready(alarm.change)]
        for alarm in ready:
            self.waiting.remove(alarm)
            self._arm(alarm, self._episode.now, 0.0)
        self._episode.awaited = bool(self.waiting)
        return bool(ready)

    # -- its state -------------------------------------------------------------------------------------------------

    def state(self) -> State:
        """When each change comes, if it does, and which of them wait for something else."""
        return {
            # One that is not scheduled may still have the time that it had in another episode.
            "due": array("d", [alarm.due if alarm.scheduled else 0.0 for alarm in self._alarms]),
            "orders": array("d", [alarm.order for alarm in self._alarms]),
            "waiting": [alarm.change.number for alarm in self.waiting],
        }

    def restore(self, told: Stored, now: float) -> None:
        """Takes over a state, after `enter` and at time 0 of a new environment; nothing is due before `now`."""
        count = len(self._alarms)
        due, orders = told.column("due", "d", count), told.column("orders", "d", count, -1.0, LAST)
        for alarm, at, order in zip(self._alarms, due, orders, strict=True):
            if order >= 0.0:
                if not now <= at <= LARGEST:
                    raise told.fault("due", at, "times that are still to come")
                self._arm(alarm, 0.0, at)
        self.waiting = [self._alarms[number] for number in told.wholes("waiting", None, 0, count - 1)]
        self._episode.awaited = bool(self.waiting)
        for field in self._episode.unmarked:  # whose states are not kept
            field.goal_moved(self._world.goal)

    # -- what can be -------------------------------------------------------------------------------------------------

    def _ready(self, change: Change) -> bool:
        return self._holds(change) and possible(self._world, change)

    def _holds(self, change: Change) -> bool:
        """Whether what a change waits for is so."""
        condition, world = change.condition, self._world
        if condition is None:
            return True
        if condition.what == "filled":
            return world.filled(condition.value)
        if condition.what == "seated":
            return world.seated() >= condition.value
        return sum(status is AgentStatus.GOAL for status in world.agent_status) >= condition.value

    # -- what happens ------------------------------------------------------------------------------------------------

    def _make(self, change: Change) -> int:
        """Lets a change happen to the place; returns the node concerned, or -1."""
        if change.kind in ("add_edge", "remove_edge"):  # until now marks have spread along the edges that were there
            for field in self._episode.marks:
                field.settle()
        return make(self._world, change)

    def _tell(self, change: Change, at: int) -> None:
        """Lets everybody know of a change that has happened to the place, and what it means to agents and marks.

        Args:
            change: The change.
            at: The node concerned, or -1.
        """
        episode, world = self._episode, self._world
        nodes: Sequence[int] = [node for node in (at, change.target) if node >= 0]
        if change.kind == "fail":
            self._fail(change)
            return
        episode.rows.event("change", -1, change.kind, at, change.target, change.box, step=change.number)
        if change.kind == "wipe":
            nodes = change.nodes
            for field in episode.marks:
                if change.fields is None or field.name in change.fields:
                    field.wipe(nodes)
        elif change.kind == "move_goal":
            nodes = range(len(world.topology))
            self._tell_goal()
        elif change.kind == "policy":
            nodes = range(len(world.topology))  # who waits chooses again
            self.tunings.append(change)
            episode.pause_at = 0  # before anything else happens the colony has its agents decide by the new values
        if change.kind == "add_agent":
            episode.join(change.agents[0])
        episode.waiting.wake(nodes)
        self.notice()

    def _tell_goal(self) -> None:
        """Tells all fields where the goal is, also those without marks that groups read which ignore the others."""
        for field in (*self._episode.marks, *self._episode.unmarked):
            field.goal_moved(self._world.goal)

    def _fail(self, change: Change) -> None:
        episode, world = self._episode, self._world
        for agent in change.agents:
            if agent in episode.finished:
                continue
            episode.rows.event("change", agent, "fail", world.agent_node[agent], step=change.number)
            if change.seconds is None:
                episode.lose(agent)
            else:
                episode.stand_still(agent, episode.now + change.seconds)
