"""The tables of a run for whoever shows it: only what is shown, some thousand rows at a time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.trace.parts import table_schema
from colonysim.trace.schema import Frame
from colonysim.view.columns import Columns

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator, Sequence

    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Table

__all__ = ["Reading", "kept_columns", "no_pheromones"]

_NEEDED: dict[Table, Sequence[str]] = {"deposits": ("episode", "time", "field", "node", "key", "value")}
"""Columns that a page needs, of tables of which it does not need all."""
_LAST_STEP = 0.9
"""Share of the work that is done when everything is read."""


def no_pheromones(run: Run, episodes: Collection[int]) -> str:
    """Why the pheromones of some episodes are not known at each of their moments; empty if they are.

    They are what the episode before ended with, and every deposit since.
    """
    before = [episode - 1 for episode in episodes if episode > 1]
    return next(filter(None, (run.missing("deposits"), *(run.missing("frames", each) for each in before))), "")


def kept_columns(run: Run, table: Table, episodes: Sequence[int]) -> Columns:
    """Rows of some episodes; of a table that the run was not to keep, or that it has none of, no rows."""
    if run.missing(table):
        return Columns(table_schema(table).empty_table(), episodes)
    return Columns(run.table(table), episodes)


class Reading:
    """Reads some episodes of a run, checks that the rows fit its scenario, and tells how far it is.

    Args:
        run: The run.
        episodes: Which of its episodes.
        without: Tables that are not read, as if they were empty.
        progress: Is told the share of the work that is done.
    """

    def __init__(
        self,
        run: Run,
        episodes: Sequence[int],
        without: Collection[Table],
        progress: Callable[[float], None] | None,
    ) -> None:
        self._run, self._part, self._episodes, self._without = run, run.only(episodes), episodes, without
        self._progress = progress
        counted = run.manifest["rows"]
        tables: tuple[Table, ...] = ("events", "decisions", "deposits", "poses", "frames")
        share = len(episodes) / max(len(run.episodes), 1)
        self._expected = max(share * sum(counted.get(table, 0) for table in tables if self._reads(table)), 1.0)
        self._done = 0

    def _reads(self, table: Table) -> bool:
        return table not in self._without and not self._run.missing(table)

    def columns(self, table: Table) -> Columns:
        """The rows of a table."""
        import pyarrow as pa

        pieces = [table_schema(table).empty_table()]
        if needed := _NEEDED.get(table):
            pieces[0] = pieces[0].select(needed)
        if self._reads(table):
            for rows in self._part.pieces(table, needed):
                rows.check_places(self._run.scenario, self._run.by_box)
                pieces.append(_narrow(rows.all))
                self._tell(rows.all.num_rows)
            pieces[0] = _narrow(pieces[0])
        return Columns(pa.concat_tables(pieces), self._episodes)

    def frames(self, episode: int) -> Iterator[Frame]:
        """The pheromone values at the end of an episode."""
        if not self._reads("frames"):
            return
        for rows in self._run.only([episode]).pieces("frames"):
            rows.check_places(self._run.scenario, self._run.by_box)
            columns = (rows.all[name].to_pylist() for name in Frame._fields)
            yield from map(Frame._make, zip(*columns, strict=True))
            self._tell(rows.all.num_rows)

    def _tell(self, rows: int) -> None:
        self._done += rows
        if self._progress is not None:
            self._progress(_LAST_STEP * min(self._done / self._expected, 1.0))


def _narrow(rows: object) -> object:
    """The same rows with each text kept once."""
    import pyarrow as pa

    fields = [
        pa.field(field.name, pa.dictionary(pa.int32(), pa.string()) if field.type == pa.string() else field.type)
        for field in rows.schema  # type: ignore[attr-defined]
    ]
    return rows.cast(pa.schema(fields))  # type: ignore[attr-defined]
