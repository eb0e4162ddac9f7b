"""How a command ends that was told to stop: by Ctrl-C, by `kill`, or because its terminal was closed."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from colonysim.cli.console import say
from colonysim.errors import Anew, Stopped

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path

__all__ = ["go_on", "told_when_stopped"]


def go_on(out: Path) -> str:
    """What to say of work that is taken up again where it was stopped."""
    return f"Interrupted; what has finished is in {out}. Run the same command again to go on."


@contextmanager
def told_when_stopped(words: Callable[[], str]) -> Iterator[None]:
    """Says what has become of the work in the block when it is stopped, and ends the command.

    Args:
        words: What to say, asked for when the work has come to its end.
    """
    try:
        yield
    except Anew:
        raise
    except KeyboardInterrupt as stop:
        say(words())
        raise SystemExit(getattr(stop, "exit_code", Stopped.exit_code)) from None
