"""A backend with a clock of its own: advanced tick by tick while anybody is doing something, and not otherwise."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

    import simpy

    from colonysim.backends.protocol import Backend, Finished
    from colonysim.world.intents import Outcome

__all__ = ["Clock"]


class Clock:
    """Advances a backend while one of its actions is pending; sleeps otherwise.

    Args:
        env: The environment of the episode.
        backend: The backend.
        latest: Asked when the episode ends if nothing happens before.
        ended: Called with an agent and an outcome, at the time at which the agent's action has ended.
    """

    def __init__(
        self,
        env: simpy.Environment,
        backend: Backend,
        latest: Callable[[], float],
        ended: Callable[[int, Outcome], None],
    ) -> None:
        self._env, self._backend, self._latest, self._ended = env, backend, latest, ended
        self._pending: dict[int, float] = {}
        self._wanted: simpy.Event | None = None

    def expect(self, agent: int, until: float) -> None:
        """Goes on until the action ends that an agent has just begun; by the time `until` it should have."""
        self._pending[agent] = until
        if self._wanted is not None and not self._wanted.triggered:
            self._wanted.succeed()

    @property
    def pending(self) -> bool:
        """Whether an action has not ended."""
        return bool(self._pending)

    def until(self) -> float:
        """The time by which all that is pending should have ended; 0 if nothing is."""
        return max(self._pending.values(), default=0.0)

    def cancel(self) -> None:
        """Stops whoever is doing something."""
        for agent in self._pending:
            self._backend.cancel(agent)

    def run(self, tick: float) -> Generator[simpy.Event, Any, None]:
        """The clock's process.

        Args:
            tick: Simulated seconds of one advance.
        """
        env, pending = self._env, self._pending
        while True:
            if not pending:
                self._wanted = env.event()
                yield self._wanted
                self._wanted = None
            yield env.timeout(tick)
            began = env.now
            # Nobody looks before the next event, so the ticks up to it need no events of their own. Up to twice the
            # time differences are exact, and what ends after many ticks ends at the same time as after single ones.
            now, finished = self._advance(began, tick, env.peek(), min(2 * began, self._latest()))
            if now > began:
                yield env.timeout(now - began)
            for agent, outcome in finished:
                if agent in pending:
                    del pending[agent]
                    self._ended(agent, outcome)

    def _advance(self, now: float, tick: float, due: float, last: float) -> tuple[float, Sequence[Finished]]:
        """Advances the backend, before `due` and up to `last`, until an action ends; returns when, and what did."""
        advance = self._backend.advance
        finished = advance(now)
        while not finished and now + tick < due and now + tick <= last:
            now += tick
            finished = advance(now)
        return now, finished
