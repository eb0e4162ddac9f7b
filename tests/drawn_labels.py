"""Where the words of a figure are."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text


def check_labels(figure: Any, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Draws a figure and checks that its words lie within it and that no two overlap."""
    drawn: list[tuple[str, Any]] = []
    draw_text = Text.draw

    def note(text: Text, renderer: Any, *rest: Any, **options: Any) -> None:
        draw_text(text, renderer, *rest, **options)
        if text.get_visible() and text.get_text().strip():
            drawn.append((text.get_text(), text.get_window_extent(renderer)))

    with monkeypatch.context() as patched:
        patched.setattr(Text, "draw", note)
        FigureCanvasAgg(figure).draw()
    assert len(drawn) > 3
    for text, box in drawn:
        assert figure.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1, (name, text)
        assert figure.bbox.y0 <= box.y0 and box.y1 <= figure.bbox.y1, (name, text)
    for (one, first), (other, second) in combinations(drawn, 2):
        assert not first.overlaps(second), (name, one, other)
