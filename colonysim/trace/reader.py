"""Reading a run directory: everything that is shown of a run comes through here."""

from __future__ import annotations

import copy
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from colonysim.arguments import whole
from colonysim.errors import TraceError
from colonysim.trace.checks import Rows
from colonysim.trace.manifest import MANIFEST, read_manifest
from colonysim.trace.packing import TableDigest, trace_sha256
from colonysim.trace.parts import read_parts, table_schema
from colonysim.trace.schema import TABLES, EpisodeResult, Event, Frame, Table

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

    from colonysim.scenario.scenario import Scenario

__all__ = ["Run"]


class Run:
    """A run that was recorded, or is being recorded, in a directory.

    Example:
        ```python
        run = Run.open("runs/hard-nodeworld-s0-1")
        print(run.status, [episode.steps for episode in run.episodes])
        distances = run.field("D", episode=3)  # {node: value}
        ```

    Attributes:
        path: The run directory, absolute; None for a run that kept no trace (its episodes are all there is).
        manifest: What was run, as plain data.
    """

    def __init__(
        self,
        path: Path | None,
        manifest: dict[str, Any],
        episodes: list[EpisodeResult] | None = None,
        scenario: Scenario | None = None,
    ) -> None:
        # Whoever holds a run may change the working directory.
        self.path = None if path is None else Path(path).absolute()
        self.manifest = manifest
        self._episodes = episodes
        self._scenario = scenario
        self._tables: dict[str, Rows] = {}
        self._only: Collection[int] | None = None

    @classmethod
    def open(cls, path: str | Path) -> Run:
        """Opens a run directory, also of a run that is still under way or was killed.

        Nothing that the directory names is imported or called: neither policies nor fields nor backends.

        Raises:
            TraceError: There is no such directory, it is not a run's, a newer version wrote it, or its manifest is
                wrong.
        """
        directory = Path(path).absolute()
        return cls(directory, read_manifest(directory))

    def __repr__(self) -> str:
        return f"Run({str(self.path) if self.path else None!r}, status={self.status!r})"

    @property
    def status(self) -> str:
        """How it ended: "finished", "interrupted" or "failed"; "running" if that was never written."""
        return str(self.manifest["status"])

    @property
    def shortfall(self) -> str:
        """How far a run came that is not finished, such as "interrupted after 3 of 30 episodes"; else empty.

        Raises:
            TraceError: A part is damaged.
        """
        if self.status == "finished":
            return ""
        how = "running or killed" if self.status == "running" else self.status
        return f"{how} after {len(self.episodes)} of {self.manifest['episodes']} episodes"

    @property
    def trace_sha256(self) -> str | None:
        """The hash over all rows, if the run came to its end."""
        digest = self.manifest.get("trace_sha256")
        return None if digest is None else str(digest)

    @property
    def scenario(self) -> Scenario:
        """The scenario as it was run, after variant and overrides.

        Raises:
            TraceError: It is a run without one, such as that of an evaluation.
            ScenarioError: The manifest's scenario is wrong.
        """
        if self._scenario is not None:
            return self._scenario
        from colonysim.scenario.loading import scenario_from_document

        if self.manifest.get("scenario") is None:
            raise TraceError(f"{self.path}: a run of single pushes, which has no scenario")
        source = "<run>" if self.path is None else f"{self.path / MANIFEST}: scenario"
        self._scenario = scenario_from_document(self.manifest["scenario"], source=source)
        return self._scenario

    @property
    def episodes(self) -> list[EpisodeResult]:
        """The results of all complete episodes."""
        if self._episodes is None:
            rows = self.table("episodes").to_pylist()
            self._episodes = [EpisodeResult(**row) for row in rows]
        return self._episodes

    def table(self, name: Table) -> Any:
        """All rows of a table as a `pyarrow.Table`; see `colonysim.trace.schema.TABLES` for the columns.

        Raises:
            TraceError: No such table, a damaged part, or a run that kept no trace.
        """
        if name not in get_args(Table):
            raise TraceError(f"no table {name!r} in a trace; there are: {', '.join(TABLES)}")
        if self.path is None:
            raise TraceError("this run kept no trace; run it again with one to read its tables")
        return self._rows(name).all

    def _rows(self, name: Table) -> Rows:
        """All rows of a table, checked."""
        assert self.path is not None
        if name in self._tables:
            return self._tables[name]
        # What is still being written is read anew each time. A complete episode has all its rows: of one that is known
        # to be complete before the others are read, its last event has to be there.
        growing = self.status == "running" and name == "events" and self._only is None
        complete = len(self.table("episodes")) if growing else 0
        rows = Rows(name, [*self._chosen(name)], table_schema(name).empty_table())
        rows.check(self.manifest["episodes"])
        last = rows.all["episode"][-1].as_py() if rows.all.num_rows else 0
        if last < complete:
            there = f"ends with episode {last}, but {complete} are complete"
            raise TraceError(f"{self.path / name}: {there}; a part is missing")
        if self.status != "running":
            self._tables[name] = rows
        return rows

    def _chosen(self, name: Table) -> Iterator[tuple[Path, Any]]:
        """The parts of a table, only the rows of the episodes that count."""
        if self._only is None or name == "episodes":
            yield from self._parts(name)
            return
        import pyarrow as pa
        import pyarrow.compute as pc

        wanted = pa.array(sorted(self._only), pa.int64())
        for path, rows in self._parts(name):
            yield path, rows.filter(pc.is_in(rows["episode"], value_set=wanted))

    def _parts(self, name: Table, columns: Sequence[str] | None = None) -> Iterator[tuple[Path, Any]]:
        """The parts of a table as they are on disk: as many rows as were counted when the run ended."""
        assert self.path is not None
        if not self.path.is_dir():
            raise TraceError(f"{self.path}: no such run directory; it was there when the run was opened")
        counted = None if self.status == "running" else self.manifest["rows"].get(name, 0)
        return read_parts(self.path, name, counted, columns)

    def check_places(self, *names: Table) -> None:
        """Checks that the nodes, holes, boxes and agents in some tables are those of the scenario.

        For whoever looks them up there; without names, in all tables.

        Raises:
            TraceError: One is not, a part is damaged, or the run kept no trace or has no scenario.
            ScenarioError: The scenario is wrong.
        """
        for name in names or TABLES:
            if self.table(name).num_rows:
                self._rows(name).check_places(self.scenario, self.by_box)

    def check_apart(self, out: str | Path) -> None:
        """Checks that a file which is to be written is none of the run's own: neither its manifest nor in a table.

        Raises:
            TraceError: It is.
        """
        if self.path is None:
            return
        try:
            within = Path(out).resolve().relative_to(self.path.resolve()).parts
        except (OSError, ValueError, RuntimeError):  # elsewhere, or no name of a file at all
            return
        if within and within[0] in (MANIFEST, *TABLES):
            raise TraceError(f"{out}: is part of the run; write to another file")

    def by_box(self, field: str) -> bool:
        """Whether the values of a pheromone field belong to boxes instead of nodes; without the field's own code."""
        told = self.manifest.get("fields", {}).get(field)
        return field == "B" if told is None else bool(told["by_box"])

    def only(self, episodes: Collection[int]) -> Run:
        """The same run with tables that hold the rows of some episodes: the others take no memory.

        Args:
            episodes: Their numbers; the list of `episodes` stays that of the whole run.
        """
        part = copy.copy(self)
        part._only, part._tables = episodes, {}
        return part

    def rows_by_episode(self, name: Table) -> dict[int, int]:
        """How many rows each episode has in a table; these are counted without being read.

        Raises:
            TraceError: A damaged part, or a run that kept no trace.
        """
        if self.path is None:
            raise TraceError("this run kept no trace; run it again with one to read its tables")
        found: Counter[int] = Counter()
        for _, rows in self._parts(name, ("episode",)):
            for each in rows["episode"].value_counts().to_pylist():
                found[each["values"]] += each["counts"]
        return dict(found)

    def _of_episode(self, name: Table, episode: int | None) -> Any:
        table = self.table(name)
        if episode is None:
            return table
        episode = whole("episode", episode)
        import pyarrow.compute as pc

        return table.filter(pc.equal(table["episode"], episode))

    def events(self, episode: int | None = None) -> Iterator[Event]:
        """What happened, in order; of one episode if given, which need not be complete.

        Raises:
            TraceError: The run has no such episode.
        """
        table = self._of_episode("events", episode)
        if episode is not None and not len(table):
            self._complete(episode)
        for batch in table.to_batches(max_chunksize=4096):
            columns = [batch.column(name).to_pylist() for name in Event._fields]
            yield from map(Event._make, zip(*columns, strict=True))

    def frames(self, episode: int | None = None, field: str | None = None) -> list[Frame]:
        """The pheromone values at the end of an episode (default: the last complete one).

        Raises:
            TraceError: The run has no such episode or field.
        """
        episode = self._complete(episode)
        table = self._of_episode("frames", episode)
        columns = [table[name].to_pylist() for name in Frame._fields]
        frames = list(map(Frame._make, zip(*columns, strict=True)))
        if field is None:
            return frames
        chosen = [frame for frame in frames if frame.field == field]
        if not chosen:
            known = ", ".join(sorted({frame.field for frame in frames})) or "none"
            raise TraceError(f"episode {episode} has no values of a field {field!r}; fields: {known}")
        return chosen

    def field(self, name: str, episode: int | None = None) -> dict[Any, float]:
        """A pheromone field at the end of an episode (default: the last complete one).

        Returns:
            {node: value} for a field with one value per node (D, E); {(node, key): value} else: H is kept
            for a node and a hole, B for a box (in place of the node) and a hole.

        Raises:
            TraceError: The run has no such episode or field.
        """
        frames = self.frames(episode, name)
        if all(frame.key == -1 for frame in frames):
            return {frame.node: frame.value for frame in frames}
        return {(frame.node, frame.key): frame.value for frame in frames}

    def _complete(self, episode: int | None) -> int:
        numbers = [result.episode for result in self.episodes]
        if not numbers:
            raise TraceError(f"{self.path}: no episode of this run is complete")
        if episode is None:
            return numbers[-1]
        episode = whole("episode", episode)
        if episode not in numbers:
            raise TraceError(f"no episode {episode} in this run; it has {numbers[0]} to {numbers[-1]}")
        return episode

    def verify(self) -> bool:
        """Whether the rows on disk, and the scenario, are those that were written: by the manifest's hashes.

        Raises:
            TraceError: A part is damaged or missing, or the run never came to its end.
        """
        from colonysim.scenario.assemble import digest

        if self.trace_sha256 is None:
            raise TraceError(f"{self.path}: the run was not finished, so there is no hash to compare with")
        if self.path is None:
            raise TraceError("this run kept no trace; there is nothing to compare its hash with")
        digests = []
        for name in TABLES:
            # Part by part: a long run does not have to fit into memory.
            rows = TableDigest(name)
            for _, part in self._parts(name):
                rows.add(list(zip(*(column.to_pylist() for column in part.columns), strict=True)))
            if name in self.manifest["rows"]:
                digests.append(rows)
        scenario = self.manifest.get("scenario")
        told = self.manifest.get("scenario_sha256")
        return trace_sha256(digests) == self.trace_sha256 and (scenario is None or digest(scenario) == told)
