"""Joins what the shards of a sweep have found in the sweep's own journal and tables."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError
from colonysim.sweep.plan import load_sweep
from colonysim.sweep.running import warn_of_others
from colonysim.sweep.shards import Shard, difference, shards_of
from colonysim.sweep.store import Store, answer_of, holds_sweep
from colonysim.sweep.tables import write_tables

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.sweep.plan import Sweep, Trial

__all__ = ["merge_shards"]

_NAMED = 3
"""Most missing trials, and shards that lack some, that a message names."""


def merge_shards(file: str | Path, out: str | Path, *, partial: bool = False) -> tuple[Sweep, Store, list[Trial]]:
    """Adds what the shards in `out` have found to its own journal, and writes the tables of all trials.

    The tables are those of a sweep that was run by one command. What the journal holds already stays, so merging again
    adds what has finished since; afterwards `run_sweep` without a shard goes on with what is missing. The shards'
    directories are only read.

    Args:
        file: The sweep file that the shards were run from.
        out: The sweep's directory.
        partial: Whether to merge also while trials are missing; in the tables these have the status "pending".

    Returns:
        The sweep, the store with the last entry of each trial, and the trials that are missing.

    Raises:
        ColonysimError: The file is wrong; there are no shards; one of them, or two together, contradict the file or
            each other; or trials are missing and `partial` is false.
    """
    planned = load_sweep(file)
    shards = shards_of(out)
    if not shards:
        raise ColonysimError(f"{out}: holds no shards to merge; `--shard 1/8` runs the first of eight")
    for shard in shards:
        if told := difference(shard, planned, out):
            raise ColonysimError(f"{out}: shard {shard} {told}; run it again with --shard {shard}, and merge then")
    found = _found(planned, shards, out)
    missing = [trial for trial in planned.trials if trial.identity not in found]
    if missing and not partial:
        raise ColonysimError(f"{out}: {_told(missing, planned, shards)}; --partial merges what there is")
    with Store(out, write=True) as store:
        store.keep_copy(Path(file))
        store.mark_stale(planned.trials)
        for trial in planned.trials:
            entry = found.get(trial.identity)
            if entry is not None and _better(entry, store.entries.get(trial.identity)):
                store.take(trial, entry)
        write_tables(store.directory, planned.trials, store.entries)
        warn_of_others(planned, store, file)
    return planned, store, missing


def _found(planned: Sweep, shards: Sequence[Shard], out: str | Path) -> dict[str, Mapping[str, Any]]:
    """By identity the entries of all trials that have finished, in the sweep's own journal or in a shard's.

    Raises:
        ColonysimError: Two journals hold different results of a trial.
    """
    asked = {trial.identity: trial for trial in planned.trials}
    found: dict[str, Mapping[str, Any]] = {}
    told_by: dict[str, Path] = {}
    for directory in (Path(out), *(shard.directory(out) for shard in shards)):
        for identity, entry in Store(directory).entries.items() if holds_sweep(directory) else ():
            before = found.get(identity)
            if identity not in asked or entry["status"] not in ("succeeded", "failed"):
                continue
            if before is not None and before["status"] == entry["status"] == "succeeded":
                if answer_of(before) != answer_of(entry):
                    raise ColonysimError(
                        f"{told_by[identity]} and {directory} hold different results of one trial, "
                        f"{asked[identity].in_words()}: something that it depends on is unknown to the sweep (`tags`)"
                    )
            elif _better(entry, before):
                found[identity], told_by[identity] = entry, directory
    return found


def _better(entry: Mapping[str, Any], before: Mapping[str, Any] | None) -> bool:
    """Whether a finished entry takes the place of another of its trial: success stays, a failure gives way."""
    return before is None or (before["status"] != "succeeded" and before != entry)


def _told(missing: Sequence[Trial], planned: Sweep, shards: Sequence[Shard]) -> str:
    """How many trials are missing, of which shards, and the first few by name."""
    lost = {trial.identity for trial in missing}
    every = [Shard(number, shards[0].count) for number in range(1, shards[0].count + 1)]
    counts = {shard: sum(trial.identity in lost for trial in shard.of(planned.trials)) for shard in every}
    parts = [
        f"{count} of shard {shard}{'' if shard in shards else ', which has not begun'}"
        for shard, count in counts.items() if count
    ]  # fmt: skip
    names = [trial.in_words() for trial in missing]
    return f"{len(missing)} of {len(planned.trials)} trials are missing: {_first(parts)} ({_first(names)})"


def _first(words: Sequence[str]) -> str:
    more = f"; and {len(words) - _NAMED} more" if len(words) > _NAMED else ""
    return "; ".join(words[:_NAMED]) + more
