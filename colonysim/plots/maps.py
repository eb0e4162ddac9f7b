"""The map of a scenario: boxes, holes, agents, and the edges that nobody can pass."""

from __future__ import annotations

import math
from collections import defaultdict
from typing import TYPE_CHECKING

from matplotlib.lines import Line2D

from colonysim.plots.paper import (
    AGENT,
    AGENTS,
    BLOCKED,
    BOX,
    GOAL,
    HOLE,
    INK,
    QUIET,
    MapLayout,
    heading_of,
    panels,
)  # fmt: skip
from colonysim.plots.sheet import SCREEN
from colonysim.trace.replay import blocked_edges, follow, with_boxes

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from colonysim.plots.sheet import Sheet
    from colonysim.trace.reader import Run

__all__ = ["draw_place", "map_figure"]


def map_figure(run: Run, episode: int, sheet: Sheet = SCREEN) -> Figure:
    """The map at the start of an episode and at its end."""
    scenario = run.scenario
    layout = MapLayout.of(scenario, sheet, 2)
    ways = follow(scenario, run.events(episode))
    figure, (first, last) = panels(layout, 2, heading_of("Map", run), legend=_legend(layout))
    for axis, at, title in ((first, 0, "start of each episode"), (last, -1, f"end of episode {episode}")):
        if at:
            boxes, goal = ways.boxes_at_end(), with_boxes(scenario, {}, ways.changed).goal
            agents = {agent: way[-1] for agent, way in ways.agents.items() if agent not in ways.gone}
            draw_place(layout, axis, boxes, agents, ways.changed, goal)
        else:
            ids = scenario.topology.ids
            boxes = {box: ids[start.node] for box, start in enumerate(scenario.boxes_at_start)}
            draw_place(layout, axis, boxes, {agent: ids[at] for agent, at in enumerate(scenario.agents_at_start)})
        layout.frame(axis, title)
    return figure


def draw_place(
    layout: MapLayout,
    axes: Axes,
    boxes: dict[int, int],
    agents: dict[int, int],
    changed: Sequence[int] = (),
    goal: int | None = None,
) -> None:
    """Draws the place with its boxes and agents on their nodes.

    Args:
        layout: The place.
        axes: Where to draw.
        boxes: The node number of each box.
        agents: That of each agent.
        changed: Changes of the timeline that have happened, as for `with_boxes`.
        goal: Index of the goal; the scenario's own if None.
    """
    scenario = layout.scenario
    ids = scenario.topology.ids
    holes = {ids[hole.node]: hole for hole in scenario.holes}
    layout.edges(axes)
    _slashes(layout, axes, blocked_edges(scenario, boxes, changed))
    layout.nodes(axes, sorted(set(boxes.values())), BOX, shape="s", size=1.4)
    first: dict[int, int] = {}
    for agent, node in sorted(agents.items()):
        first.setdefault(node, agent % len(AGENTS))
    for number, color in enumerate(AGENTS):
        layout.nodes(axes, [node for node, mine in first.items() if mine == number], color, size=1.4)
    layout.nodes(axes, [ids[scenario.goal if goal is None else goal]], GOAL, shape="D", size=1.3)
    layout.nodes(axes, [node for node in layout.graph if node not in holes], "white")
    layout.nodes(axes, list(holes), HOLE, shape="s")
    layout.numbers(axes, {node: "white" if node in holes else INK for node in layout.graph})
    for things, letter, color, corner in ((boxes, "b", BOX, (1, 1)), (agents, "a", INK, (-1, -1))):
        standing: dict[int, list[int]] = defaultdict(list)
        for thing, node in things.items():
            standing[node].append(thing)
        for node, there in standing.items():
            layout.note(axes, node, letter + ",".join(map(str, sorted(there))), color, corner)


def _slashes(layout: MapLayout, axes: Axes, edges: list[tuple[int, int]]) -> None:
    """A short red stroke across the middle of each edge."""
    half = 0.16 * layout.scenario.topology.mean_length
    for i, j in edges:
        (x0, y0), (x1, y1) = layout.at[i], layout.at[j]
        # 60 degrees to the edge, so that it reads as a slash and not as a crossing edge.
        angle = math.atan2(y1 - y0, x1 - x0) + math.pi / 3
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        dx, dy = half * math.cos(angle), half * math.sin(angle)
        axes.plot([x - dx, x + dx], [y - dy, y + dy], color=BLOCKED, linewidth=1.6, solid_capstyle="round", zorder=2)


def _legend(layout: MapLayout) -> list[Line2D]:
    """What the map of this scenario can hold, and nothing else."""

    def mark(shape: str, color: str, label: str) -> Line2D:
        return Line2D([], [], linestyle="", marker=shape, color=color, markeredgecolor=INK, label=label)

    scenario, count = layout.scenario, len(layout.scenario.agents)
    several = 1 < count <= len(AGENTS)
    handles = [mark("o", AGENTS[i], f"agent {i}") for i in range(count)] if several else [mark("o", AGENT, "agent (a)")]
    if scenario.boxes:
        handles.append(mark("s", BOX, "box (b)"))
    if scenario.holes:
        handles.append(mark("s", HOLE, "hole"))
    handles += [mark("D", GOAL, "goal"), Line2D([], [], color=BLOCKED, linewidth=1.6, label="blocked edge")]
    if any(layout.graph.edges[edge]["rise"] for edge in layout.graph.edges):
        handles.append(Line2D([], [], color=QUIET, linestyle="dashed", label="slope"))
    return handles
