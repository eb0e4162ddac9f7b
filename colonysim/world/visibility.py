# cython: boundscheck=False, wraparound=False, initializedcheck=False, auto_pickle=False
"""Visibility: the nodes, boxes and holes that an agent sees from a node, and shortest-path searches among them.

All is kept in flat arrays. Searches never clear them: each has a sequence number, and a node counts as reached if it
carries that of the search under way. So a search costs what lies within the radius, however large the place is.
"""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

from colonysim.world.neighbourhoods import neighbourhoods

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from colonysim.scenario.scenario import Hole, Scenario
    from colonysim.world.state import World

__all__ = ["Visibility"]

ROOM = 1 << 20
"""If there are more pairs of a node and a hole near it, the pairs are not stored: each query looks at all holes."""
DIAGONAL = 0.7071067811865475
"""1 / sqrt(2), for the octagonal norm."""
SHORT = 1.0 - 1e-9
"""Makes the estimate of A* a little less than the true distance, whatever is lost by rounding."""


class Visibility:
    """The nodes and boxes that are visible from one node at a time, and searches among them.

    A node is visible if it lies within the detection radius R or is a neighbour. Most methods take the node to look
    from; what is visible from it is kept until another node is asked about.

    Args:
        scenario: Its topology, detection radius, holes and rules.
        radius: Another detection radius R, graph units.

    Attributes:
        neighbourhoods: For each node the nodes within R.
        lengths: Length of each edge, graph units; searches go by them.
        shortest: No edge is shorter.
        guide: Factor of the straight line in the estimate of A*: what is left of a way is at least so long.
        found: Nodes that `around` has written, or an agent's view by way of `World.exits`.
        hole_node: The node of each hole.
        hole_keys: Keys of holes; `find_holes` says where those near a node begin.
        holes_start: The index in `hole_keys` of the first hole that `find_holes` has found.
    """

    holes_kept: bool
    holes_first: array[int]
    hole_keys: array[int]

    def __init__(self, scenario: Scenario, radius: float | None = None) -> None:
        topology = scenario.topology
        radius = scenario.detection_radius if radius is None else radius
        size, self.neighbourhoods = len(topology), neighbourhoods(topology, radius)
        self.size, self.guide = size, SHORT
        self.first, self.ends, self.lengths, _ = topology.edges
        self.shortest = min(topology.edges.lengths, default=0.0)
        self.own_lengths, self.own_shortest = self.lengths, self.shortest
        # At most so many nodes are visible from a node; no way and no queue of a search is longer.
        most = self.neighbourhoods.most + topology.most_neighbours
        # The nodes within R of `centre` are `near[at]` to `near[at + within - 1]`. All that are visible from `watch`
        # carry the sequence number `look` in `seen`.
        self.centre, self.at, self.within = -1, 0, 0
        self.watch, self.look = -1, 0
        self.scratch, self.seen = array("i", bytes(4 * most)), array("q", bytes(8 * size))
        self.found = array("i", bytes(4 * most))
        self.near = self.neighbourhoods.nodes if self.neighbourhoods.kept else self.scratch
        self.fill_holes(scenario.holes)
        # A search: for each node the length of the shortest way so far, in graph units, and the node before it on that
        # way (in `nearest_box` the first node of the way). `reached`, `done` and `wanted` hold sequence numbers.
        self.search = self.waiting = 0
        self.far, self.via = array("d", bytes(8 * size)), array("i", bytes(4 * size))
        self.stand = array("d", bytes(8 * size))
        self.reached, self.done, self.wanted = (array("q", bytes(8 * size)) for _ in range(3))
        room = min(most * topology.most_neighbours, len(self.ends)) + 1
        self.heap_far, self.heap_node = array("d", bytes(8 * room)), array("i", bytes(4 * room))
        self.queue = array("i", bytes(4 * (most + 1)))
        self.left, self.right = array("i", bytes(4 * most)), array("i", bytes(4 * most))

    def bind(self, world: World) -> None:
        """Takes over a world's arrays, which it only reads."""
        self.terrain, self.surface, self.top = world.terrain, world.surface, world.top
        self.rises = world.terrain.rises
        self.box_node, self.box_base, self.box_claim = world.box_node, world.box_base, world.box_claim
        self.stacks, self.hole_at = world.stacks, world.hole_at

    def measure_truly(self) -> None:
        """Has searches go by the true lengths again, after others were put in their place."""
        self.lengths, self.shortest, self.guide = self.own_lengths, self.own_shortest, SHORT

    # -- what is near ----------------------------------------------------------------------------------------------

    def gather(self, node: int) -> None:
        """Finds the nodes within R of `node`, unless they are known already."""
        if node == self.centre:
            return
        self.centre = node
        if self.neighbourhoods.kept:
            self.at = self.neighbourhoods.first[node]
            self.within = self.neighbourhoods.first[node + 1] - self.at
        else:
            self.within = self.neighbourhoods.gather(node, self.scratch)

    def look_from(self, node: int) -> None:
        """Finds the nodes that are visible from `node` and those within R of it, unless they are known already."""
        self.gather(node)
        if node == self.watch:
            return
        self.watch = node
        self.look += 1
        look = self.look
        for k in range(self.at, self.at + self.within):
            self.seen[self.near[k]] = look
        for edge in range(self.first[node], self.first[node + 1]):
            self.seen[self.ends[edge]] = look

    def sees(self, node: int, other: int) -> bool:
        """Whether the node `other` is visible from `node`."""
        if not 0 <= other < self.size:
            return False
        if node == self.watch:
            return self.seen[other] == self.look
        return self.neighbourhoods.both(node, other) or self.terrain.edge(node, other) >= 0

    def sees_box(self, node: int) -> bool:
        """Whether any box lies within R of `node`."""
        self.gather(node)
        k, last = self.at, self.at + self.within
        while k < last and self.top[self.near[k]] < 0:
            k += 1
        return k < last

    def boxes(self, node: int) -> list[int]:
        """The boxes within R of `node`, ascending."""
        self.gather(node)
        found: list[int] = []
        for k in range(self.at, self.at + self.within):
            if self.top[self.near[k]] >= 0:
                found += self.stacks[self.near[k]]
        found.sort()
        return found

    def holes(self, node: int) -> tuple[int, ...]:
        """The keys of the holes within R of `node`, ascending."""
        count = self.find_holes(node)
        return tuple([self.hole_keys[k] for k in range(self.holes_start, self.holes_start + count)])

    def find_holes(self, node: int) -> int:
        """The number of holes within R of `node`; their keys, ascending, are `hole_keys[holes_start]` and the next."""
        if self.holes_kept:
            self.holes_start = self.holes_first[node]
            return self.holes_first[node + 1] - self.holes_start
        count = self.holes_start = 0
        for key in range(len(self.hole_node)):
            if self.neighbourhoods.both(node, self.hole_node[key]):
                self.hole_keys[count] = key
                count += 1
        return count

    def fill_holes(self, holes: Sequence[Hole]) -> None:
        """Stores for every node the keys of the holes within R, unless these are more than `ROOM` altogether."""
        self.hole_node, self.holes_start, self.holes_kept = array("i", [hole.node for hole in holes]), 0, True
        self.holes_first, found, total = array("i", bytes(4 * self.size + 4)), self.scratch, 0
        filled = array("i", bytes(4 * self.size + 4))
        for key in range(len(self.hole_node)):
            count = self.neighbourhoods.gather(self.hole_node[key], found)
            total += count
            if total > ROOM:
                self.holes_kept, self.hole_keys = False, array("i", bytes(4 * len(self.hole_node)))
                return
            for k in range(count):
                filled[found[k] + 1] += 1
        for node in range(self.size):
            filled[node + 1] += filled[node]
            self.holes_first[node + 1] = filled[node + 1]
        self.hole_keys = array("i", bytes(4 * total))
        for key in range(len(self.hole_node)):
            for k in range(self.neighbourhoods.gather(self.hole_node[key], found)):
                node = found[k]
                self.hole_keys[filled[node]] = key
                filled[node] += 1

    def around(self, node: int) -> int:
        """Writes nodes around `node` into `found`, in no order; returns how many there are.

        These are its neighbours, those of their neighbours that are visible, and the nodes of boxes and holes within R.
        """
        self.look_from(node)
        look, count = self.look, 0
        self.search += 1
        for edge in range(self.first[node], self.first[node + 1]):
            i = self.ends[edge]
            if self.reached[i] != self.search:
                self.reached[i], self.found[count] = self.search, i
                count += 1
            for onward in range(self.first[i], self.first[i + 1]):
                j = self.ends[onward]
                if self.seen[j] == look and self.reached[j] != self.search:
                    self.reached[j], self.found[count] = self.search, j
                    count += 1
        for k in range(self.at, self.at + self.within):
            j = self.near[k]
            if (self.top[j] >= 0 or self.hole_at[j] >= 0) and self.reached[j] != self.search:
                self.reached[j], self.found[count] = self.search, j
                count += 1
        return count

    # -- ways ------------------------------------------------------------------------------------------------------

    def pushes(self, node: int, box: int, barred: int, found: array[int]) -> int:
        """Writes the neighbours of a box that it could be pushed to, its pusher staying level with it, into `found`.

        Args:
            node: Where the agent stands; the neighbours have to be visible from there.
            box: The box.
            barred: A node to leave out, or -1.
            found: Has room for all neighbours of the box.

        Returns:
            How many there are.
        """
        self.look_from(node)
        at, base, count = self.box_node[box], self.box_base[box], 0
        for edge in range(self.first[at], self.first[at + 1]):
            j = self.ends[edge]
            if j == barred or self.seen[j] != self.look:
                continue
            if self.terrain.slides(base, edge) and self.terrain.leads(base, edge):
                found[count] = j
                count += 1
        return count

    def nearest_box(
        self,
        agent: int,
        node: int,
        level: float,
        shunned: int,
        barred: int,
        others: Collection[int] = (),
        past: bool = False,
        missed: bytearray | None = None,
    ) -> tuple[int, int]:
        """The closest box by path that an agent at height `level` on `node` could hold (paper Algorithm 4).

        Of several at the same distance it is the one on the node with the lowest index, and of several ways to that
        node the one with the lowest first node.

        Args:
            agent: Which agent.
            node: Where it stands.
            level: The height at which it stands, graph units.
            shunned: A box to leave out, or -1.
            barred: A node that no way may lead over, or -1.
            others: More boxes to leave out.
            past: Whether ways may lead over the nodes of boxes that the agent could take hold of.
            missed: For each box 1 if the agent does not see it; None if it sees all.

        Returns:
            The box and the first node on the way to it, which is the box's own if it is adjacent or underfoot; or
            twice -1.
        """
        self.gather(node)
        self.search += 1
        search, left = self.search, 0
        for k in range(self.at, self.at + self.within):
            at = self.near[k]
            box = self.top[at]
            if box >= 0 and box != shunned and (missed is None or not missed[box]):
                claim = self.box_claim[box]
                if (claim == -1 or claim == agent) and (at == node or self.graspable(at, node, level, past)):
                    self.wanted[at] = search
                    left += 1
        for box in others:
            at = self.box_node[box] if 0 <= box < len(self.box_node) else -1
            if at >= 0 and self.top[at] == box and self.wanted[at] == search:
                self.wanted[at] = 0
                left -= 1
        if left == 0:
            return -1, -1
        if self.wanted[node] == search and self.terrain.is_level(self.box_base[self.top[node]] - level):
            return self.top[node], node
        self.look_from(node)
        best, best_node, best_first = 0.0, -1, -1
        # A queue, first in, first out, to which a node returns whenever a shorter way to it is found: with few visible
        # nodes at mostly equal distances that is faster than a heap.
        room = len(self.queue)
        self.queue[0], head, tail = node, 0, 1
        self.far[node], self.via[node], self.reached[node], self.stand[node] = 0.0, -1, search, level
        while head != tail:
            i = self.queue[head]
            head = head + 1 if head + 1 < room else 0
            self.done[i] = 0
            far, first = self.far[i], self.via[i]
            if best_node >= 0 and far + self.shortest > best:
                continue
            here = self.stand[i]
            for edge in range(self.first[i], self.first[i + 1]):
                j = self.ends[edge]
                if self.seen[j] != self.look:
                    continue
                through, step = far + self.lengths[edge], j if i == node else first
                if best_node >= 0 and through > best:
                    continue
                if (
                    self.wanted[j] == search
                    and self.terrain.is_level(self.box_base[self.top[j]] - here - self.rises[edge])
                    and (best_node < 0 or through < best or j < best_node or (j == best_node and step < best_first))
                ):
                    best, best_node, best_first = through, j, step
                if j == barred or (best_node >= 0 and through + self.shortest > best):
                    continue
                if self.reached[j] == search and (
                    through > self.far[j] or (through == self.far[j] and step >= self.via[j])
                ):
                    continue  # it is known to be no farther by another way
                there = self.surface[j]
                if not self.terrain.leads(here, edge):
                    if not past or not self.takes(agent, here, edge, missed):
                        continue
                    there = self.box_base[self.top[j]]
                self.far[j], self.via[j], self.reached[j], self.stand[j] = through, step, search, there
                if self.done[j] != search:
                    self.done[j], self.queue[tail] = search, j
                    tail = tail + 1 if tail + 1 < room else 0
        return (-1 if best_node < 0 else self.top[best_node]), best_first

    def takes(self, agent: int, level: float, edge: int, missed: bytearray | None) -> bool:
        """Whether an agent at height `level` could take hold of the topmost box at the end of an edge."""
        box = self.top[self.ends[edge]]
        if box < 0 or (missed is not None and missed[box]):
            return False
        claim = self.box_claim[box]
        if claim != -1 and claim != agent:
            return False
        return self.terrain.is_level(self.box_base[box] - level - self.rises[edge])

    def graspable(self, at: int, node: int, level: float, past: bool) -> bool:
        """Whether the topmost box on `at` is level with any neighbouring node; one that has sunk into a hole is not.

        Args:
            at: The box's node.
            node: The node where the agent stands.
            level: The height at which it stands, graph units.
            past: Whether it is enough to be level with the underside of a box on a neighbouring node.
        """
        base = self.box_base[self.top[at]]
        for edge in range(self.first[at], self.first[at + 1]):
            i = self.ends[edge]
            here = level if i == node else self.surface[i]
            if self.terrain.is_level(base - here + self.rises[edge]):
                return True
            box = self.top[i] if past else -1
            if box >= 0 and self.terrain.is_level(base - self.box_base[box] + self.rises[edge]):
                return True
        return False

    def way_to(
        self, node: int, box: int, end: int, barred: int, avoided: Collection[tuple[int, int]]
    ) -> tuple[int, ...]:
        """The nodes of the shortest way over which a box could be pushed to a node; empty if there is none.

        Of several of the same length it is the lexicographically first. The search is A*.

        Args:
            node: Where the agent stands; all nodes of the way are visible from there.
            box: The box.
            end: Where the box is to go.
            barred: A node that the way may not lead over, or -1.
            avoided: Pushes (from, to) that the way shall do without.
        """
        self.look_from(node)
        at, base = self.box_node[box], self.box_base[box]
        if at == end:
            return ()
        search = self.start(at, self.ahead(at, end))
        while self.waiting:
            i = self.heap_node[0]
            far = self.far[i]
            self.pop()
            if i == end:
                return self.traced(i)
            if self.done[i] == search:
                continue
            self.done[i] = search
            here = base if i == at else self.surface[i]
            for edge in range(self.first[i], self.first[i + 1]):
                j = self.ends[edge]
                if self.seen[j] != self.look or self.done[j] == search or j == barred:
                    continue
                if not self.terrain.slides(here, edge):
                    continue
                if (j != end and not self.terrain.leads(here, edge)) or (avoided and (i, j) in avoided):
                    continue
                through = far + self.lengths[edge]
                if self.reached[j] != search or through < self.far[j]:
                    self.offer(through, self.ahead(j, end), j, i)
                elif through == self.far[j] and self.earlier(i, self.via[j], j):
                    self.via[j] = i
        return ()

    def earlier(self, i: int, k: int, j: int) -> bool:
        """Whether the way to j over i comes lexicographically before the way to j over k."""
        n, m = self.trace(i, self.left), self.trace(k, self.right)
        for step in range(min(n, m)):
            if self.left[step] != self.right[step]:
                return self.left[step] < self.right[step]
        return j < self.right[n] if n < m else self.left[m] < j

    def traced(self, node: int) -> tuple[int, ...]:
        """The nodes of the way that the search has found to a node, as a tuple."""
        return tuple([self.left[place] for place in range(self.trace(node, self.left))])

    def trace(self, node: int, way: array[int]) -> int:
        """Writes the nodes of the way that the search has found to a node into `way`; returns how many."""
        count, i = 1, node
        while self.via[i] >= 0:
            i = self.via[i]
            count += 1
        i = node
        for place in range(count - 1, -1, -1):
            way[place] = i
            i = self.via[i]
        return count

    # -- the binary heap of `way_to`, ordered by (distance + estimate, node) -----------------------------------------

    def ahead(self, i: int, j: int) -> float:
        """A lower bound of the distance of two nodes, graph units: the octagonal norm is below the Euclidean one.

        It is a little too small, so that of several ways of the same length all are known when their end is taken.
        """
        dx = abs(self.neighbourhoods.x[i] - self.neighbourhoods.x[j])
        dy = abs(self.neighbourhoods.y[i] - self.neighbourhoods.y[j])
        most, both = max(dx, dy), DIAGONAL * (dx + dy)
        return self.guide * max(most, both)

    def start(self, node: int, ahead: float) -> int:
        """Begins a search at a node; returns the search's sequence number."""
        self.search += 1
        self.waiting = 0
        self.offer(0.0, ahead, node, -1)
        return self.search

    def offer(self, far: float, ahead: float, node: int, via: int) -> None:
        """Pushes a node onto the heap.

        Args:
            far: The length of the way to it, graph units.
            ahead: The least that is left from there.
            node: The node.
            via: The node before it on that way, or -1.
        """
        self.far[node], self.via[node], self.reached[node] = far, via, self.search
        far += ahead
        place = self.waiting
        self.waiting += 1
        while place > 0:
            above = (place - 1) // 2
            if self.heap_far[above] < far or (self.heap_far[above] == far and self.heap_node[above] <= node):
                break
            self.heap_far[place], self.heap_node[place] = self.heap_far[above], self.heap_node[above]
            place = above
        self.heap_far[place], self.heap_node[place] = far, node

    def pop(self) -> None:
        """Removes the first node from the heap."""
        self.waiting -= 1
        count, place = self.waiting, 0
        far, node = self.heap_far[count], self.heap_node[count]
        below = 1
        while below < count:
            if below + 1 < count and (
                self.heap_far[below + 1] < self.heap_far[below]
                or (
                    self.heap_far[below + 1] == self.heap_far[below]
                    and self.heap_node[below + 1] < self.heap_node[below]
                )
            ):
                below += 1
            if far < self.heap_far[below] or (far == self.heap_far[below] and node <= self.heap_node[below]):
                break
            self.heap_far[place], self.heap_node[place] = self.heap_far[below], self.heap_node[below]
            place = below
            below = 2 * place + 1
        self.heap_far[place], self.heap_node[place] = far, node
