"""Model files: plain arrays in an `.npz`, and a JSON card that says how they were made and checks them.

Nothing here can run code from a file, and nothing is unpacked before its size is known and expected.
"""

import hashlib
import io
import json
import math
import struct
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import as_file, files
from pathlib import Path
from typing import IO, Any, cast

import numpy as np
import numpy.typing as npt

from colonysim.errors import ColonysimError
from colonysim.files import check_writable, read_file, read_json, replace_file

__all__ = [
    "MOST_BYTES",
    "Model",
    "ModelError",
    "as_finite",
    "check_place",
    "load_arrays",
    "load_model",
    "read_card",
    "read_content",
    "save_arrays",
    "save_model",
    "shipped_models",
    "write_card",
]

FORMAT = 1
MOST_BYTES = 64 * 2**20
"""Largest model, unpacked; those that are shipped take a third of a megabyte."""
_MOST_CARD = 4 * 2**20
_OVERHEAD = 4096
"""Bytes of an `.npz` that are not its arrays' numbers, for each of its arrays."""
_MOST_ARRAYS = 10_000
_DAMAGED = (
    ValueError, TypeError, OSError, EOFError, LookupError, RuntimeError, SyntaxError, ArithmeticError, MemoryError,
    struct.error, zipfile.BadZipFile, zlib.error,
)  # fmt: skip
"""What reading bytes that are no `.npz` may end with."""
_SHIPPED = files("colonysim").joinpath("push", "models")
"""Where the models lie that come with the package; found without importing the push."""
_FIELDS: dict[str, tuple[type, str]] = {"sha256": (str, "a text"), "arrays": (dict, "an object")}
Arrays = Mapping[str, npt.NDArray[Any]]


class ModelError(ColonysimError):
    """A model that is missing, damaged or of another kind; the message names the file and the fault."""


@dataclass(frozen=True, slots=True)
class Model:
    """A model's arrays and its card.

    Attributes:
        name: The file's name without its ending.
        file: Path of the card.
        card: The JSON card: `kind`, `how` it was made, `results`, `sha256` and more.
        arrays: The arrays, all finite numbers.
    """

    name: str
    file: Path
    card: Mapping[str, Any]
    arrays: Arrays


def shipped_models() -> tuple[str, ...]:
    """Names of the models that come with the package."""
    return tuple(sorted(f.name[: -len(".json")] for f in _SHIPPED.iterdir() if f.name.endswith(".json")))


def load_model(source: str | Path, kind: str) -> Model:
    """Load a model and check it against its card.

    Args:
        source: Name of a shipped model, or path of a card (`.json`) or of the arrays (`.npz`) beside it.
        kind: What it has to be: `"q-network"`, `"forest"`, `"logistic"` or `"colony-policy"`.

    Raises:
        ModelError: It is missing, damaged, of another kind, or holds a value that is no finite number.
    """
    if isinstance(source, str) and not source.endswith((".json", ".npz")):
        return _shipped_model(source, kind)
    path = Path(source)
    if path.suffix not in (".json", ".npz"):
        raise ModelError(f"{path}: is no model; expected the path of a card, which ends in .json")
    return _read_model(path.with_suffix(".json"), kind)


@cache  # they stay as they are, and every backend of a sweep asks for them
def _shipped_model(name: str, kind: str) -> Model:
    if name not in shipped_models():
        raise ModelError(f"no shipped model {name!r}; there are {', '.join(shipped_models()) or 'none'}")
    with as_file(_SHIPPED) as folder:
        return _read_model(folder / f"{name}.json", kind)


def _read_model(card_file: Path, kind: str) -> Model:
    data_file = card_file.with_suffix(".npz")
    card = read_card(card_file, kind)
    shapes = _shapes(card_file, card["arrays"])
    content = read_content(data_file, card, MOST_BYTES + _OVERHEAD * (len(shapes) + 1))
    return Model(card_file.stem, card_file, card, load_arrays(content, str(data_file), shapes=shapes))


def read_content(file: Path, card: Mapping[str, Any], most: int = MOST_BYTES) -> bytes:
    """The bytes of a file that a card belongs to.

    Raises:
        ModelError: It cannot be read, is too large, or is not the one that the card tells of.
    """
    content = read_file(file, ModelError, most)
    found = hashlib.sha256(content).hexdigest()
    if found != card["sha256"]:
        raise ModelError(f"{file}: SHA-256 is {found}, the card says {card['sha256'][:80]}")
    return content


def read_card(file: Path, kind: str) -> dict[str, Any]:
    """The card of a model.

    Raises:
        ModelError: It is missing, damaged, or that of another kind of model.
    """
    card = read_json(file, ModelError, _MOST_CARD)
    if not isinstance(card, dict):
        raise ModelError(f"{file}: is no model card: expected an object")
    if card.get("format") != FORMAT or card.get("kind") != kind:
        shown = f"{card.get('kind')!r:.80} of format {card.get('format')!r:.80}"
        raise ModelError(f"{file}: expected a {kind!r} of format {FORMAT}, found {shown}")
    for name, (wanted, expected) in _FIELDS.items():
        if not isinstance(card.get(name), wanted):
            raise ModelError(f"{file}: {name}: is {card.get(name)!r:.80}, expected {expected}")
    return card


def _shapes(file: Path, told: Mapping[str, Any]) -> dict[str, tuple[int, ...]]:
    """The shapes of the arrays by a card."""
    shapes: dict[str, tuple[int, ...]] = {}
    for name, shape in told.items():
        if not isinstance(shape, list) or not all(type(n) is int and 0 <= n <= MOST_BYTES for n in shape):
            raise ModelError(f"{file}: arrays.{name:.80}: is {shape!r:.80}, expected a shape, such as [200, 23]")
        shapes[name] = tuple(shape)
    numbers = sum(map(math.prod, shapes.values()))
    if numbers > MOST_BYTES:
        raise ModelError(f"{file}: arrays: {numbers} numbers; a model takes at most {MOST_BYTES} bytes")
    return shapes


def save_model(path: Path, kind: str, arrays: Arrays, card: Mapping[str, Any]) -> None:
    """Write `path` (`.npz`) and its card beside it.

    Args:
        path: The file of arrays; its folder is created.
        kind: `"q-network"`, `"forest"`, `"logistic"` or `"colony-policy"`.
        arrays: What to store.
        card: How the model was made and how well it does; JSON values only.

    Raises:
        ModelError: A file cannot be written.
    """
    content = save_arrays(path, arrays)
    shapes = {key: list(array.shape) for key, array in arrays.items()}
    write_card(path.with_suffix(".json"), kind, {**card, "arrays": shapes}, content)


def write_card(file: Path, kind: str, card: Mapping[str, Any], content: bytes) -> None:
    """Write the card of a model.

    Args:
        file: Path of the card.
        kind: As for `save_model`.
        card: The same.
        content: The bytes of the file that it belongs to.

    Raises:
        ModelError: It cannot be written.
    """
    whole = {"format": FORMAT, "kind": kind, **card, "sha256": hashlib.sha256(content).hexdigest()}
    replace_file(file, json.dumps(whole, indent=1) + "\n", ModelError)


def check_place(path: Path) -> None:
    """Finds out before the work whether `save_model` could write there.

    Raises:
        ModelError: It could not.
    """
    for file in (path, path.with_suffix(".json")):
        check_writable(file, ModelError)


def load_arrays(
    content: bytes, name: str, *, shapes: Mapping[str, tuple[int, ...]] | None = None, most: int = MOST_BYTES
) -> dict[str, npt.NDArray[Any]]:
    """The arrays of an `.npz`.

    Args:
        content: The bytes of the file.
        name: Its name in messages.
        shapes: The arrays that have to be in it; None for whichever are.
        most: Bytes that they may take, unpacked.

    Raises:
        ModelError: It is damaged, is not what was expected, or holds anything but finite numbers.
    """
    # The list of the files is read as a whole when the archive is opened, and each of them begins with this.
    if content.count(b"PK\x01\x02") > _MOST_ARRAYS:
        raise ModelError(f"{name}: holds more than {_MOST_ARRAYS} arrays")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as packed:
            arrays = _unpack(packed, name, shapes, most)
    except _DAMAGED as error:
        raise ModelError(f"{name}: is no file of plain arrays: {str(error)[:200] or type(error).__name__}") from None
    for key, array in arrays.items():
        if not np.isfinite(array).all():
            raise ModelError(f"{name}: array {key!r} holds a value that is no finite number")
    return arrays


def _unpack(
    packed: zipfile.ZipFile, name: str, shapes: Mapping[str, tuple[int, ...]] | None, most: int
) -> dict[str, npt.NDArray[Any]]:
    """The arrays, each once its own header and the list of the files have told of its size."""
    members = packed.infolist()
    keys = [member.filename.removesuffix(".npy") for member in members]
    wanted = sorted(keys if shapes is None else shapes)
    if sorted(keys) != wanted or len(set(keys)) != len(keys):
        raise ModelError(f"{name}: holds the arrays {_listed(sorted(keys))}, expected {_listed(sorted(set(wanted)))}")
    if any(member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED) for member in members):
        raise ModelError(f"{name}: is packed otherwise than by deflate, expected what `numpy.savez` writes")
    claimed = sum(member.file_size for member in members)
    if claimed > most + _OVERHEAD * len(members):
        raise ModelError(f"{name}: holds {claimed} bytes unpacked, expected at most {most}")
    arrays: dict[str, npt.NDArray[Any]] = {}
    for key, member in zip(keys, members, strict=True):
        with packed.open(member) as file:
            shape, dtype, turned = _header(file)
            if dtype.kind not in "fiu":
                raise ModelError(f"{name}: array {key!r} holds {dtype}, expected numbers; is no file of plain arrays")
            if shapes is not None and shape != shapes[key]:
                raise ModelError(f"{name}: array {key!r} has the shape {list(shape)}, by the card {list(shapes[key])}")
            size = math.prod(shape) * dtype.itemsize
            if size > member.file_size:
                raise ModelError(f"{name}: array {key!r} is to hold {size} bytes, its file has {member.file_size}")
            raw = file.read(size)
        if len(raw) != size:
            raise ModelError(f"{name}: array {key!r} ends after {len(raw)} of {size} bytes")
        array = np.frombuffer(raw, dtype).reshape(shape, order="F" if turned else "C")
        arrays[key] = array.astype(dtype.newbyteorder("="))
    return arrays


def _header(file: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any], bool]:
    """Shape, type and order (whether Fortran's) by the header of an `.npy`."""
    version = np.lib.format.read_magic(file)
    if version not in ((1, 0), (2, 0)):
        raise ValueError(f"version {version} of .npy is unknown")
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, turned, dtype = read(file)
    if min(shape, default=0) < 0:
        raise ValueError(f"the shape {shape} is none")
    return shape, dtype, turned


def _listed(names: list[str]) -> str:
    return ", ".join(names)[:200] or "none"


def as_finite(array: npt.NDArray[Any], dtype: type, name: str) -> npt.NDArray[Any]:
    """An array in the type that it is calculated with.

    Args:
        array: The array.
        dtype: The type.
        name: The array's name in messages.

    Raises:
        ModelError: A number is infinite in that type.
    """
    with np.errstate(over="ignore"):
        made: npt.NDArray[Any] = array.astype(dtype)
    if not np.isfinite(made).all():
        raise ModelError(f"array {name!r} holds a number too large for {np.dtype(dtype).name}")
    return made


def save_arrays(path: Path, arrays: Arrays) -> bytes:
    """Write arrays as an uncompressed `.npz` and return the bytes written.

    Raises:
        ModelError: It cannot be written.
    """
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **cast(dict[str, Any], arrays))
    content = buffer.getvalue()
    replace_file(path, content, ModelError)
    return content
