"""A run as one HTML page to watch, made from its directory alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from colonysim.files import replace_file

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from colonysim.trace.reader import Run
    from colonysim.view.extent import Room

__all__ = ["page_of", "write_page"]


def write_page(
    run: Run,
    out: str | Path | None = None,
    episodes: Sequence[int] | None = None,
    tell: Callable[[str], None] | None = None,
    progress: Callable[[float], None] | None = None,
    room: Room | None = None,
) -> Path:
    """Writes the replay page of a run and returns its path.

    Args:
        run: The run.
        out: The file to write; by default `view.html` in the run directory.
        episodes: Which episodes; None for all that are complete, or the last of them if all would make a page of
            more than 20 MB; of a last one that is larger alone, without its pheromones or decisions.
        tell: Is told, before the page is made, what it leaves out or that it will be a large one.
        progress: Is told the share of the work that is done.
        room: How large the page may be, if not as large as said here.

    Raises:
        TraceError: The run kept no trace, has no such episode, the page would be larger than 100 MB, or `out` is part
            of the run.
        ColonysimError: The file cannot be written.
    """
    if out is not None:
        run.check_apart(out)
    text = page_of(run, episodes, tell or (lambda message: None), progress, room)
    if out is None:
        assert run.path is not None  # or its tables could not have been read
        out = run.path / "view.html"
    path = Path(out)
    replace_file(path, text)
    return path


def page_of(
    run: Run,
    episodes: Sequence[int] | None,
    tell: Callable[[str], None],
    progress: Callable[[float], None] | None,
    room: Room | None,
) -> str:
    """The same page as text; arguments and errors as for `write_page`."""
    from colonysim.view.content import gather
    from colonysim.view.extent import choose_extent
    from colonysim.view.page import page

    extent = choose_extent(run, episodes, tell, room)
    return page(gather(run, extent.episodes, without=extent.without, progress=progress))
