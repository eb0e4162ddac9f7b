"""Figures as a notebook shows them."""

from __future__ import annotations

import base64
import io
from typing import Any

from matplotlib.figure import Figure

__all__ = ["Figures"]

_DPI = 90
"""Pixels an inch in a notebook, where wide figures are made to fit."""


class Figures(tuple[Figure, ...]):
    """Figures of a run: a tuple of matplotlib figures, which a notebook shows one below the other.

    Example:
        ```python
        [figure] = run.plot("D")
        figure.savefig("distance.pdf")
        ```
    """

    __slots__ = ()

    def __repr__(self) -> str:
        names = ", ".join(str(each.get_label()) for each in self)
        return f"<{len(self)} figure{'' if len(self) == 1 else 's'}: {names}>"

    def _ipython_display_(self) -> None:
        import IPython.display

        display: Any = IPython.display.display
        for figure in self:
            image = io.BytesIO()
            figure.savefig(image, format="png", dpi=_DPI)
            text = base64.b64encode(image.getvalue()).decode()
            display({"image/png": text, "text/plain": f"<figure {figure.get_label()}>"}, raw=True)
