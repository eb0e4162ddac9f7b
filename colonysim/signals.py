"""Signals that ask for an end, held back while code runs that an exception would tear."""

from __future__ import annotations

import signal
import threading
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from types import FrameType

__all__ = ["held"]


@contextmanager
def held() -> Iterator[None]:
    """Holds SIGINT, SIGTERM and SIGHUP back for the block: who sends one is answered at its end.

    Libraries in C++ (PyTorch, while it is imported) end the interpreter with SIGABRT when an exception passes them. The
    handlers are replaced, not the signals blocked: the system would give those to any other thread.
    """
    if threading.current_thread() is not threading.main_thread():  # no handler is called here
        yield
        return
    came: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        came.append(number)

    numbers = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
    # What is ignored stays so, and what was set outside of Python (None) could not be put back.
    before = {number: signal.getsignal(number) for number in numbers}
    before = {number: handler for number, handler in before.items() if handler not in (signal.SIG_IGN, None)}
    for number in before:
        signal.signal(number, note)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if came:
            signal.raise_signal(came[0])
