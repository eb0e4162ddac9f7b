"""Work in processes of their own, so that a task that raises, hangs, dies or eats memory takes no other with it.

Each worker has a pipe to itself. The executors of the standard library share queues and locks between workers: one
that is killed at a bad moment breaks the pool, none of them can stop a single task, and their workers outlive a parent
that is killed.
"""

from __future__ import annotations

import gc
import multiprocessing
import multiprocessing.process
import os
import signal
import sys
import threading
import time
import traceback
from collections import deque
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from multiprocessing.connection import wait
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeVar

from colonysim.errors import ColonysimError

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Iterable, Iterator
    from multiprocessing.connection import Connection

__all__ = ["DEATHS", "Report", "attempt", "limit_memory", "refuse_rerun", "refuse_unguarded", "results", "run_tasks"]

Task = TypeVar("Task")

DEATHS = 3
"""A task whose process dies so often has failed; the first times it is begun again, after all others."""
_LONGEST_WAIT = 1.0
_NAME = "colonysim worker"
_UNGUARDED = 79
"""Exit code of a worker that met the call that had started it: the main script ran once more."""
_GUARD = (
    "work is done in processes of their own, and each of them imports the main script anew: put what the script does "
    'below `if __name__ == "__main__":`'
)
_numbers = count(1)


@dataclass(frozen=True)
class Report(Generic[Task]):
    """What came of a task.

    Attributes:
        task: Which one.
        status: "running" when it begins, "succeeded" or "failed" in the end.
        result: What the function returned, if it succeeded.
        error: The traceback or the reason, if it failed.
        seconds: Of wall clock.
    """

    task: Task
    status: Literal["running", "succeeded", "failed"]
    result: Any = None
    error: str = ""
    seconds: float = 0.0


def refuse_unguarded() -> None:
    """Called before anything is recorded by what starts processes.

    Raises:
        ColonysimError: Processes cannot be started from this script, or this is one of them and runs it once more.
        SystemExit: The same in a worker of ours; its parent raises the error.
    """
    refuse_rerun()
    main = sys.modules.get("__main__")
    path = getattr(main, "__file__", None)
    if getattr(main, "__spec__", None) is not None or path is None:
        return
    # A new process imports the main script from its file, which standard input is not.
    folder = multiprocessing.process.ORIGINAL_DIR or ""  # type: ignore[attr-defined]
    if not (Path(folder) / path).exists():
        raise ColonysimError(f"the script {path} is no file: save it as one; {_GUARD}")


def refuse_rerun() -> None:
    """Called before anything is recorded: a script must not do it once more in a process that only imports it.

    Raises:
        ColonysimError: This process imports the main script.
        SystemExit: The same in a worker of ours; its parent raises the error.
    """
    current = multiprocessing.current_process()
    if getattr(current, "_inheriting", False):  # the main script is being imported
        if current.name.startswith(_NAME):
            raise SystemExit(_UNGUARDED)
        raise ColonysimError(_GUARD)


def run_tasks(
    function: Callable[[Task], Any],
    tasks: Iterable[Task],
    *,
    workers: int,
    seconds: float | None = None,
    memory_mb: float | None = None,
    fresh: bool = False,
) -> Generator[Report[Task], None, None]:
    """Calls a function for each task in processes on this machine; yields the beginning and the end of each.

    The processes end with this one, however it ends.

    Args:
        function: Importable by name, as its tasks and results can be pickled.
        tasks: In the order in which they are begun.
        workers: How many run at a time.
        seconds: How long a task may take, of wall clock; beyond that it has failed. None: no limit.
        memory_mb: How much data its process may hold, where the system can limit that. None: no limit.
        fresh: Whether each task has a process to itself.

    Raises:
        ColonysimError: Processes cannot be started, most likely for want of `if __name__ == "__main__":`.
    """
    refuse_unguarded()
    waiting = deque(enumerate(tasks))
    deaths: dict[int, int] = {}
    stillborn = 0
    pool: list[_Worker[Task]] = []
    try:
        while waiting or pool:
            wanted = min(workers, len(waiting) + sum(worker.number is not None for worker in pool))
            while len(pool) < wanted:
                pool.append(_Worker(function, seconds, memory_mb))
            for worker in pool:
                if worker.idle and waiting:
                    yield worker.begin(*waiting.popleft())
            for worker in [worker for worker in pool if worker.number is None and not waiting]:
                worker.end()
                pool.remove(worker)
            patience = min((worker.left() for worker in pool), default=0.0)
            ready = set(wait([worker.pipe for worker in pool], min(patience, _LONGEST_WAIT)))
            for worker in list(pool):
                report = worker.report(worker.pipe in ready)
                stillborn = 0 if worker.ready else stillborn
                if report is not None:
                    yield report
                    if fresh and worker.alive:
                        worker.end()
                if worker.alive:
                    continue
                pool.remove(worker)
                if worker.number is not None:
                    deaths[worker.number] = deaths.get(worker.number, 0) + 1
                    if deaths[worker.number] < DEATHS:
                        waiting.append((worker.number, worker.task))
                    else:
                        error = f"its process died {DEATHS} times ({worker.how()})"
                        yield Report(worker.task, "failed", error=error, seconds=worker.seconds())
                elif not worker.ready:
                    stillborn += 1
                    if not worker.was_killed or stillborn == DEATHS:
                        raise _no_start(worker)
    finally:
        for worker in pool:
            worker.kill()


def results(
    function: Callable[[Task], Any], tasks: Iterable[Task], workers: int, *, fresh: bool = False
) -> Iterator[tuple[Task, Any]]:
    """Tasks with what the function returned, as they end; all of them have to succeed.

    Raises:
        RuntimeError: One has failed; it holds the traceback.
    """
    reports = run_tasks(function, tasks, workers=workers, fresh=fresh)
    try:
        for report in reports:
            if report.status == "failed":
                raise RuntimeError(f"{report.task}: {report.error}")
            if report.status == "succeeded":
                yield report.task, report.result
    finally:
        reports.close()


def _no_start(worker: _Worker[Task]) -> ColonysimError:
    if worker.process.exitcode == _UNGUARDED:
        return ColonysimError(_GUARD)
    return ColonysimError(f"a process for the work ended while it started ({worker.how()}); {_GUARD}")


class _Worker(Generic[Task]):
    """A process that does one task after the other.

    Attributes:
        ready: Whether it has started.
        number: Number of the task that it is at work on, or None.
        alive: False once it is gone.
    """

    task: Task

    def __init__(self, function: Callable[[Task], Any], seconds: float | None, memory_mb: float | None) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        in_main = threading.current_thread() is threading.main_thread()
        self.process = context.Process(
            target=_work, args=(theirs, function, memory_mb, in_main), daemon=True, name=f"{_NAME} {next(_numbers)}"
        )
        self.process.start()
        theirs.close()
        self.limit = seconds
        self.ready = False
        self.number: int | None = None
        self.alive = True
        self._began = time.monotonic()

    @property
    def idle(self) -> bool:
        """Whether it has started and waits for a task."""
        return self.ready and self.number is None and self.alive

    @property
    def was_killed(self) -> bool:
        """Whether a signal has ended it."""
        return (self.process.exitcode or 0) < 0

    def how(self) -> str:
        """How its process ended."""
        code = self.process.exitcode or 0
        return f"signal {-code}" if code < 0 else f"exit code {code}"

    def begin(self, number: int, task: Task) -> Report[Task]:
        self.number, self.task, self._began = number, task, time.monotonic()
        with suppress(OSError):  # it may have died; its pipe will say so
            self.pipe.send(task)
        return Report(task, "running")

    def seconds(self) -> float:
        return time.monotonic() - self._began

    def left(self) -> float:
        """Seconds until its task has taken too long."""
        return _LONGEST_WAIT if self.limit is None or self.number is None else max(0.0, self.limit - self.seconds())

    def report(self, has_word: bool) -> Report[Task] | None:
        """The end of its task, if that has come; a worker found dead is marked so."""
        if has_word:
            try:
                word, value = self.pipe.recv()
            except (EOFError, OSError):
                # Its pipe is closed a moment before it is gone; only then there is an exit code.
                self.process.join(1.0)
                self.kill()
                return None
            if word == "ready":
                self.ready = True
                return None
            self.number = None
            if word == "succeeded":
                return Report(self.task, "succeeded", value, seconds=self.seconds())
            return Report(self.task, "failed", error=value, seconds=self.seconds())
        if self.number is not None and self.limit is not None and self.seconds() > self.limit:
            self.number = None
            self.kill()
            return Report(self.task, "failed", error=f"took longer than {self.limit:g} s", seconds=self.seconds())
        return None

    def end(self) -> None:
        """Lets a worker go that has nothing to do."""
        self.pipe.close()
        if self.ready:
            self.process.join(5.0)
        self.kill()

    def kill(self) -> None:
        self.alive = False
        self.process.kill()
        self.process.join()
        self.pipe.close()


def _work(pipe: Connection, function: Callable[[Any], Any], memory_mb: float | None, in_main: bool) -> None:
    # Ctrl-C goes to the whole group; the parent decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _end_with_parent(in_main)
    limit_memory(memory_mb)
    try:
        pipe.send(("ready", None))
        while True:
            outcome = attempt(function, pipe.recv(), memory_mb)
            if outcome[0] == "failed":
                # What a failed task held refers to itself in circles, and would count as the next task's.
                gc.collect()
            pipe.send(outcome)
    except (EOFError, OSError):
        pass  # the parent is gone, or done


def _end_with_parent(in_main: bool) -> None:
    """Ends this process when its parent is gone, whatever it is doing then.

    Args:
        in_main: Whether the parent's main thread has started it.
    """
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    if sys.platform == "linux" and in_main:
        # The thread below needs the interpreter's lock, which a task may keep for good. The system's own signal does
        # not, but it comes at the end of the thread that started this process: of the main thread's only.
        import ctypes

        set_death_signal = 1
        ctypes.CDLL(None).prctl(set_death_signal, int(signal.SIGKILL))
    threading.Thread(target=watch, name="colonysim parent", daemon=True).start()


def limit_memory(memory_mb: float | None) -> None:
    """Limits the data of this process, where the system can."""
    if memory_mb is not None and sys.platform != "win32":
        import resource

        most = int(memory_mb * 1e6)
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))


def attempt(function: Callable[[Task], Any], task: Task, memory_mb: float | None) -> tuple[str, Any]:
    """Calls a function in this process: "succeeded" and its result, or "failed" and why."""
    try:
        return "succeeded", function(task)
    except MemoryError:
        return "failed", f"took more than {memory_mb:g} MB" if memory_mb else traceback.format_exc()
    except BaseException:  # a task that raises SystemExit or KeyboardInterrupt means itself, not its process
        return "failed", traceback.format_exc()
