"""Whether the values of a table can be: what a reader is handed it need not doubt."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.errors import TraceError
from colonysim.trace.fields import MOST
from colonysim.trace.schema import TABLES

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.schema import Table
    from colonysim.trace.stored import Piece

__all__ = ["LONGEST", "Rows", "coded"]

LONGEST = 9e12
"""Seconds; in milliseconds the largest of the numbers that are exact everywhere."""
_TIMES = ("time", "began", "sim_seconds", "wall_seconds")
_ORDERED: tuple[Table, ...] = ("events", "decisions", "deposits")
"""Tables whose times never go back within an episode."""


class Rows:
    """Rows of a table, and where in which file each of them is.

    Args:
        table: Name of the table.
        pieces: The rows.
        empty: The table without rows.

    Attributes:
        all: All of these rows, a `pyarrow.Table`.
    """

    def __init__(self, table: Table, pieces: Sequence[Piece], empty: Any) -> None:
        import pyarrow as pa

        self.table = table
        self._pieces = [(path, first, rows.num_rows) for path, first, rows in pieces]
        self.all = pa.concat_tables([piece.rows for piece in pieces]) if pieces else empty
        self._columns = {name: kind for name, kind in TABLES[table].items() if name in self.all.column_names}

    @property
    def last(self) -> tuple[int, float]:
        """Episode and time of the last row; the time is 0 in a table without, or read without."""
        time = self.all["time"][-1].as_py() if "time" in self._columns else 0.0
        return self.all["episode"][-1].as_py(), time

    def check(self, episodes: int, after: tuple[int, float] | None = None) -> None:
        """Checks what can be said without knowing the place.

        Args:
            episodes: How many episodes the run was to have.
            after: Episode and time of the row before these, if there is one.

        Raises:
            TraceError: The first value that cannot be, by file, column and row.
        """
        import numpy as np

        columns = {n: self._numbers(n) for n, kind in self._columns.items() if kind in ("int", "float")}
        for name, values in columns.items():
            if name in _TIMES:
                self._all(name, (values >= 0) & (values <= LONGEST), f"0 to {LONGEST:g} seconds")
            elif TABLES[self.table][name] == "int":
                self._all(name, (values >= -1) & (values <= MOST), f"-1 to {MOST}")
        number = columns["episode"]
        if self.table == "episodes":
            self._all("episode", number == np.arange(1, len(number) + 1), "1, 2, 3 and so on")
            self._all("success", (columns["success"] >= 0) & (columns["success"] <= 1), "0 to 1")
        self._all("episode", (number >= 1) & (number <= episodes), f"1 to {episodes}")
        number_before = number[:1] if after is None else after[:1]
        steps = np.diff(number, prepend=number_before)
        self._all("episode", steps >= 0, "no number smaller than the one before")
        if self.table in _ORDERED and "time" in columns:
            time = columns["time"]
            later = np.diff(time, prepend=time[:1] if after is None else after[1:]) >= 0
            self._all("time", later | (steps > 0), "no moment before the one before")
        if {"began", "time"} <= columns.keys():
            self._all("began", columns["began"] <= columns["time"], "no moment after the row's time")
        if {"targets", "boxes", "probabilities"} <= self._columns.keys():
            self._check_choices()

    def check_places(self, scenario: Scenario, by_box: Callable[[str], bool]) -> None:
        """Checks that nodes, holes, boxes and agents are those of a scenario, or -1 where there may be none.

        Args:
            scenario: What was run.
            by_box: Whether the values of a field belong to boxes.

        Raises:
            TraceError: As for `check`.
        """
        import numpy as np

        ids = np.asarray(scenario.topology.ids)
        holes = np.asarray([scenario.topology.ids[hole.node] for hole in scenario.holes], dtype=np.int64)
        agents, boxes = len(scenario.agents), len(scenario.boxes)
        columns = self._columns

        def known(name: str, values: Any, of: Any, what: str, where: Any = True) -> None:
            self._all(name, (values == -1) | np.isin(values, of) | ~np.broadcast_to(where, values.shape), what)

        boxed = np.zeros(self.all.num_rows, dtype=bool)
        if "field" in columns:
            words, codes = self._words("field")
            boxed = np.isin(codes, [i for i, word in enumerate(words) if by_box(word)])
            self._all("node", ~boxed | self._below("node", boxes), f"a box, 0 to {boxes - 1}")
            self._all("node", boxed | (self._numbers("node") >= 0), "a node")
        for name in ("node", "target", "now_at", "chosen"):
            if name in columns:
                known(name, self._numbers(name), ids, "a node of the scenario, or -1", ~boxed)
        for name in ("hole", "key"):
            if name in columns:
                known(name, self._numbers(name), holes, "the node of a hole, or -1")
        for name, count in (("agent", agents), ("box", boxes)):
            if name in columns:
                self._all(name, (self._numbers(name) == -1) | self._below(name, count), f"-1 to {count - 1}")
        if self.table == "poses":
            self._check_bodies(agents, boxes)
        elif self.table == "decisions" and {"targets", "boxes"} <= columns.keys():
            self._each("targets", lambda values: np.isin(values, ids), "nodes of the scenario")
            self._each("boxes", lambda values: (values >= -1) & (values < boxes), f"-1 to {boxes - 1}")
        elif self.table == "events" and len(columns) == len(TABLES["events"]):
            self._check_events(agents)

    def _check_events(self, agents: int) -> None:
        """What has to be told with an event of a kind."""
        kinds, kind = self._words("kind")
        actions, action = self._words("action")
        states, status = self._words("status")
        done = _is(kinds, kind, "end")
        pushed = done & _is(actions, action, "push")
        home = _is(kinds, kind, "goal")
        self._all("agent", ~(done | home) | self._below("agent", agents), f"0 to {agents - 1}")
        self._all("now_at", ~done | (self._numbers("now_at") >= 0), "a node")
        self._all("box", ~pushed | (self._numbers("box") >= 0), "a box")
        self._all("target", ~(pushed & _is(states, status, "arrived")) | (self._numbers("target") >= 0), "a node")

    def _check_bodies(self, agents: int, boxes: int) -> None:
        words, codes = self._words("body")
        agent, box = _is(words, codes, "agent"), _is(words, codes, "box")
        self._all("body", agent | box, "agent or box")
        self._all("number", ~agent | self._below("number", agents), f"0 to {agents - 1}")
        self._all("number", ~box | self._below("number", boxes), f"0 to {boxes - 1}")

    def _check_choices(self) -> None:
        import numpy as np
        import pyarrow.compute as pc

        sizes = [np.asarray(pc.list_value_length(self.all[n])) for n in ("targets", "boxes", "probabilities")]
        for name, size in zip(("boxes", "probabilities"), sizes[1:], strict=True):
            self._all(name, size == sizes[0], "as many values as targets")
        for name in ("targets", "boxes"):
            self._each(name, lambda values: (values >= -1) & (values <= MOST), f"-1 to {MOST}")
        self._each("probabilities", lambda values: (values >= 0) & (values <= 1 + 1e-6), "0 to 1")

    def _numbers(self, name: str) -> Any:
        return self.all[name].to_numpy()

    def _words(self, name: str) -> tuple[list[str], Any]:
        return coded(self.all[name])

    def _below(self, name: str, count: int) -> Any:
        values = self._numbers(name)
        return (values >= 0) & (values < count)

    def _each(self, name: str, right: Callable[[Any], Any], expected: str) -> None:
        """Checks all numbers of a column of lists."""
        import numpy as np

        first = 0
        for lists in self.all[name].chunks:
            wrong = np.flatnonzero(~right(np.asarray(lists.flatten())))
            if len(wrong):
                ends = np.cumsum(np.asarray(lists.value_lengths()))
                raise self._fault(name, first + int(np.searchsorted(ends, wrong[0], "right")), expected)
            first += len(lists)

    def _all(self, name: str, right: Any, expected: str) -> None:
        if not right.all():
            raise self._fault(name, int((~right).argmax()), expected)

    def _fault(self, name: str, row: int, expected: str) -> TraceError:
        found, at = self.all[name][row].as_py(), row
        for path, first, count in self._pieces:
            if at < count:
                where = f"{path}: column {name!r}, row {first + at}"
                return TraceError(f"{where}: is {str(found)[:60]}, expected {expected}")
            at -= count
        raise IndexError(row)


def _is(words: list[str], codes: Any, word: str) -> Any:
    return codes == (words.index(word) if word in words else -1)


def coded(column: Any) -> tuple[list[str], Any]:
    """The different texts of a column (`pyarrow.ChunkedArray`), and for each row which."""
    found = column.combine_chunks().dictionary_encode()
    if hasattr(found, "chunks"):
        found = found.unify_dictionaries().combine_chunks()
    return found.dictionary.to_pylist(), found.indices.to_numpy()
