"""Part files: how a table's columns lie on disk, and how they come back."""

from __future__ import annotations

from array import array
from collections import Counter
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.errors import TraceError
from colonysim.files import replacing
from colonysim.trace.schema import TABLES

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping

    from colonysim.trace.packing import Codes, Packed
    from colonysim.trace.schema import Table

__all__ = ["arrow_table", "read_parts", "rows_by_episode", "table_schema", "write_part"]

ROWS_IN_GROUP = 2048


def _arrow_type(kind: str) -> Any:
    import pyarrow as pa

    types = {"int": pa.int64(), "float": pa.float64(), "text": pa.string(), "bool": pa.bool_()}
    lists = {"ints": pa.list_(pa.int64()), "floats": pa.list_(pa.float64())}
    return (types | lists)[kind]


def table_schema(table: Table) -> Any:
    """The Arrow schema (`pyarrow.Schema`) of a table."""
    import pyarrow as pa

    return pa.schema([pa.field(name, _arrow_type(kind)) for name, kind in TABLES[table].items()])


def _column(part: Packed, codes: Codes) -> Any:
    import pyarrow as pa

    buffer = pa.py_buffer(part.values)
    count = len(part.values)
    if part.kind == "int":
        return pa.Array.from_buffers(pa.int64(), count, [None, buffer])
    if part.kind == "float":
        return pa.Array.from_buffers(pa.float64(), count, [None, buffer])
    if part.kind == "bool":
        return pa.Array.from_buffers(pa.int8(), count, [None, buffer]).cast(pa.bool_())
    if part.kind == "text":
        indices = pa.Array.from_buffers(pa.int64(), count, [None, buffer]).cast(pa.int32())
        return pa.DictionaryArray.from_arrays(indices, pa.array(list(codes), type=pa.string()))
    kind = pa.int64() if part.kind == "ints" else pa.float64()
    values = pa.Array.from_buffers(kind, count, [None, buffer])
    offsets = array("i", accumulate(part.sizes or (), initial=0))
    return pa.ListArray.from_arrays(
        pa.Array.from_buffers(pa.int32(), len(offsets), [None, pa.py_buffer(offsets)]), values
    )


def arrow_table(columns: Mapping[str, Packed], codes: Mapping[str, Codes]) -> Any:
    """Columns as a `pyarrow.Table` on the same memory, which must not grow while that is alive."""
    import pyarrow as pa

    return pa.table({name: _column(part, codes[name]) for name, part in columns.items()})


def write_part(path: Path, columns: Mapping[str, Packed], codes: Mapping[str, Codes]) -> None:
    """Writes one part under a temporary name and renames it into place.

    Raises:
        TraceError: The file cannot be written (disk full, no permission).
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = arrow_table(columns, codes)
    with replacing(path, TraceError) as temporary:
        # Without the Arrow schema texts come back as plain strings, whatever dictionary wrote them.
        # Numbers hardly repeat: looking for it (a dictionary) and bounds (statistics) cost more than they save.
        texts = [name for name, part in columns.items() if part.kind == "text"]
        pq.write_table(
            table,
            temporary,
            store_schema=False,
            compression="snappy",
            use_dictionary=texts,
            write_statistics=False,
            # What a part takes on its way to disk is little and given back: memory does not grow with a run's steps.
            row_group_size=ROWS_IN_GROUP,
            memory_pool=pa.system_memory_pool(),
        )


def read_parts(directory: Path, table: Table, episodes: Collection[int] | None = None) -> Any:
    """All rows of a table as one `pyarrow.Table`; files not yet renamed into place are passed over.

    Args:
        directory: The run directory.
        table: Name of the table.
        episodes: Only the rows of these.

    Raises:
        TraceError: A part is damaged or missing.
    """
    import pyarrow as pa
    import pyarrow.compute as pc

    schema = table_schema(table)
    wanted = None if episodes is None else pa.array(sorted(episodes), pa.int64())
    parts = []
    for rows in _parts(directory, table, schema):
        parts.append(rows if wanted is None else rows.filter(pc.is_in(rows["episode"], value_set=wanted)))
    return pa.concat_tables(parts) if parts else schema.empty_table()


def rows_by_episode(directory: Path, table: Table) -> dict[int, int]:
    """How many rows of a table each episode has.

    Raises:
        TraceError: A part is damaged or missing.
    """
    import pyarrow as pa

    found: Counter[int] = Counter()
    for part in _parts(directory, table, pa.schema([table_schema(table).field("episode")])):
        for each in part["episode"].value_counts().to_pylist():
            found[each["values"]] += each["counts"]
    return dict(found)


def _parts(directory: Path, table: Table, schema: Any) -> Iterator[Any]:
    """The columns of a schema in each part of a table, in order."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    for number, path in enumerate(sorted((directory / table).glob("part-*.parquet"))):
        if path.name != f"part-{number:05d}.parquet":
            raise TraceError(f"{directory / table}: part-{number:05d}.parquet is missing")
        try:
            yield pq.read_table(path, columns=schema.names).select(schema.names).cast(schema)
        except (OSError, pa.ArrowException, KeyError) as error:
            message = f"{path}: damaged part, cannot be read ({str(error).splitlines()[0]})"
            raise TraceError(message) from error
