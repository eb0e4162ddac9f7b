"""Columns of numbers as few bytes: what the page unpacks again is described in the block's own head."""

from __future__ import annotations

import gzip
import json
import struct
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

__all__ = ["Block", "unpack"]

_WHOLE = (np.int8, np.int16, np.int32)


class Block:
    """Named columns that travel together, with a head of plain data.

    Whole numbers take as many bytes as the largest needs, those that grow steadily are kept as differences, and all
    first bytes lie before all second ones: gzip finds far more to save that way.

    Layout, little-endian: length of the head (4 bytes), the head as JSON, the columns. The head names for each
    column its kind ("i" or "f"), count of values, bytes a value, whether these are differences, and where it begins.

    Attributes:
        head: Plain data for the page.
    """

    def __init__(self) -> None:
        self.head: dict[str, Any] = {}
        self._columns: dict[str, list[Any]] = {}
        self._bytes = bytearray()

    def ints(self, name: str, values: ArrayLike, *, steps: bool = False) -> None:
        """Adds whole numbers of up to 32 bits; `steps` keeps differences, which suits times and paths.

        Raises:
            OverflowError: A number does not fit 32 bits.
        """
        numbers = np.asarray(values, dtype=np.int64).ravel()
        if steps:
            numbers = np.diff(numbers, prepend=0)
        low, high = (int(numbers.min()), int(numbers.max())) if len(numbers) else (0, 0)
        for kind in _WHOLE:
            if np.iinfo(kind).min <= low and high <= np.iinfo(kind).max:
                return self._add(name, "i", numbers.astype(kind), steps)
        raise OverflowError(f"{name}: {low} to {high} do not fit 32 bits")

    def reals(self, name: str, values: ArrayLike) -> None:
        """Adds numbers with some seven digits."""
        self._add(name, "f", np.asarray(values, dtype=np.float32).ravel(), False)

    def _add(self, name: str, kind: str, numbers: NDArray[Any], steps: bool) -> None:
        width = numbers.dtype.itemsize
        little = numbers.astype(numbers.dtype.newbyteorder("<"), copy=False)
        planes = little.view(np.uint8).reshape(-1, width).T
        self._columns[name] = [kind, len(numbers), width, int(steps), len(self._bytes)]
        self._bytes += planes.tobytes()

    def compressed(self) -> bytes:
        """The whole block under gzip; equal blocks give equal bytes."""
        head = json.dumps({**self.head, "columns": self._columns}, ensure_ascii=False, separators=(",", ":")).encode()
        return gzip.compress(struct.pack("<I", len(head)) + head + bytes(self._bytes), 6, mtime=0)


def unpack(packed: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """The head and the columns of a compressed block, as the page reads them."""
    raw = gzip.decompress(packed)
    (length,) = struct.unpack_from("<I", raw)
    head = json.loads(raw[4 : 4 + length])
    columns = {}
    for name, (kind, count, width, steps, begin) in head.pop("columns").items():
        first = 4 + length + begin
        planes = np.frombuffer(raw, np.uint8, count * width, first).reshape(width, count)
        numbers = np.ascontiguousarray(planes.T).view(f"<{kind}{width}").ravel()
        columns[name] = np.cumsum(numbers, dtype=np.int64) if steps else numbers
    return head, columns
