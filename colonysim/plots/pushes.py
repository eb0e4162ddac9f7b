"""Single pushes on flat ground, up a slope and into a hole: the ways of agent and box over the ground."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon

from colonysim.errors import ColonysimError
from colonysim.plots.paper import AGENT, BLOCKED, BOX, GOAL, HOLE, INK, QUIET
from colonysim.plots.sheet import SCREEN

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from matplotlib.axes import Axes

    from colonysim.plots.sheet import Sheet
    from colonysim.trace.reader import Run

__all__ = ["chosen_pushes", "overlaid_figure", "sample_figure"]

Point = tuple[float, float]
Placed = tuple[float, float, float]
_SLOPE = "#EFE3C8"
_SAMPLES = 6
_UNIT = 0.82
"""Inches a metre."""
_PAD = 0.25
_FARTHEST = 20.0
"""Metres from the origin."""


@dataclass(frozen=True, slots=True)
class _Push:
    """One push in a frame of its own: the push line along x, its start at the origin; metres and radians."""

    episode: int
    terrain: str
    success: bool
    ended: str
    seconds: float
    goal: Point
    agent: list[Placed]
    box: list[Placed]
    pits: list[list[Point]]
    ramps: list[tuple[list[Point], float]]
    box_outline: list[Point]
    robot_outline: list[Point]

    @property
    def word(self) -> str:
        """How it ended, for a title."""
        return "success" if self.success else f"failed ({self.ended})" if self.ended != "failure" else "failed"


def chosen_pushes(run: Run, wanted: Sequence[int] | None) -> dict[str, list[int]]:
    """Episodes to draw, by terrain: those that are asked for, else the first six of each.

    Raises:
        ColonysimError: The run has no such episode, or none is complete.
    """
    there = {result.episode for result in run.episodes}
    if not there:
        raise ColonysimError(f"{run.path}: no push of this run is complete, so there is nothing to draw yet")
    for number in wanted or ():
        if number not in there:
            raise ColonysimError(f"no episode {number} in this run; it has {min(there)} to {max(there)}")
    found: dict[str, list[int]] = defaultdict(list)
    for each in run.manifest["evaluation"]["pushes"]:
        number = each["episode"]
        if number in there if wanted is None else number in wanted:
            found[each["terrain"]].append(number)
    return {kind: numbers if wanted else numbers[:_SAMPLES] for kind, numbers in found.items()}


def overlaid_figure(run: Run, chosen: Mapping[str, Sequence[int]], sheet: Sheet = SCREEN) -> Figure:
    """A panel for each terrain, its pushes turned so that their lines lie upon each other."""
    pushes = _pushes(run, [number for numbers in chosen.values() for number in numbers])
    alone = all(len(numbers) == 1 for numbers in chosen.values())
    figure, axes = _panels(
        list(pushes.values()), len(chosen), 1, f"Trajectories of single pushes · {_about(run)}", alone, sheet
    )
    for axis, (kind, numbers) in zip(axes, chosen.items(), strict=True):
        for number in numbers:
            _ground(axis, pushes[number], faint=len(numbers) > 1)
        for number in numbers:
            _ways(axis, pushes[number], outlines=alone)
        axis.set_title(f"{kind}: {_counted(numbers)}; {_rate(run, kind)}", fontsize=9, color=INK)
    return figure


def sample_figure(run: Run, kind: str, numbers: Sequence[int], sheet: Sheet = SCREEN) -> Figure:
    """A panel for each push of one terrain."""
    pushes = _pushes(run, numbers)
    figure, axes = _panels(
        list(pushes.values()), len(numbers), 2, f"Pushes · {kind} · {_about(run)} · {_rate(run, kind)}", True, sheet
    )
    for axis, number in zip(axes, numbers, strict=True):
        push = pushes[number]
        _ground(axis, push, faint=False)
        _ways(axis, push, outlines=True)
        axis.set_title(f"episode {number}: {push.word}, {push.seconds:.1f} s", fontsize=9, color=INK)
    return figure


def _about(run: Run) -> str:
    words = (run.manifest["evaluation"]["executor"], f"seed {run.manifest['seed']}", run.shortfall)
    return " · ".join(word for word in words if word)


def _counted(numbers: Sequence[int]) -> str:
    if len(numbers) == 1:
        return f"episode {numbers[0]}"
    together = numbers[-1] - numbers[0] == len(numbers) - 1
    return f"episodes {numbers[0]} to {numbers[-1]}" if together else f"{len(numbers)} episodes"


def _rate(run: Run, kind: str) -> str:
    """Successes on a terrain over all its pushes, drawn or not."""
    terrain = {each["episode"]: each["terrain"] for each in run.manifest["evaluation"]["pushes"]}
    won = [result.success for result in run.episodes if terrain[result.episode] == kind]
    return f"{sum(won):.0f} of all {len(won)} succeeded"


def _pushes(run: Run, numbers: Sequence[int]) -> dict[int, _Push]:
    import pyarrow as pa
    import pyarrow.compute as pc

    poses = run.table("poses")
    poses = poses.filter(pc.is_in(poses["episode"], pa.array(numbers, type=pa.int64())))
    ways: dict[tuple[int, str], list[Placed]] = defaultdict(list)
    columns = [poses[name].to_pylist() for name in ("episode", "body", "x", "y", "yaw")]
    for episode, body, x, y, yaw in zip(*columns, strict=True):
        # A body that was flung away, or that the physics lost, has no place in the picture.
        if max(abs(x), abs(y)) <= _FARTHEST and math.isfinite(yaw):
            ways[episode, body].append((x, y, yaw))
    results = {result.episode: result for result in run.episodes}
    evaluation = run.manifest["evaluation"]
    grounds = {each["episode"]: each for each in evaluation["pushes"]}
    length, width = evaluation["robot_size"]
    return {
        number: _turned(
            grounds[number], ways[number, "agent"], ways[number, "box"], results[number], (length / 2, width / 2)
        )
        for number in numbers
    }


def _turned(ground: Any, agent: list[Placed], box: list[Placed], result: Any, robot_half: Point) -> _Push:
    """A push in the frame of its line."""
    (x0, y0), (x1, y1) = ground["start"], ground["goal"]
    line = math.atan2(y1 - y0, x1 - x0)
    c, s = math.cos(line), math.sin(line)

    def point(x: float, y: float) -> Point:
        return c * (x - x0) + s * (y - y0), -s * (x - x0) + c * (y - y0)

    def placed(way: list[Placed]) -> list[Placed]:
        return [(*point(x, y), yaw - line) for x, y, yaw in way]

    pits = []
    for pit in ground["pits"]:
        half = pit["side"] / 2
        pits.append(_outline((*point(pit["x"], pit["y"]), pit["yaw"] - line), _rectangle(half, half)))
    ramps = []
    for ramp in ground["ramps"]:
        (a, b), (e, f) = point(ramp["x0"], ramp["y0"]), point(ramp["x1"], ramp["y1"])
        half = math.hypot(e - a, f - b) / 2
        middle = ((a + e) / 2, (b + f) / 2, math.atan2(f - b, e - a))
        ramps.append((_outline(middle, _rectangle(half, ramp["half_width"])), ramp["z1"] - ramp["z0"]))
    side = ground["box_length"] / 2
    return _Push(
        result.episode, ground["terrain"], result.success == 1.0, result.ended, result.sim_seconds, point(x1, y1),
        placed(agent), placed(box), pits, ramps, _rectangle(side, side), _rectangle(*robot_half),
    )  # fmt: skip


def _rectangle(half_length: float, half_width: float) -> list[Point]:
    return [(half_length * i, half_width * j) for i, j in ((1, 1), (-1, 1), (-1, -1), (1, -1))]


def _outline(at: Placed, corners: Iterable[Point]) -> list[Point]:
    x, y, yaw = at
    c, s = math.cos(yaw), math.sin(yaw)
    return [(x + c * i - s * j, y + s * i + c * j) for i, j in corners]


def _ground(axes: Axes, push: _Push, *, faint: bool) -> None:
    """Pits, slopes, and both ends of the push line."""
    for corners, rise in push.ramps:
        axes.add_patch(Polygon(corners, facecolor=_SLOPE, alpha=0.22 if faint else 1.0, edgecolor="none", zorder=0))
        # Crease lines at foot and crest; the outer edges of the strip lie outside of the picture.
        for i, j, height in ((1, 2, 0.0), (0, 3, rise)):
            (x0, y0), (x1, y1) = corners[i], corners[j]
            axes.plot([x0, x1], [y0, y1], color="#B89B5E", linewidth=0.7, zorder=1)
            if not faint:
                low, high = axes.get_ylim()
                axes.text(
                    x0 + 0.04, low + 0.04 * (high - low), f"{height:.2f} m", fontsize=6, color="#7A6434", zorder=6
                )
    for corners in push.pits:
        face = (0, 0, 0, 0.05 if faint else 0.22)
        edge = (0, 0, 0, 0.3 if faint else 0.9)
        axes.add_patch(Polygon(corners, facecolor=face, edgecolor=edge, linewidth=0.8, zorder=1))
    axes.plot(0, 0, "o", color="white", markeredgecolor=INK, markersize=6, zorder=4)
    axes.plot(*push.goal, "D", color="white", markeredgecolor=GOAL, markeredgewidth=1.4, markersize=6, zorder=4)


def _ways(axes: Axes, push: _Push, *, outlines: bool) -> None:
    style = "solid" if push.success else "dashed"
    for way, corners, color, width in (
        (push.box, push.box_outline, BOX, 2.2),
        (push.agent, push.robot_outline, AGENT, 1.3),
    ):
        if not way:
            continue
        xs, ys = [at[0] for at in way], [at[1] for at in way]
        axes.plot(xs, ys, color=color, linewidth=width, linestyle=style, alpha=0.85, zorder=3, solid_joinstyle="round")
        axes.plot(xs[0], ys[0], "o", color=color, markersize=4, markeredgecolor="white", markeredgewidth=0.5, zorder=5)
        if outlines:
            for at, line in ((way[0], "dotted"), (way[-1], "solid")):
                axes.add_patch(
                    Polygon(_outline(at, corners), fill=False, edgecolor=color, linewidth=0.9, linestyle=line, zorder=2)
                )
    if push.box:
        marker, color = ("s", BOX) if push.success else ("X", BLOCKED)
        axes.plot(
            *push.box[-1][:2], marker, color=color, markersize=5 if push.success else 8, markeredgecolor="white",
            markeredgewidth=0.6, zorder=6,
        )  # fmt: skip


def _panels(
    pushes: Sequence[_Push], count: int, rows: int, title: str, outlines: bool, sheet: Sheet
) -> tuple[Figure, list[Axes]]:
    """Panels of one scale with room for all the ways, a title above and a legend below."""
    reach = [
        corner
        for push in pushes
        for way, corners in ((push.agent, push.robot_outline), (push.box, push.box_outline))
        for at in (*way[:1], *way[-1:])
        for corner in _outline(at, corners)
    ]
    reach += [at[:2] for push in pushes for way in (push.agent, push.box) for at in way]
    reach += [push.goal for push in pushes] + [c for push in pushes for pit in push.pits for c in pit] + [(0.0, 0.0)]
    xs, ys = zip(*reach, strict=True)
    x0, x1, y0, y1 = min(xs) - _PAD, max(xs) + _PAD, min(ys) - _PAD, max(ys) + _PAD
    rows = min(rows, count) if count > 3 else 1
    columns, unit = math.ceil(count / rows), _UNIT
    if sheet.width is not None:
        columns = 1 if sheet.narrow else min(columns, 3)
        rows = math.ceil(count / columns)
        unit = min(_UNIT, ((sheet.width - 0.6) / columns - 0.5) / (x1 - x0))
    across, down = unit * (x1 - x0), unit * (y1 - y0)
    width = sheet.width or 0.55 + columns * (across + 0.5)
    handles = _legend(pushes, outlines)
    in_row = sheet.columns_of([str(each.get_label()) for each in handles], width)
    bottom = 0.55 + 0.17 * math.ceil(len(handles) / in_row)
    height = 0.35 + bottom + rows * (down + 0.75) - 0.4
    figure = Figure(figsize=(width, height))
    if sheet.width is None:
        height += 0.3
        figure.set_size_inches(width, height)
        figure.suptitle(title, fontsize=11, color=INK, y=1 - 0.22 / height, va="center")
    axes = []
    for i in range(count):
        row, column = divmod(i, columns)
        left, low = 0.55 + column * (across + 0.5), bottom + (rows - 1 - row) * (down + 0.75)
        axis = figure.add_axes((left / width, low / height, across / width, down / height))
        axis.set(xlim=(x0, x1), ylim=(y0, y1), aspect="equal")
        axis.set_xlabel("along the push line [m]", fontsize=7)
        if column == 0:
            axis.set_ylabel("to its left [m]", fontsize=7)
        axis.tick_params(labelsize=7, length=2)
        axis.axhline(0, color=QUIET, linewidth=0.6, linestyle="dotted", zorder=1)
        for spine in axis.spines.values():
            spine.set_color(QUIET)
        axes.append(axis)
    figure.legend(handles=handles, loc="lower center", ncols=in_row, fontsize=7, frameon=False)
    return figure, axes


def _legend(pushes: Sequence[_Push], outlines: bool) -> list[Line2D | Patch]:
    """What occurs in the figure, and nothing else."""

    def mark(shape: str, label: str, color: str, edge: str = "white", size: float = 6) -> Line2D:
        return Line2D(
            [], [], linestyle="", marker=shape, color=color, markeredgecolor=edge, markersize=size, label=label
        )

    handles: list[Line2D | Patch] = [
        Line2D([], [], color=AGENT, linewidth=1.3, label="agent"),
        Line2D([], [], color=BOX, linewidth=2.2, label="box"),
        mark("o", "start", "white", INK),
        mark("D", "goal", "white", GOAL),
    ]
    if outlines:
        handles.append(Line2D([], [], color=INK, linewidth=0.9, linestyle="dotted", label="outline at the start"))
        handles.append(Line2D([], [], color=INK, linewidth=0.9, label="outline at the end"))
    if any(push.success for push in pushes):
        handles.append(mark("s", "success: box at the end", BOX, size=5))
    if any(not push.success for push in pushes):
        handles.append(mark("X", "failure (dashed): box at the end", BLOCKED, size=8))
    if any(push.pits for push in pushes):
        handles.append(Patch(facecolor="#C8C8C8", edgecolor=HOLE, label="hole"))
    if any(push.ramps for push in pushes):
        handles.append(Patch(facecolor=_SLOPE, edgecolor="#B89B5E", label="slope"))
    return handles
