"""Model files: plain arrays in an `.npz`, and a JSON card that says how they were made and checks them.

Nothing here can run code from a file: arrays are read with `allow_pickle=False`.
"""

import hashlib
import io
import json
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from colonysim.errors import ColonysimError
from colonysim.files import replace_file

__all__ = [
    "Model",
    "ModelError",
    "load_arrays",
    "load_model",
    "save_arrays",
    "save_model",
    "shipped_models",
]

FORMAT = 1
Arrays = Mapping[str, npt.NDArray[Any]]


class ModelError(ColonysimError):
    """A model that is missing, damaged or of another kind; the message names the file and the fault."""


@dataclass(frozen=True, slots=True)
class Model:
    """A model's arrays and its card.

    Attributes:
        name: The file's name without its ending.
        card: The JSON card: `kind`, `how` it was made, `results`, `sha256` and more.
        arrays: The arrays, all finite numbers.
    """

    name: str
    card: Mapping[str, Any]
    arrays: Arrays


def shipped_models() -> tuple[str, ...]:
    """Names of the models that come with the package."""
    folder = files("colonysim.push").joinpath("models")
    return tuple(sorted(f.name[: -len(".json")] for f in folder.iterdir() if f.name.endswith(".json")))


def load_model(source: str | Path, kind: str) -> Model:
    """Load a model and check it against its card.

    Args:
        source: Name of a shipped model, or path of a card (`.json`) or of the arrays (`.npz`) beside it.
        kind: What it has to be: `"q-network"`, `"forest"` or `"logistic"`.

    Raises:
        ModelError: It is missing, damaged, of another kind, or holds a value that is no finite number.
    """
    if isinstance(source, str) and not source.endswith((".json", ".npz")):
        return _shipped_model(source, kind)
    card_file, data_file = Path(source).with_suffix(".json"), Path(source).with_suffix(".npz")
    if not card_file.is_file():
        raise ModelError(f"{card_file}: no such model card")
    return _read_model(card_file, data_file, kind)


@cache  # they stay as they are, and every backend of a sweep asks for them
def _shipped_model(name: str, kind: str) -> Model:
    folder = files("colonysim.push").joinpath("models")
    card_file, data_file = folder.joinpath(f"{name}.json"), folder.joinpath(f"{name}.npz")
    if not card_file.is_file():
        raise ModelError(f"no shipped model {name!r}; there are {', '.join(shipped_models()) or 'none'}")
    return _read_model(card_file, data_file, kind)


def _read_model(card_file: Traversable, data_file: Traversable, kind: str) -> Model:
    name = card_file.name.removesuffix(".json")
    card = _read_card(card_file)
    if card.get("format") != FORMAT or card.get("kind") != kind:
        raise ModelError(
            f"{card_file}: expected a {kind!r} of format {FORMAT}, found "
            f"{card.get('kind')!r} of format {card.get('format')!r}"
        )
    try:
        content = data_file.read_bytes()
    except OSError as error:
        raise ModelError(f"{data_file}: cannot be read: {error}") from error
    found = hashlib.sha256(content).hexdigest()
    if found != card.get("sha256"):
        raise ModelError(f"{data_file}: SHA-256 is {found}, the card says {card.get('sha256')}")
    arrays = load_arrays(content, str(data_file))
    return Model(name, card, arrays)


def save_model(path: Path, kind: str, arrays: Arrays, card: Mapping[str, Any]) -> None:
    """Write `path` (`.npz`) and its card beside it.

    Args:
        path: The file of arrays; its folder is created.
        kind: `"q-network"`, `"forest"` or `"logistic"`.
        arrays: What to store.
        card: How the model was made and how well it does; JSON values only.
    """
    content = save_arrays(path, arrays)
    whole = {
        "format": FORMAT,
        "kind": kind,
        **card,
        "arrays": {key: list(array.shape) for key, array in arrays.items()},
        "sha256": hashlib.sha256(content).hexdigest(),
    }
    replace_file(path.with_suffix(".json"), (json.dumps(whole, indent=1) + "\n").encode())


def load_arrays(content: bytes, name: str) -> dict[str, npt.NDArray[Any]]:
    """The arrays of an `.npz`; `name` is for messages.

    Raises:
        ModelError: It is damaged, or holds anything but finite numbers.
    """
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as stored:
            arrays = {key: stored[key] for key in stored.files}
    except (ValueError, OSError, EOFError, KeyError, zipfile.BadZipFile) as error:
        raise ModelError(f"{name}: is no file of plain arrays: {error}") from error
    for key, array in arrays.items():
        if array.dtype.kind not in "fiu" or not np.isfinite(array).all():
            raise ModelError(f"{name}: array {key!r} holds a value that is no finite number")
    return arrays


def save_arrays(path: Path, arrays: Arrays) -> bytes:
    """Write arrays as an uncompressed `.npz` and return the bytes written."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **cast(dict[str, Any], arrays))
    content = buffer.getvalue()
    replace_file(path, content)
    return content


def _read_card(file: Traversable) -> dict[str, Any]:
    try:
        card = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise ModelError(f"{file}: is no model card: {error}") from error
    if not isinstance(card, dict):
        raise ModelError(f"{file}: is no model card: expected an object")
    return card
