# cython: boundscheck=False, wraparound=False, initializedcheck=False
"""The hole pheromone H: a trail that grows towards a hole (paper Section 3.3.3, Algorithm 5)."""

from __future__ import annotations

import copy
from array import array
from typing import TYPE_CHECKING, Any, Literal

from colonysim.exact import exp, log
from colonysim.pheromones.field import Write
from colonysim.pheromones.marks import Fading, Marks, each_node, gather_keys
from colonysim.pheromones.spreading import NodeValues
from colonysim.states import LARGEST, Stored

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from colonysim.pheromones.field import Visit
    from colonysim.states import State
    from colonysim.world.state import World

__all__ = ["HoleTrail"]

FARTHEST = 700.0
"""The largest -ln H of a trail: exp(-700) is about the smallest positive float; beyond it H is 0."""
NOWHERE = float("inf")
"""-ln H where there is no trail."""
SMALLEST = 1024
"""Number of trails for which there is room at first."""
LEAST = 1e-304
"""Where H spreads, the smallest H of a trail."""


class HoleTrail(Marks):
    """H of each hole at each node, kept as -ln H: a distance, to which evaporation only adds.

    H becomes 1 where the hole is within R, else the larger of its own value and the largest of its reachable
    neighbours' values times exp(-edge). (The paper's text prints the minimum; its worked example needs the maximum.)

    Args:
        world: The world whose nodes are marked.
        evaporation: What remains of H after an episode, 0 to 1; 0 resets it.
        rule: "max", or "min" for the rule as the text prints it, which overwrites and leaves no trail.
        everywhere: Whether every deposit updates all nodes, as Algorithm 9 prints it.
        half_life: Simulated seconds in which H halves, None for never.
        diffusion: Share of H that a node gives to its neighbours at a tick, see `NodeValues`; 0 for none.
        period: Simulated seconds between two ticks.

    Attributes:
        spread: Of a field that spreads, H of each hole, None before there is any; they take the place of -ln H.
    """

    name = "H"
    by_hole = True

    def __init__(
        self,
        world: World,
        *,
        evaporation: float = 0.5,
        rule: Literal["max", "min"] = "max",
        everywhere: bool = False,
        half_life: float | None = None,
        diffusion: float = 0.0,
        period: float = 1.0,
    ) -> None:
        super().__init__()
        self._world = world
        self._fading = Fading(world, half_life)
        self._keep = evaporation
        self._printed = rule == "min"
        self._everywhere = everywhere
        # The trails of a node lie together in `_holes` (the hole's key) and `_fars` (-ln H less `_aged`), in the order
        # in which they came: at the indices from `_start` on, where `_room` have room and `_count` are taken.
        size = len(world.topology)
        self._start, self._count, self._room = (array("i", bytes(4 * size)) for _ in range(3))
        self._agent = -1  # whose marks are being left: a hole is near if it lies within its R
        self._used, self._holes, self._fars = 0, array("i", bytes(4 * SMALLEST)), array("d", bytes(8 * SMALLEST))
        self._aged = 0.0
        # Scratch arrays of an update. For each hole: the least -ln H so far, FARTHEST if there is none, and the index
        # of the node's own trail, counted from its `_start`, -1 if it has none. `_found`: the holes that have a value.
        holes = len(world.scenario.holes)
        self._best, self._place = array("d", [FARTHEST]) * holes, array("i", [-1]) * holes
        self._found, self._any = array("i", [0]) * holes, holes > 0
        self._diffusion, self._period = diffusion, period
        self._spreads, self.spread = bool(diffusion), list[NodeValues | None]()
        if self._spreads:
            self._new_values()  # which looks at the arguments
            self.spread, self._best = [None] * holes, array("d", [0.0]) * holes

    def __deepcopy__(self, memo: dict[int, Any]) -> HoleTrail:
        """The same trails in a copy of the world; typed views of arrays cannot be copied as they are."""
        rule: Literal["max", "min"] = "min" if self._printed else "max"
        world = copy.deepcopy(self._world, memo)
        twin = HoleTrail(
            world,
            evaporation=self._keep,
            rule=rule,
            everywhere=self._everywhere,
            half_life=self._fading.half_life,
            diffusion=self._diffusion,
            period=self._period,
        )
        twin.spread = copy.deepcopy(self.spread, memo)
        twin._fading.restart(self._fading.since)
        twin._aged, twin._used = self._aged, self._used
        twin._start, twin._count, twin._room = (
            array("i", self._start), array("i", self._count), array("i", self._room)
        )  # fmt: skip
        twin._holes, twin._fars = array("i", self._holes), array("d", self._fars)
        return twin

    def at(self, node: int, key: int = -1) -> float:
        """H of the hole `key` at a node, 0 where there is no trail."""
        if self._spreads:
            return self._strength(node, key)
        far = self.farness(node, key)
        return exp(-far) if far < FARTHEST else 0.0

    def farness(self, node: int, hole: int) -> float:
        """-ln H of a hole at a node; comparing it needs no exponential and gives the same result on every processor."""
        if not 0 <= node < len(self._start):
            return NOWHERE
        if self._spreads:
            strength = self._strength(node, hole)
            return -log(strength) if strength > 0.0 else NOWHERE
        start = self._start[node]
        for k in range(start, start + self._count[node]):
            if self._holes[k] == hole:
                return self._fars[k] + self._age()
        return NOWHERE

    def _strength(self, node: int, hole: int) -> float:
        """H of a field that spreads."""
        if not (0 <= node < len(self._start) and 0 <= hole < len(self.spread)):
            return 0.0
        values = self.spread[hole]
        if values is None:
            return 0.0
        strength = values.at(node)
        return strength if strength >= LEAST else 0.0

    def _write(self, node: int, hole: int, strength: float) -> None:
        """Sets H in a field that spreads."""
        if self.spread[hole] is None:
            self.spread[hole] = self._new_values()
        values = self.spread[hole]
        assert values is not None
        values.put(node, strength)

    def _new_values(self) -> NodeValues:
        return NodeValues(
            self._world, half_life=self._fading.half_life, diffusion=self._diffusion, period=self._period
        )

    def _age(self) -> float:
        """What evaporation has added by now to the -ln H of every trail."""
        return self._aged + self._fading.age() if self._fading.on else self._aged

    def keys(self, node: int) -> Sequence[int]:
        """The holes that have a trail at a node, ascending."""
        found: list[int] = []
        if not 0 <= node < len(self._start):
            return found
        if self._spreads:
            return [hole for hole in range(len(self.spread)) if self._strength(node, hole) > 0.0]
        start, aged = self._start[node], self._age()
        for k in range(start, start + self._count[node]):
            if self._fars[k] + aged < FARTHEST:
                found.append(self._holes[k])
        found.sort()
        return found

    def gather(self, node: int, found: array[int], count: int, marked: bytearray) -> int:
        """See `Marks.gather`; here the keys come in the order in which the trails were first written."""
        if not 0 <= node < len(self._start):
            return count
        if self._spreads:
            return gather_keys(self.keys(node), found, count, marked)
        start, aged = self._start[node], self._age()
        for k in range(start, start + self._count[node]):
            hole = self._holes[k]
            if not marked[hole] and self._fars[k] + aged < FARTHEST:
                marked[hole], found[count] = 1, hole
                count += 1
        return count

    def mark(self, visit: Visit) -> int:
        """Algorithm 5 on the visited node."""
        self._wrote = 0
        # Most visits are arrivals: to compare a string with itself is cheap.
        if not self._any or (visit.moment != "arrive" and visit.moment == "claim"):
            return 0
        if not 0 <= visit.node < len(self._start):
            raise IndexError(f"there is no node {visit.node}")
        self._agent = visit.agent
        self._update(visit.node, visit.level)
        if self._everywhere:
            surface = self._world.surface
            for node in range(len(surface)):
                if node != visit.node:
                    self._update(node, surface[node])
        return self._wrote

    def value(self, i: int) -> float:
        """H of the i-th trail that the last `mark` wrote, computed only when asked for."""
        return self._values[i] if self._spreads else exp(-self._values[i])

    def _update(self, node: int, level: float) -> None:
        """Algorithm 5 on one node, for an agent at height `level` on it, by the rule that was chosen."""
        if self._spreads:
            self._update_spread(node, level)
        elif self._printed:
            self._update_as_printed(node, level)
        else:
            self._update_max(node, level)

    def _update_max(self, node: int, level: float) -> None:
        """The rule "max": each trail becomes the larger of its H and exp(-edge) times that of reachable neighbours."""
        visibility, terrain, aged = self._world.visibility_of(self._agent), self._world.terrain, self._age()
        count = 0
        near = visibility.find_holes(node)
        for k in range(visibility.holes_start, visibility.holes_start + near):
            hole = visibility.hole_keys[k]
            self._best[hole], self._found[count] = 0.0, hole
            count += 1
        for edge in range(terrain.first[node], terrain.first[node + 1]):
            j, length = terrain.ends[edge], terrain.lengths[edge]
            if self._count[j] and terrain.leads(level, edge):
                start = self._start[j]
                for k in range(start, start + self._count[j]):
                    hole, through = self._holes[k], self._fars[k] + aged + length
                    if through < self._best[hole]:
                        if self._best[hole] == FARTHEST:
                            self._found[count] = hole
                            count += 1
                        self._best[hole] = through
        start = self._start[node]
        for k in range(start, start + self._count[node]):
            self._place[self._holes[k]] = k - start
        for i in range(count):
            hole = self._found[i]
            far, self._best[hole], k = self._best[hole], FARTHEST, self._place[hole]
            if k < 0:
                self._append(node, hole, far - aged)  # which may move the others
            elif far < self._fars[self._start[node] + k] + aged:
                self._fars[self._start[node] + k] = far - aged
            else:
                continue
            self._note(node, hole, far)
        start = self._start[node]
        for k in range(start, start + self._count[node]):
            self._place[self._holes[k]] = -1

    def _update_spread(self, node: int, level: float) -> None:
        """Algorithm 5 by either rule, on H itself."""
        visibility, terrain = self._world.visibility_of(self._agent), self._world.terrain
        holes = len(self.spread)
        for hole in range(holes):
            self._best[hole] = 1.0 if self._printed else self._strength(node, hole)
        ways = 0
        for edge in range(terrain.first[node], terrain.first[node + 1]):
            if terrain.leads(level, edge):
                j, ways, factor = terrain.ends[edge], ways + 1, exp(-terrain.lengths[edge])
                for hole in range(holes):
                    through = factor * self._strength(j, hole)
                    if (through < self._best[hole]) if self._printed else (through > self._best[hole]):
                        self._best[hole] = through
        if not self._printed:
            near = visibility.find_holes(node)
            for k in range(visibility.holes_start, visibility.holes_start + near):
                self._best[visibility.hole_keys[k]] = 1.0
        for hole in range(holes):
            strength, own = self._best[hole], self._strength(node, hole)
            if self._printed and (ways == 0 or strength < LEAST):
                strength = 0.0
            if strength != own or (self._printed and strength > 0.0):
                self._write(node, hole, strength)
                if strength > 0.0:
                    self._note(node, hole, strength)

    def _append(self, node: int, hole: int, far: float) -> None:
        """Adds a trail to a node; if there is no room beside its others, all of them move to the end of the arrays."""
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
        """The rule "min": each trail becomes the smallest of exp(-edge) times H over all reachable neighbours.

        The sign of the printed exponent is corrected. A neighbour without a trail has H = 0.
        """
        world = self._world
        neighbours = world.reachable_neighbours(level, node)
        trails = self._trails(node)
        for hole in range(len(world.scenario.holes)):
            far = max((self.farness(j, hole) + length for j, length in neighbours), default=float("inf"))
            if far < FARTHEST:
                trails[hole] = far - self._age()
                self._note(node, hole, far)
            else:
                trails.pop(hole, None)
        self._replace(node, trails)

    def _trails(self, node: int) -> dict[int, float]:
        """The trails of a node: for each hole -ln H less `_aged`."""
        start, end = self._start[node], self._start[node] + self._count[node]
        return dict(zip(self._holes[start:end], self._fars[start:end], strict=True))

    def _replace(self, node: int, trails: Mapping[int, float]) -> None:
        """Gives a node these trails instead of its own."""
        self._count[node] = 0
        for hole, far in trails.items():
            self._append(node, hole, far)

    def end_episode(self) -> None:
        """Evaporates every trail by adding to all -ln H at once, or removes them all."""
        for values in self.spread:
            if values is not None:
                values.end_episode(self._keep)
        self._aged = self._age()
        self._fading.restart(0.0)
        if self._keep <= 0.0:
            self._count = array("i", bytes(4 * len(self._count)))
            self._aged = 0.0
        elif self._keep < 1.0:
            self._aged -= log(self._keep)

    def refresh(self) -> None:
        """See `Marks.refresh`."""
        for values in self.spread:
            if values is not None:
                values.refresh()
        self._aged = self._age()
        self._fading.restart(self._world.now)

    def state(self) -> State:
        """The trails of each node in the order in which they came: how many, of which holes, and their -ln H."""
        kept = [k for node, start in enumerate(self._start) for k in range(start, start + self._count[node])]
        return {
            "count": array("i", bytes(self._count)), "holes": array("i", [self._holes[k] for k in kept]),
            "fars": array("d", [self._fars[k] for k in kept]), "aged": self._aged, "since": self._fading.since,
            "spread": [None if values is None else values.state() for values in self.spread],
        }  # fmt: skip

    def restore(self, state: State) -> None:
        """See `Marks.restore`."""
        told, nodes, most = Stored(state, "field H"), len(self._count), len(self._best)
        count = told.column("count", "i", nodes, 0, most)
        holes = told.column("holes", "i", sum(count), 0, most - 1)
        fars = told.column("fars", "d", sum(count), -LARGEST, LARGEST)
        aged = told.real("aged", -LARGEST, LARGEST)
        for hole, values in enumerate(told.listed("spread", len(self.spread))):
            if values is not None:
                fresh = self.spread[hole] = self._new_values()
                fresh.restore(values, f"field H, hole {hole}")
        self._fading.restore(told)
        self._aged, k = aged, 0
        for node in range(nodes):
            trails = dict(zip(holes[k : k + count[node]], fars[k : k + count[node]], strict=True))
            if len(trails) < count[node]:
                raise told.fault("holes", holes[k : k + count[node]].tolist(), "each hole once at a node")
            self._replace(node, trails)
            k += count[node]

    def frame(self) -> Iterable[Write]:
        """H of every hole at every node where there is a trail."""
        if self._spreads:
            found = [
                Write(node, hole, value)
                for hole, values in enumerate(self.spread)
                if values is not None
                for node, value in values.items()
                if value >= LEAST
            ]
            found.sort()
            return found
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
            if value > 0.0 and 0 <= node < len(self._start) and 0 <= hole < len(self._best) and self._spreads:
                self._write(node, hole, value)
            elif value > 0.0 and 0 <= node < len(self._start) and 0 <= hole < len(self._best):
                self._replace(node, self._trails(node) | {hole: -log(value) - self._age()})

    def wipe(self, nodes: Iterable[int]) -> None:
        """Takes away the trails on some nodes."""
        found = each_node(nodes, len(self._start))
        for values in self.spread:
            if values is not None:
                values.wipe(found)
        for node in found:
            self._count[node] = 0

    def settle(self) -> None:
        """See `Marks.settle`."""
        for values in self.spread:
            if values is not None:
                values.settle()
