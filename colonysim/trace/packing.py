"""Rows become columns, and columns a hash: the same hash however the rows were cut into parts."""

from __future__ import annotations

import hashlib
import sys
from array import array
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Any

from colonysim.trace.schema import TABLES, VERSION

try:
    from colonysim.trace.block import Block
except ImportError:  # it was not compiled
    Block = None  # type: ignore[assignment, misc]

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.trace.schema import Column, Table

__all__ = ["UNHASHED", "Block", "Codes", "Packed", "TableDigest", "trace_sha256"]

#: Columns that differ between two runs of the same seed.
UNHASHED = frozenset({("episodes", "wall_seconds")})

_SWAP = sys.byteorder == "big"


class Codes(dict[str, int]):
    """Numbers for texts, in order of first appearance; asking for a new text gives it the next number."""

    def __missing__(self, text: str) -> int:
        if not isinstance(text, str):
            raise TypeError(f"a text column takes str, not {type(text).__name__}")
        self[text] = code = len(self)
        return code


@dataclass(slots=True)
class Packed:
    """One column of a part.

    Attributes:
        kind: What the column holds.
        values: Its numbers; the codes of a text column; the concatenated numbers of a list column.
        sizes: How many numbers each row of a list column holds; else None.
    """

    kind: Column
    values: array[Any]
    sizes: array[int] | None = None

    @property
    def rows(self) -> int:
        """How many rows the column has."""
        return len(self.values if self.sizes is None else self.sizes)

    def copy(self) -> Packed:
        """The same on memory of its own."""
        return Packed(self.kind, self.values[:], None if self.sizes is None else self.sizes[:])

    def extend(self, later: Packed) -> None:
        """Takes the rows that follow."""
        self.values.extend(later.values)
        if self.sizes is not None and later.sizes is not None:
            self.sizes.extend(later.sizes)


def _pack(kind: Column, column: Sequence[Any], codes: Codes) -> Packed:
    # array() is strict: a float in an integer column is a TypeError, where NumPy would cut it off.
    if kind == "int":
        return Packed(kind, array("q", column))
    if kind == "float":
        return Packed(kind, array("d", column))
    if kind == "text":
        return Packed(kind, array("q", map(codes.__getitem__, column)))
    if kind == "bool":
        return Packed(kind, array("b", map(bool, column)))
    numbers = chain.from_iterable(column)
    return Packed(kind, array("q" if kind == "ints" else "d", numbers), array("q", map(len, column)))


def _little_endian(numbers: array[Any]) -> array[Any]:
    if not _SWAP:
        return numbers
    swapped = numbers[:]
    swapped.byteswap()
    return swapped


class TableDigest:
    """The running hash of one table, column by column; floats count by their eight bytes."""

    def __init__(self, table: Table) -> None:
        self.table = table
        self.rows = 0
        self.codes: dict[str, Codes] = {}
        self._columns = TABLES[table]
        self._values = {name: hashlib.sha256() for name in self._columns}
        self._sizes = {name: hashlib.sha256() for name in self._columns}
        for name in self._columns:
            self.codes[name] = Codes()

    def waiting(self) -> list[tuple[object, ...]] | Block:
        """Where the table's next rows may wait for `add`: a list, or where that was compiled, columns already."""
        return [] if Block is None else Block(self.table, self._columns, self.codes)

    def add(self, rows: list[tuple[object, ...]] | Block) -> dict[str, Packed]:
        """Takes the table's next rows and returns them as columns; a block is empty then, a list is left as it is.

        Raises:
            ValueError: A row has another number of values than the table has columns.
            TypeError: A value does not fit its column.
        """
        count = len(rows)
        if isinstance(rows, list):
            packed = self._turn(rows)
        else:
            packed = {name: Packed(self._columns[name], *column) for name, column in rows.take().items()}
        return self.take(packed, count)

    def take(self, packed: dict[str, Packed], count: int) -> dict[str, Packed]:
        """Takes the table's next rows, which are columns already, and returns these."""
        for name, part in packed.items():
            if (self.table, name) not in UNHASHED:
                self._values[name].update(_little_endian(part.values))
                if part.sizes is not None:
                    self._sizes[name].update(_little_endian(part.sizes))
        self.rows += count
        return packed

    def _turn(self, rows: Sequence[tuple[object, ...]]) -> dict[str, Packed]:
        columns = list(zip(*rows, strict=True))
        if rows and len(columns) != len(self._columns):
            raise ValueError(f"{self.table}: {len(columns)} values in a row of {len(self._columns)} columns")
        packed: dict[str, Packed] = {}
        for (name, kind), column in zip(self._columns.items(), columns, strict=False):
            try:
                packed[name] = _pack(kind, column, self.codes[name])
            except TypeError as error:
                raise TypeError(f"{self.table}.{name}: {error}") from error
        return packed

    def digest(self) -> bytes:
        """The hash of all rows so far."""
        whole = hashlib.sha256(f"{self.table}:{self.rows}".encode())
        for name, kind in self._columns.items():
            if (self.table, name) in UNHASHED:
                continue
            whole.update(f"|{name}:{kind}:".encode())
            whole.update(self._values[name].digest())
            whole.update(self._sizes[name].digest())
            for text in self.codes[name]:
                encoded = text.encode()
                whole.update(len(encoded).to_bytes(8, "little") + encoded)
        return whole.digest()


def trace_sha256(digests: Iterable[TableDigest]) -> str:
    """One hash for a run: over the rows of its tables, in the order of `schema.TABLES`.

    Neither wall clock, file bytes nor the way rows were cut into parts has a share in it, and neither has a table of
    measurements without rows, which earlier versions did not know.
    """
    by_table = {digest.table: digest for digest in digests}
    whole = hashlib.sha256(f"colonysim trace {VERSION}".encode())
    for table in TABLES:
        if table in by_table and (table != "measurements" or by_table[table].rows):
            whole.update(by_table[table].digest())
    return whole.hexdigest()
