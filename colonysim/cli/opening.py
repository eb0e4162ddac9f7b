"""Opening a run for a command that shows it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.cli.console import say
from colonysim.files import shown_path

if TYPE_CHECKING:
    from pathlib import Path

    from colonysim.trace.reader import Run

__all__ = ["opened"]


def opened(path: Path) -> Run:
    """A run; of one that is not finished, standard error is told how far it came.

    Raises:
        TraceError: There is no such run, or it is damaged.
    """
    from colonysim.trace.reader import Run

    run = Run.open(path)
    if run.shortfall:
        say(f"{shown_path(path)}: {run.shortfall}")
    return run
