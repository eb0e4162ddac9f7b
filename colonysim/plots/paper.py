"""Paper and pens: colours, panels of maps, and the graph that everything is drawn upon."""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import networkx as nx
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from colonysim.plots.sheet import INK
from colonysim.scenario.picture import AGENT, BOX, GOAL, HOLE

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable

    from colonysim.plots.sheet import Sheet
    from colonysim.scenario.groups import Group
    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.reader import Run

__all__ = [
    "AGENT", "AGENTS", "BLOCKED", "BOX", "FIELD", "GOAL", "HOLE", "INK", "QUIET", "MapLayout", "Pen",
    "heading_of", "ink_on", "named_in", "panels", "pens", "plain", "title_of",
]  # fmt: skip

BLOCKED, QUIET = "#D00000", "#BDBDBD"
FIELD = "viridis"
AGENTS = (AGENT, "#E69F00", "#D55E00", "#56B4E9")
"""Colours of single agents: the palette without those of boxes, goal and holes."""
_PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#222222")
_DASHES: tuple[Any, ...] = (
    "solid", (0, (5, 2)), (0, (1.2, 1.6)), (0, (6, 2, 1.2, 2)), (0, (9, 3)), (0, (6, 2, 1.2, 2, 1.2, 2)),
)  # fmt: skip
_MARKS = "os^DvPX"

_PANEL = 4.6
"""Longer side of a panel on a screen, inches."""
_TALLEST = 1.5
"""Height of a panel in print, widths of its column at most."""
_MOST_LABELS = 400
_LONGEST_NAME = 100


@dataclass(frozen=True, slots=True)
class Pen:
    """How one of several things is drawn: a colour, and dash and mark that go on where the colours end."""

    color: str
    dash: Any
    mark: str


def pens(count: int, palette: Sequence[str] = _PALETTE) -> list[Pen]:
    """Pens that can be told apart: first by their colours, then by their dashes, then by their marks."""
    many, dashes = len(palette), len(_DASHES)
    return [
        Pen(palette[i % many], _DASHES[i // many % dashes], _MARKS[(i + i // (many * dashes)) % len(_MARKS)])
        for i in range(count)
    ]  # fmt: skip


def ink_on(color: Sequence[float]) -> str:
    """Dark or white letters, whichever can be read on a colour (red, green, blue, ...; 0 to 1)."""
    red, green, blue = color[:3]
    return INK if 0.3 * red + 0.59 * green + 0.11 * blue > 0.5 else "white"


@dataclass(frozen=True, slots=True)
class MapLayout:
    """A map laid out on paper: how large a panel is, and how large nodes and letters can be in it.

    Attributes:
        scenario: What is drawn.
        graph: The place, keyed by the scenario's node numbers.
        at: Position of each node, graph units.
        width: Width of a panel, inches.
        height: Height of a panel, inches.
        dot: Diameter of a node, points.
        unit: Graph units in a point.
        letter: Font size inside a node, points; 0 if nodes are too small for their number.
        sheet: What it is drawn on.
        columns: Panels in a row.
    """

    scenario: Scenario
    graph: Any
    at: Mapping[int, tuple[float, float]]
    width: float
    height: float
    dot: float
    unit: float
    letter: float
    sheet: Sheet
    columns: int

    @classmethod
    def of(cls, scenario: Scenario, sheet: Sheet, count: int, bar: bool = False) -> MapLayout:
        """Lays a scenario's map out.

        Args:
            scenario: Whose.
            sheet: What it is drawn on.
            count: How many panels.
            bar: Whether a colour bar stands on the right.
        """
        graph = scenario.topology.graph
        at: dict[int, tuple[float, float]] = {node: graph.nodes[node]["pos"] for node in graph}
        x0, x1, y0, y1 = _bounds(at.values(), scenario.topology.mean_length)
        columns = min(count, 3) if not sheet.narrow else 1 if count < 3 else 2
        scale = _PANEL / max(x1 - x0, y1 - y0)
        if sheet.width is not None:
            left, right = _sides(sheet, bar)
            across = (sheet.width - left - right + _GAP) / columns - _GAP
            scale = min(across / (x1 - x0), _TALLEST * across / (y1 - y0), scale)
        nearest = min(graph.edges[edge]["length"] for edge in graph.edges) if graph.edges else 1.0
        dot = min(15.0, max(2.0, 0.5 * nearest * scale * 72))
        letter = 0.46 * dot if dot > 8 and len(at) <= _MOST_LABELS else 0.0
        size = (x1 - x0) * scale, (y1 - y0) * scale
        return cls(scenario, graph, at, *size, dot, 1 / (72 * scale), letter, sheet, columns)

    def frame(self, axes: Axes, title: str) -> None:
        """Gives a panel its title, limits and axes."""
        x0, x1, y0, y1 = _bounds(self.at.values(), self.scenario.topology.mean_length)
        axes.set(xlim=(x0, x1), ylim=(y0, y1), aspect="equal")
        letters = max(12, int((72 * self.width + 25) / (0.58 * (8 if self.sheet.width else 9))))
        axes.set_title(textwrap.fill(title, letters), fontsize=9, color=INK)
        axes.tick_params(labelsize=7, left=True, bottom=True, labelleft=True, labelbottom=True, length=2)
        axes.set_xlabel("x [graph units]", fontsize=7)
        axes.set_ylabel("y [graph units]", fontsize=7)
        for spine in axes.spines.values():
            spine.set_color(QUIET)

    def edges(self, axes: Axes) -> None:
        """Draws all edges; slopes are dashed."""
        slopes = [edge for edge in self.graph.edges if self.graph.edges[edge]["rise"]]
        flat = [edge for edge in self.graph.edges if not self.graph.edges[edge]["rise"]]
        for edgelist, style in ((flat, "solid"), (slopes, "dashed")):
            if edgelist:
                nx.draw_networkx_edges(
                    self.graph, self.at, ax=axes, edgelist=edgelist, edge_color=QUIET, width=0.9, style=style
                )

    def nodes(
        self,
        axes: Axes,
        nodes: Sequence[int],
        colors: Any,
        *,
        shape: str = "o",
        size: float = 1.0,
        scale: tuple[float, float] | None = None,
        edge: str = INK,
        line: float = 0.5,
    ) -> Any:
        """Draws nodes; `colors` are values on `scale`, or one colour. `size` is relative to a node's, `line` points."""
        if not nodes:
            return None
        low, high = scale or (None, None)
        drawn = nx.draw_networkx_nodes(
            self.graph, self.at, ax=axes, nodelist=list(nodes), node_color=colors, node_shape=shape,
            node_size=(size * self.dot) ** 2, edgecolors=edge, linewidths=line, cmap=FIELD if scale else None,
            vmin=low, vmax=high,
        )  # fmt: skip
        drawn.set_zorder(3)
        return drawn

    def landmarks(self, axes: Axes, boxes: Iterable[int], goals: Iterable[int]) -> None:
        """Draws outlines around the holes, the goals and the nodes of the boxes."""
        holes = [self.scenario.topology.ids[hole.node] for hole in self.scenario.holes]
        for nodes, shape, size, color in (
            (holes, "s", 1.4, HOLE), (sorted(set(boxes)), "s", 1.75, BOX), (sorted(set(goals)), "D", 1.45, GOAL),
        ):  # fmt: skip
            self.nodes(axes, nodes, "none", shape=shape, size=size, edge=color, line=1.1)

    def legend_of_landmarks(self) -> list[Line2D]:
        """Handles for what `landmarks` draws, as far as the scenario has it."""
        there = (
            (self.scenario.holes, "s", HOLE, "hole"), (self.scenario.boxes, "s", BOX, "box"), (True, "D", GOAL, "goal"),
        )  # fmt: skip
        return [
            Line2D([], [], linestyle="", marker=shape, color="none", markeredgecolor=color, markersize=6, label=label)
            for things, shape, color, label in there if things
        ]  # fmt: skip

    def numbers(self, axes: Axes, colors: Mapping[int, str]) -> None:
        """Writes each node's number into it, in a colour that can be read there."""
        if self.letter:
            for node, color in colors.items():
                x, y = self.at[node]
                axes.text(
                    x, y, str(node), fontsize=self.letter, color=color, ha="center", va="center_baseline", zorder=5
                )

    def note(self, axes: Axes, node: int, text: str, color: str, corner: tuple[int, int] = (1, 1)) -> None:
        """Writes beside a node, at one of its corners; a white edge keeps it legible over lines."""
        if not self.letter:
            return
        across, up = corner
        axes.annotate(
            text, self.at[node], xytext=(across * 0.62 * self.dot, up * 0.62 * self.dot),
            textcoords="offset points", fontsize=max(5.5, 0.45 * self.dot), color=color, weight="bold",
            ha={1: "left", -1: "right", 0: "center"}[across], va={1: "bottom", -1: "top", 0: "center"}[up],
            path_effects=[withStroke(linewidth=1.6, foreground="white")], zorder=6,
        )  # fmt: skip


_GAP = 0.55
"""Inches between two panels of a row."""


def _sides(sheet: Sheet, bar: bool) -> tuple[float, float]:
    """Inches to the left of the panels and to their right."""
    return (0.5, 0.75 if bar else 0.1) if sheet.width else (0.55, 0.95 if bar else 0.2)


def _bounds(points: Iterable[tuple[float, float]], length: float) -> tuple[float, float, float, float]:
    xs, ys = zip(*points, strict=True)
    pad = 0.55 * length
    # A line of nodes still needs some height for its letters.
    tall = max(max(ys) - min(ys), 0.25 * (max(xs) - min(xs)), length)
    wide = max(max(xs) - min(xs), 0.25 * (max(ys) - min(ys)), length)
    x, y = (max(xs) + min(xs)) / 2, (max(ys) + min(ys)) / 2
    return x - wide / 2 - pad, x + wide / 2 + pad, y - tall / 2 - pad, y + tall / 2 + pad


def heading_of(what: str, run: Run) -> str:
    """What a map shows, of which scenario; and how far the run came, if it is not finished."""
    return " · ".join(word for word in (what, named_in(run, "name"), run.shortfall) if word)


def title_of(what: str, run: Run, group: Group | None = None) -> str:
    """What a diagram shows, and of which run, or group in it; and how far that came, if it is not finished."""
    name = f"{named_in(run, 'name')} {named_in(run, 'variant')}".rstrip()
    of = (named_in(run, "backend"), named_in(run, "policy"), f"seed {run.manifest['seed']}")
    words = (what, "" if group is None else f"group {_drawable(group.name)}", name, *of, run.shortfall)
    return " · ".join(word for word in words if word)


def named_in(run: Run, field: str) -> str:
    """A name from the manifest, in letters that can be drawn."""
    return _drawable(run.manifest.get(field) or "")


def _drawable(name: str) -> str:
    return "".join(letter if letter.isprintable() else "?" for letter in name)[:_LONGEST_NAME]


def plain(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Gives a diagram its labels and the quiet frame that all diagrams have."""
    axes.set_xlabel(x, fontsize=8)
    axes.set_ylabel(y, fontsize=8)
    if title:
        axes.set_title(title, fontsize=9, color=INK)
    axes.tick_params(labelsize=8)
    axes.grid(color=QUIET, linewidth=0.4, alpha=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def panels(
    layout: MapLayout,
    count: int,
    title: str,
    *,
    scale: ScalarMappable | None = None,
    label: str = "",
    legend: Sequence[Line2D] = (),
) -> tuple[Figure, list[Axes]]:
    """A figure with room for `count` maps, some in a row, below a title.

    Places are computed, not searched for: matplotlib's own layouts take seconds for a page of maps.

    Args:
        layout: The map.
        count: Number of panels.
        title: Title of the figure; left out in print.
        scale: Draws a colour bar on the right.
        label: What the colour bar shows.
        legend: What the legend below holds, if there is to be one.
    """
    sheet, columns = layout.sheet, layout.columns
    rows = math.ceil(count / columns)
    left, right = _sides(sheet, scale is not None)
    across, down = layout.width + _GAP, layout.height + 0.75
    width = left + columns * across - _GAP + right
    if sheet.width is not None:  # a map that is higher than wide does not fill its column
        left, width = left + (sheet.width - width) / 2, sheet.width
    in_row = sheet.columns_of([str(each.get_label()) for each in legend], width)
    top, bottom = 0.4 if sheet.width else 0.7, 0.5 + (0.12 + 0.17 * math.ceil(len(legend) / in_row) if legend else 0.0)
    height = top + rows * down - 0.75 + bottom
    figure = Figure(figsize=(width, height))
    if not sheet.width:
        figure.suptitle(title, fontsize=11, color=INK, y=1 - 0.25 / height, va="center")
    if legend:
        figure.legend(handles=[*legend], loc="lower center", ncols=in_row, fontsize=7, frameon=False)
    axes = []
    for i in range(count):
        row, column = divmod(i, columns)
        low = bottom + (rows - 1 - row) * down
        box = (left + column * across, low, layout.width, layout.height)
        axes.append(figure.add_axes((box[0] / width, box[1] / height, box[2] / width, box[3] / height)))
    if scale is not None:
        at = left + columns * across - _GAP + (0.2 if not sheet.width else 0.12)
        bar = figure.add_axes((at / width, bottom / height, 0.16 / width, 1 - (bottom + top) / height))
        figure.colorbar(scale, cax=bar).set_label(label, fontsize=8)
        bar.tick_params(labelsize=7)
    return figure, axes
