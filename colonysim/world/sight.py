# cython: boundscheck=False, wraparound=False, initializedcheck=False
"""What can be seen from a node, and the ways within: searches over flat arrays that cost what lies near.

What a search has reached carries its number, so that nothing has to be cleared before the next one. Installation
compiles this file where there is a C compiler (`hatch_build.py`); `sight.pxd` says what its variables are then.
"""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

from colonysim.world.near import near

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from colonysim.scenario.scenario import Hole, Scenario
    from colonysim.world.state import World

__all__ = ["Sight"]

ROOM = 1 << 20
"""Holes near nodes that come to more than this are not noted but looked for."""
DIAGONAL = 0.7071067811865475
SHORT = 1.0 - 1e-9


class Sight:
    """The nodes and boxes within the detection radius of one node at a time, and searches among them.

    Args:
        scenario: Its place, radius and rules.
    """

    holes_kept: bool
    holes_first: array[int]
    hole_keys: array[int]

    def __init__(self, scenario: Scenario) -> None:
        topology = scenario.topology
        size, self.surroundings = len(topology), near(topology, scenario.detection_radius)
        self.size = size
        self.first, self.ends, self.lengths, self.rises = topology.edges
        self.shortest = min(topology.edges.lengths, default=0.0)
        # Nothing that is seen from a node is more than this: neither a queue nor a way nor what lies around.
        most = self.surroundings.most + topology.most_neighbours
        # Where we look from, and what is seen from there: first the nodes within the radius, those in `near` from `at`
        # on, then other neighbours.
        self.centre, self.look, self.at, self.within = -1, 0, 0, 0
        self.scratch, self.seen = array("i", bytes(4 * most)), array("q", bytes(8 * size))
        self.found = array("i", bytes(4 * most))
        self.near = self.surroundings.nodes if self.surroundings.kept else self.scratch
        self.fill_holes(scenario.holes)
        # The search: for each node how far it is, and by which node one comes there (or which step was the first).
        self.search = self.waiting = 0
        self.far, self.via = array("d", bytes(8 * size)), array("i", bytes(4 * size))
        self.stand = array("d", bytes(8 * size))
        self.reached, self.done, self.wanted = (array("q", bytes(8 * size)) for _ in range(3))
        room = min(most * topology.most_neighbours, len(self.ends)) + 1
        self.heap_far, self.heap_node = array("d", bytes(8 * room)), array("i", bytes(4 * room))
        self.queue = array("i", bytes(4 * (most + 1)))
        self.left, self.right = array("i", bytes(4 * most)), array("i", bytes(4 * most))

    def bind(self, world: World) -> None:
        """Reads a world's arrays from now on."""
        self.terrain, self.surface, self.top = world.terrain, world.surface, world.top
        self.box_node, self.box_base, self.box_claim = world.box_node, world.box_base, world.box_claim
        self.stacks, self.hole_at = world.stacks, world.hole_at

    # -- what is near ----------------------------------------------------------------------------------------------

    def turn(self, node: int) -> None:
        """Looks from `node`."""
        if node == self.centre:
            return
        self.centre = node
        self.look += 1
        near, seen, look = self.near, self.seen, self.look
        if self.surroundings.kept:
            self.at = self.surroundings.first[node]
            self.within = self.surroundings.first[node + 1] - self.at
        else:
            self.within = self.surroundings.gather(node, self.scratch)
        for k in range(self.at, self.at + self.within):
            seen[near[k]] = look
        for way in range(self.first[node], self.first[node + 1]):
            seen[self.ends[way]] = look

    def sees(self, node: int, other: int) -> bool:
        """Whether a node lies within the radius of `node` or next to it."""
        self.turn(node)
        return 0 <= other < self.size and self.seen[other] == self.look

    def sees_box(self, node: int) -> bool:
        """Whether any box lies within the radius of `node`."""
        self.turn(node)
        k, last = self.at, self.at + self.within
        while k < last and self.top[self.near[k]] < 0:
            k += 1
        return k < last

    def boxes(self, node: int) -> list[int]:
        """The boxes within the radius of `node`, ascending."""
        self.turn(node)
        found: list[int] = []
        for k in range(self.at, self.at + self.within):
            if self.top[self.near[k]] >= 0:
                found += self.stacks[self.near[k]]
        found.sort()
        return found

    def holes(self, node: int) -> tuple[int, ...]:
        """The keys of the holes within the radius of `node`, ascending."""
        count = self.look_for_holes(node)
        return tuple([self.hole_keys[k] for k in range(self.holes_at, self.holes_at + count)])

    def look_for_holes(self, node: int) -> int:
        """How many holes lie within the radius of `node`; their keys stand in `hole_keys` from `holes_at` on."""
        if self.holes_kept:
            self.holes_at = self.holes_first[node]
            return self.holes_first[node + 1] - self.holes_at
        count = self.holes_at = 0
        for key in range(len(self.hole_nodes)):
            if self.surroundings.both(node, self.hole_nodes[key]):
                self.hole_keys[count] = key
                count += 1
        return count

    def fill_holes(self, holes: Sequence[Hole]) -> None:
        """Notes for every node the holes near it, unless that comes to more than `ROOM`."""
        self.hole_nodes, self.holes_at, self.holes_kept = array("i", [hole.node for hole in holes]), 0, True
        self.holes_first, found, total = array("i", bytes(4 * self.size + 4)), self.scratch, 0
        filled = array("i", bytes(4 * self.size + 4))
        for key in range(len(self.hole_nodes)):
            count = self.surroundings.gather(self.hole_nodes[key], found)
            total += count
            if total > ROOM:
                self.holes_kept, self.hole_keys = False, array("i", bytes(4 * len(self.hole_nodes)))
                return
            for k in range(count):
                filled[found[k] + 1] += 1
        for node in range(self.size):
            filled[node + 1] += filled[node]
            self.holes_first[node + 1] = filled[node + 1]
        self.hole_keys = array("i", bytes(4 * total))
        for key in range(len(self.hole_nodes)):
            for k in range(self.surroundings.gather(self.hole_nodes[key], found)):
                node = found[k]
                self.hole_keys[filled[node]] = key
                filled[node] += 1

    def around(self, node: int) -> int:
        """Writes the neighbours of `node`, theirs in sight, and the nodes of boxes and holes near into `found`.

        Returns how many there are; they come in no order.
        """
        self.turn(node)
        look, found, count = self.look, self.found, 0
        self.search += 1
        for way in range(self.first[node], self.first[node + 1]):
            i = self.ends[way]
            if self.reached[i] != self.search:
                self.reached[i], found[count] = self.search, i
                count += 1
            for onward in range(self.first[i], self.first[i + 1]):
                j = self.ends[onward]
                if self.seen[j] == look and self.reached[j] != self.search:
                    self.reached[j], found[count] = self.search, j
                    count += 1
        for k in range(self.at, self.at + self.within):
            j = self.near[k]
            if (self.top[j] >= 0 or self.hole_at[j] >= 0) and self.reached[j] != self.search:
                self.reached[j], found[count] = self.search, j
                count += 1
        return count

    # -- ways ------------------------------------------------------------------------------------------------------

    def pushes(self, node: int, box: int, barred: int, found: array[int]) -> int:
        """Writes the nodes in sight of `node` that a box there could be pushed to, its pusher going with it.

        Returns how many there are.
        """
        self.turn(node)
        at, base, count = self.box_node[box], self.box_base[box], 0
        for way in range(self.first[at], self.first[at + 1]):
            j = self.ends[way]
            if j == barred or self.seen[j] != self.look:
                continue
            if self.terrain.slides(base, way) and self.terrain.leads(base, way):
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
    ) -> tuple[int, int]:
        """The closest box by path that an agent at height `level` on `node` could hold (paper Algorithm 4).

        Of ways of one length that to the node of the lower number goes first, of these the one with the lower first
        step.

        Args:
            agent: Which agent.
            node: Where it stands.
            level: At which height.
            shunned: A box to leave out, or -1.
            barred: A node that no way may lead over, or -1.
            others: More boxes to leave out.
            past: Whether ways may lead past boxes that the agent could take hold of: over their nodes.

        Returns:
            The box and the first node on the way to it, which is the box's own if it is adjacent or underfoot; or
            twice -1.
        """
        self.turn(node)
        self.search += 1
        search, top, wanted, left = self.search, self.top, self.wanted, 0
        for k in range(self.at, self.at + self.within):
            at = self.near[k]
            box = top[at]
            if box >= 0 and box != shunned:
                claim = self.box_claim[box]
                if (claim == -1 or claim == agent) and (at == node or self.graspable(at, node, level, past)):
                    wanted[at] = search
                    left += 1
        for box in others:
            if 0 <= box < len(self.box_node) and top[self.box_node[box]] == box:
                at = self.box_node[box]
                if wanted[at] == search:
                    wanted[at] = 0
                    left -= 1
        if left == 0:
            return -1, -1
        if wanted[node] == search and self.terrain.is_level(self.box_base[top[node]] - level):
            return top[node], node
        best, best_node, best_first = 0.0, -1, -1
        # First come, first served, and again whenever a better way has come up: with the few nodes in sight, mostly
        # at equal distances, that is faster than a heap.
        queue, room = self.queue, len(self.queue)
        queue[0], head, tail = node, 0, 1
        self.far[node], self.via[node], self.reached[node], self.stand[node] = 0.0, -1, search, level
        while head != tail:
            i = queue[head]
            head = head + 1 if head + 1 < room else 0
            self.done[i] = 0
            far, first = self.far[i], self.via[i]
            if best_node >= 0 and far + self.shortest > best:
                continue
            here = self.stand[i]
            for way in range(self.first[i], self.first[i + 1]):
                j = self.ends[way]
                if self.seen[j] != self.look:
                    continue
                through, step = far + self.lengths[way], j if i == node else first
                if best_node >= 0 and through > best:
                    continue
                if (
                    wanted[j] == search
                    and self.terrain.is_level(self.box_base[top[j]] - here - self.rises[way])
                    and (best_node < 0 or through < best or j < best_node or (j == best_node and step < best_first))
                ):
                    best, best_node, best_first = through, j, step
                if j == barred or (best_node >= 0 and through + self.shortest > best):
                    continue
                there = self.surface[j]
                if not self.terrain.leads(here, way):
                    if not past or not self.takes(agent, here, way):
                        continue
                    there = self.box_base[top[j]]
                if (
                    self.reached[j] != search
                    or through < self.far[j]
                    or (through == self.far[j] and step < self.via[j])
                ):
                    self.far[j], self.via[j], self.reached[j], self.stand[j] = through, step, search, there
                    if self.done[j] != search:
                        self.done[j], queue[tail] = search, j
                        tail = tail + 1 if tail + 1 < room else 0
        return (-1 if best_node < 0 else top[best_node]), best_first

    def takes(self, agent: int, level: float, way: int) -> bool:
        """Whether an agent that stands at height `level` could take hold of the box on top at the end of a way."""
        box = self.top[self.ends[way]]
        if box < 0:
            return False
        claim = self.box_claim[box]
        if claim != -1 and claim != agent:
            return False
        return self.terrain.is_level(self.box_base[box] - level - self.rises[way])

    def graspable(self, at: int, node: int, level: float, past: bool) -> bool:
        """Whether the box on top of `at` is level with a neighbouring node: one that has sunk into a hole is not.

        With `past` it may be level with a box there instead.
        """
        base = self.box_base[self.top[at]]
        for way in range(self.first[at], self.first[at + 1]):
            i = self.ends[way]
            here = level if i == node else self.surface[i]
            if self.terrain.is_level(base - here + self.rises[way]):
                return True
            box = self.top[i] if past else -1
            if box >= 0 and self.terrain.is_level(base - self.box_base[box] + self.rises[way]):
                return True
        return False

    def way_to(
        self, node: int, box: int, end: int, barred: int, avoided: Collection[tuple[int, int]]
    ) -> tuple[int, ...]:
        """The shortest way over which a box could be pushed to a node, all in sight of `node`; or empty.

        Of ways of one length it is the one whose nodes come first in order.

        Args:
            node: Where the agent stands.
            box: The box.
            end: Where the box is to go.
            barred: A node that the way may not lead over, or -1.
            avoided: Pushes (from, to) that the way shall do without.
        """
        self.turn(node)
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
            for way in range(self.first[i], self.first[i + 1]):
                j = self.ends[way]
                if self.seen[j] != self.look or self.done[j] == search or j == barred:
                    continue
                if not self.terrain.slides(here, way):
                    continue
                if (j != end and not self.terrain.leads(here, way)) or (avoided and (i, j) in avoided):
                    continue
                through = far + self.lengths[way]
                if self.reached[j] != search or through < self.far[j]:
                    self.offer(through, self.ahead(j, end), j, i)
                elif through == self.far[j] and self.earlier(i, self.via[j], j):
                    self.via[j] = i
        return ()

    def earlier(self, i: int, k: int, j: int) -> bool:
        """Whether of two ways to j that by i comes before that by k, node by node."""
        left, right = self.left, self.right
        n, m = self.trace(i, left), self.trace(k, right)
        for step in range(min(n, m)):
            if left[step] != right[step]:
                return left[step] < right[step]
        return j < right[n] if n < m else left[m] < j

    def traced(self, node: int) -> tuple[int, ...]:
        """The nodes of the way to a node that the search has found."""
        return tuple([self.left[place] for place in range(self.trace(node, self.left))])

    def trace(self, node: int, way: array[int]) -> int:
        """Writes the nodes of the way to a node, which the search has found, into `way`; returns how many."""
        count, i = 1, node
        while self.via[i] >= 0:
            i = self.via[i]
            count += 1
        i = node
        for place in range(count - 1, -1, -1):
            way[place] = i
            i = self.via[i]
        return count

    # -- what the search for a way runs on -----------------------------------------------------------------------------

    def ahead(self, i: int, j: int) -> float:
        """A little less than what is at least left to go between two nodes: an octagon's norm is below Euclid's.

        By that little, nodes on ways of one length come before the node where these meet (A*).
        """
        dx = abs(self.surroundings.x[i] - self.surroundings.x[j])
        dy = abs(self.surroundings.y[i] - self.surroundings.y[j])
        most, both = max(dx, dy), DIAGONAL * (dx + dy)
        return SHORT * max(most, both)

    def start(self, node: int, ahead: float) -> int:
        """Begins a search at a node; returns its number."""
        self.search += 1
        self.waiting = 0
        self.offer(0.0, ahead, node, -1)
        return self.search

    def offer(self, far: float, ahead: float, node: int, via: int) -> None:
        """Notes how far a node is, and lets it wait for its turn; `ahead` is at least left to go."""
        self.far[node], self.via[node], self.reached[node] = far, via, self.search
        far += ahead
        heap_far, heap_node, place = self.heap_far, self.heap_node, self.waiting
        self.waiting += 1
        while place > 0:
            above = (place - 1) // 2
            if heap_far[above] < far or (heap_far[above] == far and heap_node[above] <= node):
                break
            heap_far[place], heap_node[place] = heap_far[above], heap_node[above]
            place = above
        heap_far[place], heap_node[place] = far, node

    def pop(self) -> None:
        """Takes the nearest node, of equally near ones that of the lowest number, from those that wait."""
        self.waiting -= 1
        heap_far, heap_node, count, place = self.heap_far, self.heap_node, self.waiting, 0
        far, node = heap_far[count], heap_node[count]
        below = 1
        while below < count:
            if below + 1 < count and (
                heap_far[below + 1] < heap_far[below]
                or (heap_far[below + 1] == heap_far[below] and heap_node[below + 1] < heap_node[below])
            ):
                below += 1
            if far < heap_far[below] or (far == heap_far[below] and node <= heap_node[below]):
                break
            heap_far[place], heap_node[place] = heap_far[below], heap_node[below]
            place = below
            below = 2 * place + 1
        heap_far[place], heap_node[place] = far, node
