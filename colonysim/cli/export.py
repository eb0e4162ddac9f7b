"""`colonysim export`: a table of a run as CSV, JSON or one Parquet file, or the run for the Rerun viewer."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

from colonysim.cli.console import plain, say

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim export runs/hard-nodeworld-s0-1 episodes
  colonysim export runs/hard-nodeworld-s0-1 deposits --episodes 1-3 -o deposits.parquet
  colonysim export runs/hard-bullet-s0-1 poses -o trajectories.csv
  colonysim export runs/hard-bullet-s0-1 -o hard.rrd
"""


def command(
    path: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory.", show_default=False)],
    table: Annotated[
        str | None,
        typer.Argument(
            help="events, decisions, deposits, poses, controls, frames or episodes.", show_default="events"
        ),
    ] = None,
    episodes: Annotated[
        str | None, typer.Option("--episodes", help="Only these, such as 1,3,10 or 1-5.", show_default="all")
    ] = None,
    kind: Annotated[
        Literal["csv", "json", "parquet", "rrd"] | None,
        typer.Option("--format", "-f", help="[default: by the name of the file, else csv]"),
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="[default: standard output]")] = None,
) -> None:
    """Write a table of a run as CSV, JSON or one Parquet file, or the whole run for the Rerun viewer.

    In CSV the numbers of a list are parted by spaces. A name that ends with .rrd makes a recording
    of the run to be opened with `rerun FILE`: place, agents and boxes through time, events, results.
    """
    from colonysim.cli.numbers import read_numbers
    from colonysim.cli.opening import opened
    from colonysim.errors import TraceError
    from colonysim.trace.export import export

    chosen = kind or _by_name(out)
    if chosen in ("parquet", "rrd") and out is None:
        name = "Parquet file" if chosen == "parquet" else "recording"
        raise TraceError(f"a {name} cannot go to standard output; add --out FILE")
    wanted = None if episodes is None else read_numbers(episodes)
    if chosen == "rrd":
        from colonysim.view.rrd import write_recording

        if table is not None:
            raise TraceError(f"a recording is of the whole run; leave the table {table!r} out")
        assert out is not None
        write_recording(opened(path), out, wanted)
        say(str(out))
        return
    # A file or a program gets every character as it is, a terminal none that commands it.
    through = plain if sys.stdout.isatty() else str
    rows = export(opened(path), table or "events", chosen, out, wanted, through)
    if out is not None:
        say(f"{rows} rows in {out}")


def _by_name(out: Path | None) -> Literal["csv", "json", "parquet", "rrd"]:
    from colonysim.errors import TraceError
    from colonysim.trace.export import KINDS

    suffix = out.suffix.lstrip(".") if out else "csv"
    if suffix == "rrd":
        return "rrd"
    for kind in KINDS:
        if kind == suffix:
            return kind
    raise TraceError(f"{out}: cannot tell the format from the name; add --format csv, json, parquet or rrd")
