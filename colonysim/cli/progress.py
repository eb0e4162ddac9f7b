"""How far a long command has come: a bar with the time left, on standard error."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from colonysim.cli.console import error_console, plain

if TYPE_CHECKING:
    from types import TracebackType

__all__ = ["Bar"]

PATIENCE = 2.0
"""Seconds of wall clock before the bar shows."""
_PAUSE = 0.1


class Bar:
    """A progress bar that appears after two seconds; on a terminal only. Lines go above it.

    Example:
        ```python
        with Bar("running", total=30) as bar:
            bar.move(1.5)  # one and a half of thirty done
            bar.line("episode 1: 17 steps")
        ```
    """

    def __init__(self, title: str, total: float, quiet: bool = False) -> None:
        self._console = error_console()
        self._title = plain(title)
        self._total = total
        self._quiet = quiet
        self._begun = self._moved = time.monotonic()
        self._progress: _Shown | None = None

    def __enter__(self) -> Bar:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._progress is not None:
            self._progress.stop()

    def line(self, text: str) -> None:
        """A line on standard error, above the bar."""
        if not self._quiet:
            self._console.print(plain(text))

    def move(self, done: float) -> None:
        """Says how much of the total is done; cheap enough to be called for every event."""
        now = time.monotonic()
        if self._quiet or now - self._moved < _PAUSE or not self._console.is_terminal:
            return
        self._moved = now
        if self._progress is None:
            if now - self._begun < PATIENCE:
                return
            self._progress = _Shown(self._console, self._title, self._total, self._begun)
        self._progress.update(done)


class _Shown:
    """The bar itself, once it is worth showing."""

    def __init__(self, console: object, title: str, total: float, begun: float) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn

        if not isinstance(console, Console):
            raise TypeError("a bar needs a console")
        self._total = total
        self._begun = begun
        self._progress = Progress(
            TextColumn("{task.description}", markup=False), BarColumn(), TextColumn("{task.percentage:>3.0f} %"),
            TextColumn("{task.fields[clock]}"), console=console, transient=True,
        )  # fmt: skip
        self._task = self._progress.add_task(title, total=total, clock="")
        self._progress.start()

    def update(self, done: float) -> None:
        share = min(done / self._total, 1.0) if self._total else 1.0
        spent = time.monotonic() - self._begun
        left = f", {_clock(spent / share - spent)} left" if share > 0.001 else ""
        self._progress.update(self._task, completed=done, clock=_clock(spent) + left)

    def stop(self) -> None:
        self._progress.stop()


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}"
