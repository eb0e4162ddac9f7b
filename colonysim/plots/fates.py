"""Where each box ended, and how often."""

from __future__ import annotations

import math
from collections import Counter
from typing import TYPE_CHECKING

import matplotlib
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from colonysim.plots.canvas import BLOCKED, FIELD, INK, title_of
from colonysim.trace.replay import follow

if TYPE_CHECKING:
    from colonysim.trace.reader import Run

__all__ = ["fates_figure"]

_MOST_NUMBERS = 30
"""Boxes or places up to which there is room for their names and for numbers."""


def fates_figure(run: Run) -> Figure:
    """A row a box and a column a place: the number of episodes at whose end the box was there."""
    scenario = run.scenario
    ids = scenario.topology.ids
    holes = {ids[hole.node]: column for column, hole in enumerate(scenario.holes)}
    places = [*(f"hole {node}" for node in holes), "its start", "elsewhere"]
    boxes = len(scenario.boxes)
    ends: Counter[tuple[int, int]] = Counter()
    for result in run.episodes:
        for box, at in follow(scenario, run.events(result.episode)).boxes_at_end().items():
            ends[box, holes.get(at, len(holes) + (at != ids[scenario.boxes[box].node]))] += 1
    many = max(boxes, len(places)) > _MOST_NUMBERS
    width = 3.0 + (3.5 if many else max(0.72 * len(places), 4.2))
    figure = Figure(figsize=(width, 1.9 + (3.5 if many else 0.42 * max(boxes, 2))), layout="constrained")
    figure.suptitle(title_of("Where boxes end", run), fontsize=11, color=INK)
    axes = figure.subplots()
    episodes = len(run.episodes)
    counts = [[ends[box, place] for place in range(len(places))] for box in range(boxes)] or [[0] * len(places)]
    shown = [[count or math.nan for count in row] for row in counts]  # never is no colour at all
    image = axes.imshow(shown, cmap=FIELD, vmin=0, vmax=episodes, aspect="auto")
    bar = figure.colorbar(image, ax=axes, ticks=MaxNLocator(integer=True, nbins=5))
    bar.set_label("episodes", fontsize=8)
    bar.ax.tick_params(labelsize=7)
    axes.set_xlabel("place at the end of the episode; holes and starts by node", fontsize=8)
    axes.set_ylabel("box (start)", fontsize=8)
    axes.set_title(f"{episodes} episodes", fontsize=9, color=INK)
    axes.tick_params(labelsize=8, length=0)
    if many:
        axes.axvline(len(holes) - 0.5, color=BLOCKED, linewidth=0.8)
        return figure
    axes.set_xticks(range(len(places)), [place.replace(" ", "\n") for place in places])
    axes.set_yticks(range(boxes), [f"{box} ({ids[scenario.boxes[box].node]})" for box in range(boxes)])
    colours = matplotlib.colormaps[FIELD]
    for (box, place), count in ends.items():
        red, green, blue, _ = colours(count / episodes)
        ink = INK if 0.3 * red + 0.59 * green + 0.11 * blue > 0.5 else "white"
        axes.text(place, box, str(count), ha="center", va="center", fontsize=8, color=ink)
    return figure
