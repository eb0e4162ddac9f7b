"""Part files as they come back: some thousand rows at a time, of the columns and episodes that are asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from colonysim.errors import TraceError
from colonysim.files import opened_file
from colonysim.trace.parts import packed_columns, table_schema

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence
    from pathlib import Path

    from colonysim.trace.packing import TableDigest
    from colonysim.trace.schema import Table

__all__ = ["Piece", "kept_parts", "read_parts"]

_AT_A_TIME = 2**16
"""Rows of a piece, unless a part keeps more of them together."""
_MOST_BYTES = 2**36
"""Of a part, which is never read as a whole."""
_MOST_METADATA = 1_000_000
"""Longest text and list in the metadata of a part."""
_MOST_VALUES = 32
"""Values for each byte of a part at most: numbers of eight bytes that snappy makes 21 times smaller are 2.7."""
_LONGEST_TEXT = 1000
"""Of a cell, characters."""


class Piece(NamedTuple):
    """Rows that follow one another in a part.

    Attributes:
        path: The part.
        first: Where in it the first of them is, if no episode was left out.
        rows: They themselves, a `pyarrow.Table`.
    """

    path: Path
    first: int
    rows: Any


def read_parts(
    directory: Path,
    table: Table,
    rows: int | None,
    columns: Sequence[str] | None = None,
    episodes: Collection[int] | None = None,
) -> Iterator[Piece]:
    """The rows of a table in order, piece by piece; temporary files are passed over.

    Args:
        directory: The run directory.
        table: Name of the table.
        rows: How many rows the table has by the manifest; None while nobody has counted them.
        columns: Names of the columns that are read; None for all.
        episodes: Only the rows of these; what holds none of them is not read, but for its episodes. None for all.

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
        most = None if rows is None else rows - found
        part = _pieces(path, schema, most, episodes)
        found += next(part)  # type: ignore[operator]
        yield from part  # type: ignore[misc]
    if rows is not None and found != rows:
        what = f"holds {found} rows" if folder.is_dir() else "is missing"
        raise TraceError(f"{folder}: {what}, the manifest counts {rows}; part of the run is not there")


def kept_parts(directory: Path, table: Table, rows: int, digest: TableDigest) -> tuple[int, list[Path]]:
    """Takes the first rows of a table into a hash; nothing on disk is changed.

    Args:
        directory: The run directory.
        table: Name of the table.
        rows: How many rows.
        digest: The hash.

    Returns:
        How many parts hold these rows, and all files of the table besides, those that were never finished too.

    Raises:
        TraceError: A part is damaged or missing, or these rows do not end where a part does.
    """
    folder, kept = directory / table, 0
    for number, path in enumerate(_listed(folder)):
        if digest.rows == rows:
            break
        if path.name != f"part-{number:05d}.parquet":
            raise TraceError(f"{folder}: part-{number:05d}.parquet is missing")
        pieces = _pieces(path, table_schema(table), rows - digest.rows, None)
        next(pieces)
        for piece in pieces:
            assert isinstance(piece, Piece)
            digest.take(packed_columns(table, piece.rows, digest.codes), piece.rows.num_rows)
        kept += 1
    if digest.rows != rows:
        raise TraceError(f"{folder}: holds {digest.rows} of the {rows} rows that there were at the checkpoint")
    parts = {f"part-{number:05d}.parquet" for number in range(kept)}
    return kept, [path for path in _files(folder) if path.name not in parts]


def _files(folder: Path) -> list[Path]:
    """The parts in a folder, and what was to become one."""
    try:
        found = sorted(folder.iterdir()) if folder.is_dir() else []
    except OSError as error:
        raise TraceError(f"{folder}: cannot be read: {error.strerror or error}") from None
    return [path for path in found if path.name.endswith((".parquet", ".parquet.tmp")) and "part-" in path.name]


def _listed(folder: Path) -> list[Path]:
    try:
        return sorted(folder.glob("part-*.parquet")) if folder.is_dir() else []
    except OSError as error:
        raise TraceError(f"{folder}: cannot be read: {error.strerror or error}") from None


def _pieces(path: Path, schema: Any, most: int | None, episodes: Collection[int] | None) -> Iterator[int | Piece]:
    """How many rows a part has, then those: its columns and no others, of their types, without nulls.

    Sizes are looked at before memory is spent on them: a damaged file may claim any.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    texts = [field.name for field in schema if field.type == pa.string()]
    wanted = None if episodes is None else pa.array(sorted(episodes), pa.int64())
    with opened_file(path, TraceError, _MOST_BYTES) as file:
        try:
            # A thread of Arrow's that reads ahead may let go of the file while Python shuts down, which aborts.
            part = pq.ParquetFile(
                file, pre_buffer=False, read_dictionary=texts, page_checksum_verification=True,
                thrift_string_size_limit=_MOST_METADATA, thrift_container_size_limit=_MOST_METADATA,
            )  # fmt: skip
            about = part.metadata
            missing = [name for name in (*schema.names, "episode") if name not in part.schema_arrow.names]
            if missing:
                raise TraceError(f"{path}: damaged part, it has no column {missing[0]!r}")
            if most is not None and about.num_rows > most:
                raise TraceError(f"{path}: holds {about.num_rows} rows, by the manifest {most} are left of this table")
            _check_sizes(path, about, file.seek(0, 2))
            yield about.num_rows
            first = 0
            for groups, count in _together(about):
                rows = _read(path, part, groups, schema, wanted)
                if rows is not None:
                    yield Piece(path, first, rows)
                first += count
        except (
            OSError, ValueError, TypeError, KeyError, IndexError, OverflowError, MemoryError, pa.ArrowException,
        ) as error:  # fmt: skip
            told = (str(error).splitlines() or [type(error).__name__])[0]
            raise TraceError(f"{path}: damaged part, cannot be read ({told[:200]})") from error


def _together(about: Any) -> Iterator[tuple[list[int], int]]:
    """Groups of rows that are read at once, and how many rows they are."""
    groups: list[int] = []
    rows = 0
    for i in range(about.num_row_groups):
        more = about.row_group(i).num_rows
        if groups and rows + more > _AT_A_TIME:
            yield groups, rows
            groups, rows = [], 0
        groups.append(i)
        rows += more
    if groups:
        yield groups, rows


def _read(path: Path, part: Any, groups: list[int], schema: Any, wanted: Any) -> Any:
    """The rows of some groups, checked; None if there is none of an episode that is wanted."""
    import pyarrow as pa
    import pyarrow.compute as pc

    chosen = None
    if wanted is not None:
        episode = part.read_row_groups(groups, columns=["episode"], use_threads=False)["episode"]
        chosen = pc.is_in(episode, value_set=wanted)
        if not pc.any(chosen).as_py():
            return None
    rows = part.read_row_groups(groups, columns=schema.names, use_threads=False)
    _check_columns(path, rows, schema)
    rows = pa.table([rows[name].cast(schema.field(name).type) for name in schema.names], schema=schema)
    rows.validate(full=True)
    return rows if chosen is None else rows.filter(chosen)


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
