"""What a check says when a promise is broken, and how two runs or two states are compared."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Iterator, Mapping, Sequence, Set
from contextlib import contextmanager
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from colonysim.simulation import Colony
    from colonysim.world.state import World

__all__ = [
    "ConformanceError", "Recorder", "frozen", "global_randomness", "same_futures", "same_traces", "world_state",
]  # fmt: skip


class ConformanceError(ColonysimError):
    """A policy or a backend breaks one of the promises of its protocol.

    Attributes:
        promise: Which one, in a word or two ("determinism", "legal outcomes", ...).
        message: What happened.
    """

    def __init__(self, promise: str, message: str) -> None:
        # Both arguments, so that it can be built anew, as on its way from one process to another.
        super().__init__(promise, message)
        self.promise = promise
        self.message = message

    def __str__(self) -> str:
        return f"{self.promise}: {self.message}"


class Recorder:
    """A sink that keeps the rows of all tables, without wall-clock time."""

    def __init__(self) -> None:
        self.rows: list[tuple[str, tuple[Any, ...]]] = []

    def write(self, table: str, row: tuple[object, ...]) -> None:
        """Takes one row."""
        self.rows.append((table, tuple(row[:-1]) if table == "episodes" else tuple(row)))


MOMENTS = (0, 1, 4, 13, 40)
"""After so many events a colony is forked."""


def same_futures(
    make: Callable[[], Colony], fork: Callable[[Colony, int | None], Colony], *, reseeds: bool = True
) -> None:
    """Forks a colony at some moments; the twins must do what the colony does, and forks of one seed the same.

    Args:
        make: Makes the colony.
        fork: Forks it, with a seed or None.
        reseeds: Whether it can be forked with a seed.

    Raises:
        ConformanceError: They do not.
    """
    whole, colony, steps = list(make()), make(), 0
    for moment in MOMENTS:
        if moment >= len(whole):
            break
        while steps < moment:
            colony.step()
            steps += 1
        where = f"a colony saved after {moment} events"
        try:
            twin = list(fork(colony, None))
            pair = [list(fork(colony, 5)) for _ in range(2)] if reseeds else [[], []]
        except Exception as error:
            raise ConformanceError("saving", f"{where} fails: {error!r}") from error
        for event, other in zip_longest(whole[moment:], twin):
            if event != other:
                raise ConformanceError("saving", f"{where} goes on otherwise: with {other} in place of {event}")
        if pair[0] != pair[1]:
            raise ConformanceError("saving", f"two forks of {where} with the same seed differ")


def same_traces(promise: str, what: str, first: Recorder, second: Recorder) -> None:
    """Compares two runs row by row.

    Raises:
        ConformanceError: They differ; the message shows the first row that does.
    """
    for number, (a, b) in enumerate(zip(first.rows, second.rows, strict=False)):
        # repr tells 0.0 from -0.0 and calls two NaN the same, as the trace's hash does.
        if repr(a) != repr(b):
            episode = f" (episode {a[1][0]})" if a[1] else ""
            raise ConformanceError(promise, f"{what}: row {number}{episode} was {a} and is now {b}")
    if len(first.rows) != len(second.rows):
        raise ConformanceError(promise, f"{what}: there were {len(first.rows)} rows and are now {len(second.rows)}")


def frozen(value: Any, depth: int = 12) -> Any:
    """A value's content as nested tuples, so that a change in place can be seen; objects by their attributes."""
    if depth == 0 or value is None or isinstance(value, bool | int | float | complex | str | bytes):
        return repr(value)
    kind = type(value).__qualname__
    if isinstance(value, random.Random):
        return kind, value.getstate()
    if isinstance(value, Mapping):
        return kind, tuple((frozen(key, depth - 1), frozen(item, depth - 1)) for key, item in value.items())
    if isinstance(value, Set):
        return kind, tuple(sorted(map(repr, value)))
    if isinstance(value, Sequence):
        return kind, tuple(frozen(item, depth - 1) for item in value)
    if dataclasses.is_dataclass(value):
        fields = [field.name for field in dataclasses.fields(value)]
        return kind, tuple((name, frozen(getattr(value, name), depth - 1)) for name in fields)
    tolist = getattr(value, "tolist", None)
    if callable(tolist):
        return kind, frozen(tolist(), depth - 1)
    names = [*getattr(value, "__dict__", ()), *(n for c in type(value).__mro__ for n in getattr(c, "__slots__", ()))]
    return kind, tuple((name, frozen(getattr(value, name, None), depth - 1)) for name in names) or repr(value)


def world_state(world: World) -> dict[str, Any]:
    """Everything in a world that can change, by attribute: arrays as lists, and what is keyed as dictionaries."""
    names = [name for name in type(world).__slots__ if not name.startswith("_")]
    values = {name: getattr(world, name) for name in names if name not in {"scenario", "topology", "terrain"}}
    values["rises"] = world.terrain.rises
    return {
        name: repr(value if isinstance(value, (dict, float, int)) else list(value)) for name, value in values.items()
    }


@contextmanager
def global_randomness(seed: int) -> Iterator[None]:
    """Seeds the `random` module's own generator for a while, and puts it back."""
    before = random.getstate()
    random.seed(seed)
    try:
        yield
    finally:
        random.setstate(before)


def listed(names: Iterable[object]) -> str:
    """Names for a message."""
    return ", ".join(map(str, names)) or "none"
