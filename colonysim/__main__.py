"""`python -m colonysim` is the same as `colonysim`."""

from __future__ import annotations

import os

try:
    import atexit
    import signal
    import time

    from colonysim.errors import Stopped
except KeyboardInterrupt:
    os._exit(130)

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import FrameType

__all__ = ["main"]

_PATIENCE = 3.0
"""Seconds that a command has to end in order; whoever asks again in that time changes nothing."""


def main() -> None:
    """The entry point of the `colonysim` command.

    SIGTERM and SIGHUP (the terminal is closed) end a command as Ctrl-C does, with exit code 128 + the signal's number;
    not where they are ignored, as under `nohup`.
    """
    stops = _Stops()
    from colonysim.cli import main as command

    stops.orderly = True
    try:
        command()
    finally:
        stops.orderly = False


class _Stops:
    """Answers the signals that ask for an end.

    Attributes:
        orderly: Whether by `Stopped`, so that what is under way is brought to an end; else at
            once. While the interpreter is set up or taken down, nothing is lost by that, and an exception would be
            told as a traceback.
    """

    def __init__(self) -> None:
        self.orderly = False
        self._asked = -_PATIENCE
        self._numbers = []
        for name in ("SIGINT", "SIGTERM", "SIGHUP"):
            number = getattr(signal, name, None)  # Windows has not all of them
            if number and signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
                signal.signal(number, self._stop)
                self._numbers.append(number)
        # Registered first, called last: what is left then takes an instant, but Python leaves the signals to the
        # system for it, and the exit code would be another.
        atexit.register(self._ignore)

    def _stop(self, number: int, frame: FrameType | None) -> None:
        if not self.orderly:
            os._exit(128 + number)
        now = time.monotonic()
        if now - self._asked >= _PATIENCE:
            self._asked = now
            stopped = Stopped()
            stopped.exit_code = 128 + number
            raise stopped

    def _ignore(self) -> None:
        for number in self._numbers:
            signal.signal(number, signal.SIG_IGN)


if __name__ == "__main__":
    main()
