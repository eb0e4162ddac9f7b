"""Trials on a Ray cluster: the same trial function, limits and outcomes as in processes of this machine."""

from __future__ import annotations

import time
from collections import deque
from typing import TYPE_CHECKING, Any

from colonysim.errors import MissingExtraError
from colonysim.installing import install_command
from colonysim.processes import DEATHS, attempt, limit_memory
from colonysim.sweep.trial import run_trial
from colonysim.sweep.workers import Outcome

if TYPE_CHECKING:
    from collections.abc import Generator, Iterable

    from colonysim.sweep.plan import Limits, Trial

__all__ = ["run_on_ray"]

_LONGEST_WAIT = 1.0
_UNREADY = 120.0
"""Seconds after which an actor that has not started is given up, as when its node went away at that moment."""


class _Worker:
    """What runs on the cluster: an actor with a process to itself."""

    def __init__(self, memory_mb: float | None) -> None:
        limit_memory(memory_mb)
        self._memory_mb = memory_mb

    def ready(self) -> None:
        """Answers once the process has started."""

    def run(self, trial: Trial) -> tuple[str, Any]:
        """Runs a trial."""
        return attempt(run_trial, trial, self._memory_mb)


def run_on_ray(trials: Iterable[Trial], limits: Limits, workers: int | None) -> Generator[Outcome, None, None]:
    """Runs trials on the cluster that `RAY_ADDRESS` names, or on one that is started here; as `run_locally` else.

    A trial whose node goes away is begun again on another; nodes may come and go meanwhile. Scenario files must be at
    the same path on all nodes.

    Args:
        trials: In the order in which they are begun.
        limits: What each may take.
        workers: How many run at a time; None: one for each processor of the cluster, as it is at the moment.

    Raises:
        MissingExtraError: Ray is not installed.
    """
    try:
        import ray
    except ImportError as error:
        raise MissingExtraError(f"the engine 'ray' needs Ray ({error}): {install_command('ray')}") from error
    ours = not ray.is_initialized()
    if ours:
        ray.init(log_to_driver=False, configure_logging=False, include_dashboard=False)
    waiting = deque(trials)
    deaths: dict[str, int] = {}
    pool: list[_Slot] = []
    try:
        while waiting or pool:
            count = workers or max(1, int(ray.cluster_resources().get("CPU", 1)))
            while len(pool) < count and sum(slot.trial is None for slot in pool) < len(waiting):
                pool.append(_Slot(limits))
            for slot in pool:
                if slot.idle and waiting:
                    yield slot.begin(waiting.popleft())
            for slot in [slot for slot in pool if slot.idle]:
                slot.kill()
                pool.remove(slot)
            if not pool:
                continue
            done, _ = ray.wait([slot.reference for slot in pool], timeout=min(slot.left() for slot in pool))
            for slot in list(pool):
                outcome = slot.outcome(slot.reference in done)
                if outcome is not None:
                    yield outcome
                if not slot.alive:
                    pool.remove(slot)
                    if slot.trial is not None:
                        yield from _bury(slot, slot.trial, deaths, waiting)
    finally:
        for slot in pool:
            slot.kill()
        if ours:
            ray.shutdown()


def _bury(slot: _Slot, trial: Trial, deaths: dict[str, int], waiting: deque[Trial]) -> Generator[Outcome, None, None]:
    deaths[trial.identity] = deaths.get(trial.identity, 0) + 1
    if deaths[trial.identity] < DEATHS:
        waiting.append(trial)
    else:
        yield Outcome(trial, "failed", error=f"its process died {DEATHS} times", seconds=slot.seconds())


class _Slot:
    """An actor and what it is at work on.

    Attributes:
        reference: Of the answer that is waited for.
        trial: What it is at work on, or None.
        idle: Whether it has started and waits for a trial.
        alive: False once it is gone.
    """

    def __init__(self, limits: Limits) -> None:
        import ray

        # Ray keeps the processes of actors to itself: nothing else ever runs under their limits.
        self._actor = ray.remote(num_cpus=1, max_restarts=0)(_Worker).remote(limits.memory_mb)
        self._limit = limits.seconds
        self._began = time.monotonic()
        self.reference = self._actor.ready.remote()
        self.trial: Trial | None = None
        self.idle = False
        self.alive = True

    def begin(self, trial: Trial) -> Outcome:
        self.trial, self.idle, self._began = trial, False, time.monotonic()
        self.reference = self._actor.run.remote(trial)
        return Outcome(trial, "running")

    def seconds(self) -> float:
        return time.monotonic() - self._began

    def left(self) -> float:
        """Seconds that may be waited for it."""
        if self._limit is None or self.trial is None:
            return _LONGEST_WAIT
        return min(_LONGEST_WAIT, max(0.0, self._limit - self.seconds()))

    def outcome(self, has_word: bool) -> Outcome | None:
        """The end of its trial, if that has come; an actor found dead is marked so."""
        import ray

        if has_word:
            try:
                answer = ray.get(self.reference)
            except ray.exceptions.RayError:
                self.kill()
                return None
            trial, self.trial, self.idle = self.trial, None, True
            if trial is None:
                return None  # it has started
            word, value = answer
            if word == "succeeded":
                return Outcome(trial, "succeeded", value, seconds=self.seconds())
            return Outcome(trial, "failed", error=value, seconds=self.seconds())
        if self.trial is None and self.seconds() > _UNREADY:
            self.kill()
        if self.trial is not None and self._limit is not None and self.seconds() > self._limit:
            trial, self.trial = self.trial, None
            self.kill()
            return Outcome(trial, "failed", error=f"took longer than {self._limit:g} s", seconds=self.seconds())
        return None

    def kill(self) -> None:
        import ray

        self.alive = False
        ray.kill(self._actor)
