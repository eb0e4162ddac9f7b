"""`run`: simulate a colony and keep what happened in a run directory."""

from __future__ import annotations

import time
import warnings
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from colonysim.arguments import as_seed, real, whole
from colonysim.errors import ColonysimError, TraceError
from colonysim.files import LOCK, alone, remove_file
from colonysim.geometry.robot_choice import with_robot
from colonysim.plugins import called, make_backend, make_policy
from colonysim.processes import refuse_rerun
from colonysim.progress import following, shows
from colonysim.provenance import parts_of
from colonysim.scenario.contradictions import refuse_contradictions
from colonysim.scenario.loading import load_scenario
from colonysim.scenario.scenario import Scenario
from colonysim.signals import held
from colonysim.simulation import Colony, mode_of
from colonysim.simulation.colony_state import check_savable
from colonysim.simulation.keeping import saved_of
from colonysim.simulation.origins import origin_of
from colonysim.simulation.saving import write_saved
from colonysim.trace.groups import results_at_end
from colonysim.trace.kept import Kept, asked_for, by_size
from colonysim.trace.manifest import MANIFEST, begin_manifest, prepare_directory, write_manifest
from colonysim.trace.reader import Run
from colonysim.trace.writer import TraceWriter

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence

    from colonysim.backends.protocol import Backend
    from colonysim.policies.policy import Policy
    from colonysim.trace.groups import GroupResult
    from colonysim.trace.schema import Event, Frame, Table, Tap

Attendant: TypeAlias = "Callable[[Colony, Callable[[], None]], object]"
"""Is called between two events with the colony, and a function that tells a tap the rows so far."""

__all__ = ["CHECKPOINT", "groups_at_end", "new_run", "play", "recording", "run", "start_with"]

CHECKPOINT = "checkpoint.npz"
"""The newest saved colony in the directory of a run that is under way, or was stopped."""
SHORTEST, LONGEST = 0.01, 1e9
"""Bounds of the time from one checkpoint to the next, seconds of wall clock."""
STEPS = 100
"""After so many of SimPy's steps without an event to hand out, it is looked whether a checkpoint is due."""


def run(
    scenario: Scenario | str | Path,
    *,
    backend: str | Backend = "nodeworld",
    policy: str | Policy | Callable[[Scenario], Policy] | None = None,
    variant: str | None = None,
    overrides: Mapping[str, Any] | Sequence[str] | None = None,
    mode: str | None = None,
    episodes: int | None = None,
    seed: int = 0,
    out: str | Path | None = None,
    trace: bool = True,
    record: str | Iterable[str] | Kept | None = None,
    decisions: bool | None = None,
    initial: Run | str | Path | None = None,
    backend_options: Mapping[str, Any] | None = None,
    on_start: Callable[[Run], None] | None = None,
    on_event: Callable[[Event, Run], None] | None = None,
    on_begin: Callable[[Colony], None] | None = None,
    tap: Tap | None = None,
    attend: Attendant | None = None,
    checkpoint_every: float | None = None,
    progress: bool | None = None,
) -> Run:
    """Runs a colony and records it.

    A run that stops early, by Ctrl-C or by an error, leaves a directory that can be read: its manifest
    says "interrupted" or "failed", and the exception goes on to the caller. One that fails before anything
    has happened in it leaves none.

    Args:
        scenario: The colony: a scenario, the path of its file, or the name of one that comes with the package.
        backend: Name of a backend, or one.
        policy: Name of a policy, a factory, or a policy; the scenario's own if None.
        variant: One of the scenario file's variants; only with a path or a name, as a `Scenario` is one already.
        overrides: Fields of the scenario to set, as for `load_scenario`; only with a path or a name, and none that
            `policy`, `mode` or `episodes` set too.
        mode: "asynchronous" or "synchronous"; the scenario's own if None.
        episodes: How many; the scenario's own number if None.
        seed: Together with the scenario it makes the run; a whole number from 0.
        out: Where to write, absent or empty; by default a new directory below `runs/`. Not without a trace.
        trace: Whether to write a run directory at all. The trace's hash is there either way.
        record: What to keep besides events and episodes: some of "decisions" (candidates and their probabilities),
            "deposits", "poses", "controls" and "frames" (pheromones at the end of every episode) or "last-frames" (of
            the last one), as a list or one text parted by commas. By default everything, unless the world is so large
            that a table would hinder more than it helps; the manifest says below "recorded" what that leaves out. Or
            what `colonysim.trace.kept` has made of it.
        decisions: Deprecated, goes with version 0.2: False leaves the decisions out.
        initial: A run whose pheromones, as they were at its last episode's end, this one starts with.
        backend_options: Keyword arguments for a backend given by name.
        on_start: Called once with the run that is being recorded.
        on_event: Called with each event, and the run with the episodes so far.
        on_begin: Called once with the colony before its first episode begins: to have it watched and measured
            (`Colony.on`, `Colony.measure`).
        tap: Is told the rows of all tables while they come.
        attend: Called after the events of each moment with the colony and a function that tells the tap the rows so
            far. It may take its time, and change the colony (`Colony.change`).
        checkpoint_every: Seconds of wall clock after which the colony is saved in the run directory, again and again:
            should the process be killed, `colonysim.resume` goes on from there. None for never.
        progress: Whether to show how far the run has come, once it takes more than two seconds: a bar in a notebook
            and on a terminal, else a line now and then on standard error. None: in a notebook only.

    Returns:
        The run, finished.

    Raises:
        ColonysimError: Something that was asked for does not exist, does not fit or cannot be written.

    Example:
        ```python
        run = colonysim.run("hard", seed=1, episodes=10)
        print([episode.steps for episode in run.episodes], run.path)
        ```
    """
    refuse_rerun()
    # Whatever is wrong with the request is found before a directory is made for it.
    if not isinstance(scenario, Scenario):
        scenario = load_scenario(scenario, variant, overrides)
        refuse_contradictions(scenario, {"policy": policy, "mode": mode, "episodes": episodes})
    elif variant is not None or overrides:
        raise ColonysimError(
            "variant and overrides: the scenario is loaded already; give them to load_scenario, or run its path or name"
        )
    if out is not None and not trace:
        raise ColonysimError(f"{out}: nothing is written there without a trace; leave out either of them")
    if checkpoint_every is not None:
        if not trace:
            raise ColonysimError("checkpoint_every: without a trace there is no directory to go on in")
        checkpoint_every = real("checkpoint_every", checkpoint_every, SHORTEST, LONGEST)
    if record is not None and decisions is not None:
        raise ColonysimError("record and decisions: both say what is kept; leave out decisions")
    if decisions is not None:
        warnings.warn("decisions= goes with colonysim 0.2; say record= instead", DeprecationWarning, stacklevel=2)
    shown = shows(progress)
    scenario = with_robot(scenario)
    kept = record if record is None or isinstance(record, Kept) else asked_for(record)
    mode = mode_of(scenario, mode)
    count = scenario.episodes if episodes is None else whole("episodes", episodes)
    if kept is None:
        kept = by_size(scenario, count)
        kept = kept.without("decisions") if decisions is False else kept
    seed = as_seed(seed)
    chosen = make_policy(policy, scenario)
    body = make_backend(backend, backend_options, scenario)
    first = initial if initial is None or isinstance(initial, Run) else Run.open(initial)
    start = start_with(first)
    manifest = begin_manifest(
        scenario.name,
        scenario=scenario,
        backend=called("backends", backend, body),
        policy=called("policies", scenario.policy if policy is None else policy, chosen),
        mode=mode,
        episodes=count,
        seed=seed,
        variant=scenario.variant,
        options={
            "backend": dict(backend_options or {}),
            "overrides": scenario.settings,
            "decisions": "decisions" in kept.tables,
            **_told_of(first),
            **({} if checkpoint_every is None else {"checkpoint_every": checkpoint_every}),
        },
        recorded=kept.document(),
        engine=getattr(body, "engine", None),
    )
    made = _absent(Path("runs") if out is None else Path(out))
    if trace:
        named = policy if policy is not None else scenario.policy
        # "physics" is the engine that was found for it.
        driven = manifest["backend"] if backend == "physics" else backend
        manifest["sources"] = parts_of(named, driven, scenario.parameters, backend_options, scenario.parts_of_groups)
    origin = origin_of(backend, backend_options, policy)
    # Groups have policies of their own, and changed parameters make other ones: what was asked for has to be known.
    remade = bool(scenario.groups or scenario.changes) or not (attend is None and on_begin is None)

    def begun(writer: TraceWriter, kinds: tuple[str, ...] | None) -> Colony:
        return Colony(
            scenario, backend=body, policy=policy if remade else chosen, mode=mode, episodes=count, seed=seed,
            sink=writer, initial=start, decisions="decisions" in kept.tables, kinds=kinds, origin=origin,
        )  # fmt: skip

    directory = None
    try:
        with (
            new_run(None if out is None else Path(out), manifest, drop=kept.dropped, tap=tap)
            if trace
            else TraceWriter(None, manifest, drop=kept.dropped, tap=tap)
        ) as writer:
            directory = writer.directory
            groups: list[GroupResult] = []
            recorded = Run(directory, manifest, writer.results, scenario, groups)
            with following(recorded, shown, on_event) as on_event:
                play(
                    begun, writer, recorded, groups=groups, on_start=on_start, on_event=on_event, on_begin=on_begin,
                    tap=tap, attend=attend, checkpoint_every=checkpoint_every,
                )  # fmt: skip
    except Exception:
        if directory is not None and manifest["rows"] and not any(manifest["rows"].values()):
            _take_back(directory, [directory, *made] if out is None else made)
        raise
    return recorded


@contextmanager
def new_run(
    out: Path | None, manifest: dict[str, Any], *, drop: Collection[Table] = (), tap: Tap | None = None
) -> Iterator[TraceWriter]:
    """The writer of a new run, whose directory it makes and holds; however the block ends, the manifest says how.

    Args:
        out: The directory, absent or empty; None for a new one below `runs/`.
        manifest: The manifest as it is at the start.
        drop: Tables that are not kept.
        tap: Is told the rows of all tables while they come.

    Raises:
        TraceError: The directory holds files already, or cannot be made or written to.
    """
    with ExitStack() as under_way:
        # A stop between the first manifest, which says "running", and the writer would leave it at that.
        with held():
            directory = prepare_directory(out, manifest)
            under_way.enter_context(recording(directory))
            writer = under_way.enter_context(TraceWriter(directory, manifest, drop=drop, tap=tap))
        yield writer


@contextmanager
def recording(directory: Path) -> Iterator[None]:
    """Holds a run directory, so that nobody else goes on with a run that is under way."""
    with alone(directory, "is recording this run", TraceError):
        try:
            yield
        finally:
            with suppress(OSError):  # where a file that is open cannot be removed it stays
                (directory / LOCK).unlink()


def groups_at_end(colony: Colony, episode: int) -> list[GroupResult]:
    """How an episode that has just ended went for each group of a colony; nothing of one without groups."""
    at_goal = [status == "goal" for status in colony.agents.status] if colony.scenario.groups else []
    return results_at_end(colony.scenario, episode, at_goal, colony.agents.steps.tolist())


def play(
    make: Callable[[TraceWriter, tuple[str, ...] | None], Colony],
    writer: TraceWriter,
    recorded: Run,
    *,
    groups: list[GroupResult] | None = None,
    on_start: Callable[[Run], None] | None,
    on_event: Callable[[Event, Run], None] | None,
    on_begin: Callable[[Colony], None] | None,
    tap: Tap | None,
    attend: Attendant | None = None,
    checkpoint_every: float | None,
) -> None:
    """Lets a colony go on to its end, and records it; the writer is finished then.

    Args:
        make: Makes the colony, of a writer and the kinds of events that are wanted.
        writer: The writer, in whose context this is called: it says how the run ended if it is stopped.
        recorded: The run.
        groups: Gets the results of groups; None if they are read from the trace.
        on_start: As for `run`, as all others.
        on_event: The same.
        on_begin: The same.
        tap: The same.
        attend: The same.
        checkpoint_every: The same.
    """
    listens = not (on_event is None and on_begin is None and tap is None and attend is None)
    if on_start:
        on_start(recorded)
    with make(writer, None if listens else ("episode",)) as colony:
        if on_begin:
            on_begin(colony)
        _note_measures(colony, writer)
        checkpoints = None if checkpoint_every is None else Checkpoints(colony, writer, checkpoint_every)
        for event in colony:
            if groups is not None and event.kind == "episode":
                groups += groups_at_end(colony, event.episode)
            if on_event:
                on_event(event, recorded)
            if tap:
                writer.share()
            if attend and not colony.pending:
                attend(colony, writer.share_now)
            if checkpoints:
                checkpoints.look()
        if not colony.completed:
            raise ColonysimError("the colony was closed before its last episode had ended")
    writer.finish("finished")
    if writer.directory is not None:
        remove_file(writer.directory / CHECKPOINT, TraceError)


def _note_measures(colony: Colony, writer: TraceWriter) -> None:
    """Says in the manifest what is measured, for whoever goes on with the run needs the same functions.

    Raises:
        TraceError: Something was measured before that is not any more, or the other way round.
    """
    names, before = colony.measured, writer.manifest.get("measured")
    if writer.manifest.get("resumed") and names != (before or []):
        raise TraceError(
            f"{writer.directory}: this run measured {', '.join(before or []) or 'nothing'}, and is now to measure "
            f"{', '.join(names) or 'nothing'}; give the functions again: colonysim.resume(..., on_begin=...)"
        )
    if names and names != before:
        writer.manifest["measured"] = names
        if writer.directory is not None:
            write_manifest(writer.directory, writer.manifest)


class Checkpoints:
    """Saves a colony in the directory of its run, again and again.

    Args:
        colony: The colony.
        writer: What records it.
        seconds: Of wall clock, from one to the next.

    Raises:
        ColonysimError: A part of others cannot be saved.
    """

    def __init__(self, colony: Colony, writer: TraceWriter, seconds: float) -> None:
        assert writer.directory is not None
        check_savable(colony)
        self._colony, self._writer, self._seconds = colony, writer, seconds
        self._path, self._due = writer.directory / CHECKPOINT, time.monotonic() + seconds
        colony._pause(self.look, STEPS)

    def look(self) -> None:
        """Saves the colony, if it is time; to be called between two events."""
        if time.monotonic() < self._due or self._colony.over:
            return
        # Rows first: those that the checkpoint counts are on disk before it is.
        self._writer.flush()
        manifest = self._writer.manifest
        about = {"rows": self._writer.rows, "started": manifest["started"], "versions": manifest["versions"]}
        write_saved(self._path, saved_of(self._colony, about))
        self._due = time.monotonic() + self._seconds


def _absent(path: Path) -> list[Path]:
    """A path and the folders above it as far as there are none, the innermost first."""
    try:
        return [folder for folder in (path, *path.parents) if not folder.exists()]
    except OSError:  # it cannot be made either, and whoever tries says why
        return []


def _take_back(directory: Path, made: Sequence[Path]) -> None:
    """Removes the directory of a run in which nothing has happened, and what was made for it; never others' files."""
    with suppress(OSError):
        (directory / MANIFEST).unlink()
        for folder in made:
            folder.rmdir()


def _told_of(run: Run | None) -> dict[str, str | None]:
    """What the manifest says of the run that this one starts from: where it is from anywhere, and which one it is."""
    if run is None:
        return {"initial": None}
    path = None if run.path is None else str(run.path.absolute())
    return {"initial": path, "initial_trace": run.manifest.get("trace_sha256")}


def start_with(run: Run | None) -> dict[str, list[Frame]] | None:
    """The pheromones that a run has left; None without a run."""
    if run is None:
        return None
    fields: dict[str, list[Frame]] = {}
    for frame in run.frames():
        fields.setdefault(frame.field, []).append(frame)
    if not fields:
        raise TraceError(f"{run.path}: this run left no pheromones to start with (policy {run.manifest['policy']!r})")
    return fields
