# cython: initializedcheck=False
"""The distance pheromone D: how near a node is to the goal (paper Section 3.3.1, Algorithm 2)."""

from __future__ import annotations

import copy
from array import array
from heapq import heappop, heappush
from typing import TYPE_CHECKING, Any, Literal
from weakref import WeakKeyDictionary

from colonysim.pheromones.field import Write
from colonysim.pheromones.marks import Fading, Marks, each_node
from colonysim.pheromones.spreading import NodeValues
from colonysim.states import LARGEST, Stored

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.pheromones.field import Visit
    from colonysim.states import State
    from colonysim.world.state import World
    from colonysim.world.topology import Topology

__all__ = ["Distance", "extent", "farthest"]


UNKNOWN = float("inf")
"""The distance of a node that no path has reached, graph units."""

_STRAIGHT: WeakKeyDictionary[Topology, dict[int, array[float]]] = WeakKeyDictionary()
_EXTENTS: WeakKeyDictionary[Topology, dict[int, float]] = WeakKeyDictionary()


def extent(world: World) -> float:
    """The path distance from the goal to the node farthest from it along edges, whatever their heights, graph units.

    If a timeline moves the goal, it is the largest of all its places.

    With Euclidean distances instead, D would be clipped at 0 on every node whose way to the goal is a long detour.
    """
    return max(farthest(world.topology, goal) for goal in world.scenario.goals)


def farthest(topology: Topology, goal: int) -> float:
    """`extent` of a topology with a goal, graph units; computed once for each."""
    known = _EXTENTS.setdefault(topology, {})
    if goal not in known:
        known[goal] = _farthest(topology, goal)
    return known[goal]


def _farthest(topology: Topology, goal: int) -> float:
    """The length of the longest of all shortest paths from the goal, by Dijkstra's algorithm."""
    first, ends, lengths, _ = topology.edges
    far, queue = array("d", [UNKNOWN]) * len(topology), [(0.0, goal)]
    far[goal] = greatest = 0.0
    while queue:
        d, i = heappop(queue)
        if d > far[i]:
            continue
        greatest = d  # they come in order
        for edge in range(first[i], first[i + 1]):
            j, through = ends[edge], d + lengths[edge]
            if through < far[j]:
                far[j] = through
                heappush(queue, (through, j))
    return greatest


def straight(topology: Topology, goal: int) -> array[float]:
    """The Euclidean distance of each node to the goal, graph units; one array for all callers, not to be changed."""
    known = _STRAIGHT.setdefault(topology, {})
    if goal not in known:
        known[goal] = array("d", [topology.distance(i, goal) for i in range(len(topology))])
    return known[goal]


class Distance(Marks):
    """D = d_max - d, where d is a node's distance to the goal as far as its visitors know.

    Args:
        world: The world whose nodes are marked.
        rule: "lrta": d is the minimum of edge + d over all reachable neighbours, as in LRTA*. "literal": over
            official neighbours only, else the Euclidean distance, as Algorithm 2 prints it.
        d_max: The paper's maximum distance; D never falls below 0.
        unvisited: What D of a node is that nobody has visited: "straight", d_max less its Euclidean distance, or
            "zero".
        everywhere: Whether every deposit updates all nodes, as Algorithm 9 prints it: global value iteration, a
            yardstick and no local rule.
        at_start: Whether an agent deposits before its first step too.
        half_life: Simulated seconds in which the difference of D from that of an unvisited node halves, None for never.
        diffusion: Share of that difference that a node gives to its neighbours at a tick, see `NodeValues`; 0 for none.
        period: Simulated seconds between two ticks.

    Attributes:
        d: Distance of each node to the goal, graph units; the Euclidean one until an agent has been there. If D
            fades, as it was when fading last began anew, if it spreads, as it was written; `far` is what it is now.
        official: For each node 1 if its distance was found along a path from the goal, else 0.
        visited: For each node 1 if an agent has left a mark there, else 0.
        straight: The Euclidean distance of each node to the goal, graph units.
        lrta: Whether the rule is "lrta".
        blank: Whether D of an unvisited node is 0.
        spread: If D spreads, by how much the distance of each node exceeds that of an unvisited one; else None.
    """

    name = "D"

    def __init__(
        self,
        world: World,
        *,
        d_max: float,
        rule: Literal["lrta", "literal"] = "lrta",
        unvisited: Literal["straight", "zero"] = "straight",
        everywhere: bool = False,
        at_start: bool = True,
        half_life: float | None = None,
        diffusion: float = 0.0,
        period: float = 1.0,
    ) -> None:
        super().__init__()
        self._world = world
        self._fading = Fading(world, half_life)
        self.lrta = rule == "lrta"
        self._everywhere, self._at_start = everywhere, at_start
        self.blank = unvisited == "zero"
        self.d_max = d_max
        topology = world.topology
        self._goal = world.scenario.goal
        self.straight = straight(topology, self._goal)
        self.d = array("d", straight(topology, self._goal))
        self.official = bytearray(len(topology))
        self.visited = bytearray(len(topology))
        self.spread: NodeValues | None = None
        if diffusion:
            self.spread = NodeValues(world, half_life=half_life, diffusion=diffusion, period=period)
        self._changes = self._fading.on or self.spread is not None

    def __deepcopy__(self, memo: dict[int, Any]) -> Distance:
        """The same distances in a copy of the world; typed views of arrays cannot be copied as they are."""
        twin = Distance(
            copy.deepcopy(self._world, memo),
            d_max=self.d_max,
            rule="lrta" if self.lrta else "literal",
            unvisited="zero" if self.blank else "straight",
            everywhere=self._everywhere,
            at_start=self._at_start,
            half_life=self._fading.half_life,
        )
        if self.spread is not None:
            twin.spread, twin._changes = copy.deepcopy(self.spread, memo), True
        twin._fading.restart(self._fading.since)
        twin.d, twin.official, twin.visited = array("d", self.d), bytearray(self.official), bytearray(self.visited)
        return twin

    def at(self, node: int, key: int = -1) -> float:
        """D of a node; of an unvisited one, d_max less its Euclidean distance to the goal, or 0."""
        if self.spread is not None:
            value = self.d_max - (self._rest(node) + self.spread.at(node))
            return value if value > 0.0 else 0.0
        if self.blank and not self.visited[node]:
            return 0.0
        value = self.d_max - self.far(node)
        return value if value > 0.0 else 0.0

    def far(self, node: int) -> float:
        """The distance of a node to the goal as far as its visitors knew and the marks have not faded, graph units.

        D = 0 tells no distance: what has spread to an unvisited node is none then, and the Euclidean one is taken.
        """
        if not self._changes:
            return self.d[node]
        if self.spread is not None and (self.visited[node] or not self.blank):
            return self._rest(node) + self.spread.at(node)
        if not self.visited[node]:
            return self.d[node]
        rest = self._rest(node)
        return rest + (self.d[node] - rest) * self._fading.left()

    def _rest(self, node: int) -> float:
        """The distance that D of an unvisited node shows."""
        return self.d_max if self.blank else self.straight[node]

    def _store(self, node: int, far: float) -> None:
        """Sets the distance of a node."""
        if self.spread is not None:
            self.spread.put(node, far - self._rest(node))
        elif self._fading.on:
            if self._fading.faint():
                self._fade(self._world.now)
            rest = self._rest(node)
            far = rest + (far - rest) / self._fading.left()
        self.d[node] = far

    def _fade(self, second: float) -> None:
        """Takes what has faded into the distances; what fades later counts from a second of the episode."""
        for node in range(len(self.visited)):
            if self.visited[node]:
                self.d[node] = self.far(node)
        self._fading.restart(second)

    def keys(self, node: int) -> Sequence[int]:
        """None: one value a node."""
        return ()

    def mark(self, visit: Visit) -> int:
        """Algorithm 2 on the visited node."""
        self._wrote = 0
        moment = visit.moment
        # Most are arrivals: to compare a string with itself is cheap.
        if moment != "arrive" and (moment == "claim" or (moment == "start" and not self._at_start)):
            return 0
        node = visit.node
        self._update(node, visit.level)
        self._note(node, -1, self.at(node))
        if self._everywhere:
            self._sweep(node)
        return self._wrote

    def _sweep(self, done: int) -> None:
        """Updates all nodes but `done`, which has been updated."""
        surface = self._world.surface
        for node in range(len(surface)):
            if node != done:
                before = self.far(node)
                self._update(node, surface[node])
                if self.far(node) != before:
                    self._note(node, -1, self.at(node))

    def _update(self, node: int, level: float) -> None:
        """Algorithm 2 on one node, for an agent at height `level` on it."""
        terrain, changes = self._world.terrain, self._changes
        self.visited[node] = 1
        if node == self._goal:
            self.official[node] = 1
            self._store(node, 0.0)
            return
        best = best_official = UNKNOWN
        for edge in range(terrain.first[node], terrain.first[node + 1]):
            if terrain.leads(level, edge):
                j = terrain.ends[edge]
                through = (self.far(j) if changes else self.d[j]) + terrain.lengths[edge]
                if through < best:
                    best = through
                if through < best_official and self.official[j]:
                    best_official = through
        if best_official < UNKNOWN:
            self.official[node] = 1
        value = best if self.lrta else best_official
        self._store(node, value if value < UNKNOWN else self.straight[node])

    def end_episode(self) -> None:
        """Changes nothing by itself: distances outlive the episode, as the place is the same."""
        if self.spread is not None:
            self.spread.end_episode()
        elif self._fading.on:
            self._fade(0.0)

    def goal_moved(self, goal: int) -> None:
        """Unvisited nodes have their distance to the new goal; marks stay until somebody passes or they fade."""
        if goal == self._goal:
            return
        known = {node: self.far(node) for node in range(len(self.d)) if self.visited[node]}
        if self._fading.on:
            self._fading.restart(self._world.now)
        self._goal, self.straight = goal, straight(self._world.topology, goal)
        for node in range(len(self.d)):
            if not self.visited[node]:
                self.d[node] = self.straight[node]
            elif self.spread is None:
                self.d[node] = known[node]
            else:
                self.spread.put(node, known[node] - self._rest(node))

    def refresh(self) -> None:
        """See `Marks.refresh`."""
        if self.spread is not None:
            self.spread.refresh()
        elif self._fading.on:
            self._fade(self._world.now)
        self._fading.restart(self._world.now)

    def state(self) -> State:
        """Distance of each node, and which of them are official and visited."""
        return {
            "d": array("d", bytes(self.d)), "official": bytes(self.official), "visited": bytes(self.visited),
            "since": self._fading.since, "goal": self._goal,
            "spread": None if self.spread is None else self.spread.state(),
        }  # fmt: skip

    def restore(self, state: State) -> None:
        """See `Marks.restore`."""
        told, nodes = Stored(state, "field D"), len(self.visited)
        d = told.column("d", "d", nodes, -LARGEST, LARGEST)
        official, visited = told.octets("official", nodes, 1), told.octets("visited", nodes, 1)
        self._goal = told.whole("goal", 0, nodes - 1)
        self.straight = straight(self._world.topology, self._goal)
        if self.spread is not None:
            self.spread.restore(told.take("spread"), "field D, 'spread'")
        self._fading.restore(told)
        self.d, self.official, self.visited = array("d", d), bytearray(official), bytearray(visited)

    def frame(self) -> Iterable[Write]:
        """D of every node that was visited, or to which some has spread."""
        spread = set() if self.spread is None else {node for node, _ in self.spread.items()}
        nodes = range(len(self.visited))
        return [Write(node, -1, self.at(node)) for node in nodes if self.visited[node] or node in spread]

    def load(self, frame: Iterable[Write]) -> None:
        """Takes over distances from values of D.

        A node counts as official if its distance is not the Euclidean one, or is one edge more than that of an official
        neighbour.
        """
        topology = self._world.topology
        for node, _, value in sorted(frame, key=lambda write: -write.value):  # the nearest to the goal first
            self.visited[node] = 1
            far = self.d[node] = self.d_max - value
            if self.spread is not None:
                self.spread.put(node, far - self._rest(node))
            edges = zip(topology.neighbours[node], topology.lengths[node], strict=True)
            along_path = any(self.official[j] and abs(self.d[j] + length - far) < 1e-9 for j, length in edges)
            self.official[node] = node == self._goal or along_path or abs(far - self.straight[node]) > 1e-9

    def wipe(self, nodes: Iterable[int]) -> None:
        """Makes some nodes unvisited."""
        found = each_node(nodes, len(self.visited))
        if self.spread is not None:
            self.spread.wipe(found)
        for node in found:
            self.d[node], self.official[node], self.visited[node] = self.straight[node], 0, 0

    def settle(self) -> None:
        """See `Marks.settle`."""
        if self.spread is not None:
            self.spread.settle()
