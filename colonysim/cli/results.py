"""`colonysim results`: what a sweep has found so far."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["EXAMPLES", "command"]

EXAMPLES = """\b
Examples:
  colonysim results results/beta
  colonysim results results/beta --episodes 11-20 --by policy.beta
  colonysim results results/beta --sql "SELECT seed, max(steps) FROM episodes GROUP BY seed"
  colonysim results results/beta --csv --out beta.csv
"""


def command(
    directory: Annotated[Path, typer.Argument(help="The sweep's directory.", show_default=False)],
    by: Annotated[
        list[str] | None,
        typer.Option("--by", help="Column to tell apart, or group; may be given again. [default: what varies]"),
    ] = None,
    episodes: Annotated[
        str | None, typer.Option(metavar="FIRST-LAST", help="Only these episodes. [default: all]")
    ] = None,
    sql: Annotated[str | None, typer.Option(help="A query on `trials`, `episodes` and `groups` instead.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print rows as JSON.")] = False,
    as_csv: Annotated[bool, typer.Option("--csv", help="Write rows as CSV: every column, all digits.")] = False,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="Of --csv. [default: standard output]")
    ] = None,
) -> None:
    """Print means over seeds with 95 % intervals, or the answer to a query.

    Intervals are by bootstrap from 8 trials on, Student's t for fewer; with one trial there is none.
    `--by group` tells groups of agents apart, beside other columns that are given.
    It can be asked while the sweep runs: the tables are some seconds old then. In CSV the ends of an
    interval are columns of their own (success_low, success_high), and what there is none of is empty.
    """
    from colonysim.cli.console import print_json, print_table
    from colonysim.cli.numbers import read_span
    from colonysim.errors import ColonysimError
    from colonysim.sweep.groups import read_by_group
    from colonysim.sweep.tables import check_apart, query, read_tables, summary

    if as_json and as_csv:
        raise ColonysimError("--json and --csv: expected one of them")
    if out is not None:
        if not as_csv:
            raise ColonysimError("--out: only with --csv")
        check_apart(directory, out)
    if sql is not None:
        if by or episodes is not None:
            raise ColonysimError("--sql stands alone: a query says itself which columns and episodes it wants")
        names, rows = query(directory, sql)
        if as_csv:
            _write_csv(names, rows, out)
        elif as_json:
            print_json([dict(zip(names, row, strict=True)) for row in rows])
        else:
            print_table(names, [["" if v is None else str(v) for v in row] for row in rows])
        return
    tables = read_by_group(directory) if "group" in (by or ()) else read_tables(directory)
    found = summary(*tables, by, read_span(episodes))
    if as_csv:
        _write_csv([*found[0]] if found else [], [[*row.values()] for row in found], out)
        return
    if as_json:
        print_json(found)
        return
    names = [name for name in (found[0] if found else {}) if not name.endswith(("_low", "_high"))]
    columns = [f">{name}" if name in ("trials", "finished", "failed", "success", "steps") else name for name in names]
    print_table(columns, [[_cell(row, name) for name in names] for row in found], str(directory))


def _write_csv(names: Sequence[str], rows: Sequence[Sequence[Any]], out: Path | None) -> None:
    import csv
    import io

    from colonysim.cli.console import print_text, say
    from colonysim.files import replacing

    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerows([names, *rows] if names else [])
    if out is None:
        print_text(text.getvalue())
        return
    with replacing(out) as temporary:
        temporary.write_text(text.getvalue(), encoding="utf-8", newline="")
    say(f"{len(rows)} rows in {out}")


def _cell(row: dict[str, Any], name: str) -> str:
    value = row[name]
    if value is None:
        return "-"
    if f"{name}_low" not in row:
        return str(value)
    digits, low, high = 3 if name == "success" else 1, row[f"{name}_low"], row[f"{name}_high"]
    return f"{value:.{digits}f}" if low is None else f"{value:.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"
