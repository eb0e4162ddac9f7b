"""Standard error: lines for people, and whether it can be drawn on."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from colonysim.characters import visible

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["error_console", "on_terminal", "say"]


def error_console() -> Console:
    """A console on standard error, for texts that have passed `visible`; it takes nothing in them for markup."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, markup=False, emoji=False)


def on_terminal() -> bool:
    """Whether standard error can be drawn on: a terminal that moves its cursor, no file, no pipe."""
    return sys.stderr.isatty() and not error_console().is_dumb_terminal


def say(text: str) -> None:
    """A line on standard error."""
    print(visible(text), file=sys.stderr, flush=True)
