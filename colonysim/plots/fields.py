"""Pheromone fields at the end of episodes: a panel an episode, all on one scale."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import matplotlib
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from colonysim.plots.ends import EpisodeEnds
from colonysim.plots.paper import BOX, FIELD, HOLE, INK, MapLayout, heading_of, ink_on, panels
from colonysim.plots.sheet import SCREEN, EmptyFigureError
from colonysim.trace.schema import Frame

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.figure import Figure

    from colonysim.plots.sheet import Sheet
    from colonysim.trace.reader import Run

__all__ = ["box_figure", "hole_figure", "node_figure"]

_TITLES = {
    "D": "Distance pheromone D", "E": "Exploration pheromone E", "H": "Hole pheromone H", "B": "Box pheromone B",
}  # fmt: skip
_LARGEST = 1e300
"""Colours differ up to this value: what is larger, matplotlib could not take one from the other."""
_LABELS = {"D": "D [graph units]", "E": "E [visits]", "B": "{}({}) [graph units]"}


# Each figure takes how the run's episodes ended if there is more than one, so that each is followed once.


def node_figure(
    run: Run, name: str, episodes: Sequence[int], sheet: Sheet = SCREEN, ends: EpisodeEnds | None = None
) -> Figure:
    """A field with one value per node, such as D and E.

    Raises:
        EmptyFigureError: No node has a value in these episodes; so for the other fields.
    """
    values = [{frame.node: frame.value for frame in _frames(run, name, episode)} for episode in episodes]
    title = _TITLES.get(name, f"Pheromone {name}")
    return _figure(run, episodes, values, title, _LABELS.get(name, name), sheet, ends)


def hole_figure(
    run: Run, name: str, hole: int, episodes: Sequence[int], sheet: Sheet = SCREEN, ends: EpisodeEnds | None = None
) -> Figure:
    """A field with a value per node and hole, such as H: that of one hole, on every node that carries any."""
    values = [{f.node: f.value for f in _frames(run, name, episode, key=hole)} for episode in episodes]
    title = f"{_TITLES.get(name, f'Pheromone {name}')} of the hole at node {hole}"
    return _figure(run, episodes, values, title, f"{name}({hole})", sheet, ends, mark=hole)


def box_figure(
    run: Run, name: str, box: int, episodes: Sequence[int], sheet: Sheet = SCREEN, ends: EpisodeEnds | None = None
) -> Figure:
    """A field of boxes, such as B: that of one box, on each hole that the box could be meant for."""
    start = run.scenario.topology.ids[run.scenario.boxes[box].node]
    # A field with one value for a box is shown where the box stands at first.
    values = [
        {start if f.key < 0 else f.key: f.value for f in _frames(run, name, episode, node=box)} for episode in episodes
    ]
    about = f"of box {box} (starts on node {start}), on the holes it could fill"
    title = f"{_TITLES.get(name, f'Pheromone {name}')} {about}"
    label = _LABELS.get(name, "{}({})").format(name, box)
    return _figure(run, episodes, values, title, label, sheet, ends, box_at=start, shape="s")


def _frames(run: Run, name: str, episode: int, **where: int) -> list[Frame]:
    """The values of a field at an episode's end that can be drawn: a field may well say infinity.

    Args:
        run: The run.
        name: Of the field.
        episode: Which.
        where: Values of other columns, "node" or "key": only these rows.
    """
    import pyarrow.compute as pc

    frames: list[Frame] = []
    for rows in run.only([episode]).batches("frames"):
        for column, value in {"field": name, **where}.items():
            rows = rows.filter(pc.equal(rows[column], value))
        columns = [rows[column].to_pylist() for column in Frame._fields]
        frames += map(Frame._make, zip(*columns, strict=True))
    return [frame for frame in frames if math.isfinite(frame.value)]


def _figure(
    run: Run,
    episodes: Sequence[int],
    values: Sequence[Mapping[int, float]],
    title: str,
    label: str,
    sheet: Sheet,
    ends: EpisodeEnds | None,
    *,
    mark: int | None = None,
    box_at: int | None = None,
    shape: str = "o",
) -> Figure:
    if not any(values):
        raise EmptyFigureError("no value in these episodes" if len(episodes) > 1 else "no value in this episode")
    layout = MapLayout.of(run.scenario, sheet, len(episodes), bar=True)
    ends = ends or EpisodeEnds(run)
    kept = [{node: max(-_LARGEST, min(_LARGEST, value)) for node, value in found.items()} for found in values]
    everything = [value for found in kept for value in found.values()]
    low, high = min(everything, default=0.0), max(everything, default=1.0)
    # B may be the same everywhere: then the scale starts at 0.
    scale = (low if high > low else min(0.0, low), high if high > 0 or high > low else 1.0)
    norm = Normalize(*scale)
    colours = matplotlib.colormaps[FIELD]
    heading = heading_of(title, run)
    figure, axes = panels(
        layout, len(episodes), heading, scale=ScalarMappable(norm, FIELD), label=label,
        legend=layout.legend_of_landmarks(),
    )  # fmt: skip
    for axis, episode, found, coloured in zip(axes, episodes, values, kept, strict=True):
        layout.edges(axis)
        layout.nodes(axis, [node for node in layout.graph if node not in found], "white", edge="#8A8A8A")
        there = ends.of(episode)
        layout.landmarks(axis, there.boxes.values(), [there.goal])
        if box_at is not None:
            layout.nodes(axis, [box_at], "none", shape="s", size=1.25, edge=BOX)
            layout.note(axis, box_at, "start", BOX, (1, 1))
        if mark is not None:
            layout.nodes(axis, [mark], "none", shape="s", size=1.4, edge=HOLE, line=2.4)
        layout.nodes(axis, list(found), list(coloured.values()), scale=scale, shape=shape)
        inks = dict.fromkeys(layout.graph, INK)
        for node, value in found.items():
            inks[node] = ink_on(colours(norm(coloured[node])))
            if shape == "s":
                layout.note(axis, node, f"{value:.3g}", INK, (0, -1))
        layout.numbers(axis, inks)
        layout.frame(axis, f"end of episode {episode}")
    return figure
