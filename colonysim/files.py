"""Files: written under a temporary name and renamed, by one process at a time; read with care."""

from __future__ import annotations

import errno
import json
import math
import os
import shutil
import stat
import sys
import tempfile
import threading
import warnings
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, NoReturn

from colonysim.errors import ColonysimError, ColonysimWarning

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = [
    "LOCK", "alone", "check_writable", "create_file", "found_at", "opened_file", "read_file", "read_json",
    "remove_file", "replace_file", "replacing", "shown_path",
]  # fmt: skip

LOCK = ".lock"
"""Name of the file by which `alone` holds a directory."""
MAX_BYTES = 512 * 2**20
"""Largest file that is read, unless the reader of its kind says otherwise."""
MAX_DEPTH = 64
"""Deepest nesting of JSON that is read."""
_LOCKLESS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.ENOTSUP)
"""What systems say of a file system, such as one that is shared by many machines, that knows no locks."""


@contextmanager
def replacing(path: Path, error: type[ColonysimError] = ColonysimError) -> Iterator[Path]:
    r"""A temporary path beside `path`, which takes its place when the block ends well and is removed otherwise.

    Missing parent folders are made. Where `path` is a link, what it leads to is replaced. A pipe or a device is not
    replaced: what was written goes into it when the block ends well.

    Args:
        path: The file to write.
        error: What to raise if it cannot be written.

    Raises:
        ColonysimError: The file cannot be written; what stood there before is untouched. Or it is a directory.

    Example:
        ```python
        with replacing(Path("table.csv")) as temporary:
            temporary.write_text("a,b")
        ```
    """
    try:
        target = _replaced(path, error)
    except (OSError, ValueError) as reason:
        raise _unwritten(path, reason, error) from reason
    try:
        if target is None:
            with tempfile.TemporaryDirectory(prefix="colonysim-") as folder:
                temporary = Path(folder) / "content"
                yield temporary
                _pour(temporary, path)
            return
        temporary = _beside(target)
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            yield temporary
            temporary.replace(target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
    except OSError as reason:
        raise _unwritten(path, reason, error) from reason


def check_writable(path: Path, error: type[ColonysimError] = ColonysimError) -> None:
    """Finds out before long work whether `replacing` could write a file; leaves at most missing parent folders.

    Raises:
        ColonysimError: It could not.
    """
    try:
        target = _replaced(path, error)
        if target is not None:
            target.parent.mkdir(parents=True, exist_ok=True)
            temporary = _beside(target)
            temporary.touch()
            temporary.unlink()
    except (OSError, ValueError) as reason:
        raise _unwritten(path, reason, error) from reason


def _replaced(path: Path, error: type[ColonysimError]) -> Path | None:
    """The ordinary file that a writer replaces, behind all links; None where a pipe or a device is written into."""
    try:
        found = path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return path.resolve()
    if stat.S_ISDIR(found.st_mode):
        _check_ordinary(path, found.st_mode, error)
    if not stat.S_ISREG(found.st_mode):
        return None
    target = path.resolve()
    # A file that is open but has no name any more, behind a name such as /dev/stdout.
    return target if target.exists() and target.samefile(path) else None


def _pour(source: Path, target: Path) -> None:
    """Copies a file into a pipe, a device or whatever else is there."""
    # Not to be made: some systems refuse that of others' pipes in a shared folder.
    with source.open("rb") as content, os.fdopen(os.open(target, os.O_WRONLY | getattr(os, "O_BINARY", 0)), "wb") as to:
        shutil.copyfileobj(content, to)


def _unwritten(path: Path, reason: Exception, error: type[ColonysimError]) -> ColonysimError:
    return error(f"{path}: cannot be written: {_told(reason)}")


def _told(reason: Exception) -> str:
    """What the system said, or Python of a name that no file can have."""
    return getattr(reason, "strerror", None) or str(reason)


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
    except (OSError, ValueError) as reason:
        raise _unwritten(path, reason, error) from reason


def remove_file(path: Path, error: type[ColonysimError] = ColonysimError) -> None:
    """Removes a file, if it is there.

    Raises:
        ColonysimError: It cannot be removed.
    """
    try:
        path.unlink(missing_ok=True)
    except OSError as reason:
        raise error(f"{path}: cannot be removed: {_told(reason)}") from reason


def _beside(path: Path) -> Path:
    """A temporary name that is this thread's own: of two who write the same file one wins, as a whole."""
    return path.with_name(f".{os.getpid()}-{threading.get_ident()}-{path.name[-64:]}.tmp")


@contextmanager
def alone(
    directory: Path, what: str, error: type[ColonysimError] = ColonysimError, *, required: bool = True
) -> Iterator[None]:
    """Holds a directory, so that one process at a time writes there; it is made if it is absent.

    The lock is the system's: it ends with the process that holds it, however that ends. Its file stays.

    Args:
        directory: What is held.
        what: What the other process is doing, for the message: "runs this sweep".
        error: What to raise.
        required: Whether a file system that knows no locks is an error; otherwise a warning.

    Raises:
        ColonysimError: Another process holds it, or it cannot be made.
    """
    try:
        directory.mkdir(parents=True, exist_ok=True)
        file = os.open(directory / LOCK, os.O_RDWR | os.O_CREAT, 0o644)
    except (OSError, ValueError) as reason:
        raise error(f"{directory}: cannot be written to: {_told(reason)}") from reason
    try:
        try:
            _lock(file)
        except BlockingIOError:
            raise error(f"{directory}: another process {what}") from None
        except OSError as reason:
            if required or reason.errno not in _LOCKLESS:
                raise error(f"{directory / LOCK}: cannot be locked: {reason.strerror or reason}") from reason
            warnings.warn(
                f"{directory}: this file system knows no locks: see to it that no other process {what}",
                ColonysimWarning, stacklevel=4,
            )  # fmt: skip
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


@contextmanager
def opened_file(path: Path, error: type[ColonysimError] = ColonysimError, most: int = MAX_BYTES) -> Iterator[BinaryIO]:
    """An ordinary file, open to be read: a pipe or a device in its place could keep a reader waiting for ever.

    Args:
        path: The file.
        error: What to raise if it cannot be read.
        most: Largest size, bytes.

    Raises:
        ColonysimError: It is missing, no ordinary file, larger than that, or cannot be read.
    """
    try:
        # Opening a pipe that nobody writes to would wait, so its kind is asked first; and not to wait, if it changes.
        _check_ordinary(path, path.stat().st_mode, error)
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        try:
            found = os.fstat(handle)
            _check_ordinary(path, found.st_mode, error)
            if found.st_size > most:
                raise error(f"{path}: holds {found.st_size / 1e6:.1f} MB, expected at most {most / 1e6:.1f} MB")
            with os.fdopen(os.dup(handle), "rb") as file:
                yield file
        finally:
            os.close(handle)
    except FileNotFoundError:
        raise error(f"{path}: no such file") from None
    except (OSError, ValueError) as reason:
        raise error(f"{path}: cannot be read: {_told(reason)}") from None


def read_file(path: Path, error: type[ColonysimError] = ColonysimError, most: int = MAX_BYTES) -> bytes:
    """The content of an ordinary file; see `opened_file`."""
    with opened_file(path, error, most) as file:
        return file.read(most)


def _check_ordinary(path: Path, mode: int, error: type[ColonysimError]) -> None:
    if not stat.S_ISREG(mode):
        kinds = {stat.S_IFDIR: "directory", stat.S_IFIFO: "pipe", stat.S_IFSOCK: "socket"}
        raise error(f"{path}: is a {kinds.get(stat.S_IFMT(mode), 'device')}, expected a file")


def read_json(path: Path, error: type[ColonysimError] = ColonysimError, most: int = MAX_BYTES // 8) -> Any:
    """The value in a JSON file (UTF-8): finite numbers, text without lone surrogates, at most 64 levels deep.

    Args:
        path: The file.
        error: What to raise if it cannot be read.
        most: Largest size, bytes.

    Raises:
        ColonysimError: It is missing, no ordinary file, or holds anything else.
    """
    content = read_file(path, error, most)
    try:
        value = json.loads(content.decode(), parse_constant=_refuse, parse_float=_finite)
    except (ValueError, RecursionError) as reason:
        told = "is nested too deeply" if isinstance(reason, RecursionError) else str(reason)
        raise error(f"{path}: cannot be read as JSON: {told[:200]}") from None
    _check_text(value, path, "", error, 0)
    return value


def _refuse(word: str) -> NoReturn:
    raise ValueError(f"{word} is no finite number")


def _finite(text: str) -> float:
    value = float(text)
    return value if math.isfinite(value) else _refuse(text[:30])


def _check_text(value: Any, path: Path, where: str, error: type[ColonysimError], depth: int) -> None:
    if depth > MAX_DEPTH:
        raise error(f"{path}: {where[:80]}: nested deeper than {MAX_DEPTH} levels")
    if isinstance(value, str):
        if not value.isascii() and any("\ud800" <= letter <= "\udfff" for letter in value):
            raise error(f"{path}: {where[:80]}: holds half of a surrogate pair, expected text")
    elif isinstance(value, dict):
        for key, item in value.items():
            _check_text(key, path, where or "a key", error, depth)
            _check_text(item, path, f"{where}.{key}" if where else key, error, depth + 1)
    elif isinstance(value, list):
        for number, item in enumerate(value):
            if isinstance(item, (str, dict, list)):
                _check_text(item, path, f"{where}.{number}", error, depth + 1)


def found_at(value: Any, path: str) -> Any:
    """What is at a dotted path within nested mappings, such as "how.seed"; None where there is nothing."""
    for name in path.split("."):
        value = value.get(name) if isinstance(value, dict) else None
    return value


def shown_path(path: str | Path) -> str:
    """A path for people: relative if it lies below the working directory."""
    try:
        return str(Path(path).relative_to(Path.cwd()))
    except (ValueError, OSError):
        return str(path)
