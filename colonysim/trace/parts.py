"""Part files: how a table's columns lie on disk."""

from __future__ import annotations

from array import array
from contextlib import ExitStack, contextmanager, suppress
from itertools import accumulate
from typing import TYPE_CHECKING, Any

from colonysim.errors import TraceError
from colonysim.files import replacing
from colonysim.trace.packing import Packed
from colonysim.trace.schema import TABLES

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from pathlib import Path

    from colonysim.trace.packing import Codes
    from colonysim.trace.schema import Column, Table

__all__ = ["PartFile", "arrow_table", "packed_columns", "table_schema"]


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


def packed_columns(table: Table, rows: Any, codes: Mapping[str, Codes]) -> dict[str, Packed]:
    """The rows of a `pyarrow.Table` as columns; the opposite of `arrow_table`.

    Args:
        table: The table's name.
        rows: Its next rows, with all columns.
        codes: For each column the numbers of its texts so far; those of new ones are added in order of appearance.
    """
    return {name: _packed(kind, rows[name].combine_chunks(), codes[name]) for name, kind in TABLES[table].items()}


def _packed(kind: Column, column: Any, codes: Codes) -> Packed:
    import numpy as np
    import pyarrow as pa

    if isinstance(column, pa.ChunkedArray):  # as older versions of Arrow leave it, if there are no rows
        column = pa.concat_arrays(column.chunks) if column.num_chunks else pa.array([], column.type)
    if kind == "text":
        found = column.dictionary_encode()
        numbers = np.array([codes[text] for text in found.dictionary.to_pylist()], dtype="int64")
        return Packed(kind, array("q", numbers[found.indices.to_numpy()].tobytes()))
    if kind in ("ints", "floats"):
        sizes = column.value_lengths().to_numpy().astype("int64")
        code, dtype = ("q", "int64") if kind == "ints" else ("d", "float64")
        values = column.flatten().to_numpy().astype(dtype)
        return Packed(kind, array(code, values.tobytes()), array("q", sizes.tobytes()))
    code, dtype = {"int": ("q", "int64"), "float": ("d", "float64"), "bool": ("b", "int8")}[kind]
    return Packed(kind, array(code, column.to_numpy(zero_copy_only=False).astype(dtype).tobytes()))


class PartFile:
    """A part that is being written, under a temporary name until `close` renames it into place.

    Groups of rows go to disk as they come, so memory does not grow with the part. Of a process that is killed the
    file stays under its temporary name, where no reader looks.

    Args:
        path: The part.
        columns: Of its first rows; they say what each column holds.

    Attributes:
        rows: How many it has so far.

    Raises:
        TraceError: The file cannot be made.
    """

    def __init__(self, path: Path, columns: Mapping[str, Packed]) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        self.rows = 0
        kinds = {name: _arrow_type(part.kind) for name, part in columns.items()}
        texts = [name for name, part in columns.items() if part.kind == "text"]
        schema = pa.schema(kinds | dict.fromkeys(texts, pa.dictionary(pa.int32(), pa.string())))
        with ExitStack() as stack:
            temporary = stack.enter_context(replacing(path, TraceError))
            # An open file: Arrow takes no name that is not text.
            file = stack.enter_context(temporary.open("wb"))
            self._writer = pq.ParquetWriter(
                file,
                schema,
                # Without the Arrow schema texts come back as plain strings, whatever dictionary wrote them.
                store_schema=False,
                compression="snappy",
                # Numbers hardly repeat: looking for it (a dictionary) and bounds (statistics) cost more than they save.
                use_dictionary=texts,
                write_statistics=False,
                # A byte that changed on disk is found out when it is read.
                write_page_checksum=True,
                # What a part takes on its way to disk is little and given back.
                memory_pool=pa.system_memory_pool(),
            )
            self._ending = stack.pop_all()

    def add(self, columns: Mapping[str, Packed], codes: Mapping[str, Codes]) -> None:
        """Writes rows that follow; if that fails the whole part is gone.

        Raises:
            TraceError: The file cannot be written (disk full).
        """
        with self._or_nothing():
            table = arrow_table(columns, codes)
            self._writer.write_table(table, row_group_size=max(table.num_rows, 1))
            self.rows += table.num_rows

    def close(self) -> None:
        """Ends the file and renames it into place.

        Raises:
            TraceError: It cannot be written (disk full); the part is gone then.
        """
        with self._or_nothing():
            self._writer.close()
        self._ending.close()

    def abandon(self) -> None:
        """Removes what there is of the part."""
        self._writer.is_open = False  # or it would write its end into a file that is closed
        with suppress(_Abandoned), self._ending:
            raise _Abandoned

    @contextmanager
    def _or_nothing(self) -> Iterator[None]:
        try:
            yield
        except BaseException:
            self._writer.is_open = False
            with self._ending:
                raise

    def __del__(self) -> None:
        if hasattr(self, "_ending"):
            self.abandon()


class _Abandoned(Exception):  # noqa: N818
    """What ends a part that nobody wants any more."""
