"""The rows of a run under way as blocks that a page adds to what it has."""

from __future__ import annotations

import threading
from collections import deque
from typing import TYPE_CHECKING, Any

from colonysim.trace.parts import arrow_table, table_schema
from colonysim.trace.schema import Frame
from colonysim.view.columns import Columns
from colonysim.view.content import add_comings, add_rows
from colonysim.view.marks import Fields
from colonysim.view.packing import Block
from colonysim.view.reading import no_pheromones

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.trace.packing import Codes, Packed
    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Table
    from colonysim.view.marks import Mark

__all__ = ["Feed"]

_Piece = tuple["Table", "dict[str, Packed]", "Mapping[str, Codes]"]

_SHOWN: tuple[Table, ...] = ("events", "decisions", "deposits", "poses")
_HEARD = frozenset((*_SHOWN, "frames", "episodes"))
_MOST_BYTES = 128 * 2**20
"""Of packed rows that are kept for pages yet to come; then the oldest go."""
_MOST_ROWS = 2_000_000
"""That wait to be packed; then the oldest go. An agent or a box that is lost so is back with its next event."""
_PAUSE = 0.2
"""Seconds of wall clock between two blocks."""


class Feed:
    """Packs the rows of a run under way in a thread of its own; the simulation only drops copies of them here.

    Blocks have the form of a page's own data (`colonysim.view.content.gather`), of one episode each, with the rows
    that are new. They are kept, within bounds, for pages that are opened later; nobody waits for anybody.

    Args:
        run: The run that is being recorded.

    Attributes:
        trouble: What went wrong if the rows could not be packed, else empty; the run goes on without its page.
    """

    def __init__(self, run: Run) -> None:
        self.trouble = ""
        self._run = run
        self._agents = len(run.scenario.agents)
        self._fields = Fields(run)
        # Pheromones that cannot be shown right are not shown.
        self._marked = not no_pheromones(run, range(1, run.manifest["episodes"] + 1))
        # What may be ended by a signal takes the lock itself: one that came within the condition's own methods would
        # leave it locked for good.
        self._lock = threading.RLock()
        self._change = threading.Condition(self._lock)
        self._open: list[_Piece] = []
        self._waiting: deque[_Piece] = deque()
        self._rows = 0
        self._ended = False
        self._blocks: deque[bytes] = deque()
        self._first = 0
        self._bytes = 0
        self._under_way = _UnderWay()
        self._frames: list[Frame] = []
        self._thread = threading.Thread(target=self._work, name="colonysim feed", daemon=True)
        self._thread.start()

    # -- the simulation's side ------------------------------------------------------------------------------------

    def take(self, table: Table, columns: Mapping[str, Packed], codes: Mapping[str, Codes]) -> None:
        """Takes a table's next rows."""
        if table in _HEARD:
            self._open.append((table, {name: column.copy() for name, column in columns.items()}, codes))

    def cut(self) -> None:
        """Lets the rows so far be packed."""
        with self._lock:
            for piece in self._open if not self.trouble else ():
                self._waiting.append(piece)
                self._rows += _length(piece)
            while self._rows > _MOST_ROWS and len(self._waiting) > 1:
                self._rows -= _length(self._waiting.popleft())
            self._open.clear()
            self._change.notify_all()

    def end(self) -> None:
        """Says that no more rows will come; the last block tells how the run ended. Returns when it is there."""
        with self._lock:
            self._ended = True
            self._change.notify_all()
        self._thread.join()

    # -- the pages' side ------------------------------------------------------------------------------------------

    def after(self, number: int, most: int = 2**20) -> tuple[int, list[bytes]]:
        """Blocks from a number on, about as many bytes as asked for; and the number of the first of them."""
        with self._change:
            begin = max(number, self._first)
            found, size = [], 0
            for i in range(begin - self._first, len(self._blocks)):
                found.append(self._blocks[i])
                size += len(self._blocks[i])
                if size >= most:
                    break
            return begin, found

    @property
    def over(self) -> bool:
        """Whether the last block is there."""
        return not self._thread.is_alive()

    @property
    def end_number(self) -> int:
        """The number that the next block will have."""
        with self._change:
            return self._first + len(self._blocks)

    # -- the thread between them ----------------------------------------------------------------------------------

    def _work(self) -> None:
        over = False
        while not over:
            with self._change:
                self._change.wait_for(lambda: self._waiting or self._ended)
                pieces, over = list(self._waiting), self._ended
                self._waiting.clear()
                self._rows = 0
            blocks, over = self._blocks_of(pieces, over)
            with self._change:
                for block in blocks:
                    self._blocks.append(block)
                    self._bytes += len(block)
                while self._bytes > _MOST_BYTES and len(self._blocks) > 1:
                    self._bytes -= len(self._blocks.popleft())
                    self._first += 1
                if not over:
                    self._change.wait_for(lambda: self._ended, _PAUSE)

    def _blocks_of(self, pieces: Sequence[_Piece], over: bool) -> tuple[list[bytes], bool]:
        """The next blocks, and whether they are the last."""
        try:
            blocks = self._pack(pieces)
        except Exception as error:  # whatever it is: nobody else would hear of it, and the run must not end by it
            self.trouble = f"{type(error).__name__}: {error}"
            return [_last("running", None, self.trouble)], True
        return ([*blocks, _last(self._run.status, self._run.trace_sha256)] if over else blocks), over

    def _pack(self, pieces: Sequence[_Piece]) -> list[bytes]:
        import pyarrow as pa

        tables: dict[Table, Any] = {}
        for table in _HEARD:
            shown = self._marked or table not in ("deposits", "frames")
            mine = [arrow_table(columns, codes) for name, columns, codes in pieces if shown and name == table]
            tables[table] = pa.concat_tables(mine) if mine else table_schema(table).empty_table()
        episodes = sorted({number for rows in tables.values() for number in rows["episode"].unique().to_pylist()})
        return [self._block(tables, episode) for episode in episodes]

    def _block(self, tables: Mapping[Table, Any], episode: int) -> bytes:
        """What is new of one episode."""
        columns = {table: Columns(rows, [episode]) for table, rows in tables.items()}
        begins = episode != self._under_way.episode
        if begins:
            self._under_way = _UnderWay(episode)
        before: list[Mark] = self._fields.after(self._frames) if begins and self._frames else []
        self._under_way.add(columns["events"])
        block, scenario, by_hand = Block(), self._run.scenario, self._run.manifest.get("by_hand")
        block.head = {"status": "running", "hash": None, "episodes": [self._result(columns["episodes"])]}
        if by_hand:  # which the page has not been told of at the beginning
            add_comings(block, scenario, by_hand)
        add_rows(block, scenario, columns.__getitem__, [episode], self._fields, [before])
        frames = columns["frames"]
        if begins:
            self._frames = []
        if len(frames):
            self._frames += map(Frame._make, frames.rows(Frame._fields))
        return block.compressed()

    def _result(self, episodes: Columns) -> list[Any]:
        """How the episode went, or has gone so far."""
        if not len(episodes):
            return self._under_way.result(self._agents)
        names = ("episode", "steps", "success", "ended", "sim_seconds", "seated")
        return list(next(episodes.rows(names)))


def _last(status: str, digest: str | None, trouble: str = "") -> bytes:
    """The block after which a page asks for no more."""
    block = Block()
    block.head = {"status": status, "hash": digest, "trouble": trouble, "episodes": []}
    return block.compressed()


def _length(piece: _Piece) -> int:
    return piece[1]["episode"].rows


class _UnderWay:
    """How far the present episode has come."""

    def __init__(self, episode: int = 0) -> None:
        self.episode = episode
        self._steps = self._there = 0
        self._time = 0.0

    def add(self, events: Columns) -> None:
        if not len(events):
            return
        kinds, kind = events.words("kind")
        self._steps = max(self._steps, int(events.column("step").max()))
        self._there += int((kind == kinds.index("goal")).sum()) if "goal" in kinds else 0
        self._time = float(events.column("time")[-1])

    def result(self, agents: int) -> list[Any]:
        return [self.episode, self._steps, self._there / max(agents, 1), "", self._time, 0]
