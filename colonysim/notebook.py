"""Whether this is a notebook, and a progress bar below its cells."""

from __future__ import annotations

import html
import sys
from typing import Any

__all__ = ["NotebookBar", "in_notebook"]


def in_notebook() -> bool:
    """Whether this runs in the kernel of a notebook (Jupyter, VS Code, Colab), which shows HTML below a cell."""
    # A notebook has imported IPython; nobody else should wait for it.
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(shell, "kernel", None) is not None


class NotebookBar:
    """A bar with a line of text below the cell that is executed, which takes the place of itself when it moves."""

    def __init__(self) -> None:
        self._shown: Any = None

    @property
    def shown(self) -> bool:
        """Whether it is there."""
        return self._shown is not None

    def show(self, title: str, share: float, text: str) -> None:
        """Shows the bar.

        Args:
            title: What goes on.
            share: How much of it is done, 0 to 1.
            text: Stands behind the bar.
        """
        import IPython.display

        display: Any = IPython.display.display
        bar = f'<progress value="{share:.4f}" max="1" style="vertical-align: middle; width: 16em"></progress>'
        plain = f"{title}: {share:.0%}, {text}"
        data = {"text/html": f"{html.escape(title)} {bar} {share:.0%}, {html.escape(text)}", "text/plain": plain}
        if self._shown is None:
            self._shown = display(data, raw=True, display_id=True)
        else:
            self._shown.update(data, raw=True)
