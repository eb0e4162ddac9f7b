"""A run as a recording for the Rerun viewer: place, agents and boxes through time, events, results."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from colonysim.errors import MissingExtraError
from colonysim.files import replacing
from colonysim.geometry.drawing import draw
from colonysim.view.bodies import boxes_after
from colonysim.view.columns import Columns
from colonysim.view.content import chosen_episodes
from colonysim.view.extent import check_extent
from colonysim.view.reading import kept_columns

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from colonysim.trace.reader import Run

__all__ = ["write_recording"]

_AGENT, _BOX, _GOAL, _HOLE, _EDGE = [204, 121, 167], [0, 114, 178], [0, 158, 115], [58, 58, 58], [150, 150, 150]
_SHARES = np.linspace(0.0, 1.0, 6)
"""Where a body is shown between two nodes, where there are no poses."""


def write_recording(run: Run, out: Path, episodes: Sequence[int] | None = None) -> None:
    """Writes an .rrd file; nothing goes over a network.

    Time runs on from episode to episode, in simulated seconds. Of a run with poses all is in metres and as it was
    driven; else in graph units, evenly along the edges.

    Args:
        run: The run.
        out: The file; replaced in one step.
        episodes: Which; None for all that are complete.

    Raises:
        MissingExtraError: rerun-sdk is not installed.
        ColonysimError: There is nothing to record, or the file cannot be written or is part of the run.
    """
    run.check_apart(out)
    try:
        import rerun
    except ImportError:
        raise MissingExtraError(
            "a Rerun recording needs rerun-sdk, which is not installed: pip install 'colonysim[rerun]'"
        ) from None
    wanted = chosen_episodes(run, episodes)
    results = [each for each in run.episodes if each.episode in wanted]
    check_extent(run, wanted, "a recording")
    run = run.only(wanted)
    run.check_places("events", "poses")
    stream = rerun.RecordingStream("colonysim", recording_id=str(run.trace_sha256 or run.path), send_properties=False)
    with replacing(out) as temporary:
        stream.save(temporary)
        _Recording(rerun, stream, run, results).write()
        stream.flush()
        stream.disconnect()


class _Recording:
    """Sends a run to a stream."""

    def __init__(self, rerun: Any, stream: Any, run: Run, results: Sequence[Any]) -> None:
        self._rerun, self._stream, self._run, self._results = rerun, stream, run, results
        self._scenario = run.scenario
        topology = self._scenario.topology
        self._numbers = [each.episode for each in results]
        lengths = [each.sim_seconds for each in results]
        self._begins = np.concatenate([[0.0], np.cumsum(lengths)])
        self._events = Columns(run.table("events"), self._numbers)
        self._poses = kept_columns(run, "poses", self._numbers)
        if len(self._poses):
            drawing = draw(self._scenario)
            self._places = np.array([(*at, z) for at, z in zip(drawing.places, drawing.heights, strict=True)])
            self._box_sizes = [(box.length, box.length, box.height) for box in drawing.boxes]
            self._agent_sizes = [(each.length, 2 * each.half_width, each.height) for each in drawing.models]
        else:
            self._places = np.column_stack([topology.x, topology.y, topology.z]).astype(float)
            wide = 0.35 * topology.mean_length
            self._box_sizes = [(wide, wide, box.height) for box in self._scenario.boxes]
            self._agent_sizes = [(wide, 0.7 * wide, 0.4 * wide)] * len(self._scenario.agents)

    def write(self) -> None:
        """Sends everything."""
        self._send_place()
        if len(self._poses):
            self._send_poses()
        else:
            self._send_ways()
        self._send_events()
        times = self._begins[1:]
        for name in ("steps", "success"):
            values = [float(getattr(each, name)) for each in self._results]
            self._columns(f"results/{name}", times, self._numbers, self._rerun.Scalars.columns(scalars=values))

    def _columns(self, path: str, times: Any, episodes: Any, columns: Any) -> None:
        index = self._rerun.TimeColumn
        self._stream.send_columns(
            path, indexes=[index("time", duration=times), index("episode", sequence=episodes)], columns=columns
        )

    def _log(self, path: str, what: Any) -> None:
        self._stream.log(path, what, static=True)

    def _send_place(self) -> None:
        rerun, scenario, places = self._rerun, self._scenario, self._places
        ids, ways = scenario.topology.ids, scenario.topology.edges
        begins = np.repeat(np.arange(len(places)), np.diff(np.asarray(ways.first)))
        ends = np.asarray(ways.ends)
        lines = np.stack([places[begins], places[ends]], axis=1)[begins < ends]
        unit = 0.06 * float(np.linalg.norm(lines[0][1] - lines[0][0])) if len(lines) else 0.1
        colours = np.full((len(places), 3), _EDGE)
        colours[[hole.node for hole in scenario.holes]] = _HOLE
        colours[scenario.goal] = _GOAL
        self._log("place/edges", rerun.LineStrips3D(lines, colors=_EDGE, radii=0.2 * unit))
        labels = [str(node) for node in ids]
        self._log("place/nodes", rerun.Points3D(places, colors=colours, radii=unit, labels=labels, show_labels=False))
        sizes = {"box": self._box_sizes, "agent": self._agent_sizes}
        for body, colour in (("box", _BOX), ("agent", _AGENT)):
            for number, size in enumerate(sizes[body]):
                half = [0.5 * each for each in size]
                self._log(f"{body}/{number}", rerun.Boxes3D(half_sizes=[half], colors=colour, fill_mode="solid"))

    def _send_poses(self) -> None:
        poses, rerun = self._poses, self._rerun
        words, codes = poses.words("body")
        episode, number = poses.column("episode"), poses.column("number")
        time = poses.column("time") + self._begins[np.searchsorted(self._numbers, episode)]
        place = np.column_stack([poses.column(name) for name in ("x", "y", "z")])
        turned = _quaternions(*(poses.column(name) for name in ("roll", "pitch", "yaw")))
        for code, body in enumerate(words):
            for each in np.unique(number[codes == code]):
                rows = np.flatnonzero((codes == code) & (number == each))
                moves = rerun.Transform3D.columns(translation=place[rows], quaternion=turned[rows])
                self._columns(f"{body}/{each}", time[rows], episode[rows], moves)

    def _send_ways(self) -> None:
        """Where everybody and everything is while it moves, from the events."""
        scenario, events, places = self._scenario, self._events, self._places
        index = scenario.topology.index
        heights = np.array([size[2] for size in self._box_sizes])
        ways: dict[str, list[tuple[float, int, NDArray[np.float64]]]] = {}
        boxes_to = boxes_after(scenario, events, self._poses)
        columns = [events.column(name) for name in ("began", "time", "agent", "box", "now_at")]
        kinds, kind = events.words("kind")
        lift = [np.array([0.0, 0.0, 0.5 * size[2]]) for size in self._agent_sizes]
        for i, number in enumerate(self._numbers):
            agents = [places[node] + lift[agent] for agent, node in enumerate(scenario.agents_at_start)]
            stacks: dict[int, list[int]] = {}
            boxes = []
            for box, start in enumerate(scenario.boxes_at_start):
                boxes.append(self._on_top(stacks, start.node, box, heights))
            here = {f"agent/{agent}": at for agent, at in enumerate(agents)}
            here |= {f"box/{box}": at for box, at in enumerate(boxes)}
            for path, at in here.items():
                ways.setdefault(path, []).append((self._begins[i], number, at))
            for row in range(events.first[i], events.first[i + 1]):
                if kinds[kind[row]] in ("start", "change"):
                    path, at = self._appears(row, stacks, heights, lift)
                    if path:
                        here[path] = at
                        ways.setdefault(path, []).append((self._begins[i] + columns[1][row], number, at))
                if kinds[kind[row]] != "end":
                    continue
                began, time, agent, box, now_at = (column[row] for column in columns)
                moved = [(f"agent/{agent}", places[index[int(now_at)]] + lift[int(agent)])]
                if boxes_to[row] >= 0:
                    moved.append((f"box/{box}", self._on_top(stacks, index[int(boxes_to[row])], int(box), heights)))
                for path, there in moved:
                    for share in _SHARES:
                        at = here[path] + share * (there - here[path])
                        ways[path].append((self._begins[i] + began + share * (time - began), number, at))
                    here[path] = there
        for path, way in ways.items():
            times, episodes, points = zip(*way, strict=True)
            self._columns(path, times, episodes, self._rerun.Transform3D.columns(translation=np.array(points)))

    def _appears(
        self, row: int, stacks: dict[int, list[int]], heights: NDArray[Any], lift: Sequence[NDArray[np.float64]]
    ) -> tuple[str, NDArray[np.float64]]:
        """Which body an event puts somewhere, and where; no body for most events."""
        events, index = self._events, self._scenario.topology.index
        kinds, kind = events.words("kind")
        actions, action = events.words("action")
        node, agent, box = (int(events.column(name)[row]) for name in ("node", "agent", "box"))
        if kinds[kind[row]] == "start" and agent >= len(self._scenario.agents_at_start):
            return f"agent/{agent}", self._places[index[node]] + lift[agent]
        if kinds[kind[row]] == "change" and actions[action[row]] == "add_box":
            return f"box/{box}", self._on_top(stacks, index[node], box, heights)
        return "", self._places[0]

    def _on_top(self, stacks: dict[int, list[int]], node: int, box: int, heights: NDArray[Any]) -> NDArray[np.float64]:
        """Puts a box on a node, upon those that are there; returns where its middle is."""
        for stack in stacks.values():
            if box in stack:
                stack.remove(box)
        below = stacks.setdefault(node, [])
        middle = self._places[node].copy()
        middle[2] += heights[below].sum() + 0.5 * heights[box]
        below.append(box)
        return np.asarray(middle)

    def _send_events(self) -> None:
        """Every event as a line of text."""
        texts, times, episodes = [], [], []
        for i, number in enumerate(self._numbers):
            for event in self._run.events(number):
                if event.kind in ("start", "wait"):
                    continue
                texts.append(" ".join(map(str, _words(event))))
                times.append(self._begins[i] + event.time)
                episodes.append(number)
        self._columns("events", times, episodes, self._rerun.TextLog.columns(text=texts))


def _words(event: Any) -> list[Any]:
    if event.kind == "episode":
        return ["episode", event.episode, "ends:", event.status]
    if event.kind != "end":
        return ["agent", event.agent, event.kind]
    said = ["agent", event.agent, event.action, event.node, "→", event.target]
    said += ["box", event.box] if event.box >= 0 else []
    return said if event.status == "arrived" else [*said, event.status, event.reason]


def _quaternions(roll: Any, pitch: Any, yaw: Any) -> NDArray[np.float64]:
    """Turns about x, then y, then z, as x, y, z, w."""
    (sr, cr), (sp, cp), (sy, cy) = ((np.sin(a / 2), np.cos(a / 2)) for a in (roll, pitch, yaw))
    return np.column_stack([
        sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy,
    ])  # fmt: skip
