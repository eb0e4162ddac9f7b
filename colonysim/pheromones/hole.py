# cython: boundscheck=False, wraparound=False, initializedcheck=False
"""The hole pheromone H: a trail that grows towards a hole (paper Section 3.3.3, Algorithm 5)."""

from __future__ import annotations

import copy
from array import array
from typing import TYPE_CHECKING, Any, Literal

from colonysim.exact import exp, log
from colonysim.pheromones.field import Write
from colonysim.pheromones.marks import Marks

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from colonysim.pheromones.field import Visit
    from colonysim.world.state import World

__all__ = ["HoleTrail"]

# exp(-700) is the smallest trail that a float can still show; farther than that there is none.
FARTHEST = 700.0
NOWHERE = float("inf")
SMALLEST = 1024
"""Room for trails at first."""


class HoleTrail(Marks):
    """H of each hole at each node, kept as -ln H: a distance, to which evaporation only adds.

    H becomes 1 where the hole is within R, else the larger of its own value and the largest of its reachable
    neighbours' values times exp(-edge). (The paper's text prints the minimum; its worked example needs the maximum.)

    Args:
        world: The world whose nodes are marked.
        evaporation: What remains of H after an episode, 0 to 1; 0 resets it.
        rule: "max", or "min" for the rule as the text prints it, which overwrites and leaves no trail.
        everywhere: Whether every deposit updates all nodes, as Algorithm 9 prints it.
    """

    name = "H"

    def __init__(
        self,
        world: World,
        *,
        evaporation: float = 0.5,
        rule: Literal["max", "min"] = "max",
        everywhere: bool = False,
    ) -> None:
        super().__init__()
        self._world = world
        self._keep = evaporation
        self._printed = rule == "min"
        self._everywhere = everywhere
        # The trails of a node lie together, in the order in which they came: `room` places from `start` on, of which
        # `count` are taken by a hole and -ln H less what evaporated.
        size = len(world.topology)
        self._start, self._count, self._room = (array("i", bytes(4 * size)) for _ in range(3))
        self._used, self._holes, self._fars = 0, array("i", bytes(4 * SMALLEST)), array("d", bytes(8 * SMALLEST))
        self._aged = 0.0
        # For an update: by hole the least, FARTHEST where there is none, and where it stands at the node; and the holes
        # that have something.
        holes = len(world.scenario.holes)
        self._best, self._place = array("d", [FARTHEST]) * holes, array("i", [-1]) * holes
        self._found, self._any = array("i", [0]) * holes, holes > 0

    def __deepcopy__(self, memo: dict[int, Any]) -> HoleTrail:
        """The same trails in a copy of the world; the windows through which compiled code sees them stay behind."""
        rule: Literal["max", "min"] = "min" if self._printed else "max"
        world = copy.deepcopy(self._world, memo)
        twin = HoleTrail(world, evaporation=self._keep, rule=rule, everywhere=self._everywhere)
        twin._aged, twin._used = self._aged, self._used
        twin._start, twin._count, twin._room = (
            array("i", self._start), array("i", self._count), array("i", self._room)
        )  # fmt: skip
        twin._holes, twin._fars = array("i", self._holes), array("d", self._fars)
        return twin

    def at(self, node: int, key: int = -1) -> float:
        """H of the hole `key` at a node, 0 where there is no trail."""
        far = self.farness(node, key)
        return exp(-far) if far < FARTHEST else 0.0

    def farness(self, node: int, hole: int) -> float:
        """-ln H: comparisons on it need no exponential, so they are the same on every processor."""
        if not 0 <= node < len(self._start):
            return NOWHERE
        start = self._start[node]
        for k in range(start, start + self._count[node]):
            if self._holes[k] == hole:
                return self._fars[k] + self._aged
        return NOWHERE

    def keys(self, node: int) -> Sequence[int]:
        """The holes that have a trail at a node, ascending."""
        found: list[int] = []
        if not 0 <= node < len(self._start):
            return found
        start = self._start[node]
        for k in range(start, start + self._count[node]):
            if self._fars[k] + self._aged < FARTHEST:
                found.append(self._holes[k])
        found.sort()
        return found

    def gather(self, node: int, found: array[int], count: int, marked: bytearray) -> int:
        """Writes the holes of `keys` into `found` in the order in which they came, see `Marks`."""
        if not 0 <= node < len(self._start):
            return count
        start = self._start[node]
        for k in range(start, start + self._count[node]):
            hole = self._holes[k]
            if not marked[hole] and self._fars[k] + self._aged < FARTHEST:
                marked[hole], found[count] = 1, hole
                count += 1
        return count

    def mark(self, visit: Visit) -> int:
        """Algorithm 5 on the visited node."""
        self._wrote = 0
        if visit.moment == "claim" or not self._any:
            return 0
        if not 0 <= visit.node < len(self._start):
            raise IndexError(f"there is no node {visit.node}")
        self._update(visit.node, visit.level)
        if self._everywhere:
            surface = self._world.surface
            for node in range(len(surface)):
                if node != visit.node:
                    self._update(node, surface[node])
        return self._wrote

    def value(self, i: int) -> float:
        """H of the i-th trail that was written: of most nobody asks."""
        return exp(-self._values[i])

    def _update(self, node: int, level: float) -> None:
        if self._printed:
            self._update_as_printed(node, level)
        else:
            self._update_max(node, level)

    def _update_max(self, node: int, level: float) -> None:
        """The rule "max" on one node."""
        sight, terrain, aged = self._world.sight(), self._world.terrain, self._aged
        best, found, place, count = self._best, self._found, self._place, 0
        near = sight.look_for_holes(node)
        for k in range(sight.holes_at, sight.holes_at + near):
            hole = sight.hole_keys[k]
            best[hole], found[count] = 0.0, hole
            count += 1
        for edge in range(terrain.first[node], terrain.first[node + 1]):
            j, length = terrain.ends[edge], terrain.lengths[edge]
            if self._count[j] and terrain.leads(level, edge):
                start = self._start[j]
                for k in range(start, start + self._count[j]):
                    hole, through = self._holes[k], self._fars[k] + aged + length
                    if through < best[hole]:
                        if best[hole] == FARTHEST:
                            found[count] = hole
                            count += 1
                        best[hole] = through
        start = self._start[node]
        for k in range(start, start + self._count[node]):
            place[self._holes[k]] = k - start
        for i in range(count):
            hole = found[i]
            far, best[hole], k = best[hole], FARTHEST, place[hole]
            if k < 0:
                self._append(node, hole, far - aged)  # which may move the others
            elif far < self._fars[self._start[node] + k] + aged:
                self._fars[self._start[node] + k] = far - aged
            else:
                continue
            self._note(node, hole, far)
        start = self._start[node]
        for k in range(start, start + self._count[node]):
            place[self._holes[k]] = -1

    def _append(self, node: int, hole: int, far: float) -> None:
        """One trail more at a node; where there is no place left beside its others they move to the end."""
        start, count = self._start[node], self._count[node]
        if count == self._room[node]:
            room = max(4, 2 * count)
            if self._used + room > len(self._holes):
                # Not in place: compiled code looks at the old arrays.
                grown = bytes(4 * max(room, len(self._holes)))
                self._holes = array("i", bytes(self._holes) + grown)
                self._fars = array("d", bytes(self._fars) + 2 * grown)
            for k in range(count):
                self._holes[self._used + k], self._fars[self._used + k] = self._holes[start + k], self._fars[start + k]
            self._start[node], self._room[node] = self._used, room
            start, self._used = self._used, self._used + room
        self._holes[start + count], self._fars[start + count] = hole, far
        self._count[node] = count + 1

    def _update_as_printed(self, node: int, level: float) -> None:
        """The minimum over the neighbours, the exponent's sign mended; a neighbour without a trail counts 0."""
        world = self._world
        ways = world.ways(level, node)
        trails = self._trails(node)
        for hole in range(len(world.scenario.holes)):
            far = max((self.farness(j, hole) + length for j, length in ways), default=float("inf"))
            if far < FARTHEST:
                trails[hole] = far - self._aged
                self._note(node, hole, far)
            else:
                trails.pop(hole, None)
        self._replace(node, trails)

    def _trails(self, node: int) -> dict[int, float]:
        start, end = self._start[node], self._start[node] + self._count[node]
        return dict(zip(self._holes[start:end], self._fars[start:end], strict=True))

    def _replace(self, node: int, trails: Mapping[int, float]) -> None:
        self._count[node] = 0
        for hole, far in trails.items():
            self._append(node, hole, far)

    def end_episode(self) -> None:
        """Evaporates every trail, or resets it."""
        if self._keep <= 0.0:
            self._count = array("i", bytes(4 * len(self._count)))
            self._aged = 0.0
        elif self._keep < 1.0:
            self._aged -= log(self._keep)

    def frame(self) -> Iterable[Write]:
        """H of every hole at every node where there is a trail."""
        return [
            Write(node, hole, self.at(node, hole))
            for node, count in enumerate(self._count)
            if count
            for hole in sorted(self._trails(node))
            if self.at(node, hole) > 0.0
        ]

    def load(self, frame: Iterable[Write]) -> None:
        """Takes over trails, those of holes and nodes that the world has."""
        for node, hole, value in frame:
            if value > 0.0 and 0 <= node < len(self._start) and 0 <= hole < len(self._best):
                self._replace(node, self._trails(node) | {hole: -log(value) - self._aged})
