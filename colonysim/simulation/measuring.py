"""What a user measures of a colony under way, and when."""

from __future__ import annotations

from math import inf
from numbers import Real
from typing import TYPE_CHECKING

from colonysim.arguments import real
from colonysim.errors import ColonysimError, PluginError
from colonysim.simulation.foreign.answers import SHOWN, is_text
from colonysim.states import Stored
from colonysim.trace.schema import Measurement

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from colonysim.simulation.colony import Colony
    from colonysim.states import State

__all__ = ["Measures"]

SHORTEST, LONGEST = 1e-3, 1e9
"""Bounds of the time from one value to the next, simulated seconds."""


class _Measure:
    """One thing to measure, and when it is due next, simulated seconds of the episode."""

    __slots__ = ("call", "count", "every", "name")

    def __init__(self, name: str, call: Callable[[Colony], float], every: float, now: float) -> None:
        self.name, self.call, self.every = name, call, every
        self.count = 1 if every == inf else int(now / every) + 1

    @property
    def due(self) -> float:
        return self.count * self.every


class Measures:
    """The measurements of a colony.

    Attributes:
        due: When the next value is to be taken, simulated seconds of the episode; infinity for at its end.
    """

    def __init__(self) -> None:
        self._all: list[_Measure] = []
        self.due = inf
        self._saved: dict[str, tuple[int, float]] = {}
        """Of a saved colony: for each name how many values there are in the episode, counting the next, and how often
        one is taken."""

    def add(self, name: str, call: Callable[[Colony], float], every: float | None, now: float) -> None:
        """Adds one; see `Colony.measure`."""
        if not is_text(name) or not name:
            raise ColonysimError(f"measure: the name is {SHOWN.repr(name)}, expected a text of at most 1000 characters")
        if any(measure.name == name for measure in self._all):
            raise ColonysimError(f"measure: {name!r} is measured already; expected another name")
        if not callable(call):
            raise ColonysimError(f"measure: {SHOWN.repr(call)} is no function of a colony")
        period = inf if every is None else real("measure: every", every, SHORTEST, LONGEST)
        measure = _Measure(name, call, period, now)
        if name in self._saved:
            count, before = self._saved[name]
            if period != before:
                how = "at the end of each episode" if before == inf else f"every {before:g} s"
                raise ColonysimError(f"measure: {name!r} was measured {how} when the colony was saved, now the same")
            measure.count = count
            del self._saved[name]
        self._all.append(measure)
        self._set_due()

    def begin(self) -> None:
        """A new episode begins."""
        self._saved.clear()
        for measure in self._all:
            measure.count = 1
        self._set_due()

    def take(self, colony: Colony, episode: int, now: float, *, ended: bool) -> Iterator[Measurement]:
        """Takes the values that are due by now, at the end of an episode all of them.

        Raises:
            PluginError: One is no number.
        """
        for measure in self._all:
            if ended or measure.due <= now:
                yield Measurement(episode, now, measure.name, _number(measure.name, measure.call(colony)))
                measure.count += 1
        self._set_due()

    @property
    def names(self) -> list[str]:
        """What is measured."""
        return sorted(measure.name for measure in self._all)

    def state(self) -> State:
        """How many values of each there are in the episode, and seconds from one to the next."""
        now = self._saved | {measure.name: (measure.count, measure.every) for measure in self._all}
        return {name: {"count": count, "every": every} for name, (count, every) in now.items()}

    def restore(self, state: State) -> None:
        """Takes over the counts, for measures of the same names that are added later."""
        told = Stored(state, "measures")
        each = {name: told.part(name) for name in state}
        self._saved = {name: (part.whole("count", 1), part.real("every", 0.0)) for name, part in each.items()}

    def _set_due(self) -> None:
        self.due = min((measure.due for measure in self._all), default=inf)


def _number(name: str, value: object) -> float:
    # NumPy's numbers are such numbers too, its truth values are none.
    if isinstance(value, Real) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            pass
    raise PluginError(f"measurement {name!r} is {SHOWN.repr(value)}, expected a number")
