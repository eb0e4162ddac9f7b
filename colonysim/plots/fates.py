"""Where each box ended, and how often."""

from __future__ import annotations

import math
from collections import Counter
from typing import TYPE_CHECKING

import matplotlib
from matplotlib.ticker import MaxNLocator

from colonysim.plots.paper import BLOCKED, FIELD, INK, ink_on, title_of
from colonysim.plots.sheet import SCREEN, EmptyFigureError
from colonysim.trace.replay import follow

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from colonysim.plots.sheet import Sheet
    from colonysim.trace.reader import Run

__all__ = ["fates_figure"]

_MOST_UPRIGHT = 7
"""Places up to which their names stand side by side in a column of print."""
_MOST_NUMBERS = 30
"""Boxes or places up to which there is room for their names and for numbers."""


def fates_figure(run: Run, sheet: Sheet = SCREEN) -> Figure:
    """A row a box and a column a place: the number of episodes at whose end the box was there.

    Raises:
        EmptyFigureError: There are no boxes.
    """
    scenario = run.scenario
    if not scenario.boxes:
        raise EmptyFigureError("the scenario has no boxes")
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
    height = 1.9 + (3.5 if many else 0.42 * max(boxes, 2))
    figure = sheet.figure(width, height, title_of("Where boxes end", run))
    axes = figure.subplots()
    episodes = len(run.episodes)
    counts = [[ends[box, place] for place in range(len(places))] for box in range(boxes)]
    shown = [[count or math.nan for count in row] for row in counts]  # never is no colour at all
    image = axes.imshow(shown, cmap=FIELD, vmin=0, vmax=episodes, aspect="auto")
    bar = figure.colorbar(image, ax=axes, ticks=MaxNLocator(integer=True, nbins=5))
    bar.set_label("episodes", fontsize=8)
    bar.ax.tick_params(labelsize=7)
    axes.set_xlabel("place at the end of the episode", fontsize=8)
    axes.set_ylabel("box (start)", fontsize=8)
    axes.set_title(f"{episodes} episodes", fontsize=9, color=INK)
    axes.tick_params(labelsize=8, length=0)
    if many:
        axes.axvline(len(holes) - 0.5, color=BLOCKED, linewidth=0.8)
        return figure
    axes.set_xticks(range(len(places)), [place.replace(" ", "\n") for place in places])
    if sheet.narrow and len(places) > _MOST_UPRIGHT:
        axes.set_xticks(range(len(places)), places, rotation=90)
    axes.set_yticks(range(boxes), [f"{box} ({ids[scenario.boxes[box].node]})" for box in range(boxes)])
    colours = matplotlib.colormaps[FIELD]
    for (box, place), count in ends.items():
        ink = ink_on(colours(count / episodes))
        axes.text(place, box, str(count), ha="center", va="center", fontsize=8, color=ink)
    return figure
