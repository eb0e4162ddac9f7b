# cython: auto_pickle=False
"""The world: the state of an episode (agents, boxes, reservations) and the rules by which it may change.

Outcomes are written by `World.apply` and `World.arrive`, reservations, claims and requests by the methods beside them;
nothing else changes the state.
"""

from __future__ import annotations

from array import array
from copy import deepcopy
from enum import Enum
from typing import TYPE_CHECKING, Any, TypeAlias

from colonysim.states import LARGEST, Stored
from colonysim.world.intents import Push
from colonysim.world.terrain import Terrain
from colonysim.world.visibility import Visibility

if TYPE_CHECKING:
    from collections.abc import Iterable

    from colonysim.scenario.scenario import Scenario
    from colonysim.states import State
    from colonysim.world.intents import Intent, Outcome

__all__ = ["BARRED", "AgentStatus", "Place", "World", "nodes_of"]

BARRED = ("no such move", "unreachable", "no such box", "out of reach", "cannot be pushed")
"""The reasons why the rules of the place forbid a move, by the index that `World.prospect` returns."""

Place: TypeAlias = int | tuple[int, int]
"""What can be reserved: a node, or an edge (i, j) with i < j that a manoeuvre sweeps over."""


_COLUMNS = (
    "floor", "surface", "occupant", "node_holder", "top", "box_node", "box_base", "box_claim", "box_stray",
    "agent_node", "agent_from", "agent_box", "agent_status", "reserved",
)  # fmt: skip
"""What changes in an episode and has one value for each node, box or agent."""
_TABLES = ("edge_holder", "stacks", "clear_requests")
"""What changes in an episode and has values for a few nodes or edges only."""


_SAVED = {
    "surface": "d", "occupant": "i", "node_holder": "i", "top": "i", "box_node": "i", "box_base": "d",
    "agent_node": "i", "agent_from": "i", "agent_box": "i",
}  # fmt: skip
"""Those of them that are arrays, with their types."""


class AgentStatus(Enum):
    """What an agent can still do in this episode."""

    ABSENT = "absent"
    """It will join later."""
    ACTIVE = "active"
    GOAL = "goal"
    SPENT = "spent"
    LOST = "lost"


class World:
    """The state of an episode as flat arrays indexed by node, agent, box or hole, and the rules that move it on.

    Everybody may read it; only the simulation calls what changes it. -1 stands for "none"; heights are in graph units.
    The arrays are made once and filled anew by `reset`: who has got hold of one need not ask for it again.

    Attributes:
        scenario: What the world was built from.
        topology: The place itself, with the edges that come later.
        goal: The node that all agents must reach now.
        terrain: Its edges and surfaces, and the rules of heights.
        floor: Height of each node's bare surface.
        surface: Height of each node's surface with the boxes on it.
        rim: Height of each hole's rim.
        hole_node: The node of each hole, by the hole's key.
        hole_at: Key of the hole at each node, or -1.
        occupant: The agent whose body is on each node, or -1.
        stacks: For each node that has boxes, their numbers from bottom to top.
        top: The topmost box on each node, or -1.
        box_node: Where each box is; -1 for one that is not there.
        box_height: How high each box is.
        box_base: The height each box's underside stands at.
        box_claim: The agent that holds each box, or -1.
        box_stray: Whether each box lies off its node.
        agent_node: Where each agent is.
        agent_from: The node each agent came from, or -1.
        agent_box: The box whose node each agent shares (behind it), or -1.
        agent_status: What each agent can still do.
        clear_requests: For a node that a carrier asks to be cleared, the agent that asks.
        node_holder: The agent that has reserved each node, or -1.
        edge_holder: The agent that has reserved an edge (i, j) with i < j; others are free.
        reserved: What each agent has reserved.
        now: Simulated seconds of the episode; at its end, those that it took.
    """

    __slots__ = (
        "_requests", "_requests_near", "_sights", "_visibility", "agent_box", "agent_from", "agent_node",
        "agent_status", "box_base", "box_claim", "box_height", "box_node", "box_stray", "clear_requests", "edge_holder",
        "floor", "goal", "hole_at", "hole_node", "node_holder", "now", "occupant", "reserved", "rim", "scenario",
        "stacks", "surface", "terrain", "top", "topology",
    )  # fmt: skip

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.topology, self.goal = scenario.topology, scenario.goal
        size = len(scenario.topology)
        self.hole_at = array("i", [-1]) * size
        for key, hole in enumerate(scenario.holes):
            self.hole_at[hole.node] = key
        self.box_height = array("d", [box.height for box in scenario.boxes])
        self.hole_node = array("i", [hole.node for hole in scenario.holes])
        self.survey()
        self.surface = array("d", scenario.topology.z)
        self.terrain = Terrain(scenario, self.surface)
        self._visibility: Visibility | None = None
        self._sights: list[Visibility | None] | None = None  # of each agent, if their radii differ
        if any(group.detection_radius != scenario.detection_radius for group in scenario.groups):
            self._sights = [None] * len(scenario.agents)
        boxes, agents = len(scenario.boxes), len(scenario.agents)
        self.top, self.occupant, self.node_holder = (array("i", [-1]) * size for _ in range(3))
        self.box_node, self.box_base = array("i", [-1]) * boxes, array("d", [0.0]) * boxes
        self.box_claim, self.box_stray = [-1] * boxes, [False] * boxes
        self.agent_node, self.agent_from, self.agent_box = (
            array("i", scenario.agents), array("i", [-1]) * agents, array("i", [-1]) * agents
        )  # fmt: skip
        self.agent_status = [AgentStatus.ACTIVE] * agents
        self.reserved: list[tuple[Place, ...]] = [()] * agents
        self.edge_holder: dict[tuple[int, int], int] = {}
        self.stacks: dict[int, list[int]] = {}
        self.clear_requests: dict[int, int] = {}
        self._requests, self._requests_near = 0, array("i", [0]) * size
        self.now = 0.0
        self.reset()

    def survey(self) -> None:
        """Copies the heights of nodes and rims from the scenario; to be called again if these are changed."""
        self.floor = array("d", self.scenario.topology.z)
        self.rim = array("d", [hole.rim for hole in self.scenario.holes])

    def adopt(self, scenario: Scenario) -> None:
        """Goes on with another scenario of the same place, holes, agents and boxes.

        It may bring boxes that are not there yet, numbered after the others, and a timeline where there was none. Who
        has got hold of arrays of boxes or of `visibility` has to ask for them again.
        """
        more = scenario.boxes[len(self.box_node) :]
        if more:
            heights, bases = array("d", bytes(self.box_height)), array("d", bytes(self.box_base))
            nodes = array("i", bytes(self.box_node))
            for box in more:
                heights.append(box.height)
                nodes.append(-1)
                bases.append(0.0)
                self.box_claim.append(-1)
                self.box_stray.append(False)
            self.box_height, self.box_node, self.box_base = heights, nodes, bases
        if scenario.changes:
            self.terrain.own_edges()
        if more or scenario.changes:
            self._visibility = None
            if self._sights is not None:
                self._sights[:] = [None] * len(self._sights)
        self.scenario = scenario

    def reset(self) -> None:
        """Puts agents and boxes where they start, and ends all claims, reservations and requests."""
        scenario, self.now = self.scenario, 0.0
        if scenario.changes:
            self.goal = scenario.goal
            self._set_floors(self.topology.z)
            self.terrain.restore()
        self.surface[:] = self.floor
        for node in range(len(self.top)):
            self.top[node] = self.occupant[node] = self.node_holder[node] = -1
        for part in (self.edge_holder, self.stacks, self.clear_requests):
            part.clear()
        if self._requests:
            self._requests = 0
            for node in range(len(self._requests_near)):
                self._requests_near[node] = 0
        boxes, agents = len(scenario.boxes), len(scenario.agents)
        self.box_claim[:], self.box_stray[:] = [-1] * boxes, [False] * boxes
        for box in range(boxes):
            self.box_node[box] = -1
        for box, start in enumerate(scenario.boxes_at_start):
            self._put_box(box, start.node)
        self.agent_status[:], self.reserved[:] = [AgentStatus.ABSENT] * agents, [()] * agents
        for agent, node in enumerate(scenario.agents):
            self.agent_node[agent], self.agent_box[agent], self.agent_from[agent] = node, -1, -1
        for agent in range(len(scenario.agents_at_start)):
            self.join(agent)

    def __deepcopy__(self, memo: dict[int, object]) -> World:
        """Another world in the same state, of a scenario of its own: who changes one leaves the other alone."""
        twin = World(deepcopy(self.scenario, memo))
        for name in _COLUMNS:
            getattr(twin, name)[:] = getattr(self, name)
        for name in _TABLES:
            table = getattr(twin, name)
            table.clear()
            table.update(deepcopy(getattr(self, name), memo))
        for node in twin.clear_requests:
            twin._count_request(node, 1)
        if self.scenario.changes:
            twin.terrain.rises[:] = self.terrain.rises
        twin.now, twin.goal = self.now, self.goal
        return twin

    def state(self) -> State:
        """What has changed since the start of the episode, as plain data."""
        state: State = {name: array(kind, bytes(getattr(self, name))) for name, kind in _SAVED.items()}
        return state | {
            "now": self.now, "box_claim": list(self.box_claim), "box_stray": list(self.box_stray),
            "agent_status": [status.value for status in self.agent_status],
            "reserved": [[_as_list(place) for place in places] for places in self.reserved],
            "edge_holder": [[*edge, agent] for edge, agent in self.edge_holder.items()],
            "stacks": [[node, *boxes] for node, boxes in self.stacks.items()],
            "clear_requests": [[node, agent] for node, agent in self.clear_requests.items()],
            "place": self._place_state() if self.scenario.changes else None,
        }  # fmt: skip

    def _place_state(self) -> State:
        """What a timeline may have changed of the place."""
        return {
            "goal": self.goal, "floor": array("d", bytes(self.floor)),
            "taken": [list(edge) for edge in self.terrain.taken()],
        }  # fmt: skip

    def _restore_place(self, told: Stored) -> None:
        nodes = len(self.top)
        floor, goal = told.column("floor", "d", nodes, -LARGEST, LARGEST), told.whole("goal", 0, nodes - 1)
        taken = self._rows_of(told, "taken", 2, (nodes, nodes))
        if not all(self.adjacent(i, j) for i, j in taken):
            raise told.fault("taken", taken, "edges of the place")
        self.goal = goal
        self._set_floors(floor)
        self.terrain.shape(self.floor, [(i, j) for i, j in taken])

    def restore(self, state: State) -> None:
        """Takes over the state of a world of the same scenario.

        Raises:
            ColonysimError: It is none.
        """
        told = Stored(state, "world")
        nodes, boxes, agents = len(self.top), len(self.box_node), len(self.agent_node)
        bounds = {
            "surface": (nodes, -LARGEST, LARGEST), "occupant": (nodes, -1, agents - 1),
            "node_holder": (nodes, -1, agents - 1), "top": (nodes, -1, boxes - 1), "box_node": (boxes, -1, nodes - 1),
            "box_base": (boxes, -LARGEST, LARGEST), "agent_node": (agents, 0, nodes - 1),
            "agent_from": (agents, -1, nodes - 1), "agent_box": (agents, -1, boxes - 1),
        }  # fmt: skip
        columns = {name: told.column(name, kind, *bounds[name]) for name, kind in _SAVED.items()}
        stacks = {node: stack for node, *stack in self._rows_of(told, "stacks", 2, (nodes, *[boxes] * boxes))}
        placed = {box: node for node, stack in stacks.items() for box in stack}
        there = [placed.get(box, -1) for box in range(boxes)]
        missing = not self.scenario.changes and -1 in there
        if missing or sum(map(len, stacks.values())) != len(placed) or there != [*columns["box_node"]]:
            raise told.fault("stacks", stacks, "each box once, where it is")
        if any(top != (stacks[node][-1] if node in stacks else -1) for node, top in enumerate(columns["top"])):
            raise told.fault("top", columns["top"], "the topmost box of each node")
        statuses = {status.value: status for status in AgentStatus}
        found = told.listed("agent_status", agents)
        if not all(type(word) is str and word in statuses for word in found):
            raise told.fault("agent_status", found, f"words such as {', '.join(statuses)}")
        claims, strays = told.wholes("box_claim", boxes, -1, agents - 1), told.listed("box_stray", boxes)
        if not all(type(stray) is bool for stray in strays):
            raise told.fault("box_stray", strays, "True or False for each box")
        reserved = [_places(told, each, nodes) for each in told.listed("reserved", agents)]
        edges = self._rows_of(told, "edge_holder", 3, (nodes, nodes, agents))
        requests = self._rows_of(told, "clear_requests", 2, (nodes, agents))
        if self.scenario.changes:
            self._restore_place(told.part("place"))
        self.now = told.real("now", 0.0, LARGEST)
        for name, column in columns.items():
            getattr(self, name)[:] = column
        self.box_claim[:], self.box_stray[:] = claims, strays
        self.agent_status[:], self.reserved[:] = [statuses[word] for word in found], reserved
        for node in list(self.clear_requests):
            self.unask(node)
        self.stacks.clear()
        self.stacks.update(stacks)
        self.edge_holder.clear()
        self.edge_holder.update({(i, j): agent for i, j, agent in edges})
        for node, agent in requests:
            self.ask(agent, node)

    def _rows_of(self, told: Stored, name: str, least: int, below: tuple[int, ...]) -> list[list[int]]:
        """A list of rows of whole numbers, of at least so many, each number below its bound."""
        rows = told.listed(name)
        for row in rows:
            sound = isinstance(row, list) and least <= len(row) <= len(below)
            if not sound or not all(type(n) is int and 0 <= n < most for n, most in zip(row, below, strict=False)):
                raise told.fault(name, row, "numbers of what exists")
        return rows

    # -- the rules of the place ------------------------------------------------------------------------------------

    def level(self, agent: int) -> float:
        """The height `agent` stands at: its node's surface, or the base of the box it shares the node with."""
        box = self.agent_box[agent]
        return self.box_base[box] if box >= 0 else self.surface[self.agent_node[agent]]

    def arrived(self, agent: int) -> bool:
        """Whether `agent` stands on the goal itself, and not behind a box on it."""
        return self.agent_node[agent] == self.goal and self.agent_box[agent] < 0

    def passable(self, level: float, i: int, j: int) -> bool:
        """Whether an agent standing at height `level` on `i` can travel to `j`; False if no edge leads there.

        The surfaces must differ by less than `reach`; on a slope its nominal rise is taken off first.
        """
        edge = self.terrain.edge(i, j)
        return edge >= 0 and self.terrain.leads(level, edge)

    def reachable(self, i: int, j: int) -> bool:
        """Whether `j` can be reached from the surface of its neighbour `i`."""
        return self.passable(self.surface[i], i, j)

    def reachable_neighbours(self, level: float, node: int) -> list[tuple[int, float]]:
        """The neighbours that are passable from height `level` on `node`, with the lengths of the edges."""
        found, terrain = [], self.terrain
        for edge in range(terrain.first[node], terrain.first[node + 1]):
            if terrain.leads(level, edge):
                found.append((terrain.ends[edge], terrain.lengths[edge]))
        return found

    def exits(self, agent: int, found: array[int]) -> int:
        """Writes the neighbours that `agent` can travel to and that nobody else occupies or has reserved into `found`.

        Returns how many there are; `found` must have room for all neighbours of the agent's node.
        """
        node, level, terrain, count = self.agent_node[agent], self.level(agent), self.terrain, 0
        for edge in range(terrain.first[node], terrain.first[node + 1]):
            j = terrain.ends[edge]
            if terrain.leads(level, edge) and self.free(agent, j):
                found[count] = j
                count += 1
        return count

    def adjacent(self, i: int, j: int) -> bool:
        """Whether an edge leads from `i` to `j`."""
        return self.terrain.edge(i, j) >= 0

    def beside_box(self, node: int, other: int) -> bool:
        """Whether there is a box on a node that is a neighbour of both `node` and `other`."""
        if not 0 <= other < len(self.top):
            return False
        terrain = self.terrain
        for edge in range(terrain.first[other], terrain.first[other + 1]):
            j = terrain.ends[edge]
            if self.top[j] >= 0 and self.adjacent(node, j):
                return True
        return False

    def box_at_hand(self, node: int) -> bool:
        """Whether there is a box on `node` or next to it."""
        if self.top[node] >= 0:
            return True
        terrain = self.terrain
        for edge in range(terrain.first[node], terrain.first[node + 1]):
            j = terrain.ends[edge]
            if self.top[j] >= 0:
                return True
        return False

    def headroom(self, hole: int) -> float:
        """How far the surface in `hole` lies below the hole's rim; negative for a hill."""
        return self.rim[hole] - self.surface[self.hole_node[hole]]

    def filled(self, hole: int) -> bool:
        """Whether the surface in `hole` is level with the hole's rim."""
        return self.terrain.is_level(self.headroom(hole))

    def base_of(self, box: int, node: int) -> float:
        """The height of the underside of `box`, if it stands on `node`, else the one that it would have there."""
        return self.box_base[box] if self.box_node[box] == node else self.surface[node]

    def held_box(self, agent: int) -> int:
        """The box that `agent` holds and shares the node with, or -1."""
        box = self.agent_box[agent]
        return box if box >= 0 and self.box_claim[box] == agent else -1

    def graspable(self, agent: int, box: int, level: float, node: int) -> bool:
        """Whether `agent`, standing at height `level` on `node`, could hold `box` on that node or a neighbouring one.

        The box must be on top, unclaimed and its base level with the agent.
        """
        at, claim = self.box_node[box], self.box_claim[box]
        if self.top[at] != box or (claim != -1 and claim != agent):
            return False
        edge = -1 if at == node else self.terrain.edge(node, at)
        rise = self.terrain.rises[edge] if edge >= 0 else 0.0
        return self.terrain.is_level(self.box_base[box] - level - rise)

    def can_slide(self, base: float, i: int, j: int) -> bool:
        """Whether a box whose underside is at height `base` on `i` may be pushed to its neighbour `j`.

        The target's surface may not be above the base, and the scenario may forbid the edge.
        """
        edge = self.terrain.edge(i, j)
        return edge >= 0 and self.terrain.slides(base, edge)

    def falls(self, base: float, i: int, j: int) -> bool:
        """Whether a box pushed from `i` (underside at `base`) would drop at `j`; its pusher then stays behind."""
        edge = self.terrain.edge(i, j)
        return edge >= 0 and self.terrain.falls(base, edge)

    def prospect(self, agent: int, node: int, box: int) -> int:
        """The node where `agent` would stand after a move that succeeds, or why the rules of the place forbid the move.

        Args:
            agent: The agent that moves.
            node: The neighbouring node that it travels to, or pushes the box to.
            box: The box that it pushes from its own node, or that it takes hold of by stepping to the box's node; -1 to
                travel.

        Returns:
            `node`, or the agent's own node if the box drops there and its pusher stays behind. If the move is
            forbidden, -1 less the index of the reason in `BARRED`.
        """
        at, terrain = self.agent_node[agent], self.terrain
        edge = terrain.edge(at, node)
        if edge < 0:
            return -1
        if box < 0:
            return node if terrain.leads(self.level(agent), edge) else -2
        if box >= len(self.box_node):
            return -3
        if self.box_node[box] == node:
            return node if self.graspable(agent, box, self.level(agent), at) else -4
        base = self.box_base[box]
        if self.box_node[box] != at or self.top[at] != box or not terrain.slides(base, edge):
            return -5
        return at if terrain.falls(base, edge) else node

    def free(self, agent: int, node: int) -> bool:
        """Whether nobody but `agent` occupies or has reserved `node`."""
        occupant, holder = self.occupant[node], self.node_holder[node]
        return (occupant == -1 or occupant == agent) and (holder == -1 or holder == agent)

    def occupied_by_another(self, agent: int, node: int) -> bool:
        """Whether somebody but `agent` stands on `node`."""
        occupant = self.occupant[node]
        return occupant != -1 and occupant != agent

    def visibility(self) -> Visibility:
        """The index of what is visible from each node within the scenario's R; made when first asked for."""
        if self._visibility is None:
            self._visibility = Visibility(self.scenario)
            self._visibility.bind(self)
        return self._visibility

    def visibility_of(self, agent: int) -> Visibility:
        """`visibility` within the R of an agent (-1: the scenario's); agents with the same R share one."""
        found = self._visibility if self._sights is None or agent < 0 else self._sights[agent]
        return self._make_sight(agent) if found is None else found

    def _make_sight(self, agent: int) -> Visibility:
        """Makes what agents with the R of `agent` see, and gives it to all of them."""
        if self._sights is None or agent < 0:
            return self.visibility()
        radii = [self.scenario.detection_radius] * len(self._sights)
        for group in self.scenario.groups:
            for member in group.agents:
                radii[member] = group.detection_radius
        made = self.visibility()
        if radii[agent] != self.scenario.detection_radius:
            made = Visibility(self.scenario, radii[agent])
            made.bind(self)
        for other, radius in enumerate(radii):
            if radius == radii[agent]:
                self._sights[other] = made
        return made

    def _check(self, node: int) -> None:
        if not 0 <= node < len(self.top):
            raise IndexError(f"there is no node {node}")

    def boxes_near(self, node: int) -> list[int]:
        """The boxes within the detection radius of `node`, ascending.

        Raises:
            IndexError: There is no such node.
        """
        self._check(node)
        return self.visibility().boxes(node) if self.scenario.boxes else []

    def holes_near(self, node: int) -> tuple[int, ...]:
        """The keys of the holes within the detection radius of `node`, ascending."""
        self._check(node)
        return self.visibility().holes(node) if self.scenario.holes else ()

    def seated(self) -> int:
        """How many boxes lie in a hole."""
        return sum(len(self.stacks.get(hole.node, ())) for hole in self.scenario.holes)

    # -- requests ----------------------------------------------------------------------------------------------------

    def ask(self, agent: int, node: int) -> None:
        """A carrier asks for a node, for which nobody asks yet, to be cleared."""
        if 0 <= node < len(self._requests_near):  # what a policy names need not exist
            self.clear_requests[node] = agent
            self._count_request(node, 1)

    def unask(self, node: int) -> None:
        """Nobody asks for a node any more."""
        del self.clear_requests[node]
        self._count_request(node, -1)

    def _count_request(self, node: int, more: int) -> None:
        """Adds `more` (1 or -1) to the requests near a node and near each of its neighbours."""
        self._requests += more
        self._requests_near[node] += more
        terrain = self.terrain
        for edge in range(terrain.first[node], terrain.first[node + 1]):
            self._requests_near[terrain.ends[edge]] += more

    def requested_near(self, node: int) -> bool:
        """Whether there may be a request for `node` or a neighbour of it; if not, none needs to be looked up."""
        return self._requests_near[node] > 0 or self._requests != len(self.clear_requests)

    # -- reservations ----------------------------------------------------------------------------------------------

    def blockers(self, agent: int, places: Iterable[Place]) -> list[int]:
        """The nodes whose change could free `places` for `agent`; empty if all are free."""
        taken = []
        for place in places:
            if isinstance(place, int):
                if not self.free(agent, place):
                    taken.append(place)
            elif self.edge_holder.get(place, -1) not in (-1, agent):
                taken.extend(place)
        return taken

    def reserve(self, agent: int, places: Iterable[Place]) -> bool:
        """Reserves all of `places` for `agent`, or none of them."""
        places = tuple(places)
        if self.blockers(agent, places):
            return False
        self._free_held(agent)
        for place in places:
            if isinstance(place, int):
                self.node_holder[place] = agent
            else:
                self.edge_holder[place] = agent
        self.reserved[agent] = places
        return True

    def reserve_node(self, agent: int, node: int) -> bool:
        """`reserve` for one node."""
        if not self.free(agent, node):
            return False
        if self.reserved[agent]:
            self._free_held(agent)
        self.node_holder[node] = agent
        self.reserved[agent] = (node,)
        return True

    def release(self, agent: int) -> list[int]:
        """Gives up all that `agent` has reserved; returns the nodes concerned."""
        return nodes_of(self._free_held(agent))

    def _free_held(self, agent: int) -> tuple[Place, ...]:
        """Gives up all that `agent` has reserved; returns it."""
        held = self.reserved[agent]
        if held:
            for place in held:
                if isinstance(place, int):
                    self.node_holder[place] = -1
                else:
                    self.edge_holder.pop(place, None)
            self.reserved[agent] = ()
        return held

    # -- change ----------------------------------------------------------------------------------------------------

    def claim(self, agent: int, pushed: int) -> bool:
        """Records the claim of `agent`, which begins a move, and ends the one on any other box that it held.

        Args:
            agent: The agent.
            pushed: The box that it begins to push or to take hold of, or -1 if it travels.

        Returns:
            Whether the claim on `pushed` is new: a box that is out of reach, or another's, is not claimed.
        """
        held = self.agent_box[agent]
        if held >= 0 and held != pushed and self.box_claim[held] == agent:
            self.box_claim[held] = -1
        if pushed < 0 or self.box_claim[pushed] != -1:
            return False
        at, node = self.box_node[pushed], self.agent_node[agent]
        if at != node and not self.adjacent(node, at):
            return False
        self.box_claim[pushed] = agent
        return True

    def apply(self, agent: int, intent: Intent, outcome: Outcome) -> set[int]:
        """Writes what an outcome says; returns every node at which something changed."""
        origin, node = self.agent_node[agent], outcome.node
        changed = set(nodes_of(self._free_held(agent)))
        for place in outcome.boxes:
            changed.add(self.box_node[place.box])
            changed.add(place.node)
            self.box_stray[place.box] = place.stray
            self.move_box(place.box, place.node)
            self._let_go(place.box, agent)
        if node != origin:
            self._step(agent, node)
            changed.add(origin)
            changed.add(node)
        if isinstance(intent, Push):
            self._settle_push(agent, intent.box, node, origin)
        elif node != origin:
            self.agent_box[agent] = -1
        if outcome.lost:
            self.agent_status[agent] = AgentStatus.LOST
            if self.agent_box[agent] >= 0:
                self.box_claim[self.agent_box[agent]] = -1
        elif outcome.keeps:
            self._keep(agent, outcome.keeps)
        return changed

    def _let_go(self, box: int, mover: int) -> None:
        """Ends another agent's hold of a box that was shoved off its node."""
        holder = self.box_claim[box]
        shoved = holder >= 0 and holder != mover and self.agent_box[holder] == box
        if shoved and self.box_node[box] != self.agent_node[holder]:
            self.agent_box[holder] = self.box_claim[box] = -1

    def arrive(self, agent: int, node: int, box: int, to: int) -> None:
        """`apply` without an `Outcome`, for a move that ended as `prospect` said and had reserved its target only.

        Something changes on two nodes only: the agent's origin and its target.

        Args:
            agent: The agent that moved.
            node: Where the agent is now.
            box: The box that it pushed or took hold of; -1 if it travelled.
            to: The node where that box is now.
        """
        origin = self.agent_node[agent]
        self._free_held(agent)
        if box >= 0:
            self.move_box(box, to)
        if node != origin:
            self._step(agent, node)
        if box >= 0:
            self._settle_push(agent, box, node, origin)
        elif node != origin:
            self.agent_box[agent] = -1

    def _step(self, agent: int, node: int) -> None:
        """Moves an agent to a node."""
        origin = self.agent_node[agent]
        if self.occupant[origin] == agent:
            self.occupant[origin] = -1
        self.occupant[node] = agent
        self.agent_node[agent] = node
        self.agent_from[agent] = origin

    def _settle_push(self, agent: int, box: int, node: int, origin: int) -> None:
        """Ends the claim of an agent that no longer shares a node with the box that it has pushed."""
        if self.box_node[box] == node:
            self.agent_box[agent] = box
        else:
            if self.box_claim[box] == agent:
                self.box_claim[box] = -1
            # A refused first step leaves the agent where it was, perhaps beside another box of its own.
            if node != origin or self.agent_box[agent] == box:
                self.agent_box[agent] = -1

    def _keep(self, agent: int, nodes: tuple[int, ...]) -> None:
        """Reserves for an agent those of `nodes` that are free, see `Outcome.keeps`."""
        free = tuple(n for n in nodes if self.free(agent, n))
        for n in free:
            self.node_holder[n] = agent
        self.reserved[agent] = free

    def leave(self, agent: int) -> int:
        """Takes an agent that is at the goal out of the world; returns its node."""
        node = self.agent_node[agent]
        if self.occupant[node] == agent:
            self.occupant[node] = -1
        self._free_held(agent)
        box = self.agent_box[agent]
        if box >= 0 and self.box_claim[box] == agent:
            self.box_claim[box] = -1
        self.agent_box[agent] = -1
        self.agent_status[agent] = AgentStatus.GOAL
        return node

    def spend(self, agent: int) -> None:
        """The agent has used up its steps: it stays where it is and lets go of its box."""
        self.agent_status[agent] = AgentStatus.SPENT
        box = self.agent_box[agent]
        if box >= 0 and self.box_claim[box] == agent:
            self.box_claim[box] = -1

    def _set_floors(self, floors: Iterable[float]) -> None:
        for node, z in enumerate(floors):
            self.floor[node] = z

    # -- changes of the place ----------------------------------------------------------------------------------------

    def join(self, agent: int) -> None:
        """Puts an agent that was absent on its start node, which must be free."""
        self.agent_status[agent] = AgentStatus.ACTIVE
        self.occupant[self.agent_node[agent]] = agent

    def lose(self, agent: int) -> None:
        """The agent can do nothing more in this episode; its body stays where it is, and it lets go of its box."""
        self.agent_status[agent] = AgentStatus.LOST
        box = self.agent_box[agent]
        if box >= 0 and self.box_claim[box] == agent:
            self.box_claim[box] = -1

    def move_goal(self, node: int) -> None:
        """Another node is the goal from now on."""
        self.goal = node

    def set_floor(self, node: int, z: float) -> None:
        """Gives a node's bare surface another height, graph units; the boxes on it and its slopes move along."""
        self.floor[node] = z
        self._restack(node)
        self.terrain.lean(node, self.floor)

    def add_box(self, box: int) -> None:
        """Puts a box that was not there on top of whatever stands on its start node."""
        self._put_box(box, self.scenario.boxes[box].node)

    def remove_box(self, box: int) -> int:
        """Takes a box that nobody holds out of the world; returns the node where it was."""
        node = self.box_node[box]
        self.stacks[node].remove(box)
        self._restack(node)
        self.box_node[box], self.box_stray[box] = -1, False
        for agent in range(len(self.agent_box)):
            if self.agent_box[agent] == box:
                self.agent_box[agent] = -1
        return node

    def _restack(self, node: int) -> None:
        """Lets the boxes on a node stand on its floor and each other, after one of them or the floor has gone."""
        stack = self.stacks.get(node)
        base = self.floor[node]
        if stack is not None:
            for other in stack:
                self.box_base[other] = base
                base += self.box_height[other]
        self.top[node] = stack[-1] if stack else -1
        if not stack:
            self.stacks.pop(node, None)
        self.surface[node] = self._height(node)

    def _put_box(self, box: int, node: int) -> None:
        """Puts a box that stands nowhere on top of whatever stands on a node."""
        stack = self.stacks.setdefault(node, [])
        self.box_base[box] = self.surface[node]
        stack.append(box)
        self.box_node[box] = node
        self.top[node] = box
        self.surface[node] = self._height(node)

    def move_box(self, box: int, node: int) -> None:
        """Puts `box` on top of whatever stands on `node`; what stood on it sinks."""
        old = self.box_node[box]
        if old == node:
            return
        self.stacks[old].remove(box)
        self._restack(old)
        self._put_box(box, node)

    def _height(self, node: int) -> float:
        """The height of a node's surface: floor plus boxes, summed anew so that no rounding error accumulates."""
        height = self.floor[node]
        stack = self.stacks.get(node)
        if stack is not None:
            for box in stack:
                height += self.box_height[box]
        return height


def _as_list(place: Place) -> int | list[int]:
    return place if isinstance(place, int) else list(place)


def _places(told: Stored, given: object, nodes: int) -> tuple[Place, ...]:
    """Nodes and edges of a state."""
    places: list[Any] = []
    for place in given if isinstance(given, list) else [None]:
        ends = place if isinstance(place, list) else [place]
        if len(ends) not in (1, 2) or not all(type(end) is int and 0 <= end < nodes for end in ends):
            raise told.fault("reserved", place, "nodes and edges")
        places.append((ends[0], ends[1]) if isinstance(place, list) else ends[0])
    return tuple(places)


def nodes_of(places: Iterable[Place]) -> list[int]:
    """All nodes among some places: the places that are nodes, and both ends of those that are edges."""
    nodes: list[int] = []
    for place in places:
        if isinstance(place, int):
            nodes.append(place)
        else:
            nodes.extend(place)
    return nodes
