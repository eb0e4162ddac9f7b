"""Runs a sweep: what is not there yet, and nothing twice."""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from colonysim.arguments import whole
from colonysim.errors import ColonysimError
from colonysim.files import replacing
from colonysim.suggest import nearest
from colonysim.sweep.plan import load_sweep
from colonysim.sweep.store import Store
from colonysim.sweep.tables import write_tables
from colonysim.sweep.workers import Outcome, run_locally

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Sequence

    from colonysim.sweep.plan import Limits, Sweep, Trial

__all__ = ["Engine", "run_planned", "run_sweep"]

Engine = Literal["local", "ray"]

TABLES_EVERY = 10.0
"""Least seconds of wall clock between two writings of the tables; longer where they would take over a tenth of it."""


def run_sweep(
    file: str | Path,
    out: str | Path,
    *,
    workers: int | None = None,
    engine: Engine = "local",
    retry_failed: bool = False,
    on_outcome: Callable[[Outcome, int, int], None] | None = None,
) -> tuple[Sweep, Store]:
    """Runs the trials of a sweep file that `out` does not hold yet.

    It may be stopped and started again at any time, also with another version of the file: what has finished is kept,
    what was under way is begun again. Everything runs in processes of their own, so a script that calls this needs
    the usual `if __name__ == "__main__":`.

    Args:
        file: The sweep file.
        out: The sweep's directory: its journal, its tables and a copy of the file.
        workers: How many trials run at a time; None: one for each processor, with Ray of the cluster.
        engine: "local", or "ray" for the Ray cluster that `RAY_ADDRESS` names, or one on this machine.
        retry_failed: Whether trials that have failed are run again too.
        on_outcome: Called when a trial begins and when it ends, with how many are done and how many there are.

    Returns:
        The sweep as the file has it now, and the store with the last entry of each trial.

    Raises:
        ColonysimError: The file is wrong, or the directory cannot be used.
    """
    planned = load_sweep(file)
    store = run_planned(
        planned, out, workers=workers, engine=engine, retry_failed=retry_failed, on_outcome=on_outcome,
        copy_of=Path(file),
    )  # fmt: skip
    return planned, store


def run_planned(
    planned: Sweep,
    out: str | Path,
    *,
    workers: int | None = None,
    engine: Engine = "local",
    retry_failed: bool = False,
    on_outcome: Callable[[Outcome, int, int], None] | None = None,
    copy_of: Path | None = None,
) -> Store:
    """The same for trials that are planned already; `copy_of` is the file that they come from, if there is one."""
    if workers is not None:
        workers = whole("workers", workers)
    execute = _engine(engine)
    finished = {"succeeded"} if retry_failed else {"succeeded", "failed"}
    with Store(out, write=True) as store:
        if copy_of is not None:
            _keep_copy(copy_of, store.directory)
        left = [t for t in planned.trials if store.entries.get(t.identity, {}).get("status") not in finished]
        done, total = len(planned.trials) - len(left), len(planned.trials)
        written = 0.0
        running: dict[str, Outcome] = {}
        outcomes = execute(left, planned.limits, workers)
        try:
            for outcome in outcomes:
                store.put(outcome)
                if outcome.status == "running":
                    running[outcome.trial.identity] = outcome
                else:
                    running.pop(outcome.trial.identity, None)
                    done += 1
                if on_outcome is not None:
                    on_outcome(outcome, done, total)
                if time.monotonic() >= written:
                    began = time.monotonic()
                    write_tables(store.directory, planned.trials, store.entries)
                    written = time.monotonic() + max(TABLES_EVERY, 10 * (time.monotonic() - began))
        except KeyboardInterrupt:
            for outcome in running.values():
                store.put(Outcome(outcome.trial, "interrupted"))
            raise
        finally:
            outcomes.close()
            write_tables(store.directory, planned.trials, store.entries)
    return store


def _engine(name: Engine) -> Callable[[Sequence[Trial], Limits, int | None], Generator[Outcome, None, None]]:
    if name == "local":
        return lambda trials, limits, workers: run_locally(trials, limits, workers or os.cpu_count() or 1)
    if name != "ray":
        raise ColonysimError(f"no engine {name!r}; {nearest(str(name), ('local', 'ray'))}")
    from colonysim.sweep.on_ray import run_on_ray

    return run_on_ray


def _keep_copy(file: Path, directory: Path) -> None:
    copy = directory / "sweep.yaml"
    if copy.exists() and copy.samefile(file):
        return
    with replacing(copy) as temporary:
        shutil.copyfile(file, temporary)
