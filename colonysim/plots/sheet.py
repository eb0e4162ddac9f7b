"""What figures are drawn on: a screen, or a column of a paper. matplotlib is imported when something is drawn."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from colonysim.arguments import real, shown
from colonysim.errors import ColonysimError
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Sequence
    from contextlib import AbstractContextManager

    from matplotlib.figure import Figure

__all__ = ["INK", "SCREEN", "STYLES", "EmptyFigureError", "Sheet", "Style", "sheet_of"]

Style = Literal["screen", "paper"]
STYLES: tuple[Style, ...] = ("screen", "paper")
INK = "#222222"
_UNITS = {"in": 1.0, "cm": 1 / 2.54, "mm": 1 / 25.4, "pt": 1 / 72.27}
"""Inches of each unit of length; points are those of TeX, as `\\the\\columnwidth` prints them."""
_COLUMN = 3.4
"""Width of a column of a two-column journal, inches."""
_WIDTHS = (2.0, 40.0)
_NARROW = 5.0
"""Inches below which panels stand one below the other."""
_SMALL = 7.0
"""Font size of legends, points."""
_LINE = 0.16
"""Height of a row of a legend, inches."""
_LETTER = 0.55
"""Mean width of a letter, font sizes."""


class EmptyFigureError(ColonysimError):
    """A figure that would be empty; the message says what is not there."""


@dataclass(frozen=True, slots=True)
class Sheet:
    """How large a figure is, and whether it has a title and the thin lines of print.

    Attributes:
        width: Inches, for print; None for a screen, where each figure is as large as suits it.
    """

    width: float | None = None

    @property
    def narrow(self) -> bool:
        """Whether there is no room for two diagrams beside each other."""
        return self.width is not None and self.width < _NARROW

    def drawing(self) -> AbstractContextManager[None]:
        """The settings of matplotlib under which a figure is made and written."""
        import matplotlib

        # A name with two dollar signs is a name, no formula.
        if self.width is None:
            return matplotlib.rc_context({"text.parse_math": False})
        # Letters stay letters, in fonts that publishers take (type 42), not the outlines of type 3.
        return matplotlib.rc_context({"text.parse_math": False, "pdf.fonttype": 42, "svg.fonttype": "none"})

    def beside(self, count: int) -> tuple[int, int]:
        """Rows and columns of diagrams that stand beside each other where there is room."""
        return (count, 1) if self.narrow else (1, count)

    def figure(self, width: float, height: float, title: str) -> Figure:
        """An empty figure whose parts matplotlib places.

        Args:
            width: On a screen, inches.
            height: On a screen, inches; in print less, as the figure is narrower.
            title: Left out in print, where there is a caption.
        """
        from matplotlib.figure import Figure

        if self.width is None:
            figure = Figure(figsize=(width, height), layout="constrained")
            figure.suptitle(title, fontsize=11, color=INK)
            return figure
        return Figure(figsize=(self.width, height * min(1.0, math.sqrt(self.width / width))), layout="constrained")

    def columns_of(self, labels: Sequence[str], width: float) -> int:
        """How many columns a legend has that is so many inches wide."""
        each = max((len(label) for label in labels), default=1) * _LETTER * _SMALL + 35
        return max(1, min(len(labels), int(72 * width / each)))

    def legend(self, figure: Figure, handles: Sequence[Any], title: str = "") -> None:
        """Puts a legend below all diagrams of a figure of `figure`, which grows by its rows.

        Handles of the same label stand there once.
        """
        unique = {str(handle.get_label()): handle for handle in reversed(handles)}
        if unique:
            labels = [*unique][::-1]
            width, height = figure.get_size_inches()
            columns = self.columns_of(labels, width)
            figure.set_size_inches(width, height + _LINE * (math.ceil(len(labels) / columns) - 1))
            figure.legend(
                handles=[unique[label] for label in labels], loc="outside lower center", fontsize=_SMALL,
                ncols=columns, frameon=False, title=title or None, title_fontsize=_SMALL,
            )  # fmt: skip

    def finish(self, figure: Figure) -> Figure:
        """Gives a figure the letters and lines of print, if that is what it is for."""
        if self.width is None:
            return figure
        import numpy as np
        from matplotlib.collections import Collection
        from matplotlib.lines import Line2D
        from matplotlib.text import Text

        for text in figure.findobj(Text):
            text.set_fontsize(_printed(float(text.get_fontsize())))
        for line in figure.findobj(Line2D):
            line.set_linewidth(0.7 * line.get_linewidth())
            line.set_markersize(0.75 * line.get_markersize())
        for marks in figure.findobj(Collection):
            marks.set_linewidth((0.7 * np.asarray(marks.get_linewidth())).tolist())
        for axes in figure.axes:
            for axis in (axes.xaxis, axes.yaxis):
                size = axis.get_tick_params().get("labelsize", 8)
                axis.set_tick_params(
                    labelsize=_printed(size if isinstance(size, (int, float)) else 8.0), width=0.5, length=2.0,
                    grid_linewidth=0.3,
                )  # fmt: skip
            for spine in axes.spines.values():
                spine.set_linewidth(0.5)
        return figure


SCREEN = Sheet()


def sheet_of(style: str, width: str | float | None) -> Sheet:
    """The sheet that is asked for.

    Args:
        style: One of `STYLES`.
        width: Of print: such as "3.4in", "86mm", "8.6cm" or "246pt" (of TeX, 72.27 an inch), or inches; None for
            that of a column, 3.4 inches.

    Raises:
        ColonysimError: There is no such style, or this is no width.
    """
    if style not in STYLES:
        raise ColonysimError(f"no style {shown(style)}; {nearest(str(style), STYLES)}")
    if style == "screen":
        if width is not None:
            raise ColonysimError("width: only with the style paper; on a screen each figure is as wide as suits it")
        return SCREEN
    return Sheet(_COLUMN if width is None else _inches(width))


def _inches(width: str | float) -> float:
    if not isinstance(width, str):
        return real("width", width, *_WIDTHS)
    match = re.fullmatch(r"\s*([0-9]{1,5}(?:\.[0-9]{0,5})?)\s*(in|cm|mm|pt)\s*", width, re.ASCII)
    inches = float(match[1]) * _UNITS[match[2]] if match else 0.0
    if not _WIDTHS[0] <= inches <= _WIDTHS[1]:
        least, most = _WIDTHS
        raise ColonysimError(
            f"width: {shown(width)}, expected {least:g} to {most:g} inches, such as 3.4in, 86mm, 8.6cm or 246pt"
        )
    return inches


def _printed(size: float) -> float:
    """Letters of 8 points and more are one smaller in print; none is larger than 8."""
    return size if size < 8.0 else min(size - 1.0, 8.0)
