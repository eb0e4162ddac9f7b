"""Part files: how a table's columns lie on disk, and how they come back."""

from __future__ import annotations

from array import array
from itertools import accumulate
from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.errors import TraceError
from colonysim.files import read_file, replacing
from colonysim.trace.schema import TABLES

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from colonysim.trace.packing import Codes, Packed
    from colonysim.trace.schema import Table

__all__ = ["arrow_table", "read_parts", "table_schema", "write_part"]

ROWS_IN_GROUP = 2048
_MOST_METADATA = 1_000_000
"""Longest text and list in the metadata of a part."""
_MOST_VALUES = 32
"""Values for each byte of a part at most: numbers of eight bytes that snappy makes 21 times smaller are 2.7."""
_LONGEST_TEXT = 1000
"""Of a cell, characters."""


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

    # Without the Arrow schema texts come back as plain strings, whatever dictionary wrote them.
    # Numbers hardly repeat: looking for it (a dictionary) and bounds (statistics) cost more than they save.
    texts = [name for name, part in columns.items() if part.kind == "text"]
    # An open file: Arrow takes no name that is not text.
    with replacing(path, TraceError) as temporary, temporary.open("wb") as file:
        pq.write_table(
            arrow_table(columns, codes),
            file,
            store_schema=False,
            compression="snappy",
            use_dictionary=texts,
            write_statistics=False,
            # A byte that changed on disk is found out when it is read.
            write_page_checksum=True,
            # What a part takes on its way to disk is little and given back: memory does not grow with a run's steps.
            row_group_size=ROWS_IN_GROUP,
            memory_pool=pa.system_memory_pool(),
        )


def read_parts(
    directory: Path, table: Table, rows: int | None, columns: Sequence[str] | None = None
) -> Iterator[tuple[Path, Any]]:
    """The parts of a table in order, each as a path and a `pyarrow.Table`; temporary files are passed over.

    Args:
        directory: The run directory.
        table: Name of the table.
        rows: How many rows the table has by the manifest; None while nobody has counted them.
        columns: Names of the columns that are read; None for all.

    Args:
        directory: The run directory.
        table: Name of the table.
        episodes: Only the rows of these.

    Raises:
        TraceError: A part is damaged or missing, or the table has other rows than that.
    """
    import pyarrow as pa

    folder, found, schema = directory / table, 0, table_schema(table)
    if columns is not None:
        schema = pa.schema([schema.field(name) for name in columns])
    for number, path in enumerate(_listed(folder)):
        if path.name != f"part-{number:05d}.parquet":
            raise TraceError(f"{folder}: part-{number:05d}.parquet is missing")
        part = _read_part(path, schema, None if rows is None else rows - found)
        found += part.num_rows
        yield path, part
    if rows is not None and found != rows:
        what = f"holds {found} rows" if folder.is_dir() else "is missing"
        raise TraceError(f"{folder}: {what}, the manifest counts {rows}; part of the run is not there")


def _listed(folder: Path) -> list[Path]:
    try:
        return sorted(folder.glob("part-*.parquet")) if folder.is_dir() else []
    except OSError as error:
        raise TraceError(f"{folder}: cannot be read: {error.strerror or error}") from None


def _read_part(path: Path, schema: Any, most: int | None) -> Any:
    """The rows of a part: its columns and no others, of their types, without nulls.

    Sizes are looked at before memory is spent on them: a damaged file may claim any.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    content = read_file(path, TraceError)
    texts = [field.name for field in schema if field.type == pa.string()]
    try:
        file = pq.ParquetFile(
            pa.BufferReader(content), read_dictionary=texts, page_checksum_verification=True,
            thrift_string_size_limit=_MOST_METADATA, thrift_container_size_limit=_MOST_METADATA,
        )  # fmt: skip
        about = file.metadata
        missing = [name for name in schema.names if name not in file.schema_arrow.names]
        if missing:
            raise TraceError(f"{path}: damaged part, it has no column {missing[0]!r}")
        if most is not None and about.num_rows > most:
            raise TraceError(f"{path}: holds {about.num_rows} rows, by the manifest {most} are left of this table")
        _check_sizes(path, about, len(content))
        rows = file.read(columns=schema.names, use_threads=False)
        _check_columns(path, rows, schema)
        rows = pa.table([rows[name].cast(schema.field(name).type) for name in schema.names], schema=schema)
        rows.validate(full=True)
    except (OSError, ValueError, TypeError, KeyError, IndexError, OverflowError, MemoryError) as error:
        told = (str(error).splitlines() or [type(error).__name__])[0]
        raise TraceError(f"{path}: damaged part, cannot be read ({told[:200]})") from error
    return rows


def _check_sizes(path: Path, about: Any, size: int) -> None:
    groups = [about.row_group(i) for i in range(about.num_row_groups)]
    rows = sum(group.num_rows for group in groups)
    chunks = [group.column(i) for group in groups for i in range(group.num_columns)]
    values = sum(max(chunk.num_values, 0) for chunk in chunks)
    if rows != about.num_rows or min((group.num_rows for group in groups), default=0) < 0:
        raise TraceError(f"{path}: damaged part, it claims {about.num_rows} rows and its groups {rows}")
    if values > size * _MOST_VALUES:
        raise TraceError(f"{path}: damaged part, it claims {values} values in {size} bytes")


def _check_columns(path: Path, rows: Any, schema: Any) -> None:
    import pyarrow as pa

    for field in schema:
        column = rows[field.name]
        kind = column.type
        if field.type == pa.string() and pa.types.is_dictionary(kind):
            kind = kind.value_type
            texts = (text for part in column.chunks for text in part.dictionary.to_pylist())
            longest = max((len(text or "") for text in texts), default=0)
            if longest > _LONGEST_TEXT:
                raise TraceError(f"{path}: column {field.name!r} holds a text of {longest} characters")
        lists = pa.types.is_list(kind) and pa.types.is_list(field.type)
        if kind != field.type and not (lists and kind.value_type == field.type.value_type):
            raise TraceError(f"{path}: column {field.name!r} holds {kind}, expected {field.type}")
        inner = [part.flatten() for part in column.chunks] if pa.types.is_list(kind) else []
        if column.null_count or any(part.null_count for part in inner):
            raise TraceError(f"{path}: column {field.name!r} holds nulls, expected {field.type}")
