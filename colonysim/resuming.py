"""`resume`: goes on with a recorded run that was stopped."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.arguments import real
from colonysim.engines import PACKAGES
from colonysim.errors import ColonysimError, TraceError
from colonysim.files import remove_file
from colonysim.plugins import called, load, make_backend, make_policy
from colonysim.processes import refuse_rerun
from colonysim.progress import following, shows
from colonysim.provenance import files_of, other_file
from colonysim.recording import CHECKPOINT, LONGEST, SHORTEST, play, recording, start_with
from colonysim.scenario.assemble import digest
from colonysim.simulation import Colony
from colonysim.simulation.keeping import loaded
from colonysim.simulation.origins import importable, known, refuse_code_of_others, refuse_executor_of_others
from colonysim.simulation.saving import read_saved
from colonysim.trace.kept import dropped_in
from colonysim.trace.manifest import now, read_manifest, versions, write_manifest
from colonysim.trace.reader import Run
from colonysim.trace.writer import TraceWriter

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from colonysim.backends.protocol import Backend
    from colonysim.policies.policy import Policy
    from colonysim.scenario.scenario import Scenario
    from colonysim.simulation.saving import Saved
    from colonysim.trace.schema import Event, Frame, Tap

__all__ = ["anew", "refuse_other_models", "refuse_other_versions", "resume"]


def resume(
    path: str | Path,
    *,
    policy: str | Policy | Callable[[Scenario], Policy] | None = None,
    backend: str | Backend | None = None,
    on_start: Callable[[Run], None] | None = None,
    on_event: Callable[[Event, Run], None] | None = None,
    on_begin: Callable[[Colony], None] | None = None,
    tap: Tap | None = None,
    checkpoint_every: float | None = None,
    progress: bool | None = None,
) -> Run:
    """Goes on with a recorded run that was killed, stopped or has failed, from its last checkpoint.

    What was recorded after the checkpoint is dropped and comes again: the finished run has the same `trace_sha256` as
    one that was never stopped. A run without a checkpoint begins anew in its directory. All else (backend and its
    options, what is recorded, how many episodes) is as the manifest says.

    Args:
        path: The run directory.
        policy: The policy, if it is code of others: a directory does not have it imported by itself.
        backend: The backend, if it is code of others or was given as an object.
        on_start: As for `run`.
        on_event: As for `run`.
        on_begin: As for `run`; a run with measurements needs them again.
        tap: As for `run`; is told the rows that are still to come.
        checkpoint_every: Seconds of wall clock from one checkpoint to the next; by default as before.
        progress: As for `run`.

    Returns:
        The run, finished; one that was finished before is left as it is.

    Raises:
        ColonysimError: There is no such run, it is under way, its checkpoint is damaged, another version has recorded
            it, or it needs code of others that is not given.
    """
    refuse_rerun()
    shown = shows(progress)
    directory = Path(path).absolute()
    if checkpoint_every is not None:
        checkpoint_every = real("checkpoint_every", checkpoint_every, SHORTEST, LONGEST)
    read_manifest(directory)  # what is no run is left alone
    with recording(directory):
        manifest = read_manifest(directory)
        if manifest["status"] == "finished":
            return Run(directory, manifest)
        _check(manifest, directory)
        for left in directory.glob(".*.tmp"):  # by whoever was killed while writing it
            remove_file(left, TraceError)
        scenario = Run(directory, manifest).scenario
        refuse_other_models(manifest, scenario, directory)
        _refuse_other_parts(manifest, scenario, directory, policy, backend)
        source = directory / CHECKPOINT
        saved = read_saved(source) if source.exists() else None
        if saved is not None:
            refuse_other_versions(manifest, directory)
            _check_fits(saved, manifest, source)
        before = dict(manifest)
        if checkpoint_every is None:
            checkpoint_every = manifest["options"].get("checkpoint_every")
        manifest.update(status="running", finished=None, rows={}, trace_sha256=None, versions=versions())
        again = {"at": now(), "from": None if saved is None else CHECKPOINT}
        manifest["resumed"] = [*manifest.get("resumed", []), again]
        kept: dict[str, int] = {} if saved is None else dict(saved.extra["rows"])
        touched = False

        def made(writer: TraceWriter, kinds: tuple[str, ...] | None) -> Colony:
            nonlocal touched
            decisions = "decisions" in manifest["recorded"]["tables"]
            if saved is None:
                colony = anew(manifest, scenario, policy, backend, writer, kinds, decisions=decisions)
            else:
                colony = loaded(
                    Colony, source, saved, policy=policy, backend=backend, sink=writer, decisions=decisions,
                    kinds=kinds,
                )  # fmt: skip
            writer.take_up(kept)
            for item in _made_since(colony, manifest):
                colony.change(item)
            touched = True
            return colony

        try:
            with (
                TraceWriter(directory, manifest, drop=dropped_in(manifest), tap=tap) as writer,
                following(run := Run(directory, manifest, writer.results, scenario), shown, on_event) as on_event,
            ):
                play(
                    made, writer, run, on_start=on_start, on_event=on_event, on_begin=on_begin, tap=tap,
                    checkpoint_every=checkpoint_every,
                )  # fmt: skip
        except BaseException:
            if not touched:  # nothing has happened to it: it is as it was
                write_manifest(directory, before)
            raise
        return run


def _check(manifest: dict[str, Any], directory: Path) -> None:
    """Refuses a run that this process cannot go on with."""
    if manifest.get("scenario") is None:
        raise TraceError(f"{directory}: a run of single pushes, which cannot be gone on with")
    if "recorded" not in manifest:
        raise TraceError(f"{directory}: does not say what was recorded; a run of an early version, run it again")


def _refuse_other_parts(
    manifest: Mapping[str, Any],
    scenario: Scenario,
    directory: Path,
    policy: str | Policy | Callable[[Scenario], Policy] | None,
    backend: str | Backend | None,
) -> None:
    """Refuses another policy or backend than the run was begun with: its manifest would no longer be true."""
    given = {}
    if policy is not None:
        given["policy"] = called("policies", policy, make_policy(policy, scenario))
    if backend is not None and not (backend == "physics" and manifest["backend"] in PACKAGES):
        made = load("backends", backend) if isinstance(backend, str) else backend
        given["backend"] = called("backends", backend, made)
    for kind, name in given.items():
        if name != manifest[kind]:
            begun = f"was begun with {kind} {manifest[kind]!r}"
            raise ColonysimError(f"{directory}: {begun} and cannot go on with {name!r}")


def refuse_other_versions(manifest: Mapping[str, Any], path: Path) -> None:
    """Refuses what was recorded by another version of the package or of the engine: it would not go on the same.

    Raises:
        TraceError: It was.
    """
    engine = PACKAGES.get(manifest["backend"])
    here = versions()
    for package in ("colonysim", *(engine.packages if engine else ())):
        before = manifest["versions"].get(package)
        if before is not None and package in here and before != here[package]:
            raise TraceError(
                f"{path}: recorded with {package} {before}, and here is {here[package]}: go on with that one"
            )


def refuse_other_models(manifest: Mapping[str, Any], scenario: Scenario, path: Path) -> None:
    """Refuses to go on with another network than before: a file of a model has changed.

    Raises:
        TraceError: One has.
    """
    here = files_of(scenario.parameters, manifest["options"].get("backend"), scenario.parts_of_groups)
    if other := other_file(manifest.get("sources") or {}, here):
        raise TraceError(f"{path}: recorded with {other}: go on with that one")


def _check_fits(saved: Saved, manifest: dict[str, Any], path: Path) -> None:
    """Refuses a checkpoint of another run."""
    rows = saved.extra.get("rows")
    counted = isinstance(rows, dict) and all(type(count) is int and count >= 0 for count in rows.values())
    ours = saved.extra.get("started") == manifest["started"] and _same_so_far(saved.document, manifest)
    if not (counted and ours):
        raise TraceError(f"{path}: is no checkpoint of this run")


def _same_so_far(document: Mapping[str, Any], manifest: Mapping[str, Any]) -> bool:
    """Whether a scenario is that of a run, but for changes at its end that may have been made by hand later."""
    ours = manifest["scenario"]
    if digest(ours) != manifest.get("scenario_sha256"):
        return False
    before, by_hand = list(document.get("changes") or ()), set(manifest.get("by_hand") or ())
    now = list(ours.get("changes") or ())
    rest = [{name: value for name, value in each.items() if name != "changes"} for each in (document, ours)]
    return rest[0] == rest[1] and now[: len(before)] == before and set(range(len(before), len(now))) <= by_hand


def _made_since(colony: Colony, manifest: Mapping[str, Any]) -> list[Any]:
    """The changes that were made by hand after the checkpoint from which a colony goes on: it gets them again."""
    changes: list[Any] = list(manifest["scenario"].get("changes") or ())
    return changes[len(colony.scenario.changes) :]


def anew(
    manifest: Mapping[str, Any],
    scenario: Scenario,
    policy: str | Policy | Callable[[Scenario], Policy] | None,
    backend: str | Backend | None,
    writer: TraceWriter | None,
    kinds: tuple[str, ...] | None,
    *,
    decisions: bool,
) -> Colony:
    """The colony of a run, from its beginning.

    Args:
        manifest: What was run.
        scenario: Its scenario.
        policy: The policy, if it is code of others.
        backend: The backend, if it is code of others.
        writer: Takes its rows.
        kinds: Kinds of the events to hand out.
        decisions: Whether there are rows of decisions.

    Raises:
        ColonysimError: It needs code of others that is not given.
    """
    refuse_code_of_others(scenario, "them with a run of your own")
    options = dict(manifest["options"].get("backend") or {})
    if backend is None:
        refuse_executor_of_others(options)
        backend = importable("backend", manifest["backend"])
        if manifest["backend"] in PACKAGES:
            options.pop("engine", None)
    if policy is None:
        policy = None if _is_own(manifest["policy"], scenario) else importable("policy", manifest["policy"])
    body = make_backend(backend, options if isinstance(backend, str) else None, scenario)
    return Colony(
        scenario, backend=body, policy=policy, mode=manifest["mode"], episodes=manifest["episodes"],
        seed=manifest["seed"], sink=writer, initial=_start(manifest), decisions=decisions,
        kinds=kinds,
    )  # fmt: skip


def _start(manifest: Mapping[str, Any]) -> dict[str, list[Frame]] | None:
    """The pheromones that a run began with, if it took over those of another run.

    Raises:
        ColonysimError: That run is not there any more, or another one is in its place.
    """
    path, digest = (manifest["options"].get(name) for name in ("initial", "initial_trace"))
    if path is None:
        return None
    other = Run.open(path)
    if digest is not None and other.manifest.get("trace_sha256") != digest:
        raise ColonysimError(f"{path}: is not the run any more whose pheromones this one has started with")
    return start_with(other)


def _is_own(name: str, scenario: Scenario) -> bool:
    """Whether a policy's name, as a manifest has it, is that of the scenario's own policy."""
    own = scenario.policy
    if not known("policies", own):
        return False
    try:
        return called("policies", own, make_policy(None, scenario)) == name
    except ColonysimError:  # the parameters are those of the policy that was run in its place
        return False
