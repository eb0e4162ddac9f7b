"""The map of a scenario: boxes, holes, agents, and the edges that nobody can pass."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import TYPE_CHECKING

from matplotlib.lines import Line2D

from colonysim.plots.canvas import AGENT, AGENT_INK, BLOCKED, BOX, GOAL, HOLE, INK, QUIET, Canvas, heading_of, panels
from colonysim.trace.replay import blocked_edges, follow, with_boxes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from colonysim.trace.reader import Run

__all__ = ["draw_place", "map_figure"]


def map_figure(run: Run, episode: int) -> Figure:
    """The map at the start of an episode and at its end."""
    scenario = run.scenario
    canvas = Canvas.of(scenario)
    ways = follow(scenario, run.events(episode))
    figure, (first, last) = panels(canvas, 2, heading_of("Map", run), legend=True)
    for axis, at, title in ((first, 0, "start of each episode"), (last, -1, f"end of episode {episode}")):
        if at:
            boxes, goal = ways.boxes_at_end(), with_boxes(scenario, {}, ways.changed).goal
            agents = {agent: way[-1] for agent, way in ways.agents.items() if agent not in ways.gone}
            draw_place(canvas, axis, boxes, agents, ways.changed, goal)
        else:
            ids = scenario.topology.ids
            boxes = {box: ids[start.node] for box, start in enumerate(scenario.boxes_at_start)}
            draw_place(canvas, axis, boxes, {agent: ids[at] for agent, at in enumerate(scenario.agents_at_start)})
        canvas.frame(axis, title)
    figure.legend(handles=_legend(), loc="lower center", ncols=6, fontsize=7, frameon=False)
    return figure


def draw_place(
    canvas: Canvas,
    axes: Axes,
    boxes: dict[int, int],
    agents: dict[int, int],
    changed: Sequence[int] = (),
    goal: int | None = None,
) -> None:
    """Draws the place with its boxes and agents on their nodes.

    Args:
        canvas: The place.
        axes: Where to draw.
        boxes: The node number of each box.
        agents: That of each agent.
        changed: Changes of the timeline that have happened, as for `with_boxes`.
        goal: Index of the goal; the scenario's own if None.
    """
    scenario = canvas.scenario
    ids = scenario.topology.ids
    holes = {ids[hole.node]: hole for hole in scenario.holes}
    canvas.edges(axes)
    _slashes(canvas, axes, blocked_edges(scenario, boxes, changed))
    canvas.nodes(axes, sorted(set(boxes.values())), BOX, shape="s", size=1.4)
    canvas.nodes(axes, sorted(set(agents.values())), AGENT, size=1.4)
    canvas.nodes(axes, [ids[scenario.goal if goal is None else goal]], GOAL, shape="D", size=1.3)
    canvas.nodes(axes, [node for node in canvas.graph if node not in holes], "white")
    canvas.nodes(axes, list(holes), HOLE, shape="s")
    canvas.numbers(axes, {node: "white" if node in holes else INK for node in canvas.graph})
    for things, letter, color, corner in ((boxes, "b", BOX, (1, 1)), (agents, "a", AGENT_INK, (-1, -1))):
        standing: dict[int, list[int]] = defaultdict(list)
        for thing, node in things.items():
            standing[node].append(thing)
        for node, there in standing.items():
            canvas.note(axes, node, letter + ",".join(map(str, sorted(there))), color, corner)


def _slashes(canvas: Canvas, axes: Axes, edges: list[tuple[int, int]]) -> None:
    """A short red stroke across the middle of each edge."""
    half = 0.16 * canvas.scenario.topology.mean_length
    for i, j in edges:
        (x0, y0), (x1, y1) = canvas.at[i], canvas.at[j]
        # 60 degrees to the edge, so that it reads as a slash and not as a crossing edge.
        angle = math.atan2(y1 - y0, x1 - x0) + math.pi / 3
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        dx, dy = half * math.cos(angle), half * math.sin(angle)
        axes.plot([x - dx, x + dx], [y - dy, y + dy], color=BLOCKED, linewidth=1.6, solid_capstyle="round", zorder=2)


def _legend() -> list[Line2D]:
    def mark(shape: str, color: str, label: str) -> Line2D:
        return Line2D([], [], linestyle="", marker=shape, color=color, markeredgecolor=INK, label=label)

    return [
        mark("o", AGENT, "agent (a)"),
        mark("s", BOX, "box (b)"),
        mark("s", HOLE, "hole"),
        mark("D", GOAL, "goal"),
        Line2D([], [], color=BLOCKED, linewidth=1.6, label="blocked edge"),
        Line2D([], [], color=QUIET, linestyle="dashed", label="slope"),
    ]
