"""Steps and success by episode."""

from __future__ import annotations

from statistics import fmean
from typing import TYPE_CHECKING

from matplotlib.ticker import MaxNLocator

from colonysim.intervals import student
from colonysim.plots.paper import AGENT, BOX, INK, plain, title_of
from colonysim.plots.sheet import SCREEN

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from colonysim.plots.sheet import Sheet
    from colonysim.scenario.groups import Group
    from colonysim.trace.groups import GroupResult
    from colonysim.trace.reader import Run
    from colonysim.trace.schema import EpisodeResult

__all__ = ["results_figure", "running_interval"]

WINDOW = 5


def running_interval(values: Sequence[float], window: int = WINDOW) -> list[tuple[float, float, float]]:
    """Mean and its 95 % interval over up to `window` values around each (Student's t)."""
    found = []
    for i in range(len(values)):
        begin = max(0, min(i - window // 2, len(values) - window))
        part = values[begin : begin + window]
        mean = fmean(part)
        low, high = student(part) if len(part) > 1 else (mean, mean)
        found.append((mean, low, high))
    return found


def results_figure(run: Run, group: Group | None = None, sheet: Sheet = SCREEN) -> Figure:
    """Steps until all agents, or those of a group, are at the goal, and the share that is there, by episode."""
    results: Sequence[EpisodeResult | GroupResult] = run.episodes
    if group is not None:
        results = [result for result in run.groups if result.group == group.name]
    numbers = [result.episode for result in results]
    figure = sheet.figure(7.0, 5.4, title_of("Steps and success", run, group))
    above, below = figure.subplots(2, 1, sharex=True)
    most = run.scenario.max_steps
    rows = (
        (above, [float(result.steps) for result in results], "steps", BOX, float(most)),
        (below, [result.success for result in results], "success", AGENT, 1.0),
    )
    for axes, values, label, color, top in rows:
        means, lows, highs = zip(*running_interval(values), strict=True)
        axes.fill_between(
            numbers, [max(low, 0.0) for low in lows], [min(high, top) for high in highs], color=color, alpha=0.2,
            linewidth=0, label=f"its 95 % interval (t, n = {min(WINDOW, len(values))})",
        )  # fmt: skip
        axes.plot(numbers, means, color=color, linewidth=1.6, label=f"mean of {min(WINDOW, len(values))} episodes")
        axes.plot(numbers, values, ".", color=INK, markersize=5, label="episode")
        plain(axes, "episode" if axes is below else "", label)
        axes.set_ylim(0, 1.05 * top)
    above.axhline(most, color=INK, linewidth=0.8, linestyle="dotted", label="most steps allowed")
    below.set_xlim(numbers[0] - 0.5, numbers[-1] + 0.5)
    below.xaxis.set_major_locator(MaxNLocator(integer=True))
    sheet.legend(figure, above.get_legend_handles_labels()[0])
    return figure
