"""Curves of many runs: the mean over seeds with its interval, a panel a parameter."""

from __future__ import annotations

from statistics import fmean
from typing import TYPE_CHECKING

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from colonysim.intervals import of_mean
from colonysim.plots.paper import INK, QUIET

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes

__all__ = ["curves_figure"]

_COLOURS = ("#E69F00", "#009E73", "#56B4E9", "#CC79A7")


def curves_figure(
    panels: Mapping[str, Mapping[str, Sequence[Sequence[float]]]], title: str, measure: str, window: int = 10
) -> Figure:
    """A measure by episode as a moving average, a panel a parameter and a curve a value of it.

    Args:
        panels: Title, then label of a value, then for each seed the measure of each episode.
        title: Of the figure.
        measure: What the vertical axis shows.
        window: Episodes of the moving average: those up to the one at which it is drawn, at first fewer.
    """
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(3.5 * columns, 0.5 + 2.6 * rows), layout="constrained")
    figure.suptitle(title, fontsize=11, color=INK)
    grid = figure.subplots(rows, columns, sharey=True, squeeze=False)
    for axes, (name, curves) in zip(grid.flat, panels.items(), strict=False):
        for colour, (label, seeds) in zip(_COLOURS, curves.items(), strict=False):
            _curve(axes, [_smooth(seed, window) for seed in seeds], label, colour)
        axes.set_title(name, fontsize=9)
        axes.tick_params(labelsize=8)
        axes.grid(color=QUIET, linewidth=0.4, alpha=0.6)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
        axes.legend(fontsize=7, frameon=False)
    for axes in grid.flat[len(panels) :]:
        axes.set_visible(False)
    for row in grid:
        row[0].set_ylabel(measure, fontsize=8)
    grid[-1][0].set_xlabel("episode", fontsize=8)
    return figure


def _curve(axes: Axes, seeds: Sequence[Sequence[float]], label: str, colour: str) -> None:
    by_episode = list(zip(*seeds, strict=False))
    episodes = range(1, len(by_episode) + 1)
    means = [fmean(values) for values in by_episode]
    intervals = [of_mean(values, 400) or (mean, mean) for values, mean in zip(by_episode, means, strict=True)]
    lows, highs = zip(*intervals, strict=True)
    axes.fill_between(episodes, lows, highs, color=colour, alpha=0.2, linewidth=0)
    axes.plot(episodes, means, color=colour, linewidth=1.5, label=label)


def _smooth(values: Sequence[float], window: int) -> list[float]:
    return [fmean(values[max(0, end - window) : end]) for end in range(1, len(values) + 1)]
