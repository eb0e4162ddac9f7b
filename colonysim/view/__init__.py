"""A run as one HTML page to watch, made from its directory alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from colonysim.files import replace_file

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.trace.reader import Run

__all__ = ["write_page"]


def write_page(run: Run, out: str | Path | None = None, episodes: Sequence[int] | None = None) -> Path:
    """Writes the replay page of a run and returns its path.

    Args:
        run: The run.
        out: The file to write; by default `view.html` in the run directory.
        episodes: Which episodes; None for all that are complete.

    Raises:
        TraceError: The run kept no trace, or has no such episode.
        ColonysimError: The file cannot be written.
    """
    from colonysim.view.content import gather
    from colonysim.view.page import page

    text = page(gather(run, episodes))
    if out is None:
        assert run.path is not None  # or its tables could not have been read
        out = run.path / "view.html"
    path = Path(out)
    replace_file(path, text)
    return path
