# cython: auto_pickle=False
"""The process that advances a backend with a tick, while an action of that backend is pending."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

    import simpy

    from colonysim.backends.protocol import Backend, Finished
    from colonysim.world.intents import Outcome

__all__ = ["Clock"]


class Clock:
    """Advances a backend tick by tick while one of its actions is pending, and sleeps otherwise.

    Args:
        env: The environment of the episode.
        backend: The backend.
        latest: Returns the time at which the episode ends if nothing happens before, simulated seconds.
        goes_on: Called with the time of each event of the clock's own; returns whether the episode has not ended by
            then.
        ended: Called with an agent and an outcome at the time at which the agent's action has ended.
    """

    def __init__(
        self,
        env: simpy.Environment,
        backend: Backend,
        latest: Callable[[], float],
        goes_on: Callable[[float], bool],
        ended: Callable[[int, Outcome], None],
    ) -> None:
        self._env, self._backend, self._latest, self._goes_on, self._ended = env, backend, latest, goes_on, ended
        self._pending: dict[int, float] = {}
        self._wanted: simpy.Event | None = None

    def expect(self, agent: int, until: float) -> None:
        """Adds the action that an agent has just begun; it should end by the time `until`, simulated seconds."""
        self._pending[agent] = until
        if self._wanted is not None and not self._wanted.triggered:
            self._wanted.succeed()

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

    def run(self, tick: float) -> Generator[simpy.Event, Any, None]:
        """The clock's process.

        Args:
            tick: Duration of one advance, simulated seconds.
        """
        env, pending = self._env, self._pending
        while True:
            if not pending:
                self._wanted = env.event()
                yield self._wanted
                self._wanted = None
            yield env.timeout(tick)
            began = env.now
            if not self._goes_on(began):
                return
            # Nobody looks before the next event, so the ticks up to it need no events of their own. Up to twice the
            # time differences are exact, and what ends after many ticks ends at the same time as after single ones.
            now, finished = self._advance(began, tick, env.peek(), min(2 * began, self._latest()))
            if now > began:
                yield env.timeout(now - began)
                if not self._goes_on(env.now):
                    return
            for agent, outcome in finished:
                if agent in pending:
                    del pending[agent]
                    self._ended(agent, outcome)

    def _advance(self, now: float, tick: float, due: float, last: float) -> tuple[float, Sequence[Finished]]:
        """Advances the backend until an action ends, but not to the time `due` nor beyond `last`.

        Returns:
            The time reached, simulated seconds, and the actions that have ended then.
        """
        advance = self._backend.advance
        finished = advance(now)
        while not finished and now + tick < due and now + tick <= last:
            now += tick
            finished = advance(now)
        return now, finished
