"""Opening a run for a command that shows it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.cli.console import say
from colonysim.files import shown_path

if TYPE_CHECKING:
    from pathlib import Path

    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Table

__all__ = ["opened"]


def opened(path: Path, *shown: Table) -> Run:
    """A run; of one that is not finished, standard error is told how far it came.

    Args:
        path: Its directory.
        shown: Tables without which something is not shown that would be: if the run was not to keep one, standard
            error is told.

    Raises:
        TraceError: There is no such run, or it is damaged.
    """
    from colonysim.trace.reader import Run

    run = Run.open(path)
    if run.shortfall:
        say(f"{shown_path(path)}: {run.shortfall}")
    for table in shown:
        if why := run.missing(table):
            say(f"{shown_path(path)}: {why}")
    return run
