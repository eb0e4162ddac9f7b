# cython: boundscheck=False, wraparound=False, initializedcheck=False
"""The hole pheromone H: a trail that grows towards a hole (paper Section 3.3.3, Algorithm 5)."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING, Literal

from colonysim.exact import exp, log
from colonysim.pheromones.field import Write

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.pheromones.field import Visit
    from colonysim.world.state import World

__all__ = ["HoleTrail"]

# exp(-700) is the smallest trail that a float can still show; farther than that there is none.
FARTHEST = 700.0
NOWHERE = float("inf")


class HoleTrail:
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
    by_box = False

    def __init__(
        self,
        world: World,
        *,
        evaporation: float = 0.5,
        rule: Literal["max", "min"] = "max",
        everywhere: bool = False,
    ) -> None:
        self._world = world
        self._keep = evaporation
        self._printed = rule == "min"
        self._everywhere = everywhere
        # For each node that has trails their holes, in the order in which they came, and -ln H less what evaporated.
        self._far: dict[int, tuple[array[int], array[float]]] = {}
        self._aged = 0.0
        # For an update: by hole the least, FARTHEST where there is none, what is written, and where it stands at the
        # node; and the holes that have something.
        holes = len(world.scenario.holes)
        self._best, self._new = array("d", [FARTHEST]) * holes, array("d", [0.0]) * holes
        self._place, self._found = array("i", [-1]) * holes, array("i", [0]) * holes

    def at(self, node: int, key: int = -1) -> float:
        """H of the hole `key` at a node, 0 where there is no trail."""
        far = self.farness(node, key)
        return exp(-far) if far < FARTHEST else 0.0

    def farness(self, node: int, hole: int) -> float:
        """-ln H: comparisons on it need no exponential, so they are the same on every processor."""
        trails = self._far.get(node)
        if trails is not None:
            holes, fars = trails
            for k in range(len(holes)):
                if holes[k] == hole:
                    return fars[k] + self._aged
        return NOWHERE

    def keys(self, node: int) -> Sequence[int]:
        """The holes that have a trail at a node, ascending."""
        trails = self._far.get(node)
        return [hole for hole in sorted(trails[0]) if self.farness(node, hole) < FARTHEST] if trails else []

    def deposit(self, visit: Visit) -> Sequence[Write]:
        """Algorithm 5 on the visited node."""
        if visit.moment == "claim" or not self._world.scenario.holes:
            return ()
        writes = self._update(visit.node, visit.level)
        if self._everywhere:
            for node, surface in enumerate(self._world.surface):
                if node != visit.node:
                    writes += self._update(node, surface)
        return writes

    def _update(self, node: int, level: float) -> list[Write]:
        if self._printed:
            return self._update_as_printed(node, level)
        world, aged = self._world, self._aged
        best, found, place, count = self._best, self._found, self._place, 0
        for hole in world.holes_near(node):
            best[hole], found[count] = 0.0, hole
            count += 1
        for j, length in world.ways(level, node):
            trails = self._far.get(j)
            if trails is not None:
                holes, fars = trails
                for k in range(len(holes)):
                    hole, through = holes[k], fars[k] + aged + length
                    if through < best[hole]:
                        if best[hole] == FARTHEST:
                            found[count] = hole
                            count += 1
                        best[hole] = through
        writes: list[Write] = []
        if not count:
            return writes
        trails = self._far.get(node) or (array("i"), array("d"))
        holes, fars = trails
        for k in range(len(holes)):
            place[holes[k]] = k
        fresh: list[int] = []
        for i in range(count):
            hole = found[i]
            far, best[hole], k = best[hole], FARTHEST, place[hole]
            if k < 0:
                fresh.append(hole)
            elif far < fars[k] + aged:
                fars[k] = far - aged
            else:
                continue
            writes.append(Write(node, hole, exp(-far)))
            self._new[hole] = far - aged
        for k in range(len(holes)):
            place[holes[k]] = -1
        if fresh:
            added = array("d", [self._new[hole] for hole in fresh])
            self._far[node] = (trails[0] + array("i", fresh), trails[1] + added)
        return writes

    def _update_as_printed(self, node: int, level: float) -> list[Write]:
        """The minimum over the neighbours, the exponent's sign mended; a neighbour without a trail counts 0."""
        world = self._world
        ways = world.ways(level, node)
        trails = self._trails(node)
        writes = []
        for hole in range(len(world.scenario.holes)):
            far = max((self.farness(j, hole) + length for j, length in ways), default=float("inf"))
            if far < FARTHEST:
                trails[hole] = far - self._aged
                writes.append(Write(node, hole, exp(-far)))
            else:
                trails.pop(hole, None)
        self._far[node] = array("i", trails), array("d", trails.values())
        return writes

    def _trails(self, node: int) -> dict[int, float]:
        return dict(zip(*self._far.get(node, ((), ())), strict=True))

    def end_episode(self) -> None:
        """Evaporates every trail, or resets it."""
        if self._keep <= 0.0:
            self._far.clear()
            self._aged = 0.0
        elif self._keep < 1.0:
            self._aged -= log(self._keep)

    def frame(self) -> Iterable[Write]:
        """H of every hole at every node where there is a trail."""
        return [
            Write(node, hole, self.at(node, hole))
            for node in sorted(self._far)
            for hole in sorted(self._far[node][0])
            if self.at(node, hole) > 0.0
        ]

    def load(self, frame: Iterable[Write]) -> None:
        """Takes over trails."""
        for node, hole, value in frame:
            if value > 0.0:
                trails = self._trails(node) | {hole: -log(value) - self._aged}
                self._far[node] = array("i", trails), array("d", trails.values())
