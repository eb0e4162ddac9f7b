"""Reading a run directory: everything that is shown of a run comes through here."""

from __future__ import annotations

import copy
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from colonysim.arguments import whole
from colonysim.characters import printable
from colonysim.errors import TraceError
from colonysim.files import shown_path
from colonysim.trace.checks import Rows
from colonysim.trace.groups import results_of_groups
from colonysim.trace.kept import left_out
from colonysim.trace.manifest import MANIFEST, read_manifest
from colonysim.trace.packing import TableDigest, trace_sha256
from colonysim.trace.parts import packed_columns, table_schema
from colonysim.trace.schema import TABLES, EpisodeResult, Event, Frame, Table
from colonysim.trace.stored import read_parts

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

    from colonysim.plots.shown import Figures
    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.groups import GroupResult
    from colonysim.trace.stored import Piece
    from colonysim.view.showing import Page

__all__ = ["Run"]

_KEPT_ROWS = 500_000
"""Most rows of a table that is read once and kept for whoever asks for its rows episode by episode."""


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
        groups: list[GroupResult] | None = None,
    ) -> None:
        # Whoever holds a run may change the working directory.
        self.path = None if path is None else Path(path).absolute()
        self.manifest = manifest
        self._episodes = episodes
        self._scenario, self._scenario_sha256 = scenario, manifest.get("scenario_sha256")
        self._groups = groups
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
        told = self.manifest
        name = f"{told['name']} {told['variant'] or ''}".rstrip()
        what = f"{name} on {told['backend']}, policy {told['policy']}, seed {told['seed']}"
        where = shown_path(self.path) if self.path else "no trace"
        return printable(f"<Run {what}: {self.status}, {told['episodes']} episodes, {where}>", 500)

    def _repr_html_(self) -> str:
        """A notebook's picture: the map, and how the episodes went."""
        from colonysim.trace.picture import picture

        return picture(self)

    def view(
        self,
        episodes: int | Sequence[int] | None = None,
        *,
        out: str | Path | None = None,
        inline: bool | None = None,
        height: int = 640,
    ) -> Page:
        """The replay page of the run, that of `colonysim view`: in a notebook below the cell, else in the browser.

        A page in a notebook is a part of it, so it takes at most 20 MB, and shows the last episodes that make about
        4 MB unless others are asked for; what it leaves out stands above it.

        Args:
            episodes: A number or several; None for all that are complete, or the last of them.
            out: The file to write; by default `view.html` in the run directory.
            inline: Whether the page is shown in the notebook, and no file is written; None: where there is a notebook
                and no `out`.
            height: Height in a notebook, pixels, 200 to 4,000.

        Returns:
            The page, which a notebook shows.

        Raises:
            TraceError: The run kept no trace, has no such episode, or the page would be too large.
            ColonysimError: The file cannot be written.
        """
        from colonysim.view.showing import show_page

        return show_page(self, episodes, out=out, inline=inline, height=height)

    def plot(
        self,
        what: str | Sequence[str] | None = None,
        *,
        episodes: int | Sequence[int] | None = None,
        hole: int | None = None,
        box: int | None = None,
    ) -> Figures:
        """Figures of the run, those of `colonysim plot`: a notebook shows them, a script saves or changes them.

        Args:
            what: One or several of "D", "E", "H", "B" (pheromones), "map", "trajectories", "episodes", "waiting",
                "workload" and "fates", or another field of the run; of single pushes "trajectories" and "samples".
                None for everything that the run has.
            episodes: A number or several; None for up to six, from the first to the last.
            hole: Node of the hole whose H is drawn; None for all.
            box: The box whose B is drawn; None for the first six.

        Returns:
            matplotlib figures, in a tuple.

        Raises:
            MissingExtraError: matplotlib is not installed.
            ColonysimError: The run has no such episode, hole, box or field.
        """
        from colonysim.plots import figures

        return figures(self, what, episodes=episodes, hole=hole, box=box)

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
        # With another hash its timeline has got a change by hand.
        if self._scenario is not None and self._scenario_sha256 == self.manifest.get("scenario_sha256"):
            return self._scenario
        from colonysim.scenario.loading import scenario_from_document

        if self.manifest.get("scenario") is None:
            raise TraceError(f"{self.path}: a run of single pushes, which has no scenario")
        source = "<run>" if self.path is None else f"{self.path / MANIFEST}: scenario"
        self._scenario_sha256 = self.manifest.get("scenario_sha256")
        self._scenario = scenario_from_document(self.manifest["scenario"], source=source)
        return self._scenario

    @property
    def episodes(self) -> list[EpisodeResult]:
        """The results of all complete episodes."""
        if self._episodes is None:
            rows = self.table("episodes").to_pylist()
            self._episodes = [EpisodeResult(**row) for row in rows]
        return self._episodes

    @property
    def groups(self) -> list[GroupResult]:
        """How each complete episode went for each group of agents; empty if the scenario has no groups.

        Raises:
            TraceError: A part is damaged.
        """
        return results_of_groups(self) if self._groups is None else list(self._groups)

    def table(self, name: Table) -> Any:
        """All rows of a table as a `pyarrow.Table`; see `colonysim.trace.schema.TABLES` for the columns.

        Raises:
            TraceError: No such table, one that the run was not to keep, a damaged part, or a run that kept no trace.
        """
        self.check_kept(name)
        return self._rows(name).all

    def batches(self, name: Table, columns: Sequence[str] | None = None) -> Iterator[Any]:
        """The rows of a table in order, some thousand at a time: each a `pyarrow.Table`, checked as all of them are.

        Args:
            name: Name of the table.
            columns: Which columns, "episode" among them; None for all.

        Raises:
            TraceError: As for `table`.
        """
        for rows in self.pieces(name, columns):
            yield rows.all

    def missing(self, name: Table, episode: int | None = None) -> str:
        """Why the run has no rows of a table, by what was to be recorded; empty if it may well have some.

        Args:
            name: Name of the table.
            episode: Of this episode; of any if None.
        """
        return left_out(self.manifest, name, episode)

    def check_kept(self, name: Table, episode: int | None = None) -> None:
        """Checks that a table can be asked for.

        Raises:
            TraceError: There is no such table, the run kept no trace, or was not to keep it.
        """
        if name not in get_args(Table):
            raise TraceError(f"no table {name!r} in a trace; there are: {', '.join(TABLES)}")
        if self.path is None:
            raise TraceError("this run kept no trace; run it again with one to read its tables")
        if why := self.missing(name, episode):
            raise TraceError(f"{self.path}: {why}")

    def pieces(self, name: Table, columns: Sequence[str] | None = None) -> Iterator[Rows]:
        """As `batches`, for whoever checks that they fit the scenario too."""
        self.check_kept(name)
        if name == "episodes":  # each has one row, and they are checked as a whole
            yield from [rows] if (rows := self._rows(name)).all.num_rows else []
            return
        complete, last = self._known_complete(name), (0, 0.0)
        for piece in self._chosen(name, columns):
            rows = Rows(name, [piece], None)
            if len(rows.all):
                rows.check(self.manifest["episodes"], last if last[0] else None)
                last = rows.last
                yield rows
        self._check_end(name, last[0], complete)

    def _rows(self, name: Table) -> Rows:
        """All rows of a table, checked."""
        if name in self._tables:
            return self._tables[name]
        # What is still being written is read anew each time.
        complete = self._known_complete(name)
        rows = Rows(name, [*self._chosen(name)], table_schema(name).empty_table())
        rows.check(self.manifest["episodes"])
        self._check_end(name, rows.last[0] if rows.all.num_rows else 0, complete)
        if self.status != "running":
            self._tables[name] = rows
        return rows

    def _known_complete(self, name: Table) -> int:
        """How many episodes a table must hold at least.

        A complete episode has all its rows: of one that is known to be complete before the others are read, its last
        event has to be there.
        """
        growing = self.status == "running" and name == "events" and self._only is None
        return len(self.table("episodes")) if growing else 0

    def _check_end(self, name: Table, last: int, complete: int) -> None:
        assert self.path is not None
        if last < complete:
            there = f"ends with episode {last}, but {complete} are complete"
            raise TraceError(f"{self.path / name}: {there}; a part is missing")

    def _chosen(self, name: Table, columns: Sequence[str] | None = None) -> Iterator[Piece]:
        """The rows of a table, piece by piece, only those of the episodes that count."""
        return self._pieces(name, columns, None if name == "episodes" else self._only)

    def _pieces(
        self, name: Table, columns: Sequence[str] | None = None, episodes: Collection[int] | None = None
    ) -> Iterator[Piece]:
        """The parts of a table as they are on disk: as many rows as were counted when the run ended."""
        assert self.path is not None
        if not self.path.is_dir():
            raise TraceError(f"{self.path}: no such run directory; it was there when the run was opened")
        counted = None if self.status == "running" else self.manifest["rows"].get(name, 0)
        return read_parts(self.path, name, counted, columns, episodes)

    def check_places(self, *names: Table) -> None:
        """Checks that the nodes, holes, boxes and agents in some tables are those of the scenario.

        For whoever looks them up there; without names, in all tables that the run was to keep.

        Raises:
            TraceError: One is not, a part is damaged, or the run kept no trace or has no scenario.
            ScenarioError: The scenario is wrong.
        """
        if self.path is None:
            raise TraceError("this run kept no trace; run it again with one to read its tables")
        for name in names or TABLES:
            for rows in () if self.missing(name) else self.pieces(name):
                rows.check_places(self.scenario, self.by_box)

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
        self.check_kept(name)
        found: Counter[int] = Counter()
        for _, _, rows in self._pieces(name, ("episode",)):
            for each in rows["episode"].value_counts().to_pylist():
                found[each["values"]] += each["counts"]
        return dict(found)

    def _of_episode(self, name: Table, episode: int | None) -> Iterator[Any]:
        """The rows of an episode, or of all, some thousand at a time; a small table is read once and kept."""
        if episode is not None:
            episode = whole("episode", episode)
        self.check_kept(name, episode)
        if self.status == "running" or self.manifest["rows"].get(name, 0) > _KEPT_ROWS:
            chosen = self if episode is None or self._only is not None else self.only([episode])
            batches = chosen.batches(name)
        else:
            batches = iter([self.table(name)])
        if episode is None:
            return batches
        import pyarrow.compute as pc

        return (rows.filter(pc.equal(rows["episode"], episode)) for rows in batches)

    def events(self, episode: int | None = None) -> Iterator[Event]:
        """What happened, in order; of one episode if given, which need not be complete.

        Raises:
            TraceError: The run has no such episode.
        """
        found = False
        for rows in self._of_episode("events", episode):
            for batch in rows.to_batches(max_chunksize=4096):
                found = found or batch.num_rows > 0
                columns = [batch.column(name).to_pylist() for name in Event._fields]
                yield from map(Event._make, zip(*columns, strict=True))
        if episode is not None and not found:
            self._complete(episode)

    def frames(self, episode: int | None = None, field: str | None = None) -> list[Frame]:
        """The pheromone values at the end of an episode (default: the last complete one).

        Raises:
            TraceError: The run has no such episode or field, or was not to keep these values.
        """
        import pyarrow.compute as pc

        episode = self._complete(episode)
        frames: list[Frame] = []
        known: set[str] = set()
        for rows in self._of_episode("frames", episode):
            if field is not None:
                known.update(rows["field"].unique().to_pylist())
                rows = rows.filter(pc.equal(rows["field"], field))
            columns = [rows[name].to_pylist() for name in Frame._fields]
            frames += map(Frame._make, zip(*columns, strict=True))
        if field is not None and field not in known:
            raise TraceError(
                f"episode {episode} has no values of a field {field!r}; fields: {', '.join(sorted(known)) or 'none'}"
            )
        return frames

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
            for _, _, part in self._pieces(name):
                rows.take(packed_columns(name, part, rows.codes), part.num_rows)
            if name in self.manifest["rows"]:
                digests.append(rows)
        scenario = self.manifest.get("scenario")
        told = self.manifest.get("scenario_sha256")
        return trace_sha256(digests) == self.trace_sha256 and (scenario is None or digest(scenario) == told)
