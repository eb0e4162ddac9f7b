"""Paired differences between settings: those of single seeds, their mean with its interval, and that over all."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING

from matplotlib.lines import Line2D

from colonysim.plots.arrangement import short, word
from colonysim.plots.paper import INK, QUIET, pens, plain
from colonysim.sweep.comparing import Difference, Pooled, pooled

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from colonysim.plots.paper import Pen
    from colonysim.plots.sheet import Sheet

__all__ = ["differences_figure"]

_MOST_ROWS = 60
"""Rows of a figure; where there were more, only those over all settings are drawn."""
_SPREAD = 0.5
"""Part of a row over which the points of its seeds are spread, so that all are seen."""
_LETTERS = 14
"""Letters that an inch holds."""


def differences_figure(found: Sequence[Difference], measures: Sequence[str], sheet: Sheet, title: str) -> Figure:
    """A row for each setting of each value that is compared, then one over all settings (a diamond).

    Args:
        found: What `compare` found.
        measures: A diagram each.
        sheet: What is drawn on.
        title: Of the figure.
    """
    rows = _rows(found)
    others = list({repr(each.other): word(each.other) for each in found}.items())
    ways = {key: pen for (key, _), pen in zip(others, pens(len(others)), strict=True)}
    across = sheet.beside(len(measures))
    figure = sheet.figure(1.6 + 2.8 * across[1], 1.0 + across[0] * (0.5 + 0.25 * len(rows)), title)
    if sheet.width is not None:  # rows need their height however narrow the figure is
        figure.set_size_inches(sheet.width, 0.35 + across[0] * (0.5 + 0.19 * max(len(rows), 2)))
    panels = [*figure.subplots(*across, squeeze=False, sharey=True).flat]
    named, reference = short(found[0].by, 18), word(found[0].reference)
    against = f"{named} {others[0][1]} less {reference}" if len(others) == 1 else f"less that of {named} {reference}"
    for axes, measure in zip(panels, measures, strict=True):
        axes.axvline(0, color=INK, linewidth=0.8, linestyle="dotted", zorder=1)
        for y, (_, row) in enumerate(rows):
            _row(axes, y, row[measure], ways[repr(row[measure].other)])
        plain(axes, fill(f"{measure}, {against}", 26 if sheet.narrow else 36), "")
        axes.set_yticks(range(len(rows)), [label for label, _ in rows])
        axes.set_ylim(len(rows) - 0.4, -0.6)
    if len(rows) > len(others):
        names = short(", ".join(short(name) for name in found[0].where), 60)
        figure.supylabel(fill(names, int(_LETTERS * figure.get_size_inches()[1])), fontsize=8)
    pooled_too = any(isinstance(row[measures[0]], Pooled) for _, row in rows)
    sheet.legend(figure, _legend(found, pooled_too))
    return figure


def _rows(found: Sequence[Difference]) -> list[tuple[str, dict[str, Difference | Pooled]]]:
    """The label of each row and what it shows: for each measure a difference, or one over all settings."""
    groups: dict[str, dict[str, dict[str, Difference | Pooled]]] = {}
    for each in found:
        groups.setdefault(repr(each.other), {}).setdefault(repr(each.where), {})[each.measure] = each
    for total in pooled(found):
        if total.settings > 1:
            groups[repr(total.other)].setdefault("", {})[total.measure] = total
    several, many = len(groups) > 1, sum(map(len, groups.values())) > _MOST_ROWS
    rows = []
    for group in groups.values():
        for row in group.values():
            shown = next(iter(row.values()))
            if isinstance(shown, Pooled):
                rows.append((f"{word(shown.other)}: over all" if several else "over all", row))
            elif not many or len(group) == 1:
                settings = ", ".join(word(value) for value in shown.where.values())
                label = f"{word(shown.other)}: {settings}" if several and settings else settings or word(shown.other)
                rows.append((short(label, 30), row))
    return rows


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
