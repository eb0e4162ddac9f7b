"""The replay page of a run from Python: below a cell of a notebook, or in the browser."""

from __future__ import annotations

import html
from dataclasses import dataclass
from typing import TYPE_CHECKING

from colonysim.arguments import whole
from colonysim.errors import ColonysimError, TraceError
from colonysim.files import shown_path
from colonysim.notebook import in_notebook
from colonysim.progress import Bar, shows
from colonysim.terminal import say
from colonysim.view import page_of, write_page
from colonysim.view.extent import MOST, USUAL, Room

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from colonysim.trace.reader import Run

__all__ = ["Page", "show_page"]

_OPTION, _EXAMPLE = "`episodes=`", "`episodes=[{}]`"
INLINE = Room(4e6, 20e6, _OPTION, _EXAMPLE)
"""A page becomes a part of its notebook, which is loaded and saved as a whole."""
_LOWEST, _HIGHEST = 200, 4000
"""Bounds of the height of a page in a notebook, pixels."""


@dataclass(frozen=True, repr=False)
class Page:
    """The replay page of a run; a notebook shows it below the cell.

    Attributes:
        name: Name of the run.
        html: The whole page, which needs nothing else; empty if it was written to a file.
        path: The file that it was written to; None if it was not.
        height: Height in a notebook, pixels.
        notes: What it leaves out.
    """

    name: str
    html: str = ""
    path: Path | None = None
    height: int = 0
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"<Page of {self.name}: {shown_path(self.path) if self.path else f'{len(self.html) / 1e6:.1f} MB'}>"

    def _repr_html_(self) -> str:
        if self.path is not None:
            return f"<p>{html.escape(repr(self)[1:-1])}</p>"
        notes = "".join(f"<p>{html.escape(note)}</p>" for note in self.notes)
        # Of an origin of its own: what a page does, it does to itself alone. Its dialog is a form.
        return (
            f'{notes}<iframe sandbox="allow-scripts allow-forms" srcdoc="{html.escape(self.html)}" '
            f'title="Replay of {html.escape(self.name)}" width="100%" height="{self.height}" '
            'style="border: 1px solid #8884; border-radius: 6px" allowfullscreen></iframe>'
        )


def show_page(
    run: Run,
    episodes: int | Sequence[int] | None = None,
    *,
    out: str | Path | None = None,
    inline: bool | None = None,
    height: int = 640,
) -> Page:
    """As `Run.view`, which says the rest."""
    if inline and out is not None:
        raise ColonysimError(f"inline and out: the page is either shown in the notebook or written to {out}")
    height = whole("height", height, _LOWEST, _HIGHEST)
    chosen = [whole("episodes", episodes)] if isinstance(episodes, int) else episodes
    name = run.path.name if run.path else str(run.manifest["name"])
    with Bar(f"page of {name}", total=1.0, quiet=not shows(None)) as bar:
        if inline or (inline is None and out is None and in_notebook()):
            notes: list[str] = []
            text = page_of(run, chosen, notes.append, bar.move, INLINE)
            if len(text) > INLINE.most:
                raise TraceError(
                    f"{run.path}: the page takes {len(text) / 1e6:.0f} MB, at most {INLINE.most / 1e6:.0f} MB in a "
                    f"notebook; choose fewer with {_OPTION}, or write it to a file with `inline=False`"
                )
            return Page(name, text, height=height, notes=tuple(notes))
        path = write_page(run, out, chosen, say, bar.move, Room(USUAL, MOST, _OPTION, _EXAMPLE))
    import webbrowser

    if not webbrowser.open(path.resolve().as_uri()):
        say(f"no browser here: open {shown_path(path)}")
    return Page(name, path=path)
