"""`colonysim verify`: whether runs are still as they were recorded."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from colonysim.trace.reader import Run

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim verify runs/hard-nodeworld-s0-1
  colonysim verify runs/*
"""


def command(
    paths: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Run directories.", show_default=False)],
) -> None:
    """Check that the rows of runs are those that were written.

    The rows of each table are counted, and the hash over all of them and that of the scenario are computed
    anew and compared with the manifest. The exit code is 0 if all runs are as they were written, else 2:
    rows differ, are damaged or missing, or a run was never finished and has no hash.
    """
    from colonysim.cli.console import print_result, say
    from colonysim.errors import ColonysimError
    from colonysim.trace.reader import Run

    faults = 0
    for path in paths:
        try:
            print_result(f"{path}: ok: {_verified(Run.open(path))}")
        except ColonysimError as error:
            say(f"Error: {error}")
            faults += 1
    if faults:
        raise SystemExit(2)


def _verified(run: Run) -> str:
    from colonysim.errors import TraceError

    if not run.verify():
        raise TraceError(f"{run.path}: the rows or the scenario are not those that were written (another hash)")
    rows = sum(run.manifest["rows"].values())
    return f"{rows} rows, trace_sha256 {run.trace_sha256}" + (f", {run.shortfall}" if run.shortfall else "")
