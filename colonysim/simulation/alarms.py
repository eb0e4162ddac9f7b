# cython: auto_pickle=False
"""Events of SimPy that are armed again: a new `Timeout` for each step would cost more than the step itself."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

import simpy

from colonysim.simulation.order import LAST
from colonysim.states import LARGEST

if TYPE_CHECKING:
    from collections.abc import Callable

    from colonysim.states import State, Stored

__all__ = ["Alarm", "Timer", "Timers"]

MORE = 16
"""So many timers are made at once."""
_OFF = -1.0
"""The priority of an alarm that is not scheduled."""


class Alarm:
    """An event of SimPy that belongs to somebody and is scheduled anew for whatever happens to it next.

    What happens then is said by derived classes.

    Args:
        first_env: An environment that is run before the alarm is armed: an event that has happened is `ok`, and may be
            scheduled in any other.
    """

    def __init__(self, first_env: simpy.Environment) -> None:
        self._event: simpy.Event = first_env.timeout(0.0)
        self._callbacks: list[Callable[[simpy.Event], None]] = [self.come]
        self._due, self._order = 0.0, _OFF

    def come(self, event: simpy.Event) -> None:
        """SimPy's callback: the event has come."""
        raise NotImplementedError

    def arm(self, env: simpy.Environment, now: float, seconds: float, order: float) -> None:
        """Schedules the event; it must not be scheduled already.

        Args:
            env: The environment.
            now: Its time, which the caller knows; to ask the environment is slow.
            seconds: How much later.
            order: SimPy's priority: its place among the events at that time.
        """
        self._due, self._order = now + seconds, order
        self._event.callbacks = self._callbacks
        env.schedule(self._event, order, seconds)  # type: ignore[arg-type]  # SimPy compares priorities, no more

    def reset(self) -> None:
        """The event is not scheduled: there is a new environment."""
        self._event.callbacks = None  # type: ignore[assignment]  # as SimPy leaves those that have come

    @property
    def scheduled(self) -> bool:
        """Whether the event is still to come."""
        return self._event.callbacks is not None

    @property
    def due(self) -> float:
        """When it comes, or has come last, simulated seconds."""
        return self._due

    @property
    def order(self) -> float:
        """Its priority; below 0 if it is not scheduled."""
        return self._order if self.scheduled else _OFF


class Timer(Alarm):
    """An alarm for a wait that ends at a time of its own, whether or not it has ended before.

    Args:
        first_env: See `Alarm`.
        timers: Those to which it belongs.
    """

    def __init__(self, first_env: simpy.Environment, timers: Timers) -> None:
        super().__init__(first_env)
        self._timers, self.wait = timers, -1

    def come(self, event: simpy.Event) -> None:
        """Its wait expires."""
        self._timers.expire(self, self._due)


class Timers:
    """The timers of an episode; one that has come is used again.

    Args:
        expired: Called with a wait's number and the time when that has come.
    """

    def __init__(self, expired: Callable[[int, float], None]) -> None:
        self._expired = expired
        self._made: list[Timer] = []
        self._idle: list[Timer] = []

    def clear(self) -> None:
        """Nothing is due any more: there is a new environment."""
        self._idle = self._made[:]
        for timer in self._made:
            timer.reset()

    def start(self, env: simpy.Environment, now: float, seconds: float, order: float, wait: int) -> None:
        """Lets a wait of that number expire; see `Alarm.arm`."""
        if not self._idle:
            first_env = simpy.Environment()
            self._idle = [Timer(first_env, self) for _ in range(MORE)]
            self._made += self._idle
            first_env.run()
        timer = self._idle.pop()
        timer.wait = wait
        timer.arm(env, now, seconds, order)

    def expire(self, timer: Timer, now: float) -> None:
        """The time of a timer's wait has come."""
        self._idle.append(timer)
        self._expired(timer.wait, now)

    def state(self) -> State:
        """The timers under way, also of waits that have ended before: the time that comes with them counts too."""
        timers = sorted((timer for timer in self._made if timer.scheduled), key=_place)
        return {
            "due": array("d", [timer.due for timer in timers]),
            "order": array("d", [timer.order for timer in timers]),
            "wait": array("q", [timer.wait for timer in timers]),
        }

    def restore(self, state: Stored, env: simpy.Environment, now: float) -> None:
        """Starts the timers of a state in an environment that has just begun.

        Args:
            state: The state.
            env: The environment, at time 0.
            now: Nothing is due before this.
        """
        due = state.column("due", "d", None, now, LARGEST)
        order, wait = state.column("order", "d", len(due), 0.0, LAST), state.column("wait", "q", len(due), 0)
        for i in range(len(due)):
            self.start(env, 0.0, due[i], order[i], wait[i])


def _place(timer: Timer) -> tuple[float, float]:
    return timer.due, timer.order
