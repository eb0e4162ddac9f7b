"""Profiles of a fit: how far each point is from what it should explain, by one parameter at a time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from colonysim.plots.paper import INK, QUIET

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["profiles_figure"]

_COLOURS = ("#E69F00", "#009E73", "#56B4E9", "#CC79A7")
_BINS = 8


def profiles_figure(
    groups: Mapping[str, Sequence[tuple[Mapping[str, float], float]]], names: Sequence[str], measure: str, limit: float
) -> Figure:
    """Points by each parameter, with the least of each eighth of its range joined by a line: the profile.

    Args:
        groups: By label, points: values by name, and what was measured.
        names: Of the parameters, one panel each.
        measure: What the vertical axis shows.
        limit: A value to mark.
    """
    columns = min(3, len(names))
    rows = -(-len(names) // columns)
    figure = Figure(figsize=(3.5 * columns, 0.5 + 2.8 * rows), layout="constrained")
    grid = figure.subplots(rows, columns, sharey=True, squeeze=False)
    for axes, name in zip(grid.flat, names, strict=False):
        for colour, (label, points) in zip(_COLOURS, groups.items(), strict=False):
            values, heights = [point[name] for point, _ in points], [height for _, height in points]
            axes.plot(values, heights, ".", color=colour, markersize=2.5, alpha=0.5)
            axes.plot(*_profile(values, heights), color=colour, linewidth=1.4, label=label)
        axes.axhline(limit, color=INK, linewidth=0.8, linestyle="dotted")
        axes.set_xlabel(name, fontsize=8)
        axes.tick_params(labelsize=8)
        axes.grid(color=QUIET, linewidth=0.4, alpha=0.6)
        for side in ("top", "right"):
            axes.spines[side].set_visible(False)
    for axes in grid.flat[len(names) :]:
        axes.set_visible(False)
    for row in grid:
        row[0].set_ylabel(measure, fontsize=8)
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    return figure


def _profile(values: Sequence[float], heights: Sequence[float]) -> tuple[list[float], list[float]]:
    """For each part of the range the lowest point."""
    low, width = min(values), (max(values) - min(values)) or 1.0
    least: dict[int, tuple[float, float]] = {}
    for value, height in zip(values, heights, strict=True):
        part = min(_BINS - 1, int(_BINS * (value - low) / width))
        least[part] = min(least.get(part, (height, value)), (height, value))
    chosen = sorted((value, height) for height, value in least.values())
    return [value for value, _ in chosen], [height for _, height in chosen]
