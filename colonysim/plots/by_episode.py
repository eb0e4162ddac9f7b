"""Success and steps by episode, of many runs: the mean over seeds with its interval, a line for each setting."""

from __future__ import annotations

from statistics import fmean
from textwrap import fill
from typing import TYPE_CHECKING, Any

from matplotlib.ticker import MaxNLocator

from colonysim.plots.arrangement import MOST_LINES, labels, point, short, word
from colonysim.plots.paper import QUIET, pens, plain
from colonysim.plots.sheet import EmptyFigureError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from colonysim.plots.arrangement import Arrangement, Point
    from colonysim.plots.paper import Pen
    from colonysim.plots.sheet import Sheet
    from colonysim.sweep.played import Played

__all__ = ["by_episode_figure", "curves_of"]

_TOGETHER = 7
"""Lines that one diagram holds before each line of the other figures gets one of its own."""
_MOST_ROWS = 12
_MOST_INTERVALS = 100
"""Episodes at which a band is computed; between them it is straight."""
_RESAMPLES = 400
_SINGLE = 20
"""Runs up to which each is drawn below the mean, where there is no other line."""


def by_episode_figure(
    played: Sequence[Played], arrangement: Arrangement, measures: Sequence[str], episodes: tuple[int, int] | None,
    sheet: Sheet, title: str,
) -> Figure:  # fmt: skip
    """The measures by episode; where there are many settings, a row of diagrams for each line of the other figures.

    Where a diagram has more lines than bands can be told apart, there are means only.

    Raises:
        EmptyFigureError: No run has two episodes.
    """
    first, last = episodes or (1, max((each["episode"] for run in played for each in run.episodes), default=0))
    if len({each["episode"] for run in played for each in run.episodes if first <= each["episode"] <= last}) < 2:
        raise EmptyFigureError("no run has two episodes")
    rows, names = _rows(played, arrangement)
    all_lines = list(dict.fromkeys(line for lines in rows.values() for line in lines))
    ways = dict(zip(all_lines, zip(pens(len(all_lines)), labels(all_lines), strict=True), strict=True))
    banded = len(all_lines) <= _TOGETHER
    if len(rows) == 1:
        across = sheet.beside(len(measures))[::-1] if sheet.width is None else sheet.beside(len(measures))
    else:
        across = len(rows), len(measures)
    figure = sheet.figure(0.4 + 3.4 * max(across[1], 1.6), 0.9 + 2.3 * across[0], title)
    grid = figure.subplots(*across, squeeze=False, sharex=True, sharey="col" if len(rows) > 1 else False)
    for i, (row, lines) in enumerate(rows.items()):
        for j, measure in enumerate(measures):
            axes = grid[i][j] if len(rows) > 1 else grid.flat[j]
            alone = len(all_lines) == 1
            for line, group in lines.items():
                _curve(axes, group, measure, (first, last), *ways[line], alone, banded)
            named = fill(", ".join(map(word, row)), 26 if sheet.narrow else 60) if j == 0 else ""
            plain(axes, "", measure if banded else f"{measure}, mean", named)
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
            axes.set_xlim(first - 0.02 * (last - first), last + 0.02 * (last - first))
    for axes in grid[-1]:
        axes.set_xlabel("episode", fontsize=8)
    for axes in grid.flat:  # once all is drawn: diagrams that share an axis share its end
        axes.set_ylim(*((-0.04, 1.04) if axes.get_ylabel().startswith("success") else (0, None)))
    handles = [handle for axes in grid.flat for handle in axes.get_legend_handles_labels()[0]]
    sheet.legend(figure, handles, ", ".join(map(short, names)))
    return figure


def _rows(
    played: Sequence[Played], arrangement: Arrangement
) -> tuple[dict[tuple[Any, ...], dict[tuple[Any, ...], list[Played]]], tuple[str, ...]]:
    """The runs by diagram and line, and the columns that tell the lines apart."""
    lines = arrangement.lines(played)
    if arrangement.x is None:
        return {(): lines}, arrangement.by
    both = {
        (*line, value): runs for line, group in lines.items() for value, runs in arrangement.along(group).items()
    }  # fmt: skip
    values = len({key[-1] for key in both})
    if len(both) <= _TOGETHER or (len(lines) == 1 and values <= MOST_LINES):
        return {(): both}, (*arrangement.by, arrangement.x)
    if len(lines) <= _MOST_ROWS and values <= MOST_LINES:
        rows: dict[tuple[Any, ...], dict[tuple[Any, ...], list[Played]]] = {}
        for (*line, value), runs in both.items():
            rows.setdefault(tuple(line), {})[value,] = runs
        return rows, (arrangement.x,)
    return {(): lines}, arrangement.by


def curves_of(
    played: Sequence[Played], measure: str, span: tuple[int, int], most: int = _MOST_INTERVALS
) -> tuple[dict[int, float], dict[int, Point]]:
    """The mean of a measure over the runs that have an episode, for each; and its interval, for at most so many."""
    values: dict[int, list[float]] = {}
    for run in played:
        for each in run.episodes:
            if span[0] <= each["episode"] <= span[1]:
                values.setdefault(each["episode"], []).append(float(each[measure]))
    numbers = sorted(values)
    every = max(1, -(-len(numbers) // most))
    kept = [number for i, number in enumerate(numbers) if i % every == 0 or i == len(numbers) - 1]
    return {number: fmean(values[number]) for number in numbers}, {
        number: point(values[number], measure, _RESAMPLES) for number in kept
    }


def _curve(
    axes: Axes, played: Sequence[Played], measure: str, span: tuple[int, int], pen: Pen, label: str, alone: bool,
    banded: bool,
) -> None:  # fmt: skip
    means, points = curves_of(played, measure, span, _MOST_INTERVALS if banded else 1)
    if alone and 1 < len(played) <= _SINGLE:
        for run in played:
            kept = [each for each in run.episodes if span[0] <= each["episode"] <= span[1]]
            axes.plot(
                [each["episode"] for each in kept], [each[measure] for each in kept], color=QUIET, linewidth=0.5,
                label="one seed", zorder=1,
            )  # fmt: skip
    known = {number: each.interval for number, each in points.items() if each.interval}
    if banded and known:
        lows, highs = zip(*known.values(), strict=True)
        axes.fill_between(
            list(known), lows, highs, color=pen.color, alpha=0.18, linewidth=0,
            label="its 95 % interval" if alone else None, zorder=2,
        )  # fmt: skip
    axes.plot(
        list(means), list(means.values()), color=pen.color, linestyle=pen.dash, linewidth=1.4, zorder=3,
        label=(f"mean of {len(played)} seeds" if len(played) > 1 else "one seed") if alone else label,
    )  # fmt: skip
