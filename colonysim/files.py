"""Files are written under a temporary name and renamed, and one process at a time writes to a directory."""

from __future__ import annotations

import os
import sys
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

from colonysim.errors import ColonysimError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

__all__ = ["LOCK", "alone", "create_file", "replace_file", "replacing"]

LOCK = ".lock"
"""Name of the file by which `alone` holds a directory."""


@contextmanager
def replacing(path: Path, error: type[ColonysimError] = ColonysimError) -> Iterator[Path]:
    """A temporary path beside `path`, which takes its place when the block ends well and is removed otherwise.

    Missing parent folders are made.

    Args:
        path: The file to write.
        error: What to raise if it cannot be written.

    Raises:
        ColonysimError: The file cannot be written; what stood there before is untouched.

    Example:
        ```python
        with replacing(Path("table.csv")) as temporary:
            temporary.write_text("a,b")
        ```
    """
    temporary = _beside(path)
    try:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            yield temporary
            temporary.replace(path)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
    except OSError as reason:
        raise error(f"{path}: cannot be written: {reason.strerror or reason}") from reason


def replace_file(path: Path, content: bytes | str, error: type[ColonysimError] = ColonysimError) -> None:
    """Writes a whole file in one step; text becomes UTF-8.

    Raises:
        ColonysimError: It cannot be written.
    """
    with replacing(path, error) as temporary:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)


def create_file(path: Path, content: str, error: type[ColonysimError] = ColonysimError) -> None:
    """Writes a whole file that is not there yet, in one step: of several who try at once exactly one succeeds.

    Raises:
        FileExistsError: It is there.
        ColonysimError: It cannot be written.
    """
    temporary = _beside(path)
    try:
        try:
            temporary.write_text(content, encoding="utf-8", newline="\n")
            try:
                path.hardlink_to(temporary)
            except FileExistsError:
                raise
            except OSError:  # not every file system has hard links
                path.touch(exist_ok=False)
                temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except FileExistsError:
        raise
    except OSError as reason:
        raise error(f"{path}: cannot be written: {reason.strerror or reason}") from reason


def _beside(path: Path) -> Path:
    """A temporary name that is this thread's own: of two who write the same file one wins, as a whole."""
    return path.with_name(f".{os.getpid()}-{threading.get_ident()}-{path.name[-64:]}.tmp")


@contextmanager
def alone(directory: Path, what: str, error: type[ColonysimError] = ColonysimError) -> Iterator[None]:
    """Holds a directory, so that one process at a time writes there; it is made if it is absent.

    The lock is the system's: it ends with the process that holds it, however that ends. Its file stays.

    Args:
        directory: What is held.
        what: What the other process is doing, for the message: "runs this sweep".
        error: What to raise.

    Raises:
        ColonysimError: Another process holds it, or it cannot be made.
    """
    try:
        directory.mkdir(parents=True, exist_ok=True)
        file = os.open(directory / LOCK, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as reason:
        raise error(f"{directory}: cannot be written to: {reason.strerror or reason}") from reason
    try:
        try:
            _lock(file)
        except BlockingIOError:
            raise error(f"{directory}: another process {what}") from None
        except OSError as reason:
            raise error(f"{directory / LOCK}: cannot be locked: {reason.strerror or reason}") from reason
        yield
    finally:
        os.close(file)


def _lock(file: int) -> None:
    """Locks an open file for this process; of others that have it open too, none can."""
    if sys.platform == "win32":
        import msvcrt

        try:
            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        except OSError as reason:
            raise BlockingIOError from reason
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
