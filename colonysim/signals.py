"""Signals that ask for an end, held back while code runs that an exception would tear."""

from __future__ import annotations

import signal
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["held"]


@contextmanager
def held() -> Iterator[None]:
    """Holds SIGINT, SIGTERM and SIGHUP back for the block: who sends one is answered at its end.

    Libraries in C++ (PyTorch, while it is imported) end the interpreter with SIGABRT when an exception passes them.
    """
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
