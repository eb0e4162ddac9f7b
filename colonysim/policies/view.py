"""The local view: all that an agent may know, as a read-only window onto the world."""

from __future__ import annotations

from array import array
from math import sqrt
from typing import TYPE_CHECKING, Any

from colonysim.pheromones.hole import HoleTrail
from colonysim.pheromones.marks import Marks, gather_keys
from colonysim.policies.sensing import tag_of

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from colonysim.backends.protocol import Backend, FeasibleWay
    from colonysim.pheromones.field import Field
    from colonysim.policies.sensing import Senses
    from colonysim.world.intents import Intent
    from colonysim.world.state import World
    from colonysim.world.visibility import Visibility

__all__ = ["FieldWindow", "LocalView", "OutOfSightError"]


class OutOfSightError(LookupError):
    """A policy has asked for something that its agent cannot know."""


class FieldWindow:
    """The part of a pheromone field that an agent can read: its own node, its neighbours, the boxes it sees.

    The neighbours of an adjacent box count too: Algorithm 6 looks at them to find the box's holes.
    """

    __slots__ = ("_by_box", "_field", "_gathers", "_marks", "_senses", "_tag", "_view")

    def __init__(self, view: LocalView, field: Field) -> None:
        self._view = view
        self._field = field
        self._by_box = field.by_box
        # A field of this package is called directly by compiled code.
        self._marks = field if isinstance(field, Marks) else None
        # A class derived from it may have other keys.
        self._gathers = self._marks is not None and type(field) is HoleTrail
        self._senses: Senses | None = None  # if they misread marks
        self._tag = 0

    def at(self, node: int, key: int = -1) -> float:
        """The value at a node (and key: the hole), or of a box (`node`) and hole (`key`).

        Raises:
            OutOfSightError: The agent cannot read it from where it stands.
        """
        self._check(node)
        return self.read(node, key)

    def values(self, nodes: Sequence[int]) -> list[float]:
        """The values at several nodes, of a field without keys.

        Raises:
            OutOfSightError: The agent cannot read one of them from where it stands.
        """
        return [self.at(node) for node in nodes]

    def keys(self, node: int) -> Sequence[int]:
        """The keys (holes) that have a value at a node, ascending.

        Raises:
            OutOfSightError: The agent cannot read it from where it stands.
        """
        self._check(node)
        return self._field.keys(node) if self._marks is None else self._marks.keys(node)

    def read(self, node: int, key: int = -1) -> float:
        """`at` without the check, for compiled policies: they ask about nodes that the agent can read only."""
        value = self._field.at(node, key) if self._marks is None else self._marks.at(node, key)
        if self._senses is not None:
            value *= self._senses.factor(self._view._seen_as, self._tag, node, key)
        return value

    def _misread(self, senses: Senses) -> None:
        """From now on values are read as sensors that err read them."""
        self._senses, self._tag = senses, tag_of(self._field.name)

    def gather(self, node: int, found: array[int], count: int, marked: bytearray) -> int:
        """Writes the keys at a node into `found`, behind the first `count`, and marks them; no key that is marked.

        Like `read` it checks nothing.

        Args:
            node: The node.
            found: Has room for all keys.
            count: How many keys stand in `found` already.
            marked: For each key 1 if it is to be left out.

        Returns:
            How many keys stand in `found` then.
        """
        if self._marks is not None and self._gathers:
            return self._marks.gather(node, found, count, marked)
        return gather_keys(self._field.keys(node), found, count, marked)

    def _check(self, node: int) -> None:
        view = self._view
        if self._by_box:
            view.box_node(node)
        elif not view.beside(node) and not view.beside_box(node):
            raise OutOfSightError(f"{self._field.name} of node {node} cannot be read from node {view.node}")


class _Absent:
    """Stands for a field that a policy does not have: reading it is a KeyError."""

    by_box = False

    def __init__(self, name: str) -> None:
        self.name = name

    def at(self, node: int, key: int = -1) -> float:
        raise KeyError(self.name)

    def keys(self, node: int) -> Sequence[int]:
        raise KeyError(self.name)


class LocalView:
    """What one agent may know, read from the world's arrays when asked; one object for each agent, reused.

    That is: terrain, holes, boxes and agents within R; D, E and H on its own node and its neighbours; B of visible
    boxes; reservations on its neighbours; the goal's coordinates; its backend's chance of a push. Everything else
    raises `OutOfSightError`. A node is visible if it lies within R or is a neighbour; nodes are given by index.

    Methods that end in `_into` are those that compiled policies call: they write into a given array what the method
    without that ending returns as a list.

    Attributes:
        agent: The agent's index.
        pushes_boxes: Whether the agent may take hold of boxes and push them.
        d: The readable part of D; to read it is a KeyError if the policy has no such field, as with `b`, `h` and `e`.
        b: The readable part of B.
        h: The readable part of H.
        e: The readable part of E.
        radius: The detection radius R, graph units.
        foresees: Whether the backend can tell about more than the next push.
        edge_seconds: Typical duration of a travelled edge, simulated seconds: the unit in which patience is measured.
        waited: How long the agent has been waiting without a break, in units of `edge_seconds`.
        refused: Its last intent, if a node or edge that it needs was taken, or None.
        failures: The number of its last actions in a row that did not arrive.
        outcome: How its last action came out: "arrived", "blocked" or "failed"; "" before the first of the episode.
        steps: How many steps of the episode it has begun.
        node: Where it stands.
        goal: The goal, whose place every agent knows.
        held_box: The box that it holds and shares the node with, or -1.
    """

    __slots__ = (
        "_backend", "_feasible_way", "_fields", "_missed", "_overlooked", "_seen_as", "_senses", "_windows", "_world",
        "agent", "b", "d", "e", "edge_seconds", "failures", "foresees", "goal", "h", "held_box", "node", "outcome",
        "pushes_boxes", "radius", "refused", "steps", "waited",
    )  # fmt: skip

    d: FieldWindow
    b: FieldWindow
    h: FieldWindow
    e: FieldWindow

    def __init__(self, world: World, fields: Mapping[str, Field], backend: Backend, agent: int) -> None:
        self._world = world
        self._backend = backend
        self._feasible_way: FeasibleWay | None = getattr(backend, "feasible_way", None)
        self.foresees = self._feasible_way is not None
        self.agent = agent
        self.radius, self.pushes_boxes = world.scenario.detection_radius, True
        for group in world.scenario.groups:
            if agent in group.agents:
                self.radius, self.pushes_boxes = group.detection_radius, group.pushes
        self._senses: Senses | None = None
        self._missed: bytearray | None = None  # for each box 1 if it is not seen in this look, if any may be missed
        # The number of the look under way, by which sensors err, and how many boxes within R are not seen in it.
        self._seen_as = self._overlooked = 0
        self._fields = fields
        self._windows: dict[str, FieldWindow] | None = None
        self.d, self.b, self.h, self.e = (self._window(name) for name in "DBHE")
        self.edge_seconds = 1.0
        self.waited = 0.0
        self.refused: Intent | None = None
        self.failures = self.steps = 0
        self.outcome = ""
        self.look()

    def __repr__(self) -> str:
        return f"<view of agent {self.agent} from node index {self.node}>"

    def _window(self, name: str) -> FieldWindow:
        absent: Any = _Absent(name)
        return FieldWindow(self, self._fields.get(name, absent))

    @property
    def fields(self) -> dict[str, FieldWindow]:
        """The readable part of each pheromone field, by name; made when first asked for, since most agents never do."""
        if self._windows is None:
            own = {"D": self.d, "B": self.b, "H": self.h, "E": self.e}
            self._windows = {name: own.get(name) or self._window(name) for name in self._fields}
        return self._windows

    def look(self) -> None:
        """Brings the window to where the agent now stands; called by the simulation before each decision."""
        world = self._world
        self.node, self.held_box, self.goal = world.agent_node[self.agent], world.held_box(self.agent), world.goal
        if self._senses is not None:
            self._look_badly(self._senses)

    def _sense_with(self, senses: Senses) -> None:
        """From now on the agent sees and reads with sensors that err."""
        self._senses = senses
        if senses.misses:
            self._missed = bytearray(len(self._world.box_node))
        if senses.misreads:
            for window in {*self.fields.values(), self.d, self.b, self.h, self.e}:
                window._misread(senses)

    def _look_badly(self, senses: Senses) -> None:
        """Begins a look with sensors that err. The box that the agent holds is not missed: it feels that one."""
        self._seen_as = senses.look(self.agent)
        missed = self._missed
        if missed is None:
            return
        self._overlooked = 0
        for box in range(len(missed)):
            missed[box] = 0
        for box in self._world.visibility_of(self.agent).boxes(self.node):
            if box != self.held_box and senses.overlooks(self._seen_as, box):
                missed[box] = 1
                self._overlooked += 1

    def _misses(self, box: int) -> bool:
        """Whether a box within R is not seen in this look."""
        return self._missed is not None and self._missed[box] == 1

    @property
    def steps_left(self) -> float:
        """The steps that it may still begin in this episode, as a share of `max_steps`."""
        most: int = self._world.scenario.max_steps
        return 1.0 - self.steps / most

    @property
    def neighbours(self) -> tuple[int, ...]:
        """The nodes next to the agent's own, ascending."""
        return self._world.topology.neighbours[self.node]

    def beside(self, node: int) -> bool:
        """Whether a node is the agent's own or next to it."""
        return node == self.node or self._world.adjacent(self.node, node)

    # -- the place -------------------------------------------------------------------------------------------------

    def sees(self, node: int) -> bool:
        """Whether a node lies within R or next to the agent."""
        return self._world.visibility_of(self.agent).sees(self.node, node)

    def _look_at(self, node: int) -> None:
        if not self._world.visibility_of(self.agent).sees(self.node, node):
            raise OutOfSightError(f"node {node} is out of sight from node {self.node}")

    def position(self, node: int) -> tuple[float, float]:
        """x, y of a node, graph units; of another than the own one as it seems."""
        self._look_at(node)
        if self._senses is not None and self._senses.misplaces:
            self._senses.place(self._seen_as, node, node == self.node)
            return self._senses.x[node], self._senses.y[node]
        return self._world.topology.x[node], self._world.topology.y[node]

    @property
    def goal_position(self) -> tuple[float, float]:
        """x, y of the goal, which every agent knows."""
        return self._world.topology.x[self.goal], self._world.topology.y[self.goal]

    @property
    def reach(self) -> float:
        """Two surfaces that differ by less than this are level, graph units."""
        return self._world.scenario.reach

    @property
    def lengths(self) -> Sequence[float]:
        """Lengths of the edges to `neighbours`, in their order, as far apart as their ends seem to be."""
        if self._misplaces():
            return [self._apart(self.node, j) for j in self.neighbours]
        return self._world.topology.lengths[self.node]

    def ways(self, node: int) -> Sequence[tuple[int, float]]:
        """The neighbours of a visible node that are visible themselves, with the lengths of the edges."""
        self._look_at(node)
        topology = self._world.topology
        if self._misplaces():
            return [(j, self._apart(node, j)) for j in topology.neighbours[node] if self.sees(j)]
        edges = zip(topology.neighbours[node], topology.lengths[node], strict=True)
        return [(j, length) for j, length in edges if self.sees(j)]

    def _misplaces(self) -> bool:
        """Whether nodes seem to lie elsewhere."""
        return self._senses is not None and self._senses.misplaces

    def _apart(self, i: int, j: int) -> float:
        """How far apart two visible nodes seem to lie, graph units."""
        x, y = self.position(i)
        east, north = self.position(j)
        return sqrt((x - east) * (x - east) + (y - north) * (y - north))

    def _misjudge(self, senses: Senses) -> Visibility:
        """Has the searches among visible nodes go by lengths as they seem; `Visibility.measure_truly` ends that."""
        visibility = self._world.visibility_of(self.agent)
        visibility.look_from(self.node)
        terrain, look = self._world.terrain, visibility.look
        for k in range(visibility.at, visibility.at + visibility.within):
            senses.place(self._seen_as, visibility.near[k], visibility.near[k] == self.node)
        for edge in range(terrain.first[self.node], terrain.first[self.node + 1]):
            senses.place(self._seen_as, terrain.ends[edge], False)
        for k in range(visibility.at, visibility.at + visibility.within):
            self._measure(senses, visibility.near[k], look)
        for edge in range(terrain.first[self.node], terrain.first[self.node + 1]):
            self._measure(senses, terrain.ends[edge], look)
        # Nothing is certain about what is left of a way: it may seem shorter than the straight line.
        visibility.lengths, visibility.shortest, visibility.guide = senses.lengths, 0.0, 0.0
        return visibility

    def _measure(self, senses: Senses, node: int, look: int) -> None:
        """Writes down how long the edges from a visible node to visible nodes seem."""
        visibility, terrain = self._world.visibility_of(self.agent), self._world.terrain
        for edge in range(terrain.first[node], terrain.first[node + 1]):
            j = terrain.ends[edge]
            if visibility.seen[j] == look:
                dx, dy = senses.x[node] - senses.x[j], senses.y[node] - senses.y[j]
                senses.lengths[edge] = sqrt(dx * dx + dy * dy)

    def around(self) -> tuple[int, ...]:
        """The neighbours, their neighbours that are visible, and the nodes of boxes and holes within R, ascending."""
        visibility = self._world.visibility_of(self.agent)
        return tuple(sorted(visibility.found[: visibility.around(self.node)]))

    def passable(self, neighbour: int) -> bool:
        """Whether the agent could travel to a neighbour, as far as the terrain goes."""
        return self._world.passable(self._world.level(self.agent), self.node, neighbour)

    def exits(self) -> list[int]:
        """The neighbours that the agent could travel to and that nobody else occupies or has reserved, ascending."""
        found = self._world.visibility_of(self.agent).found
        return [found[k] for k in range(self._world.exits(self.agent, found))]

    def exits_into(self, found: array[int]) -> int:
        """Writes `exits` into `found`, which must have room for all neighbours; returns how many there are."""
        return self._world.exits(self.agent, found)

    def reachable(self, i: int, j: int) -> bool:
        """Whether the surface of one visible node leads to that of another."""
        self._look_at(i)
        self._look_at(j)
        return self._world.reachable(i, j)

    def free(self, node: int) -> bool:
        """Whether a neighbour (or the own node) is neither occupied nor reserved by somebody else."""
        if not self.beside(node):
            raise OutOfSightError(f"reservations on node {node} cannot be seen from node {self.node}")
        return self._world.free(self.agent, node)

    def occupied(self, node: int) -> bool:
        """Whether another agent stands on a visible node."""
        self._look_at(node)
        return self._world.occupied_by_another(self.agent, node)

    def crowded(self, neighbour: int) -> bool:
        """Whether Algorithm 8 forbids a neighbour: another agent within sight is on it or next to it."""
        world, terrain = self._world, self._world.terrain
        if not world.adjacent(self.node, neighbour):
            raise OutOfSightError(f"node {neighbour} is no neighbour of node {self.node}")
        if world.occupied_by_another(self.agent, neighbour):
            return True
        for edge in range(terrain.first[neighbour], terrain.first[neighbour + 1]):
            k = terrain.ends[edge]
            if world.occupied_by_another(self.agent, k) and self.sees(k):
                return True
        return False

    @property
    def asked_to_clear(self) -> bool:
        """Whether a carrier asks for the node the agent stands on."""
        return self.wanted(self.node)

    def wanted(self, node: int) -> bool:
        """Whether another agent that carries a box asks for a neighbour (or the own node) to be cleared for it."""
        if not self.beside(node):
            raise OutOfSightError(f"requests for node {node} cannot be heard at node {self.node}")
        requests = self._world.clear_requests
        asker = requests.get(node) if requests else None
        return asker is not None and asker != self.agent

    def requested(self) -> bool:
        """Whether `wanted` may be true of the own node or a neighbour; if not, none needs to be asked about."""
        return self._world.requested_near(self.node)

    # -- boxes and holes -------------------------------------------------------------------------------------------

    def boxes(self) -> list[int]:
        """The boxes within R, ascending."""
        if len(self._world.box_node) == 0:
            return []
        found = self._world.visibility_of(self.agent).boxes(self.node)
        return found if not self._overlooked else [box for box in found if not self._misses(box)]

    def box_node(self, box: int) -> int:
        """Where a visible box is."""
        node = self._world.box_node[box] if 0 <= box < len(self._world.box_node) else -1
        if not self.sees(node) or (self._overlooked and self._misses(box)):
            raise OutOfSightError(f"box {box} is out of sight from node {self.node}")
        return node

    def box_height(self, box: int) -> float:
        """How high a visible box is, graph units."""
        self.box_node(box)
        return self._world.box_height[box]

    def on_top(self, box: int) -> bool:
        """Whether no other box stands on a visible box."""
        return self._world.top[self.box_node(box)] == box

    def top_box(self, node: int) -> int:
        """The topmost box on a visible node, or -1."""
        self._look_at(node)
        box = self._world.top[node]
        return -1 if self._overlooked and box >= 0 and self._misses(box) else box

    def boxes_beside(self, found: array[int]) -> int:
        """Writes the neighbours that lie within R and have a box into `found`; returns how many there are."""
        world, terrain, count = self._world, self._world.terrain, 0
        for edge in range(terrain.first[self.node], terrain.first[self.node + 1]):
            j = terrain.ends[edge]
            if self._overlooked and world.top[j] >= 0 and self._misses(world.top[j]):
                continue
            if world.top[j] >= 0 and world.visibility_of(self.agent).neighbourhoods.both(self.node, j):
                found[count] = j
                count += 1
        return count

    def box_at_hand(self) -> bool:
        """Whether there is a box on the own node or next to it."""
        if self._overlooked:
            return len([node for node in (self.node, *self.neighbours) if self.top_box(node) >= 0]) > 0
        return self._world.box_at_hand(self.node)

    def box_in_sight(self) -> bool:
        """Whether there is a box within R."""
        world = self._world
        if self._overlooked:
            return len(self.boxes()) > 0
        return len(world.box_node) > 0 and world.visibility_of(self.agent).sees_box(self.node)

    def beside_box(self, node: int) -> bool:
        """Whether a node is next to a box that stands next to the agent."""
        return self._world.beside_box(self.node, node)

    def graspable_from(self, node: int, box: int) -> bool:
        """Whether the agent, once on a visible node, could take hold of a box on it or next to it.

        No agent can that pushes none.
        """
        world = self._world
        self.box_node(box)
        self._look_at(node)
        if not self.pushes_boxes:
            return False
        level = world.level(self.agent) if node == self.node else world.surface[node]
        return world.graspable(self.agent, box, level, node)

    def holes(self) -> tuple[int, ...]:
        """The keys of the holes within R, ascending."""
        if len(self._world.hole_node) == 0:
            return ()
        return self._world.visibility_of(self.agent).holes(self.node)

    def hole_in_sight(self) -> bool:
        """Whether there is a hole within R."""
        if len(self._world.hole_node) == 0:
            return False
        return self._world.visibility_of(self.agent).find_holes(self.node) > 0

    def open_hole_in_sight(self) -> bool:
        """Whether the surface in a hole within R lies below its rim, so far that nobody can cross it."""
        world = self._world
        visibility, reach = world.visibility_of(self.agent), world.terrain.reach
        near = visibility.find_holes(self.node)
        for k in range(visibility.holes_start, visibility.holes_start + near):
            hole = visibility.hole_keys[k]
            if world.headroom(hole) >= reach:
                return True
        return False

    def holes_into(self, found: array[int], centre: int) -> int:
        """Writes those of `holes` that lie within R of the visible node `centre` too into `found`; returns how many."""
        self._look_at(centre)
        visibility, count = self._world.visibility_of(self.agent), 0
        near = visibility.find_holes(self.node)
        for k in range(visibility.holes_start, visibility.holes_start + near):
            hole = visibility.hole_keys[k]
            if centre == self.node or visibility.neighbourhoods.both(centre, self._world.hole_node[hole]):
                found[count] = hole
                count += 1
        return count

    def hole_node(self, hole: int) -> int:
        """Where a visible hole is."""
        self._hole(hole)
        return self._world.hole_node[hole]

    def sees_hole(self, hole: int) -> bool:
        """Whether a hole lies within R."""
        world = self._world
        if not 0 <= hole < len(world.hole_node):
            return False
        return world.visibility_of(self.agent).neighbourhoods.both(self.node, world.hole_node[hole])

    def hole_near(self, hole: int, node: int) -> bool:
        """Whether a visible hole lies within R of a visible node."""
        self._hole(hole)
        self._look_at(node)
        return self._world.visibility_of(self.agent).neighbourhoods.both(node, self._world.hole_node[hole])

    def headroom(self, hole: int) -> float:
        """How far the surface in a visible hole lies below its rim, graph units; negative for a hill."""
        self._hole(hole)
        return self._world.headroom(hole)

    def _hole(self, hole: int) -> None:
        if not self.sees_hole(hole):
            raise OutOfSightError(f"hole {hole} is out of sight from node {self.node}")

    def can_slide(self, box: int, i: int, j: int) -> bool:
        """Whether a visible box could be pushed from a visible node to its neighbour, as far as the terrain goes."""
        self._look_at(i)
        self._look_at(j)
        world = self._world
        return world.can_slide(world.base_of(box, i), i, j)

    def can_follow(self, box: int, i: int, j: int) -> bool:
        """Whether a box pushed from `i` to `j` would stay level with its pusher, who then goes with it."""
        self._look_at(i)
        self._look_at(j)
        world = self._world
        return world.passable(world.base_of(box, i), i, j)

    def pushes(self, box: int, barred: int = -1) -> list[int]:
        """The visible nodes beside a visible box that it could be pushed to with its pusher staying level with it.

        Args:
            box: The box.
            barred: A node to leave out, or -1.
        """
        found = array("i", [0]) * len(self._world.topology.neighbours[self.box_node(box)])
        return found[: self.pushes_into(box, barred, found)].tolist()

    def pushes_into(self, box: int, barred: int, found: array[int]) -> int:
        """Writes `pushes` into `found`, which must have room for all neighbours of the box; returns how many."""
        if len(found) < len(self._world.topology.neighbours[self.box_node(box)]):
            raise ValueError("there is no room for all neighbours of the box")
        return self._world.visibility_of(self.agent).pushes(self.node, box, barred, found)

    def nearest_box(self, shunned: Collection[int] = (), barred: int = -1) -> tuple[int, int] | None:
        """The closest box by path that the agent could hold (paper Algorithm 4).

        Args:
            shunned: Boxes to leave out.
            barred: A node that no way may lead over (the goal: who comes there leaves), or -1.

        Returns:
            The box and the first node on the way to it (the box's own node if it is adjacent or underfoot), or None.
        """
        box, first = self.find_box(-1, barred, shunned)
        return None if box < 0 else (box, first)

    def find_box(self, shunned: int, barred: int, others: Collection[int] = (), past: bool = False) -> tuple[int, int]:
        """`nearest_box` for compiled policies: the box and the first node on the way to it, or twice -1.

        Args:
            shunned: A box to leave out, or -1.
            barred: A node that no way may lead over, or -1.
            others: More boxes to leave out.
            past: Whether ways may lead over the nodes of boxes that the agent could take hold of.
        """
        world = self._world
        if len(world.box_node) == 0 or not self.pushes_boxes:
            return -1, -1
        level = world.level(self.agent)
        if self._misplaces():
            return self._find_box_badly(level, shunned, barred, others, past)
        visibility, missed = world.visibility_of(self.agent), self._missed
        return visibility.nearest_box(self.agent, self.node, level, shunned, barred, others, past, missed)

    def _find_box_badly(
        self, level: float, shunned: int, barred: int, others: Collection[int], past: bool
    ) -> tuple[int, int]:
        """`find_box` by lengths as they seem."""
        assert self._senses is not None
        visibility = self._misjudge(self._senses)
        try:
            return visibility.nearest_box(self.agent, self.node, level, shunned, barred, others, past, self._missed)
        finally:
            visibility.measure_truly()

    def way_to_hole(
        self, box: int, hole: int, barred: int = -1, avoided: Collection[tuple[int, int]] = ()
    ) -> tuple[int, ...]:
        """The shortest way over which a visible box could be pushed into a visible hole.

        Args:
            box: The box.
            hole: The hole's key.
            barred: A node that the way may not lead over (the goal: the pusher would leave there), or -1.
            avoided: Pushes (from, to) that the way shall do without.

        Returns:
            The nodes from the box's to the hole's; none if there is no way within sight, or the box is there.
        """
        self.box_node(box)
        if not self._misplaces():
            return self._world.visibility_of(self.agent).way_to(self.node, box, self.hole_node(hole), barred, avoided)
        end = self.hole_node(hole)
        assert self._senses is not None
        visibility = self._misjudge(self._senses)
        try:
            return visibility.way_to(self.node, box, end, barred, avoided)
        finally:
            visibility.measure_truly()

    def feasible(self, box: int, targets: Sequence[int]) -> Sequence[float]:
        """The backend's chance, 0 to 1, that the agent can push a visible box to each of its neighbours `targets`.

        0 for an agent that pushes none.
        """
        self.box_node(box)
        for node in targets:
            self._look_at(node)
        if not self.pushes_boxes:
            return [0.0] * len(targets)
        return self._backend.feasible(self.agent, box, targets)

    def feasible_way(self, box: int, way: Sequence[int]) -> Sequence[float]:
        """The backend's chance of each push along a way of visible nodes, given that those before it succeed.

        Their product is the chance of the way. Of a backend that does not foresee only the first push is known;
        nothing speaks against the others.

        Args:
            box: A visible box.
            way: The nodes to push it over, its own first.

        Raises:
            OutOfSightError: The agent does not see the box or one of the nodes.
        """
        self.box_node(box)
        for node in way:
            self._look_at(node)
        if not self.pushes_boxes:
            return [0.0] * max(0, len(way) - 1)
        if self._feasible_way is None:
            return [*self._backend.feasible(self.agent, box, way[1:2]), *(1.0 for _ in way[2:])]
        return self._feasible_way(self.agent, box, way)
