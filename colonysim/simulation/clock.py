# cython: auto_pickle=False
"""The alarm that advances a backend with a tick, while an action of that backend is pending."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

from colonysim.backends.protocol import Finished
from colonysim.simulation.alarms import Alarm
from colonysim.simulation.order import CLOCK
from colonysim.states import LARGEST
from colonysim.world.plain import outcome_of, outcome_state

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import simpy

    from colonysim.backends.protocol import Backend
    from colonysim.states import State, Stored
    from colonysim.world.intents import Outcome
    from colonysim.world.state import World

__all__ = ["Clock"]

_IDLE, _CALLED, _TICKING, _TOLD = 0, 1, 2, 3
"""Phases: nothing is pending; an action has just begun; a tick is under way; the actions that have ended are known and
are told when their time has come."""


class Clock(Alarm):
    """Advances a backend tick by tick while one of its actions is pending, and sleeps otherwise.

    Args:
        first_env: See `Alarm`.
        backend: The backend.
        latest: Returns the time at which the episode ends if nothing happens before, simulated seconds.
        goes_on: Called with the time of each event of the clock's own; returns whether the episode has not ended by
            then.
        ended: Called with an agent and an outcome at the time at which the agent's action has ended.
    """

    def __init__(
        self,
        first_env: simpy.Environment,
        backend: Backend,
        latest: Callable[[], float],
        goes_on: Callable[[float], bool],
        ended: Callable[[int, Outcome], None],
    ) -> None:
        super().__init__(first_env)
        self._backend, self._latest, self._goes_on, self._ended = backend, latest, goes_on, ended
        self._pending: dict[int, float] = {}
        self._finished: Sequence[Finished] = ()
        self._phase, self._tick = _IDLE, 0.0

    def begin(self, env: simpy.Environment, tick: float | None) -> None:
        """Begins an episode, in which nothing is pending yet.

        Args:
            env: Its environment.
            tick: Duration of one advance, simulated seconds; None if the backend has none.
        """
        self._env, self._tick = env, 0.0 if tick is None else tick
        self._pending.clear()
        self._phase, self._finished = _IDLE, ()
        self.reset()

    def expect(self, agent: int, until: float, now: float) -> None:
        """Adds the action that an agent has just begun, now; it should end by the time `until`, simulated seconds."""
        self._pending[agent] = until
        if self._phase == _IDLE:
            self._phase = _CALLED
            self.arm(self._env, now, 0.0, CLOCK)

    def expects(self, agent: int) -> bool:
        """Whether the action of an agent is pending."""
        return agent in self._pending

    @property
    def pending(self) -> bool:
        """Whether any action is pending."""
        return bool(self._pending)

    def until(self) -> float:
        """The time by which all pending actions should have ended, simulated seconds; 0 if there are none."""
        return max(self._pending.values(), default=0.0)

    def cancel(self) -> None:
        """Cancels all pending actions."""
        for agent in self._pending:
            self._backend.cancel(agent)

    def come(self, event: simpy.Event) -> None:
        """The next phase begins."""
        now = self._due
        if self._phase == _CALLED:
            self._begin_tick(now)
            return
        if not self._goes_on(now):
            return
        if self._phase == _TICKING:
            # Nobody looks before the next event, so the ticks up to it need no events of their own. Up to twice the
            # time differences are exact, and what ends after many ticks ends at the same time as after single ones.
            reached, self._finished = self._advance(now, self._env.peek(), min(2 * now, self._latest()))
            if reached > now:
                self._phase = _TOLD
                self.arm(self._env, now, reached - now, CLOCK)
                return
        for agent, outcome in self._finished:
            if agent in self._pending:
                del self._pending[agent]
                self._ended(agent, outcome)
        self._finished = ()
        if self._pending:
            self._begin_tick(now)
        else:
            self._phase = _IDLE

    def state(self) -> State:
        """What is pending, and the phase."""
        return {
            "agents": list(self._pending), "until": array("d", self._pending.values()), "phase": self._phase,
            "due": 0.0 if self._phase == _IDLE else self._due,
            "finished": [[agent, outcome_state(outcome)] for agent, outcome in self._finished],
        }  # fmt: skip

    def restore(self, state: Stored, world: World, now: float) -> None:
        """Takes over a state; to be called after `begin`, and at time 0 of its environment.

        Args:
            state: The state.
            world: Whose agents act.
            now: Nothing is due before this, simulated seconds.
        """
        most = len(world.agent_node)
        agents = state.wholes("agents", None, 0, most - 1)
        self._pending = dict(zip(agents, state.column("until", "d", len(agents), 0.0, LARGEST), strict=True))
        finished = []
        for each in state.listed("finished"):
            if not isinstance(each, list) or len(each) != 2 or each[0] not in self._pending:
                raise state.fault("finished", each, "agents that act, and outcomes")
            outcome = outcome_of(each[1], world, "an action that has ended")
            if outcome is None:
                raise state.fault("finished", outcome, "an outcome")
            finished.append(Finished(each[0], outcome))
        self._finished, self._phase = finished, state.whole("phase", _IDLE, _TOLD)
        if self._phase != _IDLE:
            self.arm(self._env, 0.0, state.real("due", now, LARGEST), CLOCK)

    def _begin_tick(self, now: float) -> None:
        self._phase = _TICKING
        self.arm(self._env, now, self._tick, CLOCK)

    def _advance(self, now: float, due: float, last: float) -> tuple[float, Sequence[Finished]]:
        """Advances the backend until an action ends, but not to the time `due` nor beyond `last`.

        Returns:
            The time reached, simulated seconds, and the actions that have ended then.
        """
        advance, tick = self._backend.advance, self._tick
        finished = advance(now)
        while not finished and now + tick < due and now + tick <= last:
            now += tick
            finished = advance(now)
        return now, finished
