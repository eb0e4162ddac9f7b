"""Files are written under a temporary name and renamed, so that nobody sees one half written; and read with care."""

from __future__ import annotations

import json
import math
import os
import stat
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from colonysim.errors import ColonysimError

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["read_file", "read_json", "replace_file", "replacing"]

MAX_BYTES = 512 * 2**20
"""Largest file that is read, unless the reader of its kind says otherwise."""
MAX_DEPTH = 64
"""Deepest nesting of JSON that is read."""


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
    # Two processes that write the same file do not disturb each other: one of them wins, as a whole.
    temporary = path.with_name(f".{os.getpid()}-{path.name[-64:]}.tmp")
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


def read_file(path: Path, error: type[ColonysimError] = ColonysimError, most: int = MAX_BYTES) -> bytes:
    """The content of an ordinary file: a pipe or a device in its place could keep a reader waiting for ever.

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
                return file.read(most)
        finally:
            os.close(handle)
    except FileNotFoundError:
        raise error(f"{path}: no such file") from None
    except (OSError, ValueError) as reason:
        raise error(f"{path}: cannot be read: {getattr(reason, 'strerror', None) or reason}") from None


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
