# cython: auto_pickle=False
"""The sink that turns a simulation's rows into a run directory and one hash."""

from __future__ import annotations

import signal
import threading
import time
from collections import deque
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from colonysim.errors import TraceError
from colonysim.files import remove_file
from colonysim.trace.manifest import finish_manifest, write_manifest
from colonysim.trace.packing import Block, TableDigest, trace_sha256
from colonysim.trace.parts import PartFile
from colonysim.trace.schema import TABLES, EpisodeResult
from colonysim.trace.stored import kept_parts, read_parts

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping
    from pathlib import Path
    from types import FrameType, TracebackType

    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.packing import Packed
    from colonysim.trace.schema import Table, Tap

__all__ = ["TraceWriter"]

#: Rows that become columns at a time: as many as stay in a processor's cache.
BLOCK = 512
#: Rows that go to disk at a time.
GROUP = 2048
#: Share of a table's rows that one part may hold, once there are many.
SHARE = 1 / 256
#: Shortest time between two moments that a tap learns of, wall clock.
SHARE_SECONDS = 0.2


class TraceWriter:
    """Takes rows, hashes them, and writes them as Parquet parts, each renamed into place.

    Rows wait in a list until there are a few hundred, then become columns and a share of the hash. A few thousand go
    to disk as a group of the table's open part. That is closed, and so becomes readable, when an event comes more than
    two seconds (or a tenth of the run's time so far) after the last parts were, or when it holds `rows_per_part` rows.
    So memory does not grow with a run's steps, a killed run loses the last tenth of its time at most, and a long one
    does not end as thousands of small files: with time their number grows as its logarithm does. The hash does not
    depend on any of this.

    Args:
        directory: Where to write; an existing, empty directory. None to hash only.
        manifest: From `begin_manifest`; stored at once as "running", again at the end. Of what it says below
            "recorded" the writer heeds which key frames are kept.
        drop: Tables that are neither written nor hashed.
        rows_per_part: Most rows in a part, as long as a table has no more than 256 such parts.
        flush_seconds: Shortest time between two flushes that do not come of a full table, wall clock.
        tap: Is told all rows that are kept as well.

    Attributes:
        results: The results of the episodes so far.
        block_rows: So many rows become columns at a time.

    Example:
        >>> writer = TraceWriter(None, {})
        >>> writer.write("controls", (1, 0.5, 0, "script", "travel", 50))
        >>> len(writer.finish("finished"))
        64
    """

    def __init__(
        self,
        directory: Path | None,
        manifest: dict[str, Any],
        *,
        drop: Collection[Table] = (),
        rows_per_part: int = 2**20,
        flush_seconds: float = 2.0,
        tap: Tap | None = None,
    ) -> None:
        self.directory = directory
        self.manifest = manifest
        self._pending: dict[Table, Any] = {}
        self._digests: dict[Table, TableDigest] = {}
        self.results: list[EpisodeResult] = []
        self._packed: dict[Table, dict[str, Packed]] = {}
        self._parts: dict[Table, int] = {}
        self._open: dict[Table, PartFile] = {}
        self._lost = ""
        for table in TABLES:
            if table in drop:
                self._pending[table] = deque(maxlen=0)  # swallows what it is given
                continue
            digest = self._digests[table] = TableDigest(table)
            self._pending[table] = digest.waiting()
            self._packed[table] = {}
            self._parts[table] = 0
        self.block_rows = min(BLOCK, rows_per_part)
        self._group_rows = min(GROUP, rows_per_part)
        self._rows_per_part = rows_per_part
        self._flush_seconds = flush_seconds
        self._begun = self._flushed = self._shared = time.monotonic()
        self._tap = tap
        self._done = False
        if directory is not None:
            write_manifest(directory, manifest)

    def write(self, table: Table, row: tuple[object, ...]) -> None:
        """Takes one row, in the order of the table's columns."""
        rows = self._pending[table]
        rows.append(row)
        if table == "episodes":
            self.results.append(EpisodeResult._make(row))
        if len(rows) >= self.block_rows:
            self.pack(table)
        elif table == "events" or table == "episodes":
            now = time.monotonic()
            if now - self._flushed >= max(self._flush_seconds, 0.1 * (now - self._begun)):
                self.flush()

    def block(self, table: Table) -> Block | None:
        """The table's next rows, for one who writes them there value by value and calls `pack` when there are many.

        None if they were not compiled, or if the table is dropped.
        """
        rows = self._pending[table]
        return rows if Block is not None and isinstance(rows, Block) else None

    def keeps(self, table: Table, episode: int) -> bool:
        """Whether rows of an episode in a table are kept; others need not be made."""
        if table not in self._digests:
            return False
        last_only = table == "frames" and self.manifest.get("recorded", {}).get("frames") == "last"
        return not last_only or episode == self.manifest["episodes"]

    def describe(self, fields: Mapping[str, bool]) -> None:
        """Says in the manifest which pheromone fields there are, and whether their values belong to boxes.

        Readers learn it from there: they do not load the code of a policy.

        Raises:
            TraceError: The directory cannot be written to.
        """
        told = {name: {"by_box": by_box} for name, by_box in fields.items()}
        if self.manifest.get("fields") != told:
            self.manifest["fields"] = told
            if self.directory is not None:
                write_manifest(self.directory, self.manifest)

    def note_change(self, scenario: Scenario) -> None:
        """Says in the manifest that the run goes on with another scenario: its timeline has got a change by hand.

        The manifest then holds that scenario, from which the whole run can be repeated; which changes were made by hand
        stands below "by_hand". A run that is resumed may know more changes than have been made again.

        Raises:
            TraceError: The directory cannot be written to.
        """
        known, count = self.manifest.get("scenario") or {}, len(scenario.changes)
        if len(known.get("changes") or ()) >= count:
            return
        self.manifest.update(scenario=scenario.document, scenario_sha256=scenario.digest)
        self.manifest["by_hand"] = [*self.manifest.get("by_hand", ()), count - 1]
        if self.directory is not None:
            write_manifest(self.directory, self.manifest)

    @property
    def rows(self) -> dict[str, int]:
        """How many rows each table has, without those that are still waiting."""
        return {table: digest.rows for table, digest in self._digests.items()}

    def take_up(self, rows: Mapping[str, int]) -> None:
        """Goes on after so many rows of each table, which are on disk already; what is there beyond them is removed.

        Args:
            rows: For each table how many of its rows count; none of one that is not named.

        Raises:
            TraceError: A part is damaged or missing, or the rows that count do not end where a part does.
        """
        assert self.directory is not None
        beyond: list[Path] = []
        for table, digest in self._digests.items():
            kept, more = kept_parts(self.directory, table, rows.get(table, 0), digest)
            self._parts[table] = kept
            beyond += more
        # Episodes first: one that is listed is on disk as a whole.
        for path in sorted(beyond, key=lambda path: (path.parent.name == "episodes", path), reverse=True):
            remove_file(path, TraceError)
        results = read_parts(self.directory, "episodes", None) if rows.get("episodes") else ()
        self.results[:] = [EpisodeResult(**row) for piece in results for row in piece.rows.to_pylist()]

    def flush(self) -> None:
        """Closes all parts, with everything that is still in memory; episodes last, so that a listed one is complete.

        Raises:
            TraceError: The directory cannot be written to.
        """
        for table in self._digests:
            self.pack(table)
            self._close(table)
        self._flushed = time.monotonic()

    def share(self) -> None:
        """Tells the tap what it has not been told yet, unless that was done just now.

        To be called between two steps of the simulation: an event and the poses that go with it are one moment.

        Raises:
            TraceError: The directory cannot be written to.
        """
        if self._tap is not None and time.monotonic() - self._shared >= SHARE_SECONDS:
            self.share_now()

    def share_now(self) -> None:
        """Tells the tap what it has not been told yet; as `share`.

        Raises:
            TraceError: The directory cannot be written to.
        """
        if self._tap is None:
            return
        self._shared = time.monotonic()
        for table in self._digests:
            self.pack(table)
        self._tap.cut()

    def pack(self, table: Table) -> None:
        """Takes the table's waiting rows into the hash, and to disk once they are many.

        Raises:
            TraceError: The directory cannot be written to.
        """
        rows = self._pending[table]
        if not rows:
            return
        with _Undisturbed():
            columns = self._digests[table].add(rows)
            if isinstance(rows, list):
                rows.clear()
            if self._tap is not None:
                self._tap.take(table, columns, self._digests[table].codes)
            if self.directory is None:
                return
            packed = self._packed[table]
            for name, column in columns.items():
                if name in packed:
                    packed[name].extend(column)
                else:
                    packed[name] = column
        if packed["episode"].rows >= self._group_rows:
            self._store(table)
            if self._open[table].rows >= max(self._rows_per_part, SHARE * self._digests[table].rows):
                if table == "episodes":  # one that is listed is on disk as a whole
                    for other in self._digests:
                        if other != table:
                            self.pack(other)
                            self._close(other)
                self._close(table)

    def _store(self, table: Table) -> None:
        """Adds what is in memory to the table's open part."""
        packed = self._packed[table]
        if not packed or self.directory is None:
            return
        with _Undisturbed(), self._told():
            if table not in self._open:
                path = self.directory / table / f"part-{self._parts[table]:05d}.parquet"
                self._open[table] = PartFile(path, packed)
            self._open[table].add(packed, self._digests[table].codes)
            packed.clear()

    def _close(self, table: Table) -> None:
        """Puts the table's open part, with what is in memory, into its place."""
        self._store(table)
        if table in self._open:
            with _Undisturbed(), self._told():
                self._open.pop(table).close()
                self._parts[table] += 1

    @contextmanager
    def _told(self) -> Iterator[None]:
        """What could not be written is lost, and then nothing more is: rows must not follow after a gap."""
        if self._lost:
            raise TraceError(self._lost)
        try:
            yield
        except BaseException as error:
            self._lost = str(error)
            for part in self._open.values():
                part.abandon()
            self._open.clear()
            raise

    def finish(self, status: str) -> str:
        """Writes what is left and the final manifest; returns the trace's hash.

        Args:
            status: "finished", "interrupted" or "failed".

        Raises:
            TraceError: The directory cannot be written to, or the writer is finished already.
        """
        if self._done:
            raise TraceError("this trace is finished already")
        with _Undisturbed():
            self.flush()
            if self._tap is not None:
                self._tap.cut()
            self._done = True
            digest = trace_sha256(self._digests.values())
            finish_manifest(self.manifest, status, {t: d.rows for t, d in self._digests.items()}, digest)
            if self.directory is not None:
                write_manifest(self.directory, self.manifest)
        return digest

    def __enter__(self) -> TraceWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Finishes the run as what it became, unless that was done."""
        if self._done:
            return
        stopped = kind is not None and issubclass(kind, (KeyboardInterrupt, GeneratorExit))
        self.finish("finished" if kind is None else "interrupted" if stopped else "failed")


#: What may ask a run to end; Windows has not all of them.
_STOPS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


class _Undisturbed:
    """Lets Ctrl-C and its like wait for the end of the block: rows must be hashed and written once, not half or twice.

    What was to be done on such a signal is done then; one that is ignored stays so.
    """

    def __enter__(self) -> None:
        self._came: list[int] = []
        self._before: dict[int, Any] = {}
        # Elsewhere than in the main thread no handler can be set, and none is ever called.
        if threading.current_thread() is threading.main_thread():
            for number in _STOPS:
                before = signal.getsignal(number)
                if callable(before):
                    self._before[number] = before
                    signal.signal(number, self._wait)

    def _wait(self, number: int, frame: FrameType | None) -> None:
        self._came.append(number)

    def __exit__(self, *_: object) -> None:
        # Ctrl-C last: it is the one that comes twice.
        for number, before in reversed(self._before.items()):
            signal.signal(number, before)
        for number in dict.fromkeys(self._came):
            self._before[number](number, None)
