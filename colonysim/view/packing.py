"""Columns of numbers as few bytes: what the page unpacks again is described in the block's own head."""

from __future__ import annotations

import gzip
import json
import struct
from typing import TYPE_CHECKING, Any

import numpy as np

from colonysim.errors import TraceError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["Block", "unpack"]

_WHOLE = (np.int8, np.int16, np.int32)
_MOST = 2**53
"""Up to here every whole number is exact in a browser, whose numbers are doubles."""


class Block:
    """Named columns that travel together, with a head of plain data.

    Whole numbers take as many bytes as the largest needs, those that grow steadily are kept as differences, and all
    first bytes lie before all second ones: gzip finds far more to save that way. Whole numbers beyond 32 bits are
    kept as doubles, which is what they are in a browser.

    Layout, little-endian: length of the head (4 bytes), the head as JSON, the columns. The head names for each
    column its kind ("i" or "f"), count of values, bytes a value, where it begins, and, if these are differences, the
    kind and bytes of what they add up to.

    Attributes:
        head: Plain data for the page.
    """

    def __init__(self) -> None:
        self.head: dict[str, Any] = {}
        self._columns: dict[str, list[Any]] = {}
        self._bytes = bytearray()

    def ints(self, name: str, values: ArrayLike, *, steps: bool = False) -> None:
        """Adds whole numbers of up to 53 bits; `steps` keeps differences, which suits times and paths.

        Raises:
            TraceError: A number is larger than that.
        """
        numbers = np.asarray(values, dtype=np.int64).ravel()
        whole = _smallest(name, numbers)
        if not steps:
            return self._add(name, numbers.astype(whole))
        differences = np.diff(numbers, prepend=0)
        # What it adds up to takes four bytes or eight: no sum of small steps overflows.
        sums = np.result_type(whole, np.int32)
        return self._add(name, differences.astype(_smallest(name, differences)), sums)

    def reals(self, name: str, values: ArrayLike) -> None:
        """Adds numbers with some seven digits."""
        self._add(name, np.asarray(values, dtype=np.float32).ravel())

    def _add(self, name: str, numbers: NDArray[Any], sums: np.dtype[Any] | None = None) -> None:
        kind, width = numbers.dtype.kind, numbers.dtype.itemsize
        little = numbers.astype(numbers.dtype.newbyteorder("<"), copy=False)
        planes = little.view(np.uint8).reshape(-1, width).T
        added_up = [] if sums is None else [sums.kind, sums.itemsize]
        self._columns[name] = [kind, len(numbers), width, len(self._bytes), *added_up]
        self._bytes += planes.tobytes()

    def compressed(self) -> bytes:
        """The whole block under gzip; equal blocks give equal bytes."""
        head = json.dumps({**self.head, "columns": self._columns}, ensure_ascii=False, separators=(",", ":")).encode()
        return gzip.compress(struct.pack("<I", len(head)) + head + bytes(self._bytes), 6, mtime=0)


def _smallest(name: str, numbers: NDArray[np.int64]) -> np.dtype[Any]:
    """The type of the fewest bytes that holds all these numbers as they are."""
    low, high = (int(numbers.min()), int(numbers.max())) if len(numbers) else (0, 0)
    for kind in _WHOLE:
        if np.iinfo(kind).min <= low and high <= np.iinfo(kind).max:
            return np.dtype(kind)
    if not -_MOST <= low <= high <= _MOST:
        raise TraceError(f"{name}: {low} to {high}; the page holds whole numbers from -2**53 to 2**53")
    return np.dtype(np.float64)


def unpack(packed: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """The head and the columns of a compressed block, as the page reads them."""
    raw = gzip.decompress(packed)
    (length,) = struct.unpack_from("<I", raw)
    head = json.loads(raw[4 : 4 + length])
    columns = {}
    for name, (kind, count, width, begin, *sums) in head.pop("columns").items():
        first = 4 + length + begin
        planes = np.frombuffer(raw, np.uint8, count * width, first).reshape(width, count)
        numbers = np.ascontiguousarray(planes.T).view(f"<{kind}{width}").ravel()
        columns[name] = np.cumsum(numbers, dtype="".join(map(str, sums))) if sums else numbers
    return head, columns
