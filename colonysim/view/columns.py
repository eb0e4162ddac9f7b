"""The tables of a run as NumPy columns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from colonysim.errors import TraceError
from colonysim.trace.checks import coded

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray


__all__ = ["Columns"]

_MOST = 2**53
"""Up to here every whole number is exact, also where it is kept as a double."""


class Columns:
    """One table of a run as NumPy columns, for some of its episodes.

    Args:
        rows: The table, a `pyarrow.Table`.
        episodes: Which of its episodes, in order.

    Attributes:
        first: Where the rows of each episode begin, and where those of the last one end.
    """

    def __init__(self, rows: Any, episodes: Sequence[int]) -> None:
        numbers = rows["episode"].to_numpy()
        wanted = np.isin(numbers, episodes)
        self._rows = rows if wanted.all() else rows.filter(wanted)
        self.first = np.searchsorted(numbers[wanted], [*episodes, episodes[-1] + 1])

    def __len__(self) -> int:
        return int(self._rows.num_rows)

    def rows(self, names: Sequence[str]) -> Iterator[tuple[Any, ...]]:
        """The rows themselves, of some of the columns."""
        return zip(*(self._rows[name].to_pylist() for name in names), strict=True)

    def column(self, name: str) -> NDArray[Any]:
        """A column of numbers; of lists, all their numbers one after the other."""
        column = self._rows[name]
        if str(column.type).startswith("list"):
            column = column.combine_chunks().flatten()
        return np.asarray(column)

    def sizes(self, name: str) -> NDArray[Any]:
        """How many numbers each row of a column of lists holds."""
        import pyarrow.compute as pc

        return np.asarray(pc.list_value_length(self._rows[name]), dtype=np.int64)

    def milliseconds(self, name: str = "time") -> NDArray[np.int64]:
        """A column of seconds.

        Raises:
            TraceError: One of them is no number, or so large that its milliseconds are no longer exact.
        """
        times = np.rint(self.column(name) * 1000)
        wrong = np.flatnonzero(~(np.abs(times) <= _MOST))
        if len(wrong):
            raise TraceError(f"{name}: {times[wrong[0]] / 1000:g} s, expected at most {_MOST / 1000:.0f} s")
        return np.asarray(times, dtype=np.int64)

    def words(self, name: str) -> tuple[list[str], NDArray[np.int64]]:
        """A column of texts: the different ones, and for each row which."""
        words, codes = coded(self._rows[name])
        return words, codes.astype(np.int64)
