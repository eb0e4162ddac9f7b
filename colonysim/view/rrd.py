"""A run as a recording for the Rerun viewer: place, agents and boxes through time, events, results."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from colonysim.errors import MissingExtraError
from colonysim.files import replacing
from colonysim.geometry.drawing import draw
from colonysim.installing import install_command
from colonysim.trace.replay import change_in_words, places, stops
from colonysim.view.bodies import boxes_after
from colonysim.view.columns import Columns
from colonysim.view.content import chosen_episodes
from colonysim.view.extent import check_extent
from colonysim.view.reading import kept_columns

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.reader import Run
    from colonysim.trace.replay import Place

__all__ = ["write_recording"]

_AGENT, _BOX, _GOAL, _HOLE, _EDGE = [204, 121, 167], [0, 114, 178], [0, 158, 115], [58, 58, 58], [150, 150, 150]
_BLOCKED, _STOPPED = [208, 0, 0], [185, 174, 181]
_SHARES = np.linspace(0.0, 1.0, 6)
"""Where a body is shown between two nodes, where there are no poses."""

Size: TypeAlias = tuple[float, float, float]


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
            f"a Rerun recording needs rerun-sdk, which is not installed: {install_command('rerun')}"
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
        self._send_bodies()
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

    def _send_place(self) -> None:
        """The place: once, or anew at each episode's beginning and each change if the scenario has a timeline."""
        for i, number in enumerate(self._numbers):
            for place in places(self._scenario, self._run.events(number)) if self._scenario.changes or i == 0 else ():
                if self._scenario.changes:
                    self._stream.set_time("time", duration=self._begins[i] + place.since)
                    self._stream.set_time("episode", sequence=number)
                self._send_stage(place, static=not self._scenario.changes)

    def _send_stage(self, place: Place, *, static: bool) -> None:
        """Edges and nodes as they are from a moment on."""
        rerun, scenario, at = self._rerun, self._scenario, self._places
        if not len(self._poses):
            at = np.column_stack([at[:, :2], place.floor])
        lines, steps = (at[np.array(edges, dtype=np.int64).reshape(-1, 2)] for edges in (place.edges, place.steps))
        unit = 0.06 * float(np.linalg.norm(lines[0][1] - lines[0][0])) if len(lines) else 0.1
        colours = np.full((len(at), 3), _EDGE)
        colours[[hole.node for hole in scenario.holes]] = _HOLE
        colours[place.goal] = _GOAL
        labels = [str(node) for node in scenario.topology.ids]
        nodes = rerun.Points3D(at, colors=colours, radii=unit, labels=labels, show_labels=False)
        self._stream.log("place/edges", rerun.LineStrips3D(lines, colors=_EDGE, radii=0.2 * unit), static=static)
        self._stream.log("place/nodes", nodes, static=static)
        if scenario.changes:
            self._stream.log("place/steps", rerun.LineStrips3D(steps, colors=_BLOCKED, radii=0.3 * unit))

    def _send_bodies(self) -> None:
        """How large bodies are while they are there, and that agents which stand still have another colour."""
        rerun, scenario = self._rerun, self._scenario
        sizes = {f"box/{n}": size for n, size in enumerate(self._box_sizes)}
        sizes |= {f"agent/{n}": size for n, size in enumerate(self._agent_sizes)}
        shown: dict[str, list[tuple[float, int, bool]]] = {path: [] for path in sizes}
        paints: dict[str, list[tuple[float, int, list[int]]]] = {path: [] for path in sizes if path.startswith("agent")}
        for i, number in enumerate(self._numbers):
            begins, events = self._begins[i], list(self._run.events(number))
            there = {f"box/{n}" for n in range(len(scenario.boxes_at_start))}
            there |= {f"agent/{n}" for n in range(len(scenario.agents_at_start))}
            for path, each in shown.items():
                each.append((begins, number, path in there))
            for event in events:
                if event.kind == "goal" or (event.kind == "start" and event.agent >= len(scenario.agents_at_start)):
                    shown[f"agent/{event.agent}"].append((begins + event.time, number, event.kind == "start"))
                elif event.kind == "change" and event.action in ("add_box", "remove_box"):
                    shown[f"box/{event.box}"].append((begins + event.time, number, event.action == "add_box"))
            for painted in paints.values():
                painted.append((begins, number, _AGENT))
            for agent, since, until in stops(events):
                paints[f"agent/{agent}"].append((begins + since, number, _STOPPED))
                if until < np.inf:
                    paints[f"agent/{agent}"].append((begins + until, number, _AGENT))
        for path, size in sizes.items():
            half, when = [0.5 * each for each in size], shown[path]
            counts = [int(there) for _, _, there in when]
            halves = rerun.Boxes3D.columns(half_sizes=[half] * sum(counts)).partition(counts)
            self._columns(path, [at for at, _, _ in when], [number for _, number, _ in when], halves)
            fixed = {"fill_mode": "solid"} if path in paints else {"fill_mode": "solid", "colors": _BOX}
            self._stream.log(path, rerun.Boxes3D.from_fields(**fixed), static=True)
        for path, when_painted in paints.items():
            times, numbers, colours = zip(*when_painted, strict=True)
            self._columns(path, times, numbers, rerun.Boxes3D.columns(colors=colours))

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
        scenario, events, index = self._scenario, self._events, self._scenario.topology.index
        boxes_to = boxes_after(scenario, events, self._poses)
        columns = [events.column(name) for name in ("began", "time", "agent", "box", "now_at", "node", "step")]
        kinds, kind = events.words("kind")
        actions, action = events.words("action")
        ways: dict[str, list[tuple[float, int, NDArray[np.float64]]]] = {}
        for i, number in enumerate(self._numbers):
            standing = _Standing(self._places, self._box_sizes, self._agent_sizes, scenario)
            here = {path: standing.place(path) for path in standing.paths()}
            for path, at in here.items():
                ways.setdefault(path, []).append((self._begins[i], number, at))
            for row in range(events.first[i], events.first[i + 1]):
                began, time, agent, box, now_at, node, step = (column[row] for column in columns)
                what, moving = kinds[kind[row]], set[str]()
                if what == "end":
                    moving = {f"agent/{agent}"} | ({f"box/{box}"} if boxes_to[row] >= 0 else set())
                    touched = standing.put(f"agent/{agent}", index[int(now_at)])
                    if boxes_to[row] >= 0:
                        touched += standing.put(f"box/{box}", index[int(boxes_to[row])])
                elif what == "start" and agent >= len(scenario.agents_at_start):
                    touched = standing.put(f"agent/{agent}", index[int(node)])
                elif what == "change" and actions[action[row]] == "add_box":
                    touched = standing.put(f"box/{box}", index[int(node)])
                elif what == "change" and actions[action[row]] == "remove_box":
                    touched = standing.take(f"box/{box}")
                elif what == "change" and actions[action[row]] == "set_surface":
                    touched = standing.level(index[int(node)], scenario.changes[int(step)].z)
                else:
                    continue
                for path in dict.fromkeys(touched):
                    there = standing.place(path)
                    before = here.get(path, there)
                    # Who moves has been on its way since it began; what stands on something goes with it at once.
                    for share in _SHARES if path in moving else (1.0,):
                        when = began + share * (time - began) if path in moving else time
                        place = before + share * (there - before)
                        ways.setdefault(path, []).append((self._begins[i] + when, number, place))
                    here[path] = there
        for path, way in ways.items():
            times, episodes, points = zip(*way, strict=True)
            self._columns(path, times, episodes, self._rerun.Transform3D.columns(translation=np.array(points)))

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


class _Standing:
    """Where bodies stand that no poses tell of: on their nodes, boxes upon each other, agents on what fills a hole.

    Args:
        places: x, y and z of each node.
        boxes: Size of each box.
        agents: Size of each agent.
        scenario: Where they stand at first.
    """

    def __init__(
        self, places: NDArray[np.float64], boxes: Sequence[Size], agents: Sequence[Size], scenario: Scenario
    ) -> None:
        self._places = places.copy()
        self._high = {f"box/{n}": size[2] for n, size in enumerate(boxes)}
        self._high |= {f"agent/{n}": size[2] for n, size in enumerate(agents)}
        self._holes = {hole.node for hole in scenario.holes}
        self._node: dict[str, int] = {}
        self._on: dict[int, list[str]] = {}
        for agent, node in enumerate(scenario.agents_at_start):
            self.put(f"agent/{agent}", node)
        for box, start in enumerate(scenario.boxes_at_start):
            self.put(f"box/{box}", start.node)

    def paths(self) -> list[str]:
        """All that are there."""
        return [*self._node]

    def put(self, path: str, node: int) -> list[str]:
        """Puts a body on a node, a box upon those that are there; returns all whose place may be another now."""
        left = self.take(path)
        self._node[path] = node
        self._on.setdefault(node, []).append(path)
        return [*left, *self._on[node]]

    def take(self, path: str) -> list[str]:
        """Takes a body away, likewise."""
        if path not in self._node:
            return []
        left = self._on[self._node.pop(path)]
        left.remove(path)
        return left[:]

    def level(self, node: int, z: float) -> list[str]:
        """Gives a node's surface another height, likewise."""
        self._places[node, 2] = z
        return self._on.get(node, [])[:]

    def place(self, path: str) -> NDArray[np.float64]:
        """Where the middle of a body is."""
        node = self._node[path]
        boxes = [other for other in self._on[node] if other.startswith("box")]
        if path in boxes:
            boxes = boxes[: boxes.index(path)]
        elif node not in self._holes:  # who holds a box stands beside it
            boxes = []
        middle = self._places[node].copy()
        middle[2] += sum(self._high[box] for box in boxes) + 0.5 * self._high[path]
        return np.asarray(middle)


def _words(event: Any) -> list[Any]:
    if event.kind == "episode":
        return ["episode", event.episode, "ends:", event.status]
    if event.kind == "change":
        return [change_in_words(event)]
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
