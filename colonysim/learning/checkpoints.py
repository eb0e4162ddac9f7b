"""Trainings that can be stopped: after each part there is a checkpoint, and who goes on ends as if never stopped."""

from __future__ import annotations

import dataclasses
import json
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import numpy as np
from pydantic import TypeAdapter, ValidationError

from colonysim.files import alone, check_writable, read_file, replace_file
from colonysim.learning.cards import ModelError, check_place, load_arrays, save_arrays

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

__all__ = ["CHECKPOINT", "Training", "carry_out", "fitting", "read_checkpoint", "write_checkpoint"]

CHECKPOINT, HISTORY = "checkpoint.npz", "history.json"

P = TypeVar("P")
R = TypeVar("R", covariant=True)
N = TypeVar("N")


class Training(Protocol[P, R]):
    """A training between two of its parts."""

    history: list[P]
    """What each part came to."""

    @property
    def finished(self) -> bool:
        """Whether there is no further part."""
        ...

    def go_on(self) -> None:
        """The next part."""
        ...

    def save(self) -> None:
        """Writes a checkpoint."""
        ...

    def restore(self) -> None:
        """Goes on from the checkpoint, if there is one."""
        ...

    def finish(self, name: str) -> R:
        """Writes the models; the best has this name."""
        ...


def carry_out(
    begin: Callable[[], Training[P, R]],
    folder: Path,
    models: Sequence[str],
    *,
    resume: bool,
    stop_after: int | None,
    on_progress: Callable[[P], None] | None,
) -> R | None:
    """Carries a training out, part by part, with a checkpoint after each.

    Args:
        begin: Makes the training, once it is sure that what it will write can be written.
        folder: Where it writes.
        models: Names of the models that it will write, the best one's first.
        resume: Whether it goes on from the checkpoint in the folder.
        stop_after: Leave after this many parts, as an interruption would.
        on_progress: Called after each part.

    Returns:
        What the training ends with, or None when it was left early.

    Raises:
        ColonysimError: Another process is training in the folder.
        ModelError: A file cannot be written there, or the checkpoint does not fit.
    """
    with alone(folder, "is training there"):
        for name in models:
            check_place(folder / f"{name}.npz")
        for file in (CHECKPOINT, HISTORY):
            check_writable(folder / file, ModelError)
        run = begin()
        if resume:
            run.restore()
        done = 0
        while not run.finished:
            if stop_after is not None and done >= stop_after:
                return None
            run.go_on()
            run.save()
            done += 1
            if on_progress is not None:
                on_progress(run.history[-1])
        return run.finish(models[0])


def write_checkpoint(folder: Path, arrays: Mapping[str, NDArray[Any]], note: Mapping[str, Any]) -> None:
    """Writes a checkpoint, and beside it the history in plain text, for whoever wants to see how the training goes.

    Args:
        folder: Where.
        arrays: Its arrays.
        note: What else it holds, as JSON has it; `config`, `seed` and `history` among it.
    """
    text = np.frombuffer(json.dumps(note).encode(), dtype=np.uint8)
    save_arrays(folder / CHECKPOINT, {**arrays, "note": text})
    replace_file(folder / HISTORY, json.dumps(note["history"], indent=1), ModelError)


def read_checkpoint(
    folder: Path, kind: type[N], config: Any, seed: int, most: int
) -> tuple[dict[str, NDArray[Any]], N] | None:
    """The arrays and the note of a checkpoint; None if there is none.

    Args:
        folder: Where it is.
        kind: A dataclass with the fields of the note.
        config: The configuration of the training, a dataclass.
        seed: Its seed.
        most: Bytes that it may take.

    Raises:
        ModelError: It is damaged, or of a training with another configuration or seed.
    """
    path = folder / CHECKPOINT
    if not path.exists():
        return None
    arrays = load_arrays(read_file(path, ModelError, most), str(path), most=most)
    text = arrays.pop("note", np.zeros(0, dtype=np.uint8))
    try:
        note: Any = TypeAdapter(kind).validate_json(text.tobytes())
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(["note", *map(str, first["loc"])])
        raise ModelError(f"{path}: {where}: {first['msg'][:200]}") from None
    if note.config != json.loads(json.dumps(dataclasses.asdict(config))) or note.seed != seed:
        raise ModelError(f"{path}: was made with another configuration or seed; train in another folder")
    return arrays, note


@contextmanager
def fitting(folder: Path) -> Iterator[None]:
    """Tells what does not fit while the arrays of a checkpoint are taken over.

    Raises:
        ModelError: Something does not.
    """
    said = f"{folder / CHECKPOINT}: is no checkpoint of such a training"
    try:
        yield
    except KeyError as error:
        raise ModelError(f"{said}: {error} is missing") from None
    except (ValueError, TypeError, RuntimeError, OverflowError, ModelError) as error:
        told = (str(error).splitlines() or [type(error).__name__])[0]
        raise ModelError(f"{said}: {told[:200]}") from None
