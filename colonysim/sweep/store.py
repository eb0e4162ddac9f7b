"""What came of each trial, on disk: a journal that only grows, so that a kill at any moment loses nothing."""

from __future__ import annotations

import errno
import json
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError

if TYPE_CHECKING:
    from types import TracebackType

    from colonysim.sweep.workers import Outcome

__all__ = ["Store"]


class Store:
    """The journal of a sweep's directory. Only one process writes at a time; any number may read.

    Args:
        directory: Created if it is absent.
        write: Whether this process will write.

    Attributes:
        entries: The last entry of each trial by identity: `status` ("running", "succeeded", "failed" or
            "interrupted"), `seconds`, and `error` or `trace_sha256` and `episodes`.

    Raises:
        ColonysimError: Another process writes there, or the directory is no sweep's or cannot be used.
    """

    def __init__(self, directory: str | Path, *, write: bool = False) -> None:
        self.directory = Path(directory)
        self._journal = self.directory / "journal.jsonl"
        self._file = -1
        self._whole = 0
        self.entries: dict[str, dict[str, Any]] = {}
        try:
            if write:
                self.directory.mkdir(parents=True, exist_ok=True)
                if not self._journal.exists() and any(self.directory.iterdir()):
                    raise ColonysimError(f"{directory}: is not empty and no sweep's; expected a new directory")
                self._file = os.open(self._journal, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
                self._lock()
                self._read()
                os.ftruncate(self._file, self._whole)
            elif not self._journal.exists():
                raise ColonysimError(f"{directory}: holds no sweep")
            else:
                self._read()
        except OSError as error:
            raise ColonysimError(f"{directory}: {error.strerror or error}") from error

    def _lock(self) -> None:
        try:
            import fcntl
        except ImportError:  # not on this system
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(self._file)
            raise ColonysimError(f"{self.directory}: another process is running this sweep") from None

    def _read(self) -> None:
        with self._journal.open("rb") as file:
            for line in file:
                if not line.endswith(b"\n"):
                    break  # the beginning of a line that was being written when the process was killed
                self._whole += len(line)
                entry = json.loads(line)
                self.entries[entry.pop("trial")] = entry
        for entry in self.entries.values():
            if entry["status"] == "running" and self._file >= 0:
                entry["status"] = "interrupted"

    def put(self, outcome: Outcome) -> None:
        """Adds an entry.

        Raises:
            ColonysimError: It cannot be written; the journal remains whole.
        """
        entry: dict[str, Any] = {"status": outcome.status, "at": time.strftime("%Y-%m-%dT%H:%M:%S%z")}
        if outcome.status in ("succeeded", "failed"):
            entry["seconds"] = round(outcome.seconds, 3)
        if outcome.status == "failed":
            entry["error"] = outcome.error
        if outcome.result is not None:
            entry |= outcome.result
        line = (json.dumps({"trial": outcome.trial.identity, **entry}, separators=(",", ":")) + "\n").encode()
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
        self.entries[outcome.trial.identity] = entry

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._file >= 0:
            os.close(self._file)
            self._file = -1
