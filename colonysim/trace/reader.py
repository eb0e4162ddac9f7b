"""Reading a run directory: everything that is shown of a run comes through here."""

from __future__ import annotations

import copy
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from colonysim.errors import TraceError
from colonysim.trace.manifest import read_manifest
from colonysim.trace.packing import TableDigest, trace_sha256
from colonysim.trace.parts import read_parts, rows_by_episode
from colonysim.trace.schema import TABLES, EpisodeResult, Event, Frame, Table

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    from colonysim.world.scenario import Scenario

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
        path: The run directory; None for a run that kept no trace (its episodes are all there is).
        manifest: What was run, as plain data.
    """

    def __init__(
        self, path: Path | None, manifest: dict[str, Any], episodes: list[EpisodeResult] | None = None
    ) -> None:
        self.path = path
        self.manifest = manifest
        self._episodes = episodes
        self._tables: dict[str, Any] = {}
        self._only: Collection[int] | None = None

    @classmethod
    def open(cls, path: str | Path) -> Run:
        """Opens a run directory, also of a run that is still under way or was killed.

        Raises:
            TraceError: There is no such directory, it is not a run's, or a newer version wrote it.
        """
        return cls(Path(path), read_manifest(Path(path)))

    def __repr__(self) -> str:
        return f"Run({str(self.path) if self.path else None!r}, status={self.status!r})"

    @property
    def status(self) -> str:
        """How it ended: "finished", "interrupted" or "failed"; "running" if that was never written."""
        return str(self.manifest["status"])

    @property
    def trace_sha256(self) -> str | None:
        """The hash over all rows, if the run came to its end."""
        digest = self.manifest["trace_sha256"]
        return None if digest is None else str(digest)

    @cached_property
    def scenario(self) -> Scenario:
        """The scenario as it was run, after variant and overrides.

        Raises:
            TraceError: It is a run without one, such as that of an evaluation.
        """
        from colonysim.world.loading import scenario_from_document

        if "scenario" not in self.manifest:
            raise TraceError(f"{self.path}: a run of single pushes, which has no scenario")
        return scenario_from_document(self.manifest["scenario"])

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
        if name in self._tables:
            return self._tables[name]
        rows = read_parts(self.path, name, None if name == "episodes" else self._only)
        if self.status != "running":  # what is still being written must be read anew
            self._tables[name] = rows
        return rows

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
        return rows_by_episode(self.path, name)

    def _of_episode(self, name: Table, episode: int | None) -> Any:
        table = self.table(name)
        if episode is None:
            return table
        import pyarrow.compute as pc

        return table.filter(pc.equal(table["episode"], episode))

    def events(self, episode: int | None = None) -> Iterator[Event]:
        """What happened, in order; of one episode if given."""
        table = self._of_episode("events", episode)
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
        if episode not in numbers:
            raise TraceError(f"no episode {episode} in this run; it has {numbers[0]} to {numbers[-1]}")
        return episode

    def verify(self) -> bool:
        """Whether the rows on disk are those that were written, by the manifest's hash.

        Raises:
            TraceError: A part is damaged, or the run never came to its end.
        """
        if self.trace_sha256 is None:
            raise TraceError(f"{self.path}: the run was not finished, so there is no hash to compare with")
        if self.path is None:
            raise TraceError("this run kept no trace; there is nothing to compare its hash with")
        digests = []
        for name in TABLES:
            if name in self.manifest["rows"]:
                table = read_parts(self.path, name)
                digest = TableDigest(name)
                columns = [column.to_pylist() for column in table.columns]
                digest.add(list(zip(*columns, strict=True)))
                digests.append(digest)
        return trace_sha256(digests) == self.trace_sha256
