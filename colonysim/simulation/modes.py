"""Whether agents act in their own time or all at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.errors import ColonysimError
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from colonysim.scenario.scenario import Scenario

__all__ = ["MODES", "mode_of"]

MODES = ("asynchronous", "synchronous")


def mode_of(scenario: Scenario, mode: str | None) -> str:
    """The mode that is asked for, or the scenario's own.

    Raises:
        ColonysimError: There is no such mode.
    """
    chosen = scenario.mode if mode is None else mode
    if chosen not in MODES:
        raise ColonysimError(f"no mode {chosen!r}; {nearest(str(chosen), MODES)}")
    return chosen
