"""Paired differences between settings: those of single seeds, their mean with its interval, and that over all."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.lines import Line2D

from colonysim.plots.arrangement import short, word
from colonysim.plots.canvas import INK, QUIET, pens, plain
from colonysim.plots.settings import LABELS
from colonysim.sweep.comparing import Difference, Pooled, pooled

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from colonysim.plots.canvas import Pen
    from colonysim.plots.sheet import Sheet

__all__ = ["differences_figure"]

_MOST_ROWS = 60
"""Rows of a figure; where there were more, only those over all settings are drawn."""
_SPREAD = 0.5
"""Part of a row over which the points of its seeds are spread, so that all are seen."""


def differences_figure(found: Sequence[Difference], measures: Sequence[str], sheet: Sheet, title: str) -> Figure:
    """A row for each setting of each value that is compared, then one over all settings (a diamond).

    Args:
        found: What `compare` found.
        measures: A diagram each.
        sheet: What is drawn on.
        title: Of the figure.
    """
    rows = _rows(found)
    others = list(dict.fromkeys(word(each.other) for each in found))
    ways = dict(zip(others, pens(len(others)), strict=True))
    across = sheet.beside(len(measures))
    figure = sheet.figure(1.6 + 2.8 * across[1], 1.0 + across[0] * (0.5 + 0.25 * len(rows)), title)
    if sheet.width is not None:  # rows need their height however narrow the figure is
        figure.set_size_inches(sheet.width, 0.35 + across[0] * (0.5 + 0.19 * max(len(rows), 2)))
    panels = [*figure.subplots(*across, squeeze=False, sharey=True).flat]
    reference = f"{short(found[0].by)} {word(found[0].reference)}"
    for axes, measure in zip(panels, measures, strict=True):
        axes.axvline(0, color=INK, linewidth=0.8, linestyle="dotted", zorder=1)
        for y, row in enumerate(rows.values()):
            _row(axes, y, row[measure], ways[word(row[measure].other)])
        against = f"{others[0]} less {word(found[0].reference)}" if len(others) == 1 else f"less that of {reference}"
        plain(axes, f"{LABELS[measure]}, {against}", "")
        axes.set_yticks(range(len(rows)), list(rows))
        axes.set_ylim(len(rows) - 0.4, -0.6)
        if (axes is panels[0] or across[1] == 1) and len(rows) > len(others):
            axes.set_ylabel(short(", ".join(short(name) for name in found[0].where), 60), fontsize=8)
    pooled_too = any(isinstance(row[measures[0]], Pooled) for row in rows.values())
    sheet.legend(figure, _legend(found, pooled_too))
    return figure


def _rows(found: Sequence[Difference]) -> dict[str, Mapping[str, Difference | Pooled]]:
    """What each row shows, by its label: for each measure a difference, or one over all settings."""
    rows: dict[str, dict[str, Difference | Pooled]] = {}
    over_all = pooled(found)
    several = len({repr(each.other) for each in found}) > 1
    single = {(repr(each.other), repr(each.where)) for each in found}
    for total in over_all:
        head = word(total.other)
        own = [each for each in found if repr(each.other) == repr(total.other) and each.measure == total.measure]
        for each in own if len(single) <= _MOST_ROWS else ():
            settings = ", ".join(word(value) for value in each.where.values())
            label = short(f"{head}: {settings}" if several and settings else settings or head, 30)
            rows.setdefault(label, {})[each.measure] = each
        if total.settings > 1:
            rows.setdefault(f"{head}: over all" if several else "over all", {})[total.measure] = total
    return rows  # type: ignore[return-value]


def _row(axes: Axes, y: int, each: Difference | Pooled, pen: Pen) -> None:
    if isinstance(each, Difference):
        values, last = list(each.by_seed.values()), max(len(each.by_seed) - 1, 1)
        heights = [y + (_SPREAD * (i / last - 0.5) if len(values) > 1 else 0.0) for i in range(len(values))]
        axes.plot(values, heights, ".", color=QUIET, markersize=4, zorder=2)
    low, high = each.interval or (each.difference, each.difference)
    reach = [[max(0.0, each.difference - low)], [max(0.0, high - each.difference)]]
    mark, color, size = (pen.mark, pen.color, 4.5) if isinstance(each, Difference) else ("D", INK, 6)
    axes.errorbar(
        [each.difference], [y], xerr=reach, color=color, marker=mark, markersize=size, elinewidth=1.1, capsize=2,
        linestyle="none", zorder=3,
    )  # fmt: skip


def _legend(found: Sequence[Difference], pooled_too: bool) -> list[Line2D]:
    handles = [
        Line2D([], [], linestyle="", marker=".", color=QUIET, markersize=6, label="one seed"),
        Line2D([], [], marker="o", color=pens(1)[0].color, markersize=4.5, linewidth=1.1, label="mean, 95 % interval"),
    ]
    if all(each.interval is None for each in found):
        handles[1] = Line2D([], [], linestyle="", marker="o", color=pens(1)[0].color, markersize=4.5, label="mean")
    if pooled_too:
        handles.append(Line2D([], [], marker="D", color=INK, markersize=6, linewidth=1.1, label="over all settings"))
    return handles
