"""Runs a sweep: what is not there yet, and nothing twice."""

from __future__ import annotations

import os
import time
import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from colonysim.arguments import whole
from colonysim.errors import ColonysimError, ColonysimWarning
from colonysim.processes import refuse_unguarded
from colonysim.progress import Bar, shows
from colonysim.suggest import nearest
from colonysim.sweep.plan import load_sweep
from colonysim.sweep.shards import Shard, as_shard, begin_shard, refuse_unmerged, shards_of
from colonysim.sweep.store import Store, holds_sweep
from colonysim.sweep.tables import write_tables
from colonysim.sweep.workers import Outcome, run_locally

if TYPE_CHECKING:
    from collections.abc import Callable, Generator, Mapping, Sequence

    from colonysim.sweep.plan import Limits, Sweep, Trial

__all__ = ["Engine", "run_planned", "run_sweep", "warn_of_others"]

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
    shard: str | tuple[int, int] | None = None,
    on_outcome: Callable[[Outcome, int, int], None] | None = None,
    progress: bool | None = None,
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
        shard: Run one part of the trials only, "2/8" or (2, 8) for the second of eight, in a directory of its own
            below `out`: the parts may run at the same time on machines that share `out`, and `merge_shards` joins them.
        on_outcome: Called when a trial begins and when it ends, with how many are done and how many there are.
        progress: Whether to show how far the sweep has come, as for `colonysim.run`. None: in a notebook only.

    Returns:
        The sweep as the file has it now, of a shard its trials, and the store with the last entry of each trial.

    Raises:
        ColonysimError: The file is wrong, the directory cannot be used, or the script lacks its guard.
    """
    refuse_unguarded()
    shown = shows(progress)
    planned = load_sweep(file)
    _engine(engine, workers)  # what is wrong with them is found before a directory is made
    part = None if shard is None else as_shard(shard)
    if part is None:
        refuse_unmerged(out)
    else:
        shards_of(out, part)
    where = out if part is None else part.directory(out)
    with Store(where, write=True) as store, Bar("sweep", 1.0, quiet=not shown) as bar:

        def told(outcome: Outcome, done: int, total: int) -> None:
            bar.move(done, total)
            if outcome.status == "failed":
                bar.line(f"failed: {outcome.trial.in_words()}: {outcome.error.strip().splitlines()[-1]}")
            if on_outcome is not None:
                on_outcome(outcome, done, total)

        mine = planned
        if part is not None:
            begin_shard(part, planned, out)
            mine = _part_of(planned, part, store, out, retry_failed)
        run_planned(
            mine, store, workers=workers, engine=engine, retry_failed=retry_failed, on_outcome=told,
            copy_of=Path(file),
        )  # fmt: skip
        warn_of_others(planned, store, file)
    return mine, store


def _part_of(planned: Sweep, part: Shard, store: Store, out: str | Path, retry_failed: bool) -> Sweep:
    """A shard's trials, without those whose results `out` holds already, from another shard or a run of them all."""
    held = Store(out).entries if holds_sweep(out) else {}
    finished = _finished(retry_failed)
    trials = [
        trial for trial in part.of(planned.trials)
        if _status(store.entries, trial) in finished or _status(held, trial) not in finished
    ]  # fmt: skip
    return replace(planned, trials=tuple(trials))


def warn_of_others(planned: Sweep, store: Store, asking: str | Path) -> None:
    """Says how many trials of a journal a sweep does not ask for.

    Args:
        planned: The sweep.
        store: The journal.
        asking: What the sweep was planned from, for the message.
    """
    asked = {trial.identity for trial in planned.trials}
    others = sum(entry["status"] != "stale" and name not in asked for name, entry in store.entries.items())
    if others:
        warnings.warn(
            f"{store.directory}: {_trials(others)} in the journal that {asking} does not ask for as it is now, and "
            "that the tables do not show", ColonysimWarning, stacklevel=3,
        )  # fmt: skip


def run_planned(
    planned: Sweep,
    store: Store,
    *,
    workers: int | None = None,
    engine: Engine = "local",
    retry_failed: bool = False,
    on_outcome: Callable[[Outcome, int, int], None] | None = None,
    copy_of: Path | None = None,
) -> None:
    """The same for trials that are planned already, into a store that is open for writing.

    `copy_of` is the file that they come from, if there is one.
    """
    refuse_unguarded()
    execute = _engine(engine, workers)
    if copy_of is not None:
        store.keep_copy(copy_of)
    stale = store.mark_stale(planned.trials)
    if stale:
        names = ", ".join(f"{name} ({_trials(count)})" for name, count in stale.items())
        warnings.warn(
            f"{store.directory}: changed since its trials were run: {names}; they are run again",
            ColonysimWarning, stacklevel=2,
        )  # fmt: skip
    finished = _finished(retry_failed)
    left = [trial for trial in planned.trials if _status(store.entries, trial) not in finished]
    done, total = len(planned.trials) - len(left), len(planned.trials)
    # The tables are of this plan from the start: a sweep that is killed soon must not show the one before.
    written = _write_tables(planned, store)
    running: dict[str, Outcome] = {}
    outcomes = execute(left, planned.limits)
    try:
        for outcome in outcomes:
            if outcome.result is not None and "changed" in outcome.result:
                raise ColonysimError(
                    f"changed since the sweep was planned: {outcome.result['changed']}; what has finished is in "
                    f"{store.directory}, start it again to go on"
                )
            store.put(outcome)
            if outcome.status == "running":
                running[outcome.trial.identity] = outcome
            else:
                running.pop(outcome.trial.identity, None)
                done += 1
            if on_outcome is not None:
                on_outcome(outcome, done, total)
            if time.monotonic() >= written:
                written = _write_tables(planned, store)
    except (KeyboardInterrupt, ColonysimError):
        for outcome in running.values():
            store.put(Outcome(outcome.trial, "interrupted"))
        raise
    finally:
        outcomes.close()
        write_tables(store.directory, planned.trials, store.entries)


def _write_tables(planned: Sweep, store: Store) -> float:
    """Writes the tables; returns when they are due again."""
    began = time.monotonic()
    write_tables(store.directory, planned.trials, store.entries)
    now = time.monotonic()
    return now + max(TABLES_EVERY, 10 * (now - began))


def _status(entries: Mapping[str, Mapping[str, Any]], trial: Trial) -> str | None:
    return entries.get(trial.identity, {}).get("status")


def _finished(retry_failed: bool) -> tuple[str, ...]:
    """The statuses of trials that are not run again."""
    return ("succeeded",) if retry_failed else ("succeeded", "failed")


def _trials(count: int) -> str:
    return f"{count} trial{'' if count == 1 else 's'}"


def _engine(name: Engine, workers: int | None) -> Callable[[Sequence[Trial], Limits], Generator[Outcome, None, None]]:
    if workers is not None:
        workers = whole("workers", workers)
    if name == "local":
        return lambda trials, limits: run_locally(trials, limits, workers or os.cpu_count() or 1)
    if name != "ray":
        raise ColonysimError(f"no engine {name!r}; {nearest(str(name), ('local', 'ray'))}")
    from colonysim.sweep.on_ray import run_on_ray

    return lambda trials, limits: run_on_ray(trials, limits, workers)
