"""What a running colony shows of itself: agents, boxes, pheromone fields and the place, read-only, as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import nan
from typing import TYPE_CHECKING, Any

from colonysim.arguments import whole
from colonysim.errors import ColonysimError
from colonysim.trace.groups import group_at

if TYPE_CHECKING:
    from collections.abc import Sequence

    import networkx as nx
    import numpy as np
    from numpy.typing import NDArray

    from colonysim.pheromones.field import Field
    from colonysim.policies.view import LocalView
    from colonysim.simulation.episode import Episode
    from colonysim.world.state import World

__all__ = ["AgentsView", "BoxesView", "FieldView", "FieldsView", "WorldView"]


def _array(values: Any, kind: str) -> NDArray[Any]:
    """A copy that does not change when the colony goes on."""
    import numpy as np

    made: NDArray[Any] = np.array(values, dtype=kind)
    made.flags.writeable = False
    return made


class _OfWorld:
    """Something of a world; node numbers are those of the scenario's file."""

    __slots__ = ("_world",)

    def __init__(self, world: World) -> None:
        self._world = world

    def _numbers(self, nodes: Sequence[int]) -> NDArray[np.int64]:
        ids = self._world.topology.ids
        return _array([ids[node] if node >= 0 else -1 for node in nodes], "int64")

    def _places(self, nodes: Sequence[int], heights: Sequence[float]) -> NDArray[np.float64]:
        topology, nowhere = self._world.topology, (nan, nan, nan)
        return _array(
            [(topology.x[i], topology.y[i], z) if i >= 0 else nowhere for i, z in zip(nodes, heights, strict=True)],
            "float64",
        ).reshape(-1, 3)


class AgentsView(_OfWorld):
    """All agents of a colony as they are now; each property is a new array with one value an agent.

    Example:
        ```python
        colony.agents.position[:, :2]  # where they are on the map
        (colony.agents.status == "goal").mean()  # the share that has arrived
        ```
    """

    __slots__ = ("_episode", "_views")

    def __init__(self, world: World, episode: Episode, views: Sequence[LocalView]) -> None:
        super().__init__(world)
        self._episode, self._views = episode, views

    def __len__(self) -> int:
        return len(self._world.agent_node)

    def __repr__(self) -> str:
        return f"<{len(self)} agents: " + ", ".join(self.status) + ">"

    @property
    def node(self) -> NDArray[np.int64]:
        """Number of the node that each agent is on, or comes from while it is under way."""
        return self._numbers(self._world.agent_node)

    @property
    def level(self) -> NDArray[np.float64]:
        """Height that each agent stands at, graph units."""
        return _array([self._world.level(agent) for agent in range(len(self))], "float64")

    @property
    def position(self) -> NDArray[np.float64]:
        """x, y and z of each agent's node and level, graph units; shape (agents, 3)."""
        return self._places(self._world.agent_node, [self._world.level(agent) for agent in range(len(self))])

    @property
    def held_box(self) -> NDArray[np.int64]:
        """The box that each agent holds, -1 for none."""
        return _array([self._world.held_box(agent) for agent in range(len(self))], "int64")

    @property
    def status(self) -> NDArray[np.str_]:
        """What each agent can still do: "active", "goal", "spent", "lost", or "absent" until it joins."""
        return _array([status.value for status in self._world.agent_status], "U6")

    @property
    def group(self) -> NDArray[np.str_]:
        """Name of each agent's group; empty for those of none."""
        return _array([group_at(self._world.scenario, agent) for agent in range(len(self))], "str")

    @property
    def takes_part(self) -> NDArray[np.bool_]:
        """Whether each agent is there from the start of this episode, or joins later in it."""
        timeline = self._episode.timeline
        if timeline is None:  # the colony is closed
            return _array([status.value != "absent" for status in self._world.agent_status], "bool")
        return _array([timeline.takes_part(agent) for agent in range(len(self))], "bool")

    @property
    def steps(self) -> NDArray[np.int64]:
        """Steps that each agent has begun in this episode."""
        return _array(self._episode.steps, "int64")

    def steps_of(self, agent: int) -> int:
        """`steps` of one agent.

        Raises:
            ColonysimError: There is no such agent.
        """
        return int(self._episode.steps[whole("agent", agent, 0, len(self) - 1)])

    @property
    def waited(self) -> NDArray[np.float64]:
        """How long each agent had waited since its last action when it last looked, in travelled edges' time."""
        return _array([view.waited for view in self._views], "float64")


class BoxesView(_OfWorld):
    """All boxes of a colony as they are now; each property is a new array with one value a box."""

    __slots__ = ()

    def __len__(self) -> int:
        return len(self._world.box_node)

    def __repr__(self) -> str:
        return f"<{len(self)} boxes, {self._world.seated()} in holes>"

    @property
    def node(self) -> NDArray[np.int64]:
        """Number of the node that each box is on, -1 for a box that is not there."""
        return self._numbers(self._world.box_node)

    @property
    def height(self) -> NDArray[np.float64]:
        """How high each box is, graph units."""
        return _array(self._world.box_height, "float64")

    @property
    def base(self) -> NDArray[np.float64]:
        """Height of each box's underside, graph units."""
        return _array(self._world.box_base, "float64")

    @property
    def position(self) -> NDArray[np.float64]:
        """x, y and z of each box's node and underside, graph units; shape (boxes, 3), nan where one is not there."""
        return self._places(self._world.box_node, self._world.box_base)

    @property
    def holder(self) -> NDArray[np.int64]:
        """The agent that holds each box, -1 for none."""
        return _array(self._world.box_claim, "int64")

    @property
    def stray(self) -> NDArray[np.bool_]:
        """Whether each box lies off its node (physics only)."""
        return _array(self._world.box_stray, "bool")


class WorldView(_OfWorld):
    """The place as it is now; arrays have one value a node, in the order of the scenario's file."""

    __slots__ = ()

    def __len__(self) -> int:
        return len(self._world.topology)

    def __repr__(self) -> str:
        return f"<place of {len(self)} nodes, {len(self._world.hole_node)} holes>"

    @property
    def node(self) -> NDArray[np.int64]:
        """Number of each node."""
        return _array(self._world.topology.ids, "int64")

    @property
    def surface(self) -> NDArray[np.float64]:
        """Height of each node's surface with the boxes on it, graph units."""
        return _array(self._world.surface, "float64")

    @property
    def position(self) -> NDArray[np.float64]:
        """x, y and surface of each node, graph units; shape (nodes, 3)."""
        return self._places(range(len(self)), self._world.surface)

    @property
    def occupant(self) -> NDArray[np.int64]:
        """The agent whose body is on each node, -1 for none."""
        return _array(self._world.occupant, "int64")

    @property
    def holes(self) -> NDArray[np.int64]:
        """Number of each hole's node."""
        return self._numbers(self._world.hole_node)

    @property
    def filled(self) -> NDArray[np.bool_]:
        """Whether each hole can be walked over: its surface and its rim are level."""
        world = self._world
        return _array([world.filled(hole) for hole in range(len(world.hole_node))], "bool")

    @property
    def goal(self) -> int:
        """Number of the goal's node."""
        return self._world.topology.ids[self._world.goal]

    @property
    def graph(self) -> nx.Graph[int]:
        """The place without its boxes as a NetworkX graph, keyed by node numbers; a copy of what is there now."""
        graph, terrain, index = self._world.topology.graph.copy(), self._world.terrain, self._world.topology.index
        if self._world.scenario.changes:
            graph.remove_edges_from([(i, j) for i, j in graph.edges if not terrain.has_edge(index[i], index[j])])
            for node, z in zip(self._world.topology.ids, self._world.floor, strict=True):
                graph.nodes[node]["z"] = z
        return graph

    def reachable(self, origin: int, target: int) -> bool:
        """Whether an agent on the surface of a node could travel to its neighbour now.

        Args:
            origin: Number of the node.
            target: Number of the neighbour; False if no edge leads there.
        """
        index = self._world.topology.index
        return self._world.reachable(index[origin], index[target])


class FieldView(_OfWorld):
    """One pheromone field as it is now.

    Attributes:
        name: Its name.
        by_box: Whether its values belong to boxes instead of nodes.
        by_hole: Whether there is one for each hole, as of H and B.
    """

    __slots__ = ("_field", "by_box", "by_hole", "name")

    def __init__(self, world: World, field: Field) -> None:
        super().__init__(world)
        self._field = field
        self.name, self.by_box = field.name, bool(field.by_box)
        self.by_hole = bool(getattr(field, "by_hole", False))

    def __repr__(self) -> str:
        return f"<field {self.name}: {len(self.items())} values>"

    def at(self, place: int, hole: int = -1) -> float:
        """One value.

        Args:
            place: Number of a node, or of a box for a field of boxes.
            hole: Number of a hole's node for a field that has a value for each; -1 for none.

        Raises:
            KeyError: There is no such node, box or hole.
            ColonysimError: The field has a value for each hole, and none is named.
        """
        world = self._world
        key = -1
        if self.by_hole and hole == -1:
            raise ColonysimError(f"{self.name} has a value for each hole: name the node of one, hole=")
        if hole != -1:
            if hole not in world.topology.index:
                raise KeyError(f"no node {hole}")
            key = world.hole_at[world.topology.index[hole]]
            if key < 0:
                raise KeyError(f"no hole at node {hole}")
        if not self.by_box:
            return self._field.at(world.topology.index[place], key)
        if not 0 <= place < len(world.box_node):
            raise KeyError(f"no box {place}")
        return self._field.at(place, key)

    def items(self) -> dict[tuple[int, int], float]:
        """All values that count: {(node or box, hole's node or -1): value}."""
        world, ids = self._world, self._world.topology.ids
        return {
            (place if self.by_box else ids[place], ids[world.hole_node[key]] if key >= 0 else -1): value
            for place, key, value in self._field.frame()
        }

    def values(self, hole: int = -1) -> NDArray[np.float64]:
        """The value at every node, or of every box, in their order.

        Args:
            hole: As for `at`.
        """
        places = range(len(self._world.box_node)) if self.by_box else self._world.topology.ids
        return _array([self.at(place, hole) for place in places], "float64")


class FieldsView(Mapping[str, FieldView]):
    """The pheromone fields of a colony by name."""

    __slots__ = ("_fields",)

    def __init__(self, world: World, fields: Mapping[str, Field]) -> None:
        self._fields = {name: FieldView(world, field) for name, field in fields.items()}

    def __getitem__(self, name: str) -> FieldView:
        return self._fields[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._fields)

    def __len__(self) -> int:
        return len(self._fields)

    def __repr__(self) -> str:
        return f"<fields {', '.join(self._fields) or '(none)'}>"
