"""The ways of agents and boxes through an episode."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import TYPE_CHECKING

from matplotlib.lines import Line2D

from colonysim.plots.paper import AGENTS, BOX, GOAL, HOLE, INK, MapLayout, Pen, panels, pens, title_of
from colonysim.plots.sheet import SCREEN, EmptyFigureError
from colonysim.trace.replay import follow, places

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from colonysim.plots.sheet import Sheet
    from colonysim.trace.reader import Run

__all__ = ["trajectories_figure"]

Way = list[tuple[float, float]]
_FURTHEST = 1e12
"""Graph units; what is further away is outside a panel in any case."""
_MOST_NAMED = 8
"""Agents up to which the legend names each."""


def trajectories_figure(run: Run, episodes: Sequence[int], sheet: Sheet = SCREEN) -> Figure:
    """A panel an episode; as driven if the run holds poses, else from node to node.

    Raises:
        EmptyFigureError: Nothing moved in these episodes.
    """
    scenario = run.scenario
    layout = MapLayout.of(scenario, sheet, len(episodes))
    found = [(episode, _driven(run, episode)) for episode in episodes]
    moved = [(driven is not None, driven or _node_to_node(run, layout, episode)) for episode, driven in found]
    if not any(agents or boxes for _, (agents, boxes) in moved):
        raise EmptyFigureError("nothing moved in these episodes")
    several = pens(len(scenario.agents), AGENTS), pens(len(scenario.boxes), (BOX,))
    figure, axes = panels(layout, len(episodes), title_of("Trajectories", run), legend=_legend(layout, several[0]))
    results = {result.episode: result for result in run.episodes}
    for axis, episode, (driven, (agents, boxes)) in zip(axes, episodes, moved, strict=True):
        _place(layout, axis, {place.goal for place in places(scenario, run.events(episode))})
        first_box = len(scenario.agents)
        for ways, pen, width, first in ((boxes, several[1], 2.4, first_box), (agents, several[0], 1.3, 0)):
            for number, way in ways.items():
                aside = _side(layout, first + number) if driven else (0.0, 0.0)
                _draw(axis, way, pen[number], width, aside)
        result = results[episode]
        layout.frame(axis, f"episode {episode}: {result.steps} steps, success {result.success:.2f}")
    return figure


def _place(layout: MapLayout, axes: Axes, goals: set[int]) -> None:
    scenario = layout.scenario
    ids = scenario.topology.ids
    holes = [ids[hole.node] for hole in scenario.holes]
    layout.edges(axes)
    layout.nodes(axes, [node for node in layout.graph if node not in holes], "white", edge="#9A9A9A")
    layout.nodes(axes, holes, HOLE, shape="s")
    layout.landmarks(axes, [ids[start.node] for start in scenario.boxes_at_start], [ids[goal] for goal in goals])
    layout.numbers(axes, {node: "white" if node in holes else INK for node in layout.graph})


def _node_to_node(run: Run, layout: MapLayout, episode: int) -> tuple[dict[int, Way], dict[int, Way]]:
    """The ways along the edges, each passing its nodes on another side, so that none hides another."""
    ways = follow(run.scenario, run.events(episode))
    shifted: list[dict[int, Way]] = [{}, {}]
    for place, paths in enumerate((ways.agents, ways.boxes)):
        for thing, nodes in paths.items():
            dx, dy = _side(layout, thing + place * len(ways.agents))
            if len(nodes) > 1:
                shifted[place][thing] = [(layout.at[node][0] + dx, layout.at[node][1] + dy) for node in nodes]
    return shifted[0], shifted[1]


def _side(layout: MapLayout, thing: int) -> tuple[float, float]:
    """Which way a thing is moved aside at a node: just outside it, so that its number stays legible."""
    many = len(layout.scenario.agents) + len(layout.scenario.boxes)
    angle = 2 * math.pi * thing / many + 0.4
    radius = 0.66 * layout.dot * layout.unit
    return radius * math.cos(angle), radius * math.sin(angle)


def _driven(run: Run, episode: int) -> tuple[dict[int, Way], dict[int, Way]] | None:
    """The poses of an episode in graph units, or None if the run has none at all."""
    poses = None if run.missing("poses") else run.table("poses")
    if poses is None or not poses.num_rows:
        return None
    import pyarrow.compute as pc

    from colonysim.geometry.robot_choice import robot_of
    from colonysim.geometry.scale import metres_of

    scale = metres_of(run.scenario, robot_of(run.scenario))
    poses = poses.filter(pc.equal(poses["episode"], episode))
    agents: dict[int, Way] = defaultdict(list)
    boxes: dict[int, Way] = defaultdict(list)
    columns = [poses[name].to_pylist() for name in ("body", "number", "x", "y")]
    for body, number, x, y in zip(*columns, strict=True):
        (boxes if body == "box" else agents)[number].append((_kept(x / scale), _kept(y / scale)))
    return agents, boxes


def _kept(value: float) -> float:
    return max(-_FURTHEST, min(_FURTHEST, value))


def _draw(axes: Axes, way: Way, pen: Pen, width: float, aside: tuple[float, float]) -> None:
    xs, ys = zip(*way, strict=True)
    axes.plot(
        xs, ys, color=pen.color, linewidth=width, linestyle=pen.dash, alpha=0.85, solid_joinstyle="round", zorder=2
    )
    for (x, y), marker, size in ((way[0], "o", 4), (way[-1], "X", 6)):
        axes.plot(
            x + aside[0], y + aside[1], marker, color=pen.color, markersize=size, markeredgecolor="white",
            markeredgewidth=0.6, zorder=6,
        )  # fmt: skip


def _legend(layout: MapLayout, agents: Sequence[Pen]) -> list[Line2D]:
    def line(pen: Pen, width: float, label: str) -> Line2D:
        return Line2D([], [], color=pen.color, linestyle=pen.dash, linewidth=width, label=label)

    named = 1 < len(agents) <= _MOST_NAMED
    shown = agents if named else agents[:1]
    handles = [line(pen, 1.3, f"agent {i}" if named else "agent") for i, pen in enumerate(shown)]
    if layout.scenario.boxes:
        handles += [
            Line2D([], [], color=BOX, linewidth=2.4, label="box"),
            Line2D([], [], linestyle="", marker="s", color="none", markeredgecolor=BOX, label="box at first"),
        ]
    handles += [
        Line2D([], [], linestyle="", marker="o", color=INK, markersize=4, label="start"),
        Line2D([], [], linestyle="", marker="X", color=INK, markersize=6, label="end"),
    ]
    if layout.scenario.holes:
        handles.append(Line2D([], [], linestyle="", marker="s", color=HOLE, label="hole"))
    return [*handles, Line2D([], [], linestyle="", marker="D", color="none", markeredgecolor=GOAL, label="goal")]
