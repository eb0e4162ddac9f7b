"""The file of a saved colony: a ZIP archive with one JSON text and arrays, as NumPy's `.npz` files are.

`numpy.load(path, allow_pickle=False)` opens it; docs/saving.md describes what is in it. What is read may come from
anywhere: sizes are looked at before memory is spent on them, and nothing in it is ever executed.
"""

from __future__ import annotations

import io
import json
import math
import sys
import zipfile
import zlib
from array import array
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from colonysim.arguments import MAX_SEED
from colonysim.errors import ColonysimError
from colonysim.files import MAX_DEPTH, opened_file, replacing
from colonysim.states import ARRAY_KINDS, DEEPEST, NUMPY_KINDS, Stored, number_kind

if TYPE_CHECKING:
    from collections.abc import Mapping

    from colonysim.states import State

__all__ = ["VERSION", "Origin", "Saved", "read_saved", "write_saved"]

FORMAT = "colonysim colony"
VERSION = 3
"""Of the format; another one is not read."""
TEXT = "colony.json"
"""The text's name in the archive."""
MOST_BYTES = 4 * 2**30
"""Largest archive, and largest content of one, that is read."""
MOST_TEXT = 2**28
"""Largest text that is read, bytes."""
MOST_MEMBERS = 1_000_000
"""Arrays in a file, and the text."""
_TYPES = dict(zip(ARRAY_KINDS, ("i1", "u1", "<i2", "<u2", "<i4", "<u4", "<i8", "<u8", "<f4", "<f8"), strict=True))
"""NumPy's types of `array.array`'s type codes, as they are on disk."""
_MARK = "~"
"""Begins the only key of a mapping that stands for what JSON has no word for."""


@dataclass(frozen=True, slots=True)
class Origin:
    """How a colony was asked for.

    Attributes:
        backend: Name of the backend, or "package.module:Name".
        options: Its options; None if it was given as an object, which no name stands for.
        policy: Name of the policy, or "package.module:Name"; None for the scenario's own.
        made: Whether the policy was given as an object or a function, which no name stands for.
    """

    backend: str
    options: Mapping[str, Any] | None = field(default_factory=dict)
    policy: str | None = None
    made: bool = False


@dataclass(frozen=True, slots=True)
class Saved:
    """A colony between two events.

    Attributes:
        document: The scenario, as plain data.
        digest: SHA-256 of that.
        origin: How it was asked for.
        mode: "asynchronous" or "synchronous".
        episodes: How many it has.
        state: All else, by parts.
        version: Of the package that wrote it.
        extra: What else the writer wants to know later, as JSON has it.
        files: The files of models that it was made with, as of `provenance.files_of`.
    """

    document: Mapping[str, Any]
    digest: str
    origin: Origin
    mode: str
    episodes: int
    state: State
    version: str
    extra: Mapping[str, Any] = field(default_factory=dict)
    files: Mapping[str, Any] = field(default_factory=dict)


def write_saved(path: Path, saved: Saved) -> None:
    """Writes a file in one step.

    Raises:
        ColonysimError: It cannot be written, or something in the state is no plain data.
    """
    arrays: dict[str, Any] = {}
    text = {
        "format": FORMAT, "schema": VERSION, "colonysim": saved.version, "scenario_sha256": saved.digest,
        "scenario": saved.document, "backend": saved.origin.backend, "options": saved.origin.options,
        "policy": saved.origin.policy, "made": saved.origin.made, "mode": saved.mode, "episodes": saved.episodes,
        "extra": saved.extra, "files": saved.files,
        "state": _written(saved.state, arrays, "state"),
    }  # fmt: skip
    if len(arrays) >= MOST_MEMBERS:
        raise ColonysimError(f"{path}: the colony holds {len(arrays)} arrays, expected fewer than {MOST_MEMBERS}")
    with replacing(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file:
        file.writestr(zipfile.ZipInfo(TEXT), json.dumps(text, ensure_ascii=False, allow_nan=False).encode(), 8)
        for name, values in arrays.items():
            # Without the time of day, so that equal colonies are equal files.
            with file.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as member:
                np.lib.format.write_array(member, values, allow_pickle=False)


def _written(value: Any, arrays: dict[str, Any], name: str, depth: int = 0) -> Any:
    """A value as JSON has it; arrays are put aside under the path at which they stand."""
    kind = type(value)
    if value is None or kind in (bool, int, str):
        return value
    if kind is float:
        return value if math.isfinite(value) else {_MARK + "float": str(value)}
    if depth > DEEPEST:
        raise ColonysimError(f"{name}: is nested deeper than {DEEPEST} levels")
    if kind is list:
        return [_written(item, arrays, f"{name}.{n}", depth + 1) for n, item in enumerate(value)]
    if kind is tuple:
        return {_MARK + "tuple": [_written(item, arrays, f"{name}.{n}", depth + 1) for n, item in enumerate(value)]}
    if kind is dict:
        if all(type(key) is str and not key.startswith(_MARK) for key in value):
            return {key: _written(item, arrays, f"{name}.{key}", depth + 1) for key, item in value.items()}
        pairs = [[key, item] for key, item in value.items()]
        return {_MARK + "pairs": _written(pairs, arrays, name, depth + 1)}
    place = f"{len(arrays)}-{name}" if any(sign in name for sign in '/\\:*?"<>|') or len(name) > 200 else name
    place = "".join(letter if letter.isascii() and (letter.isalnum() or letter in ".-_") else "_" for letter in place)
    while place in arrays:
        place += "_"
    if kind is array and value.typecode in _TYPES:
        arrays[place] = np.frombuffer(value, value.typecode).astype(_TYPES[value.typecode]) if value else _none(value)
        return {_MARK + value.typecode: place}
    if kind is bytes:
        arrays[place] = np.frombuffer(value, "u1")
        return {_MARK + "bytes": place}
    if number_kind(value) and number_kind(value) in NUMPY_KINDS:
        arrays[place] = np.asarray(value)
        return {_MARK + ("number" if isinstance(value, np.generic) else "array"): place}
    raise ColonysimError(f"{name}: a value of type {kind.__name__} is no plain data")


def _none(value: array[Any]) -> Any:
    return np.zeros(0, _TYPES[value.typecode])


def read_saved(path: Path) -> Saved:
    """Reads a file.

    Raises:
        ColonysimError: There is none, it is damaged, too large, or not such a file, or another version's.
    """
    with opened_file(path, ColonysimError, MOST_BYTES) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                members = {info.filename: info for info in archive.infolist()}
                total = sum(info.file_size for info in members.values())
                if len(archive.infolist()) > MOST_MEMBERS or total > MOST_BYTES:
                    most = f"{MOST_BYTES / 1e6:.0f} MB and {MOST_MEMBERS} arrays"
                    raise ColonysimError(f"{path}: is too large, expected at most {most} in it")
                if TEXT not in members or members[TEXT].file_size > MOST_TEXT:
                    raise ColonysimError(f"{path}: is no saved colony (it holds no {TEXT})")
                text = json.loads(archive.read(TEXT).decode(), parse_constant=_refuse)
                about = _about(text, path)
                state = _read(about.take("state"), _Arrays(archive, members))
        except (
            zipfile.BadZipFile, zipfile.LargeZipFile, OSError, ValueError, RecursionError, RuntimeError,
            NotImplementedError, EOFError, MemoryError, KeyError, TypeError, OverflowError, zlib.error,
        ) as error:  # fmt: skip
            raise ColonysimError(f"{path}: damaged, or no saved colony: {str(error)[:200]}") from None
    if not isinstance(state, dict):
        raise about.fault("state", state, "a state")
    document, options, policy = about.take("scenario"), about.take("options"), about.take("policy")
    if not isinstance(document, dict) or not isinstance(options, (dict, type(None))):
        raise ColonysimError(f"{path}: damaged: neither scenario nor options may be anything but mappings")
    asked = None if policy is None else about.text("policy")
    origin = Origin(about.text("backend"), options, asked, about.flag("made"))
    extra, files = about.take("extra"), about.take("files")
    return Saved(
        document, about.text("scenario_sha256"), origin, about.text("mode"), about.whole("episodes", 0, MAX_SEED),
        state, about.text("colonysim"), extra if isinstance(extra, dict) else {},
        files if isinstance(files, dict) else {},
    )  # fmt: skip


def _about(text: Any, path: Path) -> Stored:
    if not isinstance(text, dict) or text.get("format") != FORMAT:
        raise ColonysimError(f"{path}: is no saved colony ({TEXT} is not that of a {FORMAT})")
    if type(text.get("schema")) is not int or text["schema"] != VERSION:
        raise ColonysimError(
            f"{path}: saved by colonysim {str(text.get('colonysim'))[:20]} in format {str(text.get('schema'))[:20]}, "
            f"this one reads format {VERSION}"
        )
    return Stored(text, str(path))


def _refuse(word: str) -> Any:
    raise ValueError(f"{word} is no finite number")


@dataclass(slots=True)
class _Arrays:
    """The arrays of an archive, read when they are asked for."""

    archive: zipfile.ZipFile
    members: dict[str, zipfile.ZipInfo]

    def take(self, name: Any) -> Any:
        """An array, which can be asked for once; its size is that of the member, whatever its header claims."""
        content = self.archive.read(self.members.pop(f"{name}.npy"))
        file = io.BytesIO(content)
        version = np.lib.format.read_magic(file)
        header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, columns, kind = header(file)
        size = len(content) - file.tell()
        if kind.hasobject or kind.kind not in NUMPY_KINDS or math.prod(shape) * kind.itemsize != size:
            raise ValueError(f"array {name} is not as its header says")
        values = np.frombuffer(content, kind, offset=file.tell())
        return values.reshape(shape, order="F" if columns else "C").copy()


def _read(value: Any, arrays: _Arrays, depth: int = 0) -> Any:
    """The value that `_written` has written."""
    if depth > 2 * MAX_DEPTH:
        raise ValueError("it is nested too deeply")
    if isinstance(value, list):
        return [_read(item, arrays, depth + 1) for item in value]
    if not isinstance(value, dict):
        return value
    key = next(iter(value), "")
    if len(value) != 1 or not key.startswith(_MARK):
        return {key: _read(item, arrays, depth + 1) for key, item in value.items()}
    word, inner = key[len(_MARK) :], value[key]
    if word == "float":
        return float(inner)
    if word == "tuple":
        return tuple(_read(list(inner), arrays, depth + 1))
    if word == "pairs":
        return {_hashable(name): item for name, item in _read(list(inner), arrays, depth + 1)}
    if not isinstance(inner, str):
        raise ValueError(f"{key} names no array")
    found = arrays.take(inner)
    if word == "number":
        return found.reshape(-1)[0]
    if word == "array":
        return found
    if found.ndim != 1 or found.dtype != np.dtype("u1" if word == "bytes" else _TYPES[word]):
        raise ValueError(f"array {inner} is of another type")
    if word == "bytes":
        return found.tobytes()
    own = array(word, found.tobytes())
    if sys.byteorder == "big":
        own.byteswap()
    return own


def _hashable(key: Any) -> Any:
    try:
        hash(key)
    except TypeError:
        raise ValueError("a key of a mapping is none") from None
    return key
