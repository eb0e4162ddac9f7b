"""Figures of many runs: success and steps over their settings, as lines, points or a map of colours."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import matplotlib
from matplotlib.colors import Normalize
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter

from colonysim.plots.arrangement import labels, number_of, point, short, value_of, word
from colonysim.plots.paper import FIELD, ink_on, pens, plain
from colonysim.plots.sheet import EmptyFigureError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from colonysim.plots.arrangement import Arrangement, Point
    from colonysim.plots.sheet import Sheet
    from colonysim.sweep.played import Played

__all__ = ["heatmap_figure", "means_figure"]

_SPREAD = 0.72
"""Part of the room of a value that the points of several lines share."""
_MOST_LEVEL, _MOST_SLANTED, _MOST_UPRIGHT = 24, 10, 60
"""Characters of all names that stand side by side, and values whose names stand slanted, and upright."""
_MOST_CELLS = 12
"""Values of a parameter up to which each cell of a map of colours tells its mean."""
_MOST_MAPS = 6


def means_figure(
    played: Sequence[Played], arrangement: Arrangement, measures: Sequence[str], episodes: tuple[int, int] | None,
    sheet: Sheet, title: str,
) -> Figure:  # fmt: skip
    """The mean of each measure with its 95 % interval over seeds, along a parameter and by line.

    Raises:
        EmptyFigureError: Nothing varies along an axis.
    """
    if arrangement.x is None:
        besides = ", ".join(("their seeds", *map(short, arrangement.by)))
        raise EmptyFigureError(f"the runs differ in nothing but {besides}")
    lines = arrangement.lines(played)
    along = {line: _points(arrangement, group, measures, episodes) for line, group in lines.items()}
    ways = pens(len(along))
    places = list(arrangement.along(played))
    figure = sheet.figure(5.6, 1.2 + 2.5 * len(measures), title)
    panels = [*figure.subplots(len(measures), 1, sharex=True, squeeze=False).flat]
    for axes, measure in zip(panels, measures, strict=True):
        for i, (points, label) in enumerate(zip(along.values(), labels(along), strict=True)):
            xs = [_place(arrangement, places, value, i, len(along)) for value in points]
            shown = [each[measure] for each in points.values()]
            joined = arrangement.numeric and not arrangement.averaged
            axes.errorbar(
                xs, [each.mean for each in shown], yerr=[*zip(*(each.reach for each in shown), strict=True)],
                color=ways[i].color, linestyle=ways[i].dash if joined else "none", marker=ways[i].mark, markersize=4,
                linewidth=1.3, elinewidth=0.9, capsize=2, label=label, zorder=3,
            )  # fmt: skip
        plain(axes, "", measure)
        _limits(axes, measure, [each[measure] for points in along.values() for each in points.values()])
    panels[-1].set_xlabel(short(arrangement.x, 40), fontsize=8)
    if arrangement.numeric:
        _scaled(panels[-1], [float(value) for value in places])
    else:
        _named(panels[-1], labels((value,) for value in places))
    if arrangement.by:
        handles = panels[0].get_legend_handles_labels()[0]
        sheet.legend(figure, handles, ", ".join(short(name) for name in arrangement.by))
    return figure


def _points(
    arrangement: Arrangement, group: Sequence[Played], measures: Sequence[str], episodes: tuple[int, int] | None
) -> dict[Any, dict[str, Point]]:
    """For each value along the axis each measure over the runs that have it."""
    found = {}
    for value, runs in arrangement.along(group).items():
        means = [means for each in runs if (means := each.means(episodes))]
        if means:
            found[value] = {measure: point([each[measure] for each in means], measure) for measure in measures}
    return found


def _place(arrangement: Arrangement, places: Sequence[Any], value: Any, line: int, lines: int) -> float:
    """Where a value stands on the axis; at one that is no number the points of several lines stand side by side."""
    if arrangement.numeric:
        return float(value)
    return places.index(value) + (_SPREAD * (line - (lines - 1) / 2) / lines if lines > 1 else 0.0)


def _limits(axes: Axes, measure: str, points: Sequence[Point]) -> None:
    if measure == "success":
        axes.set_ylim(-0.04, 1.04)
    else:
        axes.set_ylim(0, 1.06 * max([each.mean + each.reach[1] for each in points if each.count] or [1.0]) or 1.0)


def _scaled(axes: Axes, values: Sequence[float]) -> None:
    """A logarithmic axis where numbers go over two powers of ten; with few values a tick at each."""
    low, high = min(values), max(values)
    logarithmic = low > 0 and high / low >= 100 and len(values) > 2
    if logarithmic:
        axes.set_xscale("log")
        axes.xaxis.set_minor_formatter(NullFormatter())
    apart = [b / a > 1.6 if logarithmic else b - a > 0.08 * (high - low) for a, b in pairwise(values)]
    if len(values) <= 8 and all(apart):
        axes.set_xticks(values)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.6g}"))
    if low == high:
        axes.set_xlim(low - 0.5, high + 0.5)


def _named(axes: Axes, names: Sequence[str]) -> None:
    """Names below the axis, turned where they would run into each other."""
    axes.set_xlim(-0.6, len(names) - 0.4)
    level = sum(map(len, names)) <= 2 * _MOST_LEVEL and len(names) <= _MOST_SLANTED
    if len(names) > _MOST_UPRIGHT:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True, nbins=_MOST_SLANTED))
        axes.xaxis.set_major_formatter(
            FuncFormatter(lambda at, _: names[int(at)] if at == int(at) and 0 <= at < len(names) else "")
        )
    else:
        axes.set_xticks(range(len(names)), names)
    if level:
        return
    turned = 90 if len(names) > _MOST_SLANTED else 30
    for label in axes.get_xticklabels():
        label.set(rotation=turned, ha="right", rotation_mode="anchor", va="center" if turned == 90 else "top")
    if len(names) > 2 * _MOST_SLANTED:
        axes.tick_params(axis="x", labelsize=6)


def heatmap_figure(
    played: Sequence[Played], arrangement: Arrangement, measures: Sequence[str], episodes: tuple[int, int] | None,
    sheet: Sheet, title: str,
) -> Figure:  # fmt: skip
    """The mean of each measure by two parameters that are numbers: a map of colours, or points where they are no grid.

    Raises:
        EmptyFigureError: There are no two such parameters.
    """
    numbers = [name for name in (*arrangement.by, *arrangement.averaged) if _is_number(played, name)]
    if not arrangement.numeric or not numbers:
        raise EmptyFigureError("no two parameters vary that are numbers")
    x, y = str(arrangement.x), numbers[0]
    others = [name for name in arrangement.by if name != y]
    groups: dict[tuple[Any, ...], list[Played]] = {}
    for each in played:
        groups.setdefault(tuple(value_of(each, name) for name in others), []).append(each)
    if len(groups) > _MOST_MAPS:
        raise EmptyFigureError(f"{len(groups)} maps of colours, expected at most {_MOST_MAPS}; choose with --by")
    cells = {key: _cells(group, x, y, measures, episodes) for key, group in groups.items()}
    figure = sheet.figure(0.6 + 3.4 * len(measures), 1.4 + 2.4 * len(cells), title)
    grid = figure.subplots(len(cells), len(measures), squeeze=False, sharex=True, sharey=True)
    for column, measure in enumerate(measures):
        values = [cell[measure] for found in cells.values() for cell in found.values()]
        low, high = min(values), max(values)
        norm = Normalize(low, high if high > low else low + 1.0)
        for row, (key, found) in enumerate(cells.items()):
            image = _map(grid[row][column], {at: cell[measure] for at, cell in found.items()}, norm, measure, sheet)
            if key and column == 0:
                grid[row][0].set_title(", ".join(word(value) for value in key), fontsize=9)
        bar = figure.colorbar(image, ax=list(grid[:, column]), location="top", pad=0.02, aspect=25)
        bar.set_label(f"{measure}, mean over seeds", fontsize=8)
        bar.locator = MaxNLocator(nbins=4)
        bar.update_ticks()
        bar.ax.tick_params(labelsize=7)
        grid[-1][column].set_xlabel(short(x, 34), fontsize=8)
    for row in range(len(cells)):
        grid[row][0].set_ylabel(short(y, 34), fontsize=8)
    return figure


def _is_number(played: Sequence[Played], name: str) -> bool:
    values = [number_of(each.about.get(name)) for each in played]
    return None not in values and len(set(values)) > 1


def _cells(
    played: Sequence[Played], x: str, y: str, measures: Sequence[str], episodes: tuple[int, int] | None
) -> dict[tuple[float, float], dict[str, float]]:
    groups: dict[tuple[float, float], list[dict[str, float]]] = {}
    for each in played:
        if means := each.means(episodes):
            groups.setdefault((float(value_of(each, x)), float(value_of(each, y))), []).append(means)
    return {
        at: {measure: point([means[measure] for means in group], measure, 1).mean for measure in measures}
        for at, group in groups.items()
    }


def _map(axes: Axes, cells: Mapping[tuple[float, float], float], norm: Normalize, measure: str, sheet: Sheet) -> Any:
    xs, ys = (sorted({at[i] for at in cells}) for i in (0, 1))
    axes.tick_params(labelsize=7)
    if 2 * len(cells) < len(xs) * len(ys):  # drawn at random, no grid
        across, up = zip(*cells, strict=True)
        return axes.scatter(across, up, c=[*cells.values()], norm=norm, cmap=FIELD, s=28, edgecolors="none")
    rows = [[cells.get((x, y), math.nan) for x in xs] for y in ys]
    image = axes.imshow(rows, origin="lower", cmap=FIELD, norm=norm, aspect="auto")
    for axis, values in ((axes.xaxis, xs), (axes.yaxis, ys)):
        every = max(1, -(-len(values) // 8))
        axis.set_ticks(range(0, len(values), every), [f"{value:.4g}" for value in values[::every]])
    if len(xs) <= _MOST_CELLS // (2 if sheet.narrow else 1) and len(ys) <= _MOST_CELLS:
        for (x, y), value in cells.items():
            axes.text(
                xs.index(x), ys.index(y), f"{value:.2f}" if measure == "success" else f"{value:.1f}", ha="center",
                va="center", fontsize=6.5, color=ink_on(matplotlib.colormaps[FIELD](norm(value))),
            )  # fmt: skip
    return image
