"""Tables of a run in formats that other programs read."""

from __future__ import annotations

import csv
import io
import json
import math
from typing import TYPE_CHECKING, Any, Literal, cast

from colonysim.arguments import wholes
from colonysim.errors import TraceError
from colonysim.files import replacing
from colonysim.suggest import nearest
from colonysim.trace.parts import table_schema
from colonysim.trace.schema import TABLES

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator
    from pathlib import Path

    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Table

__all__ = ["KINDS", "as_texts", "export"]

KINDS: tuple[Kind, ...] = ("csv", "json", "parquet")
Kind = Literal["csv", "json", "parquet"]
_AT_A_TIME = 4096


def export(run: Run, table: str, kind: Kind, out: Path, episodes: Collection[int] | None = None) -> int:
    """Writes a table of a run.

    Args:
        run: The run.
        table: Name of the table.
        kind: "csv" (lists as numbers parted by spaces), "json" (one list of objects) or "parquet".
        out: The file; replaced in one step.
        episodes: Only these; all of them must be there.

    Returns:
        The number of rows.

    Raises:
        TraceError: No such table, format or episode, a damaged part, or the file cannot be written, or is part of the
            run.
    """
    if kind not in KINDS:
        raise TraceError(f"no format {kind!r}; {nearest(str(kind), KINDS)}")
    counted = _Counted(_batches(run, table, episodes))
    run.check_apart(out)
    with replacing(out, TraceError) as temporary:
        if kind == "parquet":
            import pyarrow.parquet as pq

            with temporary.open("wb") as file, pq.ParquetWriter(file, table_schema(cast("Table", table))) as writer:
                for rows in counted:
                    writer.write_table(rows)
        else:
            with temporary.open("w", encoding="utf-8", newline="") as text:
                text.writelines(_texts(table, counted, kind))
    return counted.rows


def as_texts(
    run: Run, table: str, kind: Literal["csv", "json"], episodes: Collection[int] | None = None
) -> Iterator[str]:
    """The same as text, piece by piece, as `export` writes it to a file.

    Raises:
        TraceError: No such table, or a damaged part.
    """
    return _texts(table, _batches(run, table, episodes), kind)


class _Counted:
    """Tables that go by, and how many rows they had."""

    def __init__(self, tables: Iterable[Any]) -> None:
        self._tables, self.rows = tables, 0

    def __iter__(self) -> Iterator[Any]:
        for table in self._tables:
            self.rows += table.num_rows
            yield table


def _batches(run: Run, name: str, episodes: Collection[int] | None) -> Iterator[Any]:
    """The rows, some thousand at a time; what is asked for is checked at once."""
    if name not in TABLES:
        raise TraceError(f"no table {name!r} in a trace; {nearest(name, TABLES)}")
    table = name
    wanted = None if episodes is None else wholes("episodes", episodes)
    if wanted is None:
        run.check_kept(table)
        return run.batches(table)
    missing = sorted({*wanted} - {each.episode for each in run.episodes} - {*run.rows_by_episode(table)})
    if missing:
        raise TraceError(f"no episode {missing[0]} in this run; {len(run.episodes)} are complete")
    for episode in wanted:
        run.check_kept(table, episode)
    if table == "episodes":  # they are counted as they are
        import pyarrow as pa
        import pyarrow.compute as pc

        rows = run.table(table)
        return iter([rows.filter(pc.is_in(rows["episode"], pa.array(sorted(wanted), type=pa.int64())))])
    return run.only(wanted).batches(table)


def _texts(table: str, tables: Iterable[Any], kind: Kind) -> Iterator[str]:
    """The file, some thousand rows at a time."""
    batches = (batch for rows in tables for batch in rows.to_batches(max_chunksize=_AT_A_TIME))
    if kind == "json":
        before = "["
        for batch in batches:
            for row in batch.to_pylist():
                # JSON has no number that is not finite.
                whole = {n: None if isinstance(v, float) and not math.isfinite(v) else v for n, v in row.items()}
                yield f"{before}\n {json.dumps(whole, ensure_ascii=False)}"
                before = ","
        yield "[]\n" if before == "[" else "\n]\n"
        return
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(TABLES[cast("Table", table)])
    for batch in batches:
        for row in zip(*(column.to_pylist() for column in batch.columns), strict=True):
            writer.writerow([" ".join(map(str, value)) if isinstance(value, list) else value for value in row])
        yield text.getvalue()
        text.seek(0)
        text.truncate()
    yield text.getvalue()
