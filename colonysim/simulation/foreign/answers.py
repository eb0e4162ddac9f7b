"""The base class of the adapters: calls a third party's part, and converts and checks its answers."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Sequence
from copy import deepcopy
from itertools import islice
from numbers import Real
from reprlib import Repr
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from colonysim.errors import PASSED_ON, ColonysimError, PluginError, UnsavableError, told
from colonysim.pheromones.field import Write
from colonysim.states import copied, says

if TYPE_CHECKING:
    from colonysim.trace.rows import Rows
    from colonysim.world.state import World

__all__ = [
    "LARGEST", "LONGEST_TEXT", "MOST", "SHOWN", "Foreign", "fits", "is_text", "listed", "plain", "real", "truth",
    "whole",
]  # fmt: skip

MOST = 4_000_000
"""No answer has so many items."""
LARGEST = 2.0**53
"""Numbers up to this are exact everywhere."""
SHOWN = Repr()
SHOWN.maxother = SHOWN.maxstring = 200
LONGEST_TEXT = 1000
"""Characters of a reason, and of a field's name: readers of a run take no longer ones."""


def is_text(value: Any) -> bool:
    """Whether a value is a text that a trace can hold and readers take."""
    if not isinstance(value, str) or not 0 <= len(value) <= LONGEST_TEXT:
        return False
    return value.isascii() or not any("\ud800" <= letter <= "\udfff" for letter in value)


def fits(value: Any, kind: str) -> bool:
    """Whether a value can stand in a column of a kind."""
    if kind == "text":
        return is_text(value)
    if kind == "bool":
        return isinstance(value, bool)
    if kind in ("ints", "floats"):
        return isinstance(value, Sequence) and all(fits(each, kind[:-1]) for each in value)
    number = real(value)
    return number is not None and abs(number) <= LARGEST and (kind == "float" or isinstance(value, int))


def whole(value: Any) -> int | None:
    """A whole number of whatever kind, as an int; None if it is none."""
    if type(value) is int:
        return value
    try:
        return None if isinstance(value, bool) else operator.index(value)
    except TypeError:
        return None


def truth(value: Any) -> bool | None:
    """A truth value of Python or NumPy as a bool; None if it is none."""
    return bool(value) if isinstance(value, bool | np.bool_) else None


def plain(value: Any) -> Any:
    """A number or truth value of NumPy as Python's own; anything else as it is."""
    return value.item() if isinstance(value, np.generic) else value


def listed(given: Iterable[Any]) -> list[Any]:
    """What is given, as a list; what has no end is an error too."""
    found = list(islice(given, MOST))
    if len(found) == MOST:
        raise ValueError(f"it goes on after {MOST} items")
    return found


def real(value: Any) -> float | None:
    """A finite number of whatever kind, as a float; None if it is none."""
    if not isinstance(value, Real) or isinstance(value, bool):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


class Foreign:
    """Calls a part of a third party, and raises a `PluginError` that names the part if it fails.

    Args:
        part: The policy, field or backend.
        what: "policy", "field" or "backend".
        world: The world; its scenario says what exists.
        rows: The trace; tells the simulated time.
    """

    def __init__(self, part: Any, what: str, world: World, rows: Rows) -> None:
        self._part, self._what, self._rows = part, what, rows
        self.name: str = part.name
        self._nodes, self._holes = len(world.topology), len(world.scenario.holes)
        self._world = world

    def __deepcopy__(self, memo: dict[int, object]) -> Self:
        """A copy in a copied world; what it knows the time by stays the same, and cannot be copied when compiled."""
        memo[id(self._rows)] = self._rows
        twin = memo[id(self)] = type(self).__new__(type(self))
        for name, value in vars(self).items():
            setattr(twin, name, deepcopy(value, memo))
        return twin

    @property
    def _boxes(self) -> int:
        """How many boxes there are; some may come while a colony is under way."""
        return len(self._world.box_node)

    def _fault(self, why: str, agent: int | None = None, kind: type[PluginError] = PluginError) -> PluginError:
        who = "" if agent is None else f", agent {agent}"
        return kind(f"{self._what} {self.name!r}{who} at {self._rows.now:g} s: {why}")

    def _call(self, method: str, *arguments: Any, agent: int | None = None) -> Any:
        try:
            return getattr(self._part, method)(*arguments)
        except PASSED_ON:
            raise
        except BaseException as error:
            raise self._raised(method, error, agent) from error

    def _raised(self, method: str, error: BaseException, agent: int | None = None) -> PluginError:
        """What to say of an error: another's code may fail in any way, exit() included; ours still owes a message."""
        return self._fault(f"{method} raises {told(error)}", agent)

    @property
    def savable(self) -> bool:
        """Whether the part has the two methods by which it takes part in saving."""
        if self._what == "policy":  # these two speak of memories, and what derives from a policy has the same
            return all(callable(getattr(self._part, name, None)) for name in ("state", "restore"))
        return says(self._part, "state") and says(self._part, "restore")

    def check_savable(self) -> None:
        """Checks that the part can be saved.

        Raises:
            UnsavableError: It cannot.
        """
        if not self.savable:
            why = (
                f"{type(self._part).__name__} has no methods 'state' and 'restore' of its own, without which a colony "
                "cannot be saved"
            )
            raise self._fault(why, kind=UnsavableError)

    def _copied(self, method: str, given: Any, agent: int | None = None) -> Any:
        try:
            return copied(given, f"what {method} returns")
        except ColonysimError as error:
            raise self._fault(str(error), agent) from None

    def _listed(self, method: str, given: Any, agent: int | None = None) -> list[Any]:
        try:
            return listed(given)
        except (ColonysimError, MemoryError):
            raise
        except Exception as error:
            why = f"{method} returns {SHOWN.repr(given)}, expected a list ({type(error).__name__}: {error})"
            raise self._fault(why, agent) from error

    def _writes(self, method: str, by_box: bool, agent: int | None, given: Any) -> list[Write]:
        found = []
        for each in self._listed(method, given, agent):
            try:
                node, key, value = each
            except (TypeError, ValueError):
                raise self._fault(f"{method} returns {SHOWN.repr(each)}, expected a Write", agent) from None
            place, hole, number = whole(node), whole(key), real(value)
            if place is None or not 0 <= place < (self._boxes if by_box else self._nodes):
                what = "box" if by_box else "node"
                raise self._fault(f"{method} returns {SHOWN.repr(each)}, but there is no such {what}", agent)
            if hole is None or not -1 <= hole < self._holes:
                raise self._fault(f"{method} returns {SHOWN.repr(each)}, but its key is no hole and not -1", agent)
            if number is None:
                raise self._fault(f"{method} returns {SHOWN.repr(each)}, expected a finite value", agent)
            found.append(Write(place, hole, number))
        return found
