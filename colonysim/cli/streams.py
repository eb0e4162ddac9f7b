"""Standard output and error that may go away: progress is lost without a word, results with one."""

from __future__ import annotations

import errno
import io
import os
import select
import sys
from typing import TYPE_CHECKING, Any, TextIO

from colonysim.errors import ColonysimError

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["GONE", "guard"]

GONE = 141
"""The exit code when whoever reads the results has gone, as a shell tells it of a program that SIGPIPE ended."""


def guard() -> None:
    """Makes standard output and error such that the command outlives them.

    What cannot be written to standard error is lost from then on. The first that cannot be written to standard output
    raises; what follows is lost, so that nothing is tried once more while the interpreter ends. A stream that was
    closed from the start is filled: the next file to be opened would take its number, and get what is meant for it.
    """
    for number, mode in enumerate((os.O_RDONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            # Standard output that can only be read: to write results to it fails, as it does where it is closed.
            os.set_inheritable(os.open(os.devnull, mode), True)
    if sys.stdin is None:
        sys.stdin = os.fdopen(0, closefd=False)
    sys.stdout = _guarded(sys.stdout, 1, _results_are_lost)
    sys.stderr = _guarded(sys.stderr, 2, lambda _: None)


def _results_are_lost(error: OSError) -> None:
    if error.errno == errno.EPIPE:
        raise SystemExit(GONE) from None
    raise ColonysimError(f"standard output cannot be written to: {error.strerror}") from None


def _guarded(stream: TextIO | None, number: int, lost: Callable[[OSError], None]) -> TextIO:
    raw = io.FileIO(number, "w", closefd=False) if stream is None else stream.buffer
    raw = getattr(raw, "raw", raw)  # unbuffered streams have none below
    # Nor is a letter that the terminal's encoding does not have worth an end of the command.
    return io.TextIOWrapper(
        io.BufferedWriter(_Stream(raw, lost)), getattr(stream, "encoding", None), "backslashreplace",
        line_buffering=getattr(stream, "line_buffering", True),
    )  # fmt: skip


class _Stream(io.RawIOBase):
    """Writes to another until that fails once; from then on everything is taken and forgotten."""

    def __init__(self, raw: Any, lost: Callable[[OSError], None]) -> None:
        self._raw = raw
        self._lost = lost
        self._gone = False

    def write(self, data: Any) -> int:
        """Writes bytes, some at least; waits where the other end is not to be waited for by itself."""
        while not self._gone:
            try:
                written = self._raw.write(data)
                if written is not None:
                    return int(written)
                select.select([], [self._raw], [])
            except OSError as error:
                self._gone = True
                self._lost(error)
        return len(data)

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return int(self._raw.fileno())

    def isatty(self) -> bool:
        return bool(self._raw.isatty())
