"""`colonysim export`: a table of a run as CSV, JSON or one Parquet file, or the run for the Rerun viewer."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, get_args

import typer

__all__ = ["EXAMPLES", "command"]

_Format = Literal["csv", "json", "parquet", "rrd"]
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
            help="events, decisions, deposits, poses, controls, frames, episodes or measurements.",
            show_default="events",
        ),
    ] = None,
    episodes: Annotated[
        str | None, typer.Option("--episodes", help="Only these, such as 1,3,10 or 1-5.", show_default="all")
    ] = None,
    kind: Annotated[
        _Format | None,
        typer.Option("--format", "-f", help="[default: by the name of the file, else csv]"),
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="[default: standard output]")] = None,
) -> None:
    """Write a table of a run as CSV, JSON or one Parquet file, or the whole run for the Rerun viewer.

    In CSV the numbers of a list are parted by spaces. A name that ends with .rrd makes a recording
    of the run to be opened with `rerun FILE`: place, agents and boxes through time, events, results.
    """
    from colonysim.cli.console import print_text, say
    from colonysim.cli.numbers import read_numbers
    from colonysim.cli.opening import opened
    from colonysim.errors import TraceError
    from colonysim.trace.export import as_texts, export

    chosen = _format(out, kind)
    wanted = None if episodes is None else read_numbers(episodes)
    if out is None:
        if chosen in ("parquet", "rrd"):
            name = "Parquet file" if chosen == "parquet" else "recording"
            raise TraceError(f"a {name} cannot go to standard output; add --out FILE")
        for text in as_texts(opened(path), table or "events", "json" if chosen == "json" else "csv", wanted):
            print_text(text)
        return
    if chosen == "rrd":
        from colonysim.view.rrd import write_recording

        if table is not None:
            raise TraceError(f"a recording is of the whole run; leave the table {table!r} out")
        write_recording(opened(path, "poses"), out, wanted)
        say(str(out))
        return
    rows = export(opened(path), table or "events", chosen, out, wanted)
    say(f"{rows} rows in {out}")


def _format(out: Path | None, asked: _Format | None) -> _Format:
    """The format that was asked for, or that of the name; the two must not say different things."""
    from colonysim.errors import TraceError

    suffix = out.suffix.lstrip(".").lower() if out else asked or "csv"
    named = next((kind for kind in get_args(_Format) if kind == suffix), None)
    if asked and named and asked != named:
        raise TraceError(f"{out}: the name says {named}, --format says {asked}; leave out one or change it")
    if (chosen := asked or named) is None:
        raise TraceError(f"{out}: cannot tell the format from the name; add --format csv, json, parquet or rrd")
    return chosen
