"""What to install when an optional part is missing."""

from __future__ import annotations

import sys
from importlib.util import find_spec

from colonysim.errors import MissingExtraError

__all__ = ["need", "need_bullet"]


def need(package: str, extra: str, purpose: str) -> None:
    """Checks that an optional package is installed.

    Raises:
        MissingExtraError: It is not; the message holds the command that installs it.
    """
    if find_spec(package) is None:
        raise MissingExtraError(f"{purpose} needs {package}, which is not installed: pip install 'colonysim[{extra}]'")


def need_bullet() -> None:
    """Checks that PyBullet is there.

    Raises:
        MissingExtraError: It is not, perhaps because it has no wheel for this Python.
    """
    if find_spec("pybullet") is not None:
        return
    reason = "the backend 'bullet' needs PyBullet, which is not installed"
    if sys.version_info < (3, 12):
        raise MissingExtraError(f"{reason}: pip install 'colonysim[bullet]'")
    running = f"{sys.version_info.major}.{sys.version_info.minor}"
    raise MissingExtraError(
        f"{reason}; it publishes wheels up to CPython 3.11 only and this is Python {running}. With Python 3.11: "
        "python3.11 -m venv .venv && .venv/bin/pip install 'colonysim[bullet]'"
    )
