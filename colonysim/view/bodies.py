"""Rigid bodies for the page: where they were, and the ground that they stood on."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from colonysim.geometry.drawing import draw
from colonysim.geometry.scale import metres_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from colonysim.scenario.scenario import Scenario
    from colonysim.view.columns import Columns
    from colonysim.view.packing import Block

__all__ = ["add_bodies", "boxes_after"]

_FINE = 1000
"""Places are kept in millimetres, angles in thousandths of a radian."""
_SUNK = 0.08
"""A box whose centre is this much below where it would be on the rim lies in the pit, metres with the
standard robot."""


def add_bodies(block: Block, scenario: Scenario, poses: Columns, episodes: Sequence[int]) -> None:
    """Adds the poses of all bodies, each body's own one after the other, and the ground; nothing without poses."""
    if not len(poses):
        return
    drawing = draw(scenario)
    agents, boxes = len(scenario.agents), len(scenario.boxes)
    words, codes = poses.words("body")
    is_box = codes == words.index("box") if "box" in words else np.zeros(len(codes), dtype=bool)
    body = poses.column("number") + np.where(is_box, agents, 0)
    episode = np.searchsorted(episodes, poses.column("episode"))
    time = poses.milliseconds()
    order = np.lexsort((time, body, episode))
    places = np.arange(len(episodes) * (agents + boxes) + 1)
    block.ints("poses.first", np.searchsorted((episode * (agents + boxes) + body)[order], places))
    block.ints("poses.time", time[order], steps=True)
    for name in ("x", "y", "z", "roll", "pitch", "yaw"):
        values = np.nan_to_num(poses.column(name)[order])
        if name in ("roll", "pitch", "yaw"):
            values = np.unwrap(values)
        block.ints(f"poses.{name}", np.rint(np.clip(values, -1e6, 1e6) * _FINE), steps=True)
    slabs = [[*slab.centre, *slab.half, slab.yaw, slab.slope] for slab in drawing.slabs]
    block.reals("slabs", slabs)
    block.head["bodies"] = {
        "fine": _FINE,
        "scale": metres_of(scenario, drawing.robot),
        "places": [(*place, height) for place, height in zip(drawing.places, drawing.heights, strict=True)],
        "pits": [[pit.x, pit.y, pit.yaw, pit.side, pit.rim, pit.depth] for pit in drawing.pits],
        "boxes": [[box.length, box.height] for box in drawing.boxes],
        "robots": [
            [robot.bumper, robot.half_width, robot.track, robot.wheel_radius, robot.scale] for robot in drawing.models
        ],
    }


def boxes_after(scenario: Scenario, events: Columns, poses: Columns) -> NDArray[Any]:
    """For each event the number of the node that its box is on afterwards, or -1 if the box was not moved.

    A push that arrives leads to its target; where a failed one left the box only its pose tells.
    """
    actions, action = events.words("action")
    states, status = events.words("status")
    kinds, kind = events.words("kind")
    pushed = (kind == _code(kinds, "end")) & (action == _code(actions, "push"))
    arrived = status == _code(states, "arrived")
    after = np.where(pushed & arrived, events.column("target"), -1)
    failed = np.flatnonzero(pushed & ~arrived)
    if len(failed) and len(poses):
        where = _Landing(scenario, poses)
        episode, time, box = (events.column(name) for name in ("episode", "time", "box"))
        for i in failed:
            after[i] = where.of(int(episode[i]), float(time[i]), int(box[i]))
    return after


def _code(words: list[str], word: str) -> int:
    return words.index(word) if word in words else -1


class _Landing:
    """Which node a box belongs to by its pose, as the physics backend would say."""

    def __init__(self, scenario: Scenario, poses: Columns) -> None:
        self._drawing = draw(scenario)
        self._ids = scenario.topology.ids
        words, codes = poses.words("body")
        columns = [poses.column(name) for name in ("episode", "time", "number", "x", "y", "z")]
        rows = np.flatnonzero(codes == _code(words, "box"))
        self._at: dict[tuple[int, float, int], tuple[float, float, float]] = {
            (int(e), float(t), int(n)): (float(x), float(y), float(z))
            for e, t, n, x, y, z in zip(*(column[rows] for column in columns), strict=True)
        }

    def of(self, episode: int, time: float, box: int) -> int:
        """The number of the node that a box is on, or -1 if no pose tells."""
        place = self._at.get((episode, time, box))
        if place is None or not all(map(math.isfinite, place)):
            return -1
        drawing = self._drawing
        nearest = min(range(len(drawing.places)), key=lambda node: math.dist(place[:2], drawing.places[node]))
        if nearest in drawing.pit_at:
            upright = drawing.heights[nearest] + drawing.boxes[box].height / 2
            if place[2] > upright - _SUNK * drawing.robot.scale:  # beside the pit or across it, not in it
                return -1
        return self._ids[nearest]
