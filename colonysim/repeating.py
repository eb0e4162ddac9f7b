"""`repeat`: runs a recorded run again, with everything that was done to it by hand."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from colonysim.errors import TraceError
from colonysim.files import shown_path
from colonysim.processes import refuse_rerun
from colonysim.progress import following, shows
from colonysim.recording import new_run, play
from colonysim.resuming import anew, refuse_other_models, refuse_other_versions
from colonysim.trace.kept import dropped_in
from colonysim.trace.manifest import now, read_manifest, versions
from colonysim.trace.reader import Run

if TYPE_CHECKING:
    from collections.abc import Callable

    from colonysim.backends.protocol import Backend
    from colonysim.policies.policy import Policy
    from colonysim.scenario.scenario import Scenario
    from colonysim.simulation import Colony
    from colonysim.trace.schema import Event
    from colonysim.trace.writer import TraceWriter

__all__ = ["first_difference", "repeat"]


def repeat(
    path: str | Path,
    *,
    out: str | Path | None = None,
    policy: str | Policy | Callable[[Scenario], Policy] | None = None,
    backend: str | Backend | None = None,
    on_start: Callable[[Run], None] | None = None,
    on_event: Callable[[Event, Run], None] | None = None,
    progress: bool | None = None,
) -> Run:
    """Runs a recorded run again from its beginning, into a directory of its own.

    What was changed by hand (`Colony.change`, the controls of `colonysim run --live`) stands in the scenario of the
    run's manifest, and comes at the same moments. `first_difference` tells whether the two are the same.

    Args:
        path: The run directory; the run may have been stopped.
        out: Where to write, absent or empty; by default a new directory below `runs/`.
        policy: The policy, if it is code of others: a directory does not have it imported by itself.
        backend: The backend, if it is code of others or was given as an object.
        on_start: As for `run`.
        on_event: As for `run`.
        progress: As for `run`.

    Returns:
        The new run, finished.

    Raises:
        ColonysimError: There is no such run, another version or other models have recorded it, it was measured by
            functions, or it needs code of others that is not given.
    """
    refuse_rerun()
    directory, shown = Path(path).absolute(), shows(progress)
    before = read_manifest(directory)
    if before.get("scenario") is None:
        raise TraceError(f"{directory}: a run of single pushes, which cannot be repeated")
    if "recorded" not in before:
        raise TraceError(f"{directory}: does not say what was recorded; a run of an early version")
    if before.get("measured"):
        raise TraceError(f"{directory}: was measured by functions, which no directory holds; run it again in Python")
    scenario = Run(directory, before).scenario
    refuse_other_versions(before, directory)
    refuse_other_models(before, scenario, directory)
    manifest = {name: value for name, value in before.items() if name != "resumed"}
    manifest.update(
        status="running", started=now(), finished=None, rows={}, trace_sha256=None, versions=versions(),
        repeats=shown_path(directory),
    )  # fmt: skip

    def made(writer: TraceWriter, kinds: tuple[str, ...] | None) -> Colony:
        decisions = "decisions" in manifest["recorded"]["tables"]
        return anew(manifest, scenario, policy, backend, writer, kinds, decisions=decisions)

    with new_run(None if out is None else Path(out), manifest, drop=dropped_in(manifest)) as writer:
        run = Run(writer.directory, manifest, writer.results, scenario)
        with following(run, shown, on_event) as on_event:
            play(
                made, writer, run, on_start=on_start, on_event=on_event, on_begin=None, tap=None, checkpoint_every=None
            )
    return run


def first_difference(run: Run, again: Run) -> int | None:
    """The first event, counted from 0, that a run has and its repetition has not; None if all came again.

    Of finished runs the hashes over all tables are compared too: -1 if the events are the same and others are not.
    Of one that was stopped, all that it recorded has to come again; more may follow.
    """
    rows, others = run.table("events").to_pylist(), again.table("events").to_pylist()
    for number, row in enumerate(rows):
        if number >= len(others) or row != others[number]:
            return number
    if run.status == "finished" and run.trace_sha256 != again.trace_sha256:
        return -1
    return None
