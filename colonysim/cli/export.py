"""`colonysim export`: a table of a run as CSV, JSON or one Parquet file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim export runs/hard-nodeworld-s0-1 episodes
  colonysim export runs/hard-nodeworld-s0-1 deposits --episodes 1-3 -o deposits.parquet
"""


def command(
    path: Annotated[Path, typer.Argument(metavar="RUN", help="A run directory.", show_default=False)],
    table: Annotated[
        str,
        typer.Argument(help="events, decisions, deposits, poses, controls, frames or episodes."),
    ] = "events",
    episodes: Annotated[
        str | None, typer.Option("--episodes", help="Only these, such as 1,3,10 or 1-5.", show_default="all")
    ] = None,
    kind: Annotated[
        Literal["csv", "json", "parquet"] | None,
        typer.Option("--format", "-f", help="[default: by the name of the file, else csv]"),
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="[default: standard output]")] = None,
) -> None:
    """Write a table of a run as CSV, JSON or one Parquet file.

    In CSV the numbers of a list are parted by spaces.
    """
    from colonysim.cli.numbers import read_numbers
    from colonysim.errors import TraceError
    from colonysim.trace.export import export
    from colonysim.trace.reader import Run

    chosen = kind or _by_name(out)
    if chosen == "parquet" and out is None:
        raise TraceError("a Parquet file cannot go to standard output; add --out FILE")

    rows = export(Run.open(path), table, chosen, out, None if episodes is None else read_numbers(episodes))
    if out is not None:
        typer.echo(f"{rows} rows in {out}", err=True)


def _by_name(out: Path | None) -> Literal["csv", "json", "parquet"]:
    from colonysim.errors import TraceError
    from colonysim.trace.export import KINDS

    suffix = out.suffix.lstrip(".") if out else "csv"
    for kind in KINDS:
        if kind == suffix:
            return kind
    raise TraceError(f"{out}: cannot tell the format from the name; add --format csv, json or parquet")
