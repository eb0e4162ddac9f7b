"""A place seen from above: what stands still is drawn once, what moves are artists that are set for each image."""

from __future__ import annotations

from bisect import bisect_right
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.patches import Circle, Polygon, Rectangle

from colonysim.geometry.drawing import draw
from colonysim.plots.paper import AGENT, BLOCKED, BOX, GOAL, HOLE, INK

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from colonysim.geometry.drawing import Drawing
    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.replay import Place
    from colonysim.video.motion import Motion

__all__ = ["Scene"]

_LOW, _HIGH = np.array([0.78, 0.76, 0.71]), np.array([0.95, 0.94, 0.91])
"""Colours of the lowest and the highest ground."""
_STOPPED = "#B9AEB5"
"""An agent that stands still because it failed."""
_SEATED = "#7FB2D5"
"""A box that lies in a hole: ground to drive on."""
_SQUARE = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
# Seen from above with its nose to the right, in half lengths and half widths.
_ROBOT = np.array(
    [(-1.0, -0.8), (-0.8, -1.0), (0.35, -1.0), (1.0, -0.45), (1.0, 0.45), (0.35, 1.0), (-0.8, 1.0), (-1.0, 0.8)]
)
_NOSE = np.array([(0.55, 0.0), (1.0, 0.0)])
_STRIPS = 24
_MOST_NUMBERS = 30
"""With more agents than this their numbers are left out."""


class Scene:
    """A place and what moves in it.

    Args:
        axes: Where it is drawn.
        scenario: The place.
        motion: Where everything is in each image.
        bodies: Whether that is in metres.
        stages: What the place is like over the episode, see `colonysim.trace.replay.places`.

    Attributes:
        moving: The artists to draw for each image, from the ground upwards.
    """

    def __init__(self, axes: Axes, scenario: Scenario, motion: Motion, bodies: bool, stages: Sequence[Place]) -> None:
        self._scenario, self._motion, self._stages = scenario, motion, stages
        self._rims = {hole.node: hole.rim for hole in scenario.holes}
        self._heights = np.array([box.height for box in scenario.boxes])
        axes.set_aspect("equal")
        axes.axis("off")
        if bodies:
            drawing = draw(scenario)
            _ground(axes, drawing)
            places = np.array(drawing.places)
            pits = {node: drawing.pits[pit] for node, pit in drawing.pit_at.items()}
            self._pits = {node: ((pit.x, pit.y), pit.side, pit.yaw) for node, pit in pits.items()}
            self._box = np.array([box.length for box in drawing.boxes])
            self._robots = np.array([(robot.bumper, robot.half_width) for robot in drawing.models])
            self._graph = _Graph(axes, scenario, places, 0.5 * drawing.robot.half_width, "#D3CFC4")
        else:
            places = np.column_stack([scenario.topology.x, scenario.topology.y])
            unit = 0.8 * scenario.topology.mean_length
            self._graph = _Graph(axes, scenario, places, 0.18 * unit, "#B8B8B8")
            for low, high, limit in zip(places.min(0) - 0.7 * unit, places.max(0) + 0.7 * unit, "xy", strict=True):
                axes.set(**{f"{limit}lim": (low, high)})
            self._pits = {node: (tuple(places[node]), 0.62 * unit, 0.0) for node in self._rims}
            self._box = np.full(len(scenario.boxes), 0.5 * unit)
            self._robots = np.tile(np.array([0.2, 0.18]) * unit, (len(scenario.agents), 1))
        holes = [
            axes.add_patch(Polygon(_placed(_SQUARE * side, centre, yaw), color=HOLE, linewidth=0, zorder=2))
            for centre, side, yaw in self._pits.values()
        ]
        self._goal = _Goal(axes, places, float(self._robots[:, 0].max(initial=0.0)))
        self._set_stage(stages[0])
        axes.autoscale_view()
        # What stands still all the time is drawn once; with a place that changes that is the ground alone.
        self._still: list[Artist] = [*self._graph.parts, *holes, *self._goal.parts] if len(stages) > 1 else []
        for part in self._still:
            part.set_animated(True)
        self._trails = [
            LineCollection([], color=color, linewidths=width, alpha=0.45, animated=True)
            for color, width in ((BOX, 1.6), (AGENT, 1.1))
        ]
        self._boxes = PolyCollection([], edgecolors="white", linewidths=0.6, animated=True)
        self._agents = PolyCollection([], facecolors=AGENT, edgecolors=INK, linewidths=0.6, animated=True)
        self._noses = LineCollection([], color=INK, linewidths=1.0, animated=True)
        for artist in (*self._trails, self._boxes, self._agents, self._noses):
            axes.add_collection(artist, autolim=False)
        few = len(scenario.agents) <= _MOST_NUMBERS
        self._fills = {
            node: _label(axes, centre, side, across=1 if centre[0] < places[:, 0].mean() else -1)
            for node, (centre, side, _) in self._pits.items()
        }
        self._numbers = [
            axes.text(
                0,
                0,
                str(i),
                fontsize=5.5,
                color="white",
                weight="bold",
                ha="center",
                va="center_baseline",
                animated=True,
            )
            for i in range(len(scenario.agents) if few else 0)
        ]
        self.moving: list[Artist] = [
            *self._still, *self._trails, self._boxes, *self._fills.values(), self._agents, self._noses, *self._numbers
        ]  # fmt: skip

    def show(self, frame: int, time: float, there: NDArray[np.bool_], stopped: NDArray[np.bool_]) -> None:
        """Sets everything that moves.

        Args:
            frame: Which image.
            time: Simulated seconds of the episode.
            there: For each agent whether it is still there, and not left at the goal.
            stopped: For each agent whether it stands still because it failed.
        """
        motion = self._motion
        stage = self._stages[bisect_right(self._stages, time, key=attrgetter("since")) - 1]
        if stage is not self._stage:
            self._set_stage(stage)
        boxes, agents = motion.boxes[frame], motion.agents[frame]
        for trails, ways in zip(self._trails, (motion.boxes, motion.agents), strict=True):
            trails.set_segments(list(ways[: frame + 1, :, :2].swapaxes(0, 1)))
        seated = np.array([int(node) in self._rims for node in motion.boxes_at[frame]], dtype=bool)
        order = np.argsort(~seated, kind="stable")
        self._boxes.set_verts([_placed(_SQUARE * self._box[i], boxes[i, :2], boxes[i, 2]) for i in order])
        self._boxes.set_facecolor([_SEATED if seated[i] else BOX for i in order])
        standing = np.flatnonzero(there)
        self._agents.set_verts([_placed(_ROBOT * self._robots[i], agents[i, :2], agents[i, 2]) for i in standing])
        self._agents.set_facecolor([_STOPPED if stopped[i] else AGENT for i in standing])
        self._noses.set_segments([_placed(_NOSE * self._robots[i], agents[i, :2], agents[i, 2]) for i in standing])
        for i, number in enumerate(self._numbers):
            number.set_position(agents[i, :2])
            number.set_visible(bool(there[i]))
        for node, text in self._fills.items():
            text.set_text(f"{100 * self._fill(frame, node):.0f} %")

    def filled(self, frame: int) -> int:
        """How many holes are as good as level in an image."""
        gaps = [(1 - self._fill(frame, node)) * self._depth(node) for node in self._rims]
        return sum(gap < self._scenario.reach for gap in gaps)

    def _fill(self, frame: int, node: int) -> float:
        """How full a hole is, at most 1."""
        inside, depth = self._motion.boxes_at[frame] == node, self._depth(node)
        return float(min(1.0, self._heights[inside].sum() / depth)) if depth > 0 else 1.0

    def _depth(self, node: int) -> float:
        return self._rims[node] - self._stage.floor[node]

    def _set_stage(self, stage: Place) -> None:
        """Shows the place as it is from a moment on."""
        self._stage = stage
        self._graph.show(stage)
        self._goal.show(stage.goal)


_ROOM_BELOW = 0.06
"""A goal that is lower than this share of the place's height has its word above it: below, the picture ends."""


class _Goal:
    """The goal, where it is now."""

    def __init__(self, axes: Axes, places: NDArray[np.float64], size: float) -> None:
        self._places, self._below = places, 2.5 * size
        self._discs = [
            Circle((0.0, 0.0), 2.2 * size, color=GOAL, alpha=0.35, linewidth=0, zorder=2),
            Circle((0.0, 0.0), 2.2 * size, fill=False, edgecolor=GOAL, linewidth=1.2, zorder=2),
        ]
        for disc in self._discs:
            axes.add_patch(disc)
        self._word = axes.text(0, 0, "goal", fontsize=7, color=INK, weight="bold", ha="center", va="top")
        low, high = places[:, 1].min(), places[:, 1].max()
        self._lowest = low + _ROOM_BELOW * (high - low)
        self.parts: list[Artist] = [*self._discs, self._word]

    def show(self, node: int) -> None:
        """Shows it on a node."""
        x, y = self._places[node]
        for disc in self._discs:
            disc.center = (x, y)
        above = bool(self._lowest > y)
        self._word.set(position=(x, y + self._below if above else y - self._below), va="bottom" if above else "top")


def _placed(
    points: NDArray[np.float64], centre: Sequence[float] | NDArray[np.float64], yaw: float
) -> NDArray[np.float64]:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.asarray(points @ np.array([(c, s), (-s, c)]) + np.asarray(centre))


def _label(axes: Axes, centre: Sequence[float], side: float, across: int) -> Any:
    """An empty text at an upper corner of a pit, on its right (1) or left (-1)."""
    return axes.text(
        centre[0] + 0.62 * across * side, centre[1] + 0.35 * side, "", fontsize=7, weight="bold", color=INK,
        ha="left" if across > 0 else "right", va="bottom", animated=True,
    )  # fmt: skip


def _ground(axes: Axes, drawing: Drawing) -> None:
    """Levels as rectangles and ramps as strips, the lighter the higher."""
    levels = [ground.z for ground in drawing.grounds]
    low, span = min(levels), (max(levels) - min(levels)) or 1.0

    def color(z: float) -> tuple[float, ...]:
        share = (z - low) / span if len(set(levels)) > 1 else 1.0
        return tuple(_LOW + share * (_HIGH - _LOW))

    for ground in sorted(drawing.grounds, key=lambda ground: ground.z):
        size = (ground.xmax - ground.xmin, ground.ymax - ground.ymin)
        axes.add_patch(Rectangle((ground.xmin, ground.ymin), *size, color=color(ground.z), linewidth=0, zorder=1))
    for ramp in drawing.ramps:
        along = np.array([np.cos(ramp.yaw), np.sin(ramp.yaw)])
        # The landings at both ends lie over the gaps between a ramp and its levels.
        ends = np.linspace(0.0, ramp.length, _STRIPS + 1)
        ends[0], ends[-1] = -ramp.landing, ramp.length + ramp.landing
        for share, begin, end in zip(np.linspace(0, 1, _STRIPS), ends[:-1], ends[1:], strict=True):
            centre = np.array([ramp.x0, ramp.y0]) + along * (begin + end) / 2
            shape = _placed(_SQUARE * (1.05 * (end - begin), 2 * ramp.half_width), centre, ramp.yaw)
            shade = color(ramp.z0 + share * (ramp.z1 - ramp.z0))
            axes.add_patch(Polygon(shape, color=shade, linewidth=0, antialiased=False, zorder=1.2))


class _Graph:
    """Edges and nodes of a given diameter; slopes are dashed, and what has become too high a step has a red slash."""

    def __init__(self, axes: Axes, scenario: Scenario, places: NDArray[np.float64], node: float, color: str) -> None:
        self._rises, self._places = scenario.topology.rises, places
        self._edges = LineCollection([], colors=color, linewidths=0.8, zorder=1.4)
        self._slashes = LineCollection([], colors=BLOCKED, linewidths=1.6, zorder=1.45, capstyle="round")
        across = np.full(len(places), node)
        nodes = EllipseCollection(
            across, across, np.zeros(len(places)), units="xy", offsets=places, offset_transform=axes.transData,
            facecolors="white", edgecolors=color, linewidths=0.6, zorder=1.5,
        )  # fmt: skip
        self.parts: list[Artist] = [self._edges, self._slashes, nodes]
        for part in (self._edges, self._slashes, nodes):
            axes.add_collection(part)

    def show(self, stage: Place) -> None:
        """Shows the edges that are there."""
        self._edges.set_segments([self._places[list(edge)] for edge in stage.edges])
        self._edges.set_linestyle(["dashed" if self._rises.get(edge) else "solid" for edge in stage.edges])
        self._slashes.set_segments([_slash(*self._places[list(edge)]) for edge in stage.steps])


def _slash(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    """A stroke across the middle of an edge, at 60 degrees to it."""
    along, (c, s) = (other - one) * 0.2, (np.cos(np.pi / 3), np.sin(np.pi / 3))
    across = np.array([c * along[0] - s * along[1], s * along[0] + c * along[1]])
    middle = (one + other) / 2
    return np.array([middle - across, middle + across])
