"""What came of each trial, on disk: a journal that only grows, so that a kill at any moment loses nothing."""

from __future__ import annotations

import errno
import json
import os
import shutil
import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError
from colonysim.files import LOCK, alone, replacing
from colonysim.jsonlines import numbered, warn_of
from colonysim.sweep.groups import are_groups
from colonysim.sweep.tables import BOUNDS, COPY, EPISODE, JOURNAL, SHARDS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from types import TracebackType

    from colonysim.sweep.plan import Trial
    from colonysim.sweep.workers import Outcome

__all__ = ["Store", "answer_of", "holds_sweep"]

_STATUSES = ("running", "succeeded", "failed", "interrupted", "stale")


def holds_sweep(directory: str | Path) -> bool:
    """Whether a directory has a journal."""
    return (Path(directory) / JOURNAL).exists()


def answer_of(entry: Mapping[str, Any]) -> tuple[Any, ...]:
    """What an entry tells of a trial's result: the same however often the trial is run."""
    return tuple(entry.get(name) for name in ("trace_sha256", "episodes", "groups"))


class Store:
    """The journal of a sweep's directory. Only one process writes at a time; any number may read.

    A line of the journal that is damaged is named in a warning and left out; the trial that it told of has the status
    of the line before, so that a sweep runs it again.

    Args:
        directory: Created if it is absent.
        write: Whether this process will write.

    Attributes:
        entries: The last entry of each trial by identity: `status` ("running", "succeeded", "failed", "interrupted",
            or "stale" where something that determines the result has changed since), `seconds`, and `error` or
            `trace_sha256` and `episodes`.

    Raises:
        ColonysimError: Another process writes there, or the directory is no sweep's or cannot be used.
    """

    def __init__(self, directory: str | Path, *, write: bool = False) -> None:
        self.directory = Path(directory)
        self._journal = self.directory / JOURNAL
        self._file = -1
        self._whole = 0
        self._held = ExitStack()
        self.entries: dict[str, dict[str, Any]] = {}
        self._made_by: dict[str, tuple[str, dict[str, str]]] = {}
        """For what was asked the trial that answered last, and what its answer depends on."""
        if not write:
            if not self._journal.exists():
                raise ColonysimError(f"{directory}: holds no sweep")
            self._read()
            return
        try:
            with ExitStack() as held:
                held.enter_context(alone(self.directory, "is running this sweep", required=False))
                names = {path.name for path in self.directory.iterdir()}
                if self._journal.name not in names and names - {LOCK, SHARDS}:
                    raise ColonysimError(f"{directory}: is not empty and no sweep's; expected a new directory")
                self._file = os.open(self._journal, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
                held.callback(os.close, self._file)
                self._read()
                self._held = held.pop_all()
        except OSError as error:
            raise ColonysimError(f"{directory}: {error.strerror or error}") from error

    def _read(self) -> None:
        faults: dict[int, str] = {}
        answered: dict[str, tuple[int, Any]] = {}
        number = 0
        for number, entry, damage in numbered(self._journal):
            if damage := damage or _fault_of(entry):
                faults[number] = damage
                continue
            trial, answer = entry.pop("trial"), answer_of(entry)
            if entry["status"] != "succeeded":
                answered.pop(trial, None)
            elif trial in answered:
                first, other = answered[trial]
                faults[number] = f"line {first} told already what came of this trial"
                if other != answer:
                    self.entries[trial] = {"status": "interrupted"}
                continue
            else:
                answered[trial] = number, answer
            if "asked" in entry:
                self._made_by[entry.pop("asked")] = trial, entry.pop("made_by")
            self.entries[trial] = entry
        self._whole = self._journal.stat().st_size
        if not self._ends_whole():
            if self._file < 0:
                faults.pop(number, None)  # it may be being written
            else:
                self._append(b"\n")
        if self._file >= 0:
            for entry in self.entries.values():
                if entry["status"] == "running":
                    entry["status"] = "interrupted"
        warn_of(self._journal, faults, "what these lines told of runs again, the others hold")

    def _ends_whole(self) -> bool:
        """Whether nothing stands behind the journal's last end of a line."""
        with self._journal.open("rb") as file:
            file.seek(max(0, self._whole - 1))
            return file.read() in (b"", b"\n")

    def put(self, outcome: Outcome) -> None:
        """Adds an entry.

        Raises:
            ColonysimError: It cannot be written; the journal remains whole.
        """
        trial = outcome.trial
        entry: dict[str, Any] = {"status": outcome.status, "at": _now()}
        about: dict[str, Any] = {}
        if outcome.status == "running":
            about = {"asked": trial.asked(), "made_by": trial.determinants()}
            self._made_by[about["asked"]] = trial.identity, about["made_by"]
        if outcome.status in ("succeeded", "failed"):
            entry["seconds"] = round(outcome.seconds, 3)
        if outcome.status == "failed":
            entry["error"] = outcome.error
        if outcome.result is not None:
            entry |= outcome.result
        self._put(trial.identity, entry, about)

    def take(self, trial: Trial, entry: Mapping[str, Any]) -> None:
        """Adds the entry of a finished trial that another journal holds.

        Raises:
            ColonysimError: As for `put`.
        """
        about = {"asked": trial.asked(), "made_by": trial.determinants()}
        self._made_by[trial.asked()] = trial.identity, trial.determinants()
        self._put(trial.identity, dict(entry), about)

    def keep_copy(self, file: Path) -> None:
        """Keeps a copy of the sweep file beside the journal.

        Raises:
            ColonysimError: It cannot be written.
        """
        copy = self.directory / COPY
        if copy.exists() and copy.samefile(file):
            return
        with replacing(copy) as temporary:
            shutil.copyfile(file, temporary)

    def mark_stale(self, trials: Iterable[Trial]) -> dict[str, int]:
        """Marks what was answered before under other code, scenarios or versions than these trials have now.

        Returns:
            By name of what has changed: how many entries it makes stale.
        """
        changed: dict[str, int] = {}
        for trial in trials:
            before, made_by = self._made_by.get(trial.asked(), (trial.identity, {}))
            if before == trial.identity or self.entries[before]["status"] not in ("succeeded", "failed"):
                continue
            now = trial.determinants()
            names = [name for name in {**made_by, **now} if made_by.get(name) != now.get(name)]
            self._put(before, {"status": "stale", "at": _now(), "changed": names}, {})
            for name in names:
                changed[name] = changed.get(name, 0) + 1
        return changed

    def _put(self, identity: str, entry: dict[str, Any], about: dict[str, Any]) -> None:
        self._append((json.dumps({"trial": identity, **entry, **about}, separators=(",", ":")) + "\n").encode())
        self.entries[identity] = entry

    def _append(self, line: bytes) -> None:
        try:
            if os.write(self._file, line) < len(line):
                os.ftruncate(self._file, self._whole)
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        except OSError as error:
            raise ColonysimError(
                f"{self._journal}: cannot be written: {error.strerror or error}; what is there is kept, run the sweep"
                " again when that is mended"
            ) from error
        self._whole += len(line)

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._held.close()
        self._file = -1


def _now() -> str:
    return time.strftime("%Y-%m-%dT%H:%M:%S%z")


def _fault_of(entry: dict[str, Any]) -> str | None:
    """What is wrong with an entry of the journal, or None."""
    if not isinstance(entry.get("trial"), str):
        return "it names no trial"
    status = entry.get("status")
    if not isinstance(status, str) or status not in _STATUSES:
        return f"expected a status, one of {', '.join(_STATUSES)}"
    if not (isinstance(entry.get("seconds", 0.0), (int, float)) and _within("seconds", entry.get("seconds", 0.0))):
        return "its seconds are no number"
    if "asked" in entry and not (isinstance(entry["asked"], str) and _texts(entry.get("made_by"))):
        return "what its result depends on is not as it was written"
    if (status == "failed" or "error" in entry) and not isinstance(entry.get("error"), str):
        return "it does not say why the trial failed"
    if (status == "succeeded" or "trace_sha256" in entry) and not isinstance(entry.get("trace_sha256"), str):
        return "it has no hash of the trace"
    if not are_groups(entry.get("groups", [])):
        return "its groups of agents are not as they were written"
    if (status == "succeeded" or "episodes" in entry) and not _are_episodes(entry.get("episodes")):
        return "its episodes are not as they were written"
    return None


def _texts(value: Any) -> bool:
    return isinstance(value, dict) and all(isinstance(text, str) for text in value.values())


_KINDS: tuple[type | tuple[type, ...], ...] = (int, int, (int, float), str, (int, float), int)
"""Of the columns `EPISODE`."""


def _are_episodes(value: Any) -> bool:
    return isinstance(value, list) and all(
        isinstance(row, list)
        and len(row) == len(EPISODE)
        and all(isinstance(cell, kind) and not isinstance(cell, bool) for cell, kind in zip(row, _KINDS, strict=True))
        and all(_within(name, cell) for name, cell in zip(EPISODE, row, strict=True))
        for row in value
    )


def _within(name: str, value: Any) -> bool:
    """Whether a number is one that a table takes."""
    least, most = BOUNDS.get(name, (value, value))
    return bool(least <= value <= most)
