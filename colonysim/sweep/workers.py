"""Trials in processes of their own, so that one that raises, hangs, dies or eats memory takes no other with it.

Each worker has a pipe to itself. The executors of the standard library share queues and locks between workers: one
that is killed at a bad moment breaks the pool, and none of them can stop a single task.
"""

from __future__ import annotations

import multiprocessing
import signal
import sys
import time
import traceback
from collections import deque
from dataclasses import dataclass
from multiprocessing.connection import wait
from typing import TYPE_CHECKING, Any, Literal

from colonysim.sweep.trial import run_trial

if TYPE_CHECKING:
    from collections.abc import Generator, Iterable
    from multiprocessing.connection import Connection

    from colonysim.sweep.plan import Limits, Trial

__all__ = ["DEATHS", "Outcome", "attempt", "limit_memory", "run_locally"]

DEATHS = 3
"""A trial whose process dies so often has failed; the first times it is begun again, after all others."""
_LONGEST_WAIT = 1.0


@dataclass(frozen=True)
class Outcome:
    """What came of a trial.

    Attributes:
        trial: Which one.
        status: "running" when it begins, "succeeded", "failed" or "interrupted" in the end.
        result: What `run_trial` returned, if it succeeded.
        error: The traceback or the reason, if it failed.
        seconds: Of wall clock.
    """

    trial: Trial
    status: Literal["running", "succeeded", "failed", "interrupted"]
    result: dict[str, Any] | None = None
    error: str = ""
    seconds: float = 0.0


def run_locally(trials: Iterable[Trial], limits: Limits, workers: int) -> Generator[Outcome, None, None]:
    """Runs trials in processes on this machine; yields the beginning and the end of each as they come.

    Args:
        trials: In the order in which they are begun.
        limits: What each may take.
        workers: How many run at a time.
    """
    waiting = deque(trials)
    deaths: dict[str, int] = {}
    pool: list[_Worker] = []
    try:
        while waiting or pool:
            while waiting and len(pool) < workers:
                pool.append(_Worker(limits))
            for worker in pool:
                if worker.trial is None and waiting:
                    worker.begin(waiting.popleft())
                    yield Outcome(worker.task, "running")
            idle = [worker for worker in pool if worker.trial is None]
            for worker in idle:
                worker.end()
                pool.remove(worker)
            patience = min((worker.left() for worker in pool), default=0.0)
            ready = set(wait([worker.pipe for worker in pool], min(patience, _LONGEST_WAIT)))
            for worker in list(pool):
                outcome = worker.outcome(worker.pipe in ready)
                if outcome is not None:
                    yield outcome
                if not worker.alive:
                    pool.remove(worker)
                    if worker.trial is not None:
                        yield from _bury(worker, deaths, waiting)
    finally:
        for worker in pool:
            worker.kill()


def _bury(worker: _Worker, deaths: dict[str, int], waiting: deque[Trial]) -> Generator[Outcome, None, None]:
    trial = worker.task
    deaths[trial.identity] = deaths.get(trial.identity, 0) + 1
    if deaths[trial.identity] < DEATHS:
        waiting.append(trial)
    else:
        code = worker.process.exitcode or 0
        how = f"signal {-code}" if code < 0 else f"exit code {code}"
        yield Outcome(trial, "failed", error=f"its process died {DEATHS} times ({how})", seconds=worker.seconds())


class _Worker:
    """A process that runs one trial after the other.

    Attributes:
        trial: What it is at work on, or None.
        alive: False once it is gone.
    """

    def __init__(self, limits: Limits) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=_work, args=(theirs, limits.memory_mb), daemon=True)
        self.process.start()
        theirs.close()
        self.limit = limits.seconds
        self.trial: Trial | None = None
        self.alive = True
        self._ready = False
        self._began = time.monotonic()

    @property
    def task(self) -> Trial:
        """The trial it is at work on."""
        assert self.trial is not None
        return self.trial

    def begin(self, trial: Trial) -> None:
        self.trial, self._began = trial, time.monotonic()
        try:
            self.pipe.send(trial)
        except OSError:
            self.alive = False

    def seconds(self) -> float:
        return time.monotonic() - self._began

    def left(self) -> float:
        """Seconds until it has taken too long; its own start is not counted."""
        return _LONGEST_WAIT if self.limit is None or not self._ready else max(0.0, self.limit - self.seconds())

    def outcome(self, has_word: bool) -> Outcome | None:
        """The end of its trial, if that has come; a worker found dead is marked so."""
        if has_word:
            try:
                word, value = self.pipe.recv()
            except (EOFError, OSError):
                self.kill()
                return None
            if word == "ready":
                self._ready, self._began = True, time.monotonic()
                return None
            trial, self.trial = self.task, None
            if word == "succeeded":
                return Outcome(trial, "succeeded", value, seconds=self.seconds())
            return Outcome(trial, "failed", error=value, seconds=self.seconds())
        if self.trial is not None and self._ready and self.limit is not None and self.seconds() > self.limit:
            trial, self.trial = self.trial, None
            self.kill()
            return Outcome(trial, "failed", error=f"took longer than {self.limit:g} s", seconds=self.seconds())
        return None

    def end(self) -> None:
        """Lets an idle worker go."""
        self.pipe.close()
        self.process.join(5.0)
        self.kill()

    def kill(self) -> None:
        self.alive = False
        self.process.kill()
        self.process.join()
        self.pipe.close()


def _work(pipe: Connection, memory_mb: float | None) -> None:
    # Ctrl-C goes to the whole group; the parent decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    limit_memory(memory_mb)
    try:
        pipe.send(("ready", None))
        while True:
            pipe.send(attempt(pipe.recv(), memory_mb))
    except (EOFError, OSError):
        pass  # the parent is gone, or done


def limit_memory(memory_mb: float | None) -> None:
    """Limits the data of this process, where the system can."""
    if memory_mb is not None and sys.platform != "win32":
        import resource

        most = int(memory_mb * 1e6)
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))


def attempt(trial: Trial, memory_mb: float | None) -> tuple[str, Any]:
    """Runs a trial in this process: "succeeded" and its result, or "failed" and why."""
    try:
        return "succeeded", run_trial(trial)
    except MemoryError:
        return "failed", f"took more than {memory_mb:g} MB" if memory_mb else traceback.format_exc()
    except Exception:
        return "failed", traceback.format_exc()
