"""Where in somebody else's code an error came from."""

from __future__ import annotations

import sysconfig
import traceback
from pathlib import Path
from typing import TYPE_CHECKING

from colonysim.files import shown_path

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["place_of"]

_INSTALLED = frozenset({"site-packages", "dist-packages"})
_STANDARD = tuple({sysconfig.get_path("stdlib"), sysconfig.get_path("platstdlib")})


def place_of(error: BaseException) -> str:
    """File and line of the innermost frame of the user's code, such as "mine.py:12".

    What is installed is the user's only where nothing else is: then it is the package that was called first. Empty if
    the error comes from no code of others.

    Args:
        error: An error that tells of another one, its cause.
    """
    cause = error.__cause__
    if cause is None:
        return ""
    if isinstance(cause, SyntaxError) and cause.filename is not None:
        return f"{shown_path(cause.filename)}:{cause.lineno}"
    frames = list(_others(cause))
    own = [(file, line) for file, line in frames if not _INSTALLED & set(file.parts)]
    if frames and not own:
        own = [(file, line) for file, line in frames if file.parent == frames[0][0].parent]
    return f"{shown_path(own[-1][0])}:{own[-1][1]}" if own else ""


def _others(error: BaseException) -> Iterator[tuple[Path, int]]:
    """File and line of each frame that is neither ours nor Python's own, the outermost first."""
    for frame, line in traceback.walk_tb(error.__traceback__):
        # A compiled module of ours says no whole path.
        name, file = str(frame.f_globals.get("__name__")), Path(frame.f_code.co_filename)
        if name.partition(".")[0] == "colonysim" or not file.is_absolute():
            continue
        pythons = any(file.is_relative_to(folder) for folder in _STANDARD) and not _INSTALLED & set(file.parts)
        if not pythons:
            yield file, line
