"""Files with a JSON object a line, as programs append them and as accidents leave them."""

from __future__ import annotations

import json
import warnings
from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError, ColonysimWarning

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping
    from pathlib import Path

__all__ = ["append_line", "described", "numbered", "read_lines", "warn_of"]

_MOST = 20
"""More damaged lines of a file than these are counted, not named."""


def numbered(path: Path) -> Iterator[tuple[int, dict[str, Any], str | None]]:
    """Each line's number, from 1, its object, and what is wrong with it; the last one need not be ended.

    Raises:
        ColonysimError: The file cannot be read.
    """
    try:
        if not path.is_file():
            raise ColonysimError(f"{path}: {'is no file' if path.exists() else 'no such file'}")
        with path.open("rb") as file:
            for number, line in enumerate(file, 1):
                yield number, *_parsed(line)
    except OSError as error:
        raise ColonysimError(f"{path}: cannot be read: {error.strerror or error}") from error


def read_lines(
    path: Path, fault_of: Callable[[dict[str, Any]], str | None]
) -> tuple[list[dict[str, Any]], dict[int, str]]:
    """The rows of a file that are whole, and by the number of a line why it is left out.

    Args:
        path: The file.
        fault_of: What is wrong with a row, or None; asked row by row, in order.

    Raises:
        ColonysimError: The file cannot be read.
    """
    rows: list[dict[str, Any]] = []
    faults: dict[int, str] = {}
    for number, row, fault in numbered(path):
        if fault := fault or fault_of(row):
            faults[number] = fault
        else:
            rows.append(row)
    return rows, faults


def append_line(path: Path, row: Mapping[str, Any]) -> None:
    """Adds a row to the end of a file, on a line of its own whatever stands there.

    Raises:
        ColonysimError: It cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a+b") as file:
            size = file.tell()
            file.seek(max(0, size - 1))
            begun = size > 0 and file.read(1) != b"\n"
            file.write((b"\n" if begun else b"") + json.dumps(row).encode() + b"\n")
    except OSError as error:
        raise ColonysimError(f"{path}: cannot be written: {error.strerror or error}") from error


def described(path: Path, faults: Mapping[int, str]) -> str:
    """Names damaged lines."""
    named = "; ".join(f"line {number}: {fault}" for number, fault in list(faults.items())[:_MOST])
    return f"{path}: {named}{f'; and {len(faults) - _MOST} more' if len(faults) > _MOST else ''}"


def warn_of(path: Path, faults: Mapping[int, str], then: str) -> None:
    """Names damaged lines in one warning, if there are any; `then` says what becomes of them."""
    if faults:
        warnings.warn(f"{described(path, faults)}; {then}", ColonysimWarning, stacklevel=3)


def _parsed(line: bytes) -> tuple[dict[str, Any], str | None]:
    """The object on a line, or what is wrong with it."""
    if not line.strip():
        return {}, "it is blank"
    if b"\0" in line:
        return {}, "it holds zero bytes"
    try:
        row = json.loads(line.decode("utf-8"))
    except UnicodeDecodeError:
        return {}, "it is no UTF-8 text"
    except (ValueError, RecursionError):
        return {}, "it is no JSON" if line.rstrip().endswith(b"}") else "it is no JSON, or cut off"
    return (row, None) if isinstance(row, dict) else ({}, "expected a JSON object")
