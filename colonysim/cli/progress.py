"""How far a long command has come: a bar with the time left on a terminal, a line now and then in a log."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from colonysim.characters import visible
from colonysim.cli.console import error_console, on_terminal, say

if TYPE_CHECKING:
    from types import TracebackType

    from rich.progress import Progress

__all__ = ["BETWEEN_LINES", "PATIENCE", "Bar"]

PATIENCE = 2.0
"""Seconds of wall clock before the bar shows."""
BETWEEN_LINES = 10.0
"""Least seconds of wall clock between two lines where there is no bar; more once that is under a tenth of the time."""
_PAUSE = 0.1


class Bar:
    """A progress bar that appears after two seconds; where no terminal is, a line now and then. Lines go above it.

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
        self._drawn = on_terminal()
        self._begun = self._moved = time.monotonic()
        self._first: float | None = None
        self._progress: Progress | None = None

    def __enter__(self) -> Bar:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._progress is not None:
            self._progress.stop()

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


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}"
