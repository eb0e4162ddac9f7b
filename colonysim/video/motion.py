"""Where everything is in each image of a film, by the poses of a run or, without any, by its events."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from colonysim.view.bodies import boxes_after
from colonysim.view.reading import kept_columns

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from colonysim.trace.reader import Run

__all__ = ["Motion", "by_events", "by_poses", "coming_and_leaving"]


@dataclass(frozen=True, slots=True)
class Motion:
    """Places by image; the first axis of each array is the image, the second the agent or box.

    Attributes:
        agents: x, y and yaw of each agent.
        boxes: x, y and yaw of each box.
        boxes_at: Index of the node that each box was brought to last.
    """

    agents: NDArray[np.float64]
    boxes: NDArray[np.float64]
    boxes_at: NDArray[np.int64]


def coming_and_leaving(run: Run, episode: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """When each agent was there first, and when it reached the goal and left, seconds; infinity if it did not."""
    came, left = (np.full(len(run.scenario.agents), math.inf) for _ in range(2))
    for event in run.events(episode):
        if event.kind == "start":
            came[event.agent] = event.time
        elif event.kind == "goal":
            left[event.agent] = event.time
    return came, left


def by_poses(run: Run, episode: int, times: NDArray[np.float64]) -> Motion:
    """The motion of rigid bodies, metres."""
    poses = kept_columns(run, "poses", [episode])
    words, codes = poses.words("body")
    number, time = poses.column("number"), poses.column("time")

    def tracks(body: str, count: int) -> NDArray[np.float64]:
        made = np.zeros((len(times), count, 3))
        for i in range(count):
            rows = np.flatnonzero((codes == words.index(body)) & (number == i))
            for axis, name in enumerate(("x", "y", "yaw")):
                values = np.nan_to_num(poses.column(name)[rows])
                if len(rows):
                    made[:, i, axis] = np.interp(times, time[rows], np.unwrap(values) if name == "yaw" else values)
        return made

    scenario = run.scenario
    boxes = len(scenario.boxes)
    at = _boxes_at(run, episode, times)
    moved = _there(tracks("box", boxes), at) if boxes else np.zeros((len(times), 0, 3))
    return Motion(tracks("agent", len(scenario.agents)), moved, at)


def by_events(run: Run, episode: int, times: NDArray[np.float64]) -> Motion:
    """The motion from node to node, evenly along the edges, graph units."""
    scenario = run.scenario
    topology = scenario.topology
    agents = [_Way(topology.x[node], topology.y[node]) for node in scenario.agents]
    boxes = [_Way(topology.x[box.node], topology.y[box.node]) for box in scenario.boxes]
    for event in run.events(episode):
        if event.kind == "change" and event.action == "add_box":
            there = topology.index[event.node]
            boxes[event.box].go(event.time, event.time, topology.x[there], topology.y[there])
        if event.kind != "end":
            continue
        here = topology.index[event.now_at]
        agents[event.agent].go(event.began, event.time, topology.x[here], topology.y[here])
        if event.action == "push" and event.status == "arrived":
            there = topology.index[event.target]
            boxes[event.box].go(event.began, event.time, topology.x[there], topology.y[there])
    at = _boxes_at(run, episode, times)
    return Motion(_sample(agents, times), _there(_sample(boxes, times, turning=False), at), at)


def _there(tracks: NDArray[np.float64], at: NDArray[np.int64]) -> NDArray[np.float64]:
    """The tracks of boxes, nan while they are not there: nothing is drawn of them then."""
    tracks[at < 0] = math.nan
    return tracks


class _Way:
    """Corners of a way, with the time at each."""

    def __init__(self, x: float, y: float) -> None:
        self.corners = [(0.0, x, y)]

    def go(self, began: float, ended: float, x: float, y: float) -> None:
        """Rests until it begins, and is there when it ended."""
        _, x0, y0 = self.corners[-1]
        self.corners += [(began, x0, y0), (ended, x, y)]


def _sample(ways: Sequence[_Way], times: NDArray[np.float64], turning: bool = True) -> NDArray[np.float64]:
    made = np.zeros((len(times), len(ways), 3))
    for i, way in enumerate(ways):
        when, x, y = np.array(way.corners).T
        made[:, i, 0], made[:, i, 1] = np.interp(times, when, x), np.interp(times, when, y)
        moves = np.flatnonzero(np.hypot(np.diff(x), np.diff(y)) > 0)
        if turning and len(moves):
            # It faces the way that it goes, or went last; before its first step, the way that it will go.
            last = np.maximum(np.searchsorted(when[moves], times, side="right") - 1, 0)
            made[:, i, 2] = np.arctan2(np.diff(y)[moves], np.diff(x)[moves])[last]
    return made


def _boxes_at(run: Run, episode: int, times: NDArray[np.float64]) -> NDArray[np.int64]:
    scenario = run.scenario
    events = kept_columns(run, "events", [episode])
    after: NDArray[Any] = boxes_after(scenario, events, kept_columns(run, "poses", [episode]))
    starts = [box.node for box in scenario.boxes_at_start]
    starts += [-1] * (len(scenario.boxes) - len(starts))
    at = np.tile(np.array(starts, dtype=np.int64), (len(times), 1))
    when, box = events.column("time"), events.column("box")
    for i in np.flatnonzero(after >= 0):
        at[times >= when[i], box[i]] = scenario.topology.index[int(after[i])]
    if scenario.changes:
        for event in run.events(episode):
            if event.kind == "change" and event.action in ("add_box", "remove_box"):
                there = scenario.topology.index[event.node] if event.action == "add_box" else -1
                at[times >= event.time, event.box] = there
    return at
