"""`run`: simulate a colony and keep what happened in a run directory."""

from __future__ import annotations

import warnings
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.arguments import as_seed, whole
from colonysim.errors import ColonysimError, TraceError
from colonysim.files import shown_path
from colonysim.geometry.robot_choice import with_robot
from colonysim.plugins import called, make_backend, make_policy
from colonysim.processes import refuse_rerun
from colonysim.provenance import parts_of
from colonysim.scenario.contradictions import refuse_contradictions
from colonysim.scenario.loading import load_scenario
from colonysim.scenario.scenario import Scenario
from colonysim.simulation import Colony, mode_of
from colonysim.trace.groups import results_at_end
from colonysim.trace.kept import Kept, asked_for, by_size
from colonysim.trace.manifest import MANIFEST, begin_manifest, prepare_directory
from colonysim.trace.reader import Run
from colonysim.trace.writer import TraceWriter

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from colonysim.backends.protocol import Backend
    from colonysim.policies.policy import Policy
    from colonysim.trace.groups import GroupResult
    from colonysim.trace.schema import Event, Frame, Tap

__all__ = ["run"]


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
    if record is not None and decisions is not None:
        raise ColonysimError("record and decisions: both say what is kept; leave out decisions")
    if decisions is not None:
        warnings.warn("decisions= goes with colonysim 0.2; say record= instead", DeprecationWarning, stacklevel=2)
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
    start = _pheromones(initial)
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
            "initial": _shown(initial),
        },
        recorded=kept.document(),
        engine=getattr(body, "engine", None),
    )
    listens = on_event is not None or on_begin is not None or tap is not None
    directory, made = None, _absent(Path("runs") if out is None else Path(out))
    if trace:
        named = policy if policy is not None else scenario.policy
        # "physics" is the engine that was found for it.
        driven = manifest["backend"] if backend == "physics" else backend
        manifest["sources"] = parts_of(named, driven, scenario.parameters, backend_options, scenario.parts_of_groups)
        directory = prepare_directory(None if out is None else Path(out), manifest)
    writer = TraceWriter(directory, manifest, drop=kept.dropped, tap=tap)
    groups: list[GroupResult] = []
    recorded = Run(directory, manifest, writer.results, scenario, groups)
    try:
        with writer:
            if on_start:
                on_start(recorded)
            with Colony(
                scenario, backend=body, policy=policy if scenario.groups else chosen, mode=mode, episodes=count,
                seed=seed, sink=writer, initial=start, decisions="decisions" in kept.tables,
                kinds=None if listens else ("episode",),
            ) as colony:  # fmt: skip
                if on_begin:
                    on_begin(colony)
                for event in colony:
                    if event.kind == "episode" and scenario.groups:
                        at_goal = [status == "goal" for status in colony.agents.status]
                        groups += results_at_end(scenario, event.episode, at_goal, colony.agents.steps.tolist())
                    if on_event:
                        on_event(event, recorded)
                    if tap:
                        writer.share()
                if not colony.completed:
                    raise ColonysimError("the colony was closed before its last episode had ended")
    except Exception:
        if directory is not None and manifest["rows"] and not any(manifest["rows"].values()):
            _take_back(directory, [directory, *made] if out is None else made)
        raise
    return recorded


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


def _shown(initial: Run | str | Path | None) -> str | None:
    path = initial.path if isinstance(initial, Run) else initial
    return None if path is None else shown_path(path)


def _pheromones(initial: Run | str | Path | None) -> dict[str, list[Frame]] | None:
    if initial is None:
        return None
    fields: dict[str, list[Frame]] = {}
    run = initial if isinstance(initial, Run) else Run.open(initial)
    for frame in run.frames():
        fields.setdefault(frame.field, []).append(frame)
    if not fields:
        raise TraceError(f"{run.path}: this run left no pheromones to start with (policy {run.manifest['policy']!r})")
    return fields
