"""How far long work has come: a bar in a notebook and on a terminal, a line now and then in a log."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING

from colonysim.characters import visible
from colonysim.errors import ColonysimError
from colonysim.notebook import NotebookBar, in_notebook
from colonysim.terminal import error_console, on_terminal, say

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import TracebackType
    from typing import Self

    from rich.progress import Progress

    from colonysim.trace.reader import Run
    from colonysim.trace.schema import EpisodeResult, Event

__all__ = ["BETWEEN_LINES", "PATIENCE", "Bar", "RunBar", "following", "shows"]

PATIENCE = 2.0
"""Seconds of wall clock before the bar shows."""
BETWEEN_LINES = 10.0
"""Least seconds of wall clock between two lines where there is no bar; more once that is under a tenth of the time."""
_PAUSE = 0.1
FIRST_EPISODES = 100
"""So many episodes of a run have a line each in a log; of those that come after, one now and then has."""


def shows(progress: bool | None) -> bool:
    """Whether progress is shown: as it was asked for, by default in a notebook only.

    Raises:
        ColonysimError: It is neither true, false nor None.
    """
    if progress is not None and not isinstance(progress, bool):
        raise ColonysimError(f"progress: {progress!r}, expected true, false or None (in a notebook only)")
    return in_notebook() if progress is None else progress


class Bar:
    """A progress bar that appears after two seconds; where it cannot be drawn, a line now and then. Lines go above it.

    Args:
        title: What goes on.
        total: How much there is to do, in whatever unit; 1 for a share.
        quiet: Whether to say nothing at all.

    Example:
        ```python
        with Bar("running", total=30) as bar:
            bar.move(1.5)  # one and a half of thirty done
            bar.line("episode 1: 17 steps")
        ```
    """

    def __init__(self, title: str, total: float, quiet: bool = False) -> None:
        self._title = visible(title)
        self._total = total
        self._quiet = quiet
        self._notebook = NotebookBar() if in_notebook() else None
        self._drawn = self._notebook is not None or on_terminal()
        self._begun = self._moved = time.monotonic()
        self._first: float | None = None
        self._progress: Progress | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._progress is not None:
            self._progress.stop()
        elif self._notebook is not None and self._notebook.shown and kind is None:  # there the bar stays
            self._draw(1.0, _clock(time.monotonic() - self._begun))

    def line(self, text: str) -> None:
        """A line on standard error, above the bar."""
        if self._quiet:
            return
        if self._progress is None:
            say(text)
        else:
            self._progress.console.print(visible(text), soft_wrap=True)

    def move(self, done: float, total: float | None = None) -> None:
        """Says how much is done, and of how much if that has changed; cheap enough to be called for every event."""
        if total is not None:
            self._total = total
        if self._first is None:
            self._first = done  # what was there before took none of the time
        now = time.monotonic()
        spent = now - self._begun
        if self._quiet or now - self._moved < (_PAUSE if self._drawn else max(BETWEEN_LINES, spent / 10)):
            return
        self._moved = now
        share = min(done / self._total, 1.0) if self._total else 1.0
        clock, gone = _clock(spent), done - self._first
        if gone > 0.001 * self._total:
            clock += f", {_clock(spent * max(self._total - done, 0.0) / gone)} left"
        if not self._drawn:
            count = f"{int(done)} of {self._total:g}, " if self._total > 1 else ""
            say(f"{self._title}: {count}{share:.0%}, {clock}")
        elif spent >= PATIENCE:
            self._draw(share, clock)

    def _draw(self, share: float, clock: str) -> None:
        if self._notebook is not None:
            self._notebook.show(self._title, share, clock)
            return
        if self._progress is None:
            from rich.progress import BarColumn, Progress, TextColumn

            self._progress = Progress(
                TextColumn("{task.description}", markup=False), BarColumn(),
                TextColumn("{task.percentage:>3.0f} %"), TextColumn("{task.fields[clock]}"),
                console=error_console(), transient=True,
            )  # fmt: skip
            self._progress.add_task(self._title, total=1.0, clock="")
            self._progress.start()
        self._progress.update(self._progress.task_ids[0], completed=share, clock=clock)


class RunBar(Bar):
    """A bar that follows a run: is called with each event, and the run with the episodes so far.

    Args:
        title: What runs.
        episodes: How many there will be.
        max_steps: Steps that are expected of the first one; of others as many as the one before had.
        quiet: Whether to say nothing at all.
        told: Puts an episode that has ended into a line; None for no lines.
    """

    def __init__(
        self,
        title: str,
        episodes: int,
        max_steps: int,
        quiet: bool = False,
        told: Callable[[EpisodeResult], str] | None = None,
    ) -> None:
        super().__init__(title, episodes, quiet)
        self._expected, self._step, self._told = max_steps, 0, told
        self._lined = time.monotonic()

    def __call__(self, event: Event, run: Run) -> None:
        """Takes an event."""
        if event.kind == "episode":
            result = run.episodes[-1]
            self._expected, self._step = max(result.steps, 1), 0
            if self._told is not None and (self._drawn or self._is_worth_a_line(len(run.episodes))):
                self.line(self._told(result))
        else:
            self._step = max(self._step, event.step)
        self.move(len(run.episodes) + min(self._step / self._expected, 0.95))


    def _is_worth_a_line(self, episode: int) -> bool:
        """Whether an episode that has ended is told of in a log."""
        now = time.monotonic()
        if episode > FIRST_EPISODES and now - self._lined < max(BETWEEN_LINES, (now - self._begun) / 10):
            return False
        self._lined = now
        return True


@contextmanager
def following(
    run: Run, shown: bool, on_event: Callable[[Event, Run], None] | None
) -> Iterator[Callable[[Event, Run], None] | None]:
    """Shows how far a run has come.

    Args:
        run: The run, before its first event.
        shown: Whether that is wanted.
        on_event: Is called with each event, and the run with the episodes so far.

    Yields:
        What has to be called with them; None for nothing.
    """
    if not shown:
        yield on_event
        return
    told = run.manifest
    with RunBar(f"{told['name']} on {told['backend']}", told["episodes"], run.scenario.max_steps) as bar:

        def both(event: Event, run: Run) -> None:
            bar(event, run)
            if on_event is not None:
                on_event(event, run)

        yield both


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}"
