"""From a plain document to a Scenario: checks what the fields say about each other."""

from __future__ import annotations

import hashlib
import json
from math import inf
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from colonysim.scenario.changes import read_changes, read_newcomers
from colonysim.scenario.complaints import complaint
from colonysim.scenario.faults import faults_of
from colonysim.scenario.format import (
    BoxMapping,
    BoxRow,
    Crowd,
    Duration,
    Geometric,
    Grid,
    HoleMapping,
    Line,
    NodeRow,
    PolicySection,
    RadiusEdges,
    Ring,
    Rooms,
    ScenarioFile,
)
from colonysim.scenario.generate import (
    MAX_EDGES,
    MAX_NODES,
    TooManyEdgesError,
    draw_some,
    geometric,
    grid,
    grid_edges,
    line,
    radius_edges,
    ring,
    rooms,
)
from colonysim.scenario.groups import groups_of
from colonysim.scenario.scenario import BoxStart, Hole, Scenario, Timing
from colonysim.scenario.sections import LARGEST, SMALLEST
from colonysim.scenario.solvable import cut_off
from colonysim.world.topology import Topology

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.scenario.generate import Point
    from colonysim.scenario.places import Places

__all__ = ["assemble"]


def assemble(document: Mapping[str, Any], places: Places) -> Scenario:
    """Builds the scenario that a resolved document (plain data, no variants) describes.

    Raises:
        ScenarioError: A field is wrong, or fields do not fit each other.
    """
    try:
        file = ScenarioFile.model_validate(document)
    except ValidationError as error:
        raise complaint(error, document, places) from None
    return _Assembly(file, places).scenario(document)


def digest(document: Mapping[str, Any]) -> str:
    """SHA-256 of a plain document in canonical JSON: sorted keys, no blanks, UTF-8."""
    text = json.dumps(document, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


class _Assembly:
    """One pass over a file whose fields are well-formed, by itself a scratch pad."""

    def __init__(self, file: ScenarioFile, places: Places) -> None:
        self._file = file
        self._places = places
        self._index: dict[int, int] = {}

    def scenario(self, document: Mapping[str, Any]) -> Scenario:
        file, places = self._file, self._places
        ids, heights, points, edges = self._place()
        newcomers = read_newcomers(file.changes, places, edges, self._pair, self._node)
        floors, rims = self._hole_levels(heights, edges)
        edges |= newcomers.edges
        slopes = self._slopes(edges, set(floors))
        for node, floor in floors.items():
            heights[node] = floor
        topology = Topology.build(ids, [(x, y, z) for (x, y), z in zip(points, heights, strict=True)], edges, slopes)
        self._check_extent(topology)
        goal = self._goal(floors)
        boxes = self._boxes(set(floors), goal)
        starts = self._starts(topology, goal, set(floors), {box.node for box in boxes})
        agents = tuple(node for some in starts for node in some) + newcomers.agents
        boxes += newcomers.boxes
        self._check_solvable(topology, boxes, goal, agents)
        policy = file.policy if isinstance(file.policy, PolicySection) else PolicySection(name=file.policy)
        return Scenario(
            name=file.name,
            description=file.description,
            topology=topology,
            holes=tuple(Hole(node, floor, rims[node]) for node, floor in floors.items()),
            boxes=boxes,
            agents=agents,
            goal=goal,
            no_push=frozenset(self._edge(pair, f"no_push.{n}", edges) for n, pair in enumerate(file.no_push)),
            detection_radius=float(file.detection_radius),
            max_steps=file.max_steps,
            episodes=file.episodes,
            mode=file.mode,
            stall_seconds=float(file.stall_seconds),
            time_limit=None if file.time_limit is None else float(file.time_limit),
            reach=float(file.reach),
            timing=self._timing(topology, edges),
            changes=read_changes(
                file.changes, places, topology, rims, goal, len(boxes), len(agents), self._node,
                lambda pair, path: self._edge(pair, path, edges), [group.name for group in file.groups or ()],
            ),
            newcomers=newcomers if file.changes else None,
            policy=policy.name,
            parameters=dict(policy.model_extra or {}),
            groups=() if file.groups is None else groups_of(file, [len(some) for some in starts], policy.name, places),
            faults=faults_of(file.faults),
            physics=file.physics.model_dump(exclude_none=True),
            document=document,
            digest=digest(document),
            source=places.source,
            positions=places.positions,
            overrides=places.overrides,
        )

    def _node(self, number: int, path: str) -> int:
        """The index of a node by its number."""
        if number not in self._index:
            nearest = min(self._index, key=lambda known: (abs(known - number), known))
            raise self._places.fault(
                path,
                f"there is no node {number}, expected one of the {len(self._index)} nodes"
                f" {min(self._index)} to {max(self._index)}; did you mean {nearest}?",
            )
        return self._index[number]

    def _pair(self, pair: tuple[int, int], path: str) -> tuple[int, int]:
        i, j = (self._node(number, f"{path}.{n}") for n, number in enumerate(pair))
        if i == j:
            raise self._places.fault(path, f"joins node {pair[0]} with itself, expected two nodes")
        return i, j

    def _edge(self, pair: tuple[int, int], path: str, edges: set[tuple[int, int]]) -> tuple[int, int]:
        """A pair that must be an edge, in the direction given."""
        i, j = self._pair(pair, path)
        if (min(i, j), max(i, j)) not in edges:
            ids = {index: number for number, index in self._index.items()}
            joined = sorted(ids[b if a == i else a] for a, b in edges if i in (a, b))
            shown = ", ".join(map(str, joined[:12])) + (", ..." if len(joined) > 12 else "")
            raise self._places.fault(
                path,
                f"{pair[0]}-{pair[1]} is no edge, expected one; node {pair[0]} is joined with {shown or 'nothing'}",
            )
        return i, j

    def _place(self) -> tuple[list[int], list[float], list[Point], set[tuple[int, int]]]:
        """Node numbers, heights, positions, and edges as (smaller, larger) index."""
        file, fault = self._file, self._places.fault
        if file.topology is not None:
            for name in ("nodes", "edges"):
                if getattr(file, name) is not None:
                    raise fault(name, f"stands beside `topology`, expected either `topology` or `{name}`")
            return self._generated(file.topology)
        if file.nodes is None:
            raise fault("nodes", "is missing, expected the nodes [id, x, y, z], or a generated `topology`")
        if file.edges is None:
            raise fault("edges", "is missing, expected a list of [from, to], or {radius: ...}")
        ids, heights, points = [], [], []
        for n, node in enumerate(file.nodes):
            if node.id in self._index:
                first = self._index[node.id]
                line_of = self._places.positions.get(f"nodes.{first}")
                where = f" on line {line_of[0]}" if line_of else f" as nodes.{first}"
                raise fault(f"nodes.{n}", f"node {node.id} is listed twice, first{where}")
            self._index[node.id] = n
            ids.append(node.id)
            points.append((float(node.x), float(node.y)) if isinstance(node, NodeRow) else
                          (float(node.at[0]), float(node.at[1])))  # fmt: skip
            heights.append(float(node.z))
        edges: set[tuple[int, int]] = set()
        if isinstance(file.edges, RadiusEdges):
            try:
                edges.update(radius_edges(points, float(file.edges.radius)))
            except TooManyEdgesError as error:
                raise fault("edges.radius", f"{error}, expected a smaller radius") from None
            edges.update(self._listed_edges(file.edges.include, "edges.include"))
            edges.difference_update(self._listed_edges(file.edges.exclude, "edges.exclude"))
        else:
            edges.update(self._listed_edges(file.edges, "edges"))
        return ids, heights, points, edges

    def _check_extent(self, topology: Topology) -> None:
        """Generated places keep to the coordinates that listed nodes may have, and every edge has a length."""
        for axis in (topology.x, topology.y):
            far = max(max(axis), -min(axis))
            if far > LARGEST:
                raise self._places.fault("topology", f"has nodes at {far:g}, expected none beyond {LARGEST:g}")
        for i, lengths in enumerate(topology.lengths):
            if lengths and min(lengths) < SMALLEST:
                j, ids = topology.neighbours[i][lengths.index(min(lengths))], topology.ids
                raise self._places.fault(
                    f"nodes.{max(i, j)}" if self._file.nodes is not None else "topology",
                    f"node {ids[max(i, j)]} stands where node {ids[min(i, j)]} stands and is joined with it,"
                    f" expected edges that have a length of at least {SMALLEST:g}",
                )

    def _listed_edges(self, pairs: Sequence[tuple[int, int]], path: str) -> list[tuple[int, int]]:
        seen: dict[tuple[int, int], int] = {}
        for n, pair in enumerate(pairs):
            i, j = self._pair(pair, f"{path}.{n}")
            key = (min(i, j), max(i, j))
            if key in seen:
                raise self._places.fault(
                    f"{path}.{n}", f"edge {pair[0]}-{pair[1]} is listed twice, first as {path}.{seen[key]}"
                )
            seen[key] = n
        return list(seen)

    def _generated(
        self, kind: Grid | Line | Ring | Geometric | Rooms
    ) -> tuple[list[int], list[float], list[Point], set[tuple[int, int]]]:
        fault = self._places.fault
        if isinstance(kind, Rooms):
            count = (kind.columns * (kind.size + 1) - 1) * (kind.rows * (kind.size + 1) - 1)
        else:
            count = kind.columns * kind.rows if isinstance(kind, Grid) else kind.nodes
        if count > MAX_NODES:
            raise fault("topology", f"makes {count} nodes, expected at most {MAX_NODES}")
        self._index = {number: number for number in range(count)}
        for n, number in enumerate(kind.without):
            self._node(number, f"topology.without.{n}")
        without = set(kind.without)
        if isinstance(kind, Grid):
            many = grid_edges(kind.columns, kind.rows, kind.diagonals, len(without))
            if many > MAX_EDGES:
                raise fault("topology", f"makes {many} edges, expected at most {MAX_EDGES}")
            if not (kind.diagonals or kind.cut_corners):
                raise fault("topology.cut_corners", "false beside no diagonals, expected `diagonals: true`")
        try:
            if isinstance(kind, Grid):
                points, pairs = grid(
                    kind.columns, kind.rows, kind.spacing, kind.diagonals, kind.cut_corners, without
                )  # fmt: skip
            elif isinstance(kind, Rooms):
                (points, pairs), walls = rooms(kind.columns, kind.rows, kind.size, kind.spacing, kind.seed)
                without.update(walls)
            elif isinstance(kind, Line):
                points, pairs = line(kind.nodes, kind.spacing)
            elif isinstance(kind, Geometric):
                points, pairs = geometric(
                    kind.nodes, kind.radius, kind.width, kind.height, kind.seed, kind.apart, kind.connected
                )
            else:
                points, pairs = ring(kind.nodes, kind.spacing)
        except ValueError as error:
            raise fault("topology", str(error)) from None
        ids = [number for number in range(count) if number not in without]
        if not ids:
            raise fault("topology.without", "leaves no node")
        self._index = {number: i for i, number in enumerate(ids)}
        kept = {(i, j) if i < j else (j, i) for i, j in pairs}
        if without:
            index = self._index
            kept = {(index[i], index[j]) for i, j in kept if i in index and j in index}
        return ids, [float(kind.z)] * len(ids), [points[number] for number in ids], kept

    def _hole_levels(
        self, heights: Sequence[float], edges: set[tuple[int, int]]
    ) -> tuple[dict[int, float], dict[int, float]]:
        """Floor and rim of each hole by node, in the order of the file."""
        numbers = [hole.node if isinstance(hole, HoleMapping) else hole for hole in self._file.holes]
        nodes = [self._node(number, self._within("holes", n, "node")) for n, number in enumerate(numbers)]
        holes = set(nodes)
        around: dict[int, list[float]] = {node: [] for node in nodes}
        for i, j in edges:
            for node, other in ((i, j), (j, i)):
                if node in holes and other not in holes:
                    around[node].append(heights[other])
        floors: dict[int, float] = {}
        rims: dict[int, float] = {}
        for n, (hole, node) in enumerate(zip(self._file.holes, nodes, strict=True)):
            path, number = f"holes.{n}", numbers[n]
            if node in floors:
                raise self._places.fault(path, f"node {number} is listed twice as a hole")
            if isinstance(hole, HoleMapping) and hole.depth is not None:
                floors[node], rims[node] = heights[node] - float(hole.depth), heights[node]
                continue
            if not around[node]:
                raise self._places.fault(
                    path, f"hole {number} has no neighbour that could be its rim; write {{node: {number}, depth: ...}}"
                )
            floors[node], rims[node] = heights[node], max(around[node])
            if not floors[node] < rims[node]:
                raise self._places.fault(
                    path,
                    f"the floor of hole {number} is {floors[node]:g}, not below its rim {rims[node]:g}: the z of a"
                    f" node listed as a hole is its floor; if it is the rim, write {{node: {number}, depth: ...}}",
                )
        return floors, rims

    def _within(self, name: str, n: int, field: str) -> str:
        """The path of a field of an entry that may be written as a mapping."""
        path = f"{name}.{n}.{field}"
        return path if path in self._places.positions else f"{name}.{n}"

    def _slopes(self, edges: set[tuple[int, int]], holes: set[int]) -> list[tuple[int, int]]:
        slopes = []
        for n, pair in enumerate(self._file.slopes):
            i, j = self._edge(pair, f"slopes.{n}", edges)
            if i in holes or j in holes:
                number = pair[0] if i in holes else pair[1]
                raise self._places.fault(f"slopes.{n}", f"node {number} is a hole, expected a slope between others")
            slopes.append((i, j))
        return slopes

    def _goal(self, holes: Mapping[int, float]) -> int:
        goal = self._node(self._file.goal, "goal")
        if goal in holes:
            raise self._places.fault(
                "goal",
                f"node {self._file.goal} is a hole, and no box is ever pushed to the goal, where its pusher would"
                " leave; expected a node beside it",
            )
        return goal

    def _boxes(self, holes: set[int], goal: int) -> tuple[BoxStart, ...]:
        boxes: list[BoxStart] = []
        taken: set[int] = set()
        for n, box in enumerate(self._file.boxes):
            field = "node" if isinstance(box, BoxMapping) else "0" if isinstance(box, BoxRow) else ""
            node = self._node(box.node, f"boxes.{n}.{field}")
            if node == goal:
                raise self._places.fault(
                    f"boxes.{n}", f"a box stands on the goal {box.node}, where agents arrive, expected another node"
                )
            if node not in holes and node in taken:
                raise self._places.fault(f"boxes.{n}", f"a second box stands on node {box.node}, which is no hole")
            taken.add(node)
            boxes.append(BoxStart(node, float(box.height)))
        return tuple(boxes)

    def _starts(self, topology: Topology, goal: int, holes: set[int], boxes: set[int]) -> list[list[int]]:
        """The start nodes of the agents of each group; without groups, of all."""
        file, fault = self._file, self._places.fault
        if file.groups is None:
            if file.agents is None:
                what = "start node of each agent, or {count, seed, within} for nodes that are drawn"
                raise fault("agents", f"is missing, expected {what}; or `groups` of agents that differ")
            given = {"agents": file.agents}
        elif file.agents is not None:
            raise fault("groups", "stands beside `agents`, expected either `agents` or `groups`")
        else:
            given = {f"groups.{n}.agents": group.agents for n, group in enumerate(file.groups)}
        # Listed nodes first: those that are drawn are free.
        taken: dict[int, str] = {}
        found = {
            path: [] if isinstance(agents, Crowd) else self._listed_agents(agents, path, goal, holes, boxes, taken)
            for path, agents in given.items()
        }
        for path, agents in given.items():
            if isinstance(agents, Crowd):
                found[path] = self._drawn_agents(agents, path, topology, {goal, *holes, *boxes, *taken})
                taken |= dict.fromkeys(found[path], path)
        return list(found.values())

    def _listed_agents(
        self, numbers: Sequence[int], listed: str, goal: int, holes: set[int], boxes: set[int], agents: dict[int, str]
    ) -> list[int]:
        """The nodes that are listed at a path; `agents` tells where the others, whose nodes are taken, are listed."""
        found = []
        for n, number in enumerate(numbers):
            path = f"{listed}.{n}"
            node = self._node(number, path)
            if node in agents:
                raise self._places.fault(path, f"two agents stand on node {number}, the other is {agents[node]}")
            if node == goal:
                raise self._places.fault(path, f"an agent stands on the goal {number}, expected another node")
            if node in holes:
                raise self._places.fault(path, f"an agent stands in the hole {number}, expected another node")
            if node in boxes:
                raise self._places.fault(path, f"an agent and a box stand on node {number}, expected one of them")
            agents[node] = path
            found.append(node)
        return found

    def _drawn_agents(self, crowd: Crowd, path: str, topology: Topology, taken: set[int]) -> list[int]:
        xmin, ymin, xmax, ymax = crowd.within or (-inf, -inf, inf, inf)
        x, y = topology.x, topology.y
        free = [i for i in range(len(x)) if i not in taken and xmin <= x[i] <= xmax and ymin <= y[i] <= ymax]
        if crowd.count > len(free):
            where = "within these borders" if crowd.within else "beside the goal, the holes and the boxes"
            message = f"{crowd.count} agents, but only {len(free)} nodes are free {where}"
            raise self._places.fault(f"{path}.count", message)
        return list(draw_some(free, crowd.count, crowd.seed))

    def _timing(self, topology: Topology, edges: set[tuple[int, int]]) -> Timing:
        timing = self._file.timing
        shortest = min((min(some) for some in topology.lengths if some), default=1.0)
        longest = max((max(some) for some in topology.lengths if some), default=1.0)
        for name in ("travel", "push"):
            pace, fixed = float(getattr(timing, name)), float(getattr(timing, f"{name}_fixed"))
            if pace == 0 and fixed == 0:
                raise self._places.fault(f"timing.{name}", f"0 beside a {name}_fixed of 0, expected some time")
            for length in (shortest, longest):
                seconds = fixed + pace * length
                if not SMALLEST <= seconds <= LARGEST:
                    raise self._places.fault(
                        f"timing.{name}",
                        f"an edge of length {length:g} takes {seconds:g} s, expected {SMALLEST:g} to {LARGEST:g} s",
                    )
        travels = self._durations(timing.travels, "timing.travels", edges)
        return Timing(
            travel=float(timing.travel),
            push=float(timing.push),
            travel_fixed=float(timing.travel_fixed),
            push_fixed=float(timing.push_fixed),
            jitter=float(timing.jitter),
            travels={(j, i): seconds for (i, j), seconds in travels.items()} | travels,
            pushes=self._durations(timing.pushes, "timing.pushes", edges),
        )

    def _durations(
        self, rows: Sequence[Duration], path: str, edges: set[tuple[int, int]]
    ) -> dict[tuple[int, int], float]:
        found: dict[tuple[int, int], float] = {}
        for n, row in enumerate(rows):
            edge = self._edge((row.start, row.end), f"{path}.{n}", edges)
            if edge in found:
                raise self._places.fault(f"{path}.{n}", f"edge {row.start}-{row.end} is listed twice")
            found[edge] = float(row.seconds)
        return found

    def _check_solvable(self, topology: Topology, boxes: Sequence[BoxStart], goal: int, agents: Sequence[int]) -> None:
        if any(change.set_surface or change.move_goal is not None for change in self._file.changes):
            return  # what cannot be reached now may be later
        heights = [box.height for box in boxes]
        found = cut_off(topology, heights, float(self._file.reach), goal, agents)
        if found is None:
            return
        ids = topology.ids
        start = ids[agents[found.agent]]
        if found.edge is None:
            why = f"no edge leads out of its part of the place, which has {len(found.stands)} of {len(ids)} nodes"
        else:
            i, j = found.edge
            way = "up" if found.step > 0 else "down"
            why = (
                f"the smallest step in its way is {abs(found.step):g} {way} from {ids[i]} to {ids[j]}, level is less"
                f" than {self._file.reach:g}, and the boxes' heights add up to {sum(heights):g}"
            )
        raise self._places.fault(
            "goal",
            f"no filling of holes lets the agent on node {start} reach the goal {ids[goal]}: {why};"
            " expected an edge, a slope or boxes that fill the gap",
        )
