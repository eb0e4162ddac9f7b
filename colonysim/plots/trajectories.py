"""The ways of agents and boxes through an episode."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import TYPE_CHECKING

from matplotlib.lines import Line2D

from colonysim.plots.canvas import AGENT, BOX, GOAL, HOLE, INK, Canvas, panels, title_of
from colonysim.trace.replay import follow, places

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from colonysim.trace.reader import Run

__all__ = ["trajectories_figure"]

Way = list[tuple[float, float]]
_FURTHEST = 1e12
"""Graph units; what is further away is outside a panel in any case."""
_LINES = ("solid", "dashed", "dashdot", "dotted")


def trajectories_figure(run: Run, episodes: Sequence[int]) -> Figure:
    """A panel an episode; as driven if the run holds poses, else from node to node."""
    canvas = Canvas.of(run.scenario)
    figure, axes = panels(canvas, len(episodes), title_of("Trajectories", run), legend=True)
    results = {result.episode: result for result in run.episodes}
    for axis, episode in zip(axes, episodes, strict=True):
        _place(canvas, axis, {place.goal for place in places(run.scenario, run.events(episode))})
        driven = _driven(run, episode)
        agents, boxes = driven or _node_to_node(run, canvas, episode)
        first_box = len(run.scenario.agents)
        for ways, color, width, first in ((boxes, BOX, 2.4, first_box), (agents, AGENT, 1.3, 0)):
            for number, way in ways.items():
                aside = _side(canvas, first + number) if driven else (0.0, 0.0)
                _draw(axis, way, color, width, _LINES[number % len(_LINES)], aside)
        result = results[episode]
        canvas.frame(axis, f"episode {episode}: {result.steps} steps, success {result.success:.2f}")
    figure.legend(handles=_legend(), loc="lower center", ncols=6, fontsize=7, frameon=False)
    return figure


def _place(canvas: Canvas, axes: Axes, goals: set[int]) -> None:
    scenario = canvas.scenario
    ids = scenario.topology.ids
    holes = [ids[hole.node] for hole in scenario.holes]
    canvas.edges(axes)
    canvas.nodes(axes, [node for node in canvas.graph if node not in holes], "white", edge="#9A9A9A")
    canvas.nodes(axes, holes, HOLE, shape="s")
    canvas.nodes(axes, [ids[goal] for goal in sorted(goals)], "none", shape="D", size=1.35, edge=GOAL)
    canvas.numbers(axes, {node: "white" if node in holes else INK for node in canvas.graph})


def _node_to_node(run: Run, canvas: Canvas, episode: int) -> tuple[dict[int, Way], dict[int, Way]]:
    """The ways along the edges, each passing its nodes on another side, so that none hides another."""
    ways = follow(run.scenario, run.events(episode))
    shifted: list[dict[int, Way]] = [{}, {}]
    for place, paths in enumerate((ways.agents, ways.boxes)):
        for thing, nodes in paths.items():
            dx, dy = _side(canvas, thing + place * len(ways.agents))
            if len(nodes) > 1:
                shifted[place][thing] = [(canvas.at[node][0] + dx, canvas.at[node][1] + dy) for node in nodes]
    return shifted[0], shifted[1]


def _side(canvas: Canvas, thing: int) -> tuple[float, float]:
    """Which way a thing is moved aside at a node: just outside it, so that its number stays legible."""
    many = len(canvas.scenario.agents) + len(canvas.scenario.boxes)
    angle = 2 * math.pi * thing / many + 0.4
    radius = 0.66 * canvas.dot * canvas.unit
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


def _draw(axes: Axes, way: Way, color: str, width: float, style: str, aside: tuple[float, float]) -> None:
    xs, ys = zip(*way, strict=True)
    axes.plot(xs, ys, color=color, linewidth=width, linestyle=style, alpha=0.85, solid_joinstyle="round", zorder=2)
    for (x, y), marker, size in ((way[0], "o", 4), (way[-1], "X", 6)):
        axes.plot(
            x + aside[0], y + aside[1], marker, color=color, markersize=size, markeredgecolor="white",
            markeredgewidth=0.6, zorder=6,
        )  # fmt: skip


def _legend() -> list[Line2D]:
    return [
        Line2D([], [], color=AGENT, linewidth=1.3, label="agent"),
        Line2D([], [], color=BOX, linewidth=2.4, label="box"),
        Line2D([], [], linestyle="", marker="o", color=INK, markersize=4, label="start"),
        Line2D([], [], linestyle="", marker="X", color=INK, markersize=6, label="end"),
        Line2D([], [], linestyle="", marker="s", color=HOLE, label="hole"),
        Line2D([], [], linestyle="", marker="D", color="white", markeredgecolor=GOAL, label="goal"),
    ]
