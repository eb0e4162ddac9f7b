"""The scenario format: what a file under `scenarios/` may say, field by field.

These models see one file after its variant and overrides have been applied. They check the shape of
each field; what fields say about each other is checked in `assemble.py`.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Strict, Tag
from pydantic_core import PydanticCustomError

from colonysim.engines import EngineName
from colonysim.scenario.sections import (
    Coordinate,
    Count,
    Flag,
    Length,
    Metres,
    NodeId,
    NotNegative,
    Pair,
    Positive,
    Scale,
    Seconds,
    Section,
    Seed,
    Size,
    Text,
)
from colonysim.scenario.timeline import ChangeSection

__all__ = ["FORM_TAGS", "MAX_NAME", "ScenarioFile"]

MAX_NAME = 100
"""Most characters of a scenario's name."""
MAX_CHANGES = 10_000
"""Most changes of a timeline."""
MAX_GROUPS = 100
"""Most groups of agents."""
MAX_PARTS = 200
"""Most levels, pits or ramps of a ground that is given."""
FORM_TAGS = ("\0list", "\0mapping", "\0plain")
"""Names of the ways of writing a thing; they stand in pydantic's error paths, and no field may be called so."""


def _form(value: Any) -> str | None:
    """Which way of writing a thing was used."""
    if isinstance(value, (list, tuple)):
        return FORM_TAGS[0]
    if isinstance(value, (dict, BaseModel)):
        return FORM_TAGS[1]
    return FORM_TAGS[2] if isinstance(value, (int, str, float)) else None


def _name(text: str) -> str:
    """Refuses what would break the line that a name stands in; other control characters are refused everywhere."""
    if not text.strip() or any(letter in text for letter in "\t\n"):
        raise PydanticCustomError("one_line", "one line of text")
    return text


class NodeRow(NamedTuple):
    """A node as [id, x, y] or [id, x, y, z]."""

    id: NodeId
    x: Coordinate
    y: Coordinate
    z: Coordinate = 0.0


class NodeMapping(Section):
    """A node as a mapping."""

    id: NodeId
    """Its number."""
    at: tuple[Coordinate, Coordinate]
    """[x, y] in graph units."""
    z: Coordinate = 0.0
    """Height of its surface, graph units; of a hole listed by its number alone, the floor."""


Node = Annotated[
    Annotated[NodeRow, Tag(FORM_TAGS[0])] | Annotated[NodeMapping, Tag(FORM_TAGS[1])], Discriminator(_form)
]


class RadiusEdges(Section):
    """Edges by distance."""

    radius: Length
    """Nodes at most this far apart in the xy plane are joined, graph units."""
    include: list[Pair] = []
    """Edges besides those."""
    exclude: list[Pair] = []
    """Edges left out."""


Edges = Annotated[
    Annotated[list[Pair], Tag(FORM_TAGS[0])] | Annotated[RadiusEdges, Tag(FORM_TAGS[1])], Discriminator(_form)
]


class Generated(Section):
    """What all generated places have in common; their nodes are numbered from 0."""

    z: Coordinate = 0.0
    """Height of all nodes, graph units."""
    without: list[NodeId] = []
    """Nodes left out; the others keep their numbers."""


class Grid(Generated):
    """A rectangular grid; node `row * columns + column` stands at (column, row) times spacing."""

    kind: Literal["grid"]
    columns: Count
    """Nodes along x."""
    rows: Count
    """Nodes along y."""
    spacing: Length = 1.0
    """Distance of neighbours, graph units."""
    diagonals: Flag = False
    """Whether diagonal neighbours are joined too."""
    cut_corners: Flag = True
    """Whether diagonal neighbours are joined though one of the two nodes beside their edge is left out."""


class Line(Generated):
    """Nodes in a row along x."""

    kind: Literal["line"]
    nodes: Count
    """Number of nodes."""
    spacing: Length = 1.0
    """Distance of neighbours, graph units."""


class Ring(Generated):
    """Nodes evenly on a circle round (0, 0)."""

    kind: Literal["ring"]
    nodes: Annotated[int, Strict(), Field(ge=3, le=10**9)]
    """Number of nodes, at least 3."""
    spacing: Length = 1.0
    """Distance of neighbours, graph units."""


class Geometric(Generated):
    """A random geometric graph: nodes uniform in a rectangle, joined when within a radius."""

    kind: Literal["geometric"]
    nodes: Count
    """Number of nodes."""
    radius: Length
    """Nodes at most this far apart are joined, graph units."""
    seed: Seed
    """Seed of the positions: the place is part of the scenario, not of the run."""
    width: Length = 10.0
    """Extent along x, graph units."""
    height: Length = 10.0
    """Extent along y, graph units."""
    apart: NotNegative = 0.0
    """Least distance of two nodes, graph units."""
    connected: Flag = True
    """Whether separate parts are joined by the shortest edges that do so."""


class Rooms(Generated):
    """Square rooms in columns and rows, parted by walls; a door joins each two that lie side by side.

    Nodes are numbered as those of the grid that rooms, walls and doors are cut out of; walls are no nodes.
    """

    kind: Literal["rooms"]
    columns: Count
    """Rooms along x."""
    rows: Count
    """Rooms along y."""
    size: Annotated[int, Strict(), Field(ge=2, le=10**9)]
    """Nodes along each side of a room, at least 2."""
    seed: Seed
    """Where the doors are."""
    spacing: Length = 1.0
    """Distance of neighbours, graph units."""


Topology = Annotated[Grid | Line | Ring | Geometric | Rooms, Field(discriminator="kind")]


class HoleMapping(Section):
    """A hole by its depth: the node's z is then the rim."""

    node: NodeId
    """Its node."""
    depth: Length | None = None
    """How far the floor lies below the node's z, graph units; absent: the node's z is the floor."""


Hole = Annotated[Annotated[NodeId, Tag(FORM_TAGS[2])] | Annotated[HoleMapping, Tag(FORM_TAGS[1])], Discriminator(_form)]


class BoxRow(NamedTuple):
    """A box as [node, height]."""

    node: NodeId
    height: Length


class BoxMapping(Section):
    """A box as a mapping."""

    node: NodeId
    """Where it stands at the start of each episode."""
    height: Length
    """How high it is, graph units."""


Box = Annotated[Annotated[BoxRow, Tag(FORM_TAGS[0])] | Annotated[BoxMapping, Tag(FORM_TAGS[1])], Discriminator(_form)]


class Crowd(Section):
    """Agents on nodes that are drawn: free ones, neither the goal nor a hole nor under a box."""

    count: Count
    """How many agents."""
    seed: Seed
    """Which nodes are drawn: the start is part of the scenario, not of the run."""
    within: tuple[Coordinate, Coordinate, Coordinate, Coordinate] | None = None
    """[xmin, ymin, xmax, ymax]: only nodes inside, borders included."""


Agents = Annotated[
    Annotated[list[NodeId], Field(min_length=1), Tag(FORM_TAGS[0])] | Annotated[Crowd, Tag(FORM_TAGS[1])],
    Discriminator(_form),
]


class Duration(NamedTuple):
    """A measured duration as [from, to, seconds]."""

    start: NodeId
    end: NodeId
    seconds: Seconds


def _listed(value: Any) -> Any:
    """Refuses mappings, which pydantic would take for a named tuple's fields."""
    if not isinstance(value, (list, tuple)):
        raise PydanticCustomError("list_type", "expected a list")
    return value


DurationRow = Annotated[Duration, BeforeValidator(_listed)]


class TimingSection(Section):
    """How long actions take on a backend without a clock of its own."""

    travel: NotNegative = 1.0
    """Seconds per graph unit of a travelled edge."""
    push: NotNegative = 1.0
    """Seconds per graph unit of a pushed edge."""
    travel_fixed: NotNegative = 0.0
    """Seconds added to each travelled edge."""
    push_fixed: NotNegative = 0.0
    """Seconds added to each pushed edge."""
    jitter: Annotated[float, Strict(), Field(ge=0, lt=1, allow_inf_nan=False)] = 0.1
    """Half-width of a uniform factor around 1, drawn for each action."""
    travels: list[DurationRow] = []
    """Measured seconds of single edges, [from, to, seconds]; they hold for both directions unless both are
    listed, and take precedence."""
    pushes: list[DurationRow] = []
    """Measured seconds of single pushed edges, [from, to, seconds], in that direction only."""


class PolicySection(BaseModel):
    """The policy and its parameters; the parameters are checked by the policy itself."""

    model_config = ConfigDict(extra="allow", frozen=True)

    name: Text = "stigmergy"
    """Name of a policy, or "package.module:Name"."""


Policy = Annotated[
    Annotated[Text, Tag(FORM_TAGS[2])] | Annotated[PolicySection, Tag(FORM_TAGS[1])], Discriminator(_form)
]


class GroupPolicy(BaseModel):
    """The policy of a group, or what differs in the scenario's; the parameters are checked by the policy itself."""

    model_config = ConfigDict(extra="allow", frozen=True)

    name: Text | None = None
    """Name of another policy, or "package.module:Name"; all its parameters then stand here."""


class RobotSection(Section):
    """The robot in numbers; whatever is absent is as the preset has it, scaled along."""

    preset: Text | None = None
    """The robot that the numbers change: standard, half, an installed one's name, or "package.module:NAME"."""
    scale: Annotated[float, Strict(), Field(gt=0, le=1e3, allow_inf_nan=False)] | None = None
    """How many times as large as the standard robot: boxes, pits, the map and all clearances grow with it."""
    length: Positive | None = None
    """Of the chassis, from the bumper to the tail, metres."""
    width: Positive | None = None
    """Of the chassis, metres."""
    clearance: Positive | None = None
    """Height of the chassis' underside over the ground, metres."""
    height: Positive | None = None
    """Height of the chassis' upper side over the ground, metres."""
    wheel_radius: Positive | None = None
    """Radius of the wheels, metres."""
    track: Positive | None = None
    """Distance of the left from the right wheels, metres."""
    wheelbase: Positive | None = None
    """Distance of the front from the rear axle, metres."""
    chassis_mass: Positive | None = None
    """Mass of the robot without its wheels, kg."""
    wheel_mass: Positive | None = None
    """Mass of each of the four wheels, kg."""
    wheel_speed: Positive | None = None
    """Fastest that the motors turn the wheels, rad/s."""
    grip: Positive | None = None
    """Friction coefficient between tyres and ground."""
    bumper_friction: Positive | None = None
    """Friction coefficient of the chassis; that of a contact is the product with the box's."""


RobotChoice = Annotated[
    Annotated[Text, Tag(FORM_TAGS[2])] | Annotated[RobotSection, Tag(FORM_TAGS[1])], Discriminator(_form)
]


class GroupSection(Section):
    """Agents that differ from others in something."""

    name: Annotated[str, Strict(), Field(min_length=1, max_length=MAX_NAME), AfterValidator(_name)]
    """Short name, shown in reports."""
    agents: Agents
    """Start node of each agent, or {count, seed, within} for nodes that are drawn."""
    speed: Annotated[float, Strict(), Field(ge=1e-3, le=1e3, allow_inf_nan=False)] = 1.0
    """How many times as fast as `timing` says they move; for backends without a clock of their own."""
    detection_radius: Length | None = None
    """How far they see in the xy plane (R), graph units; the scenario's unless given."""
    pushes: Flag = True
    """Whether they take hold of boxes and push them."""
    ignores: list[Text] = []
    """Names of the fields that they do not read: they see nodes as if nobody had ever marked them."""
    robot: RobotChoice | None = None
    """Their robot on a physics backend, of the same scale as `physics.robot`: a name, or {preset, numbers...}."""
    policy: (
        Annotated[Annotated[Text, Tag(FORM_TAGS[2])] | Annotated[GroupPolicy, Tag(FORM_TAGS[1])], Discriminator(_form)]
        | None
    ) = None
    """Parameters that differ from those of the scenario's policy, or another policy: its name, or {name, ...}."""

    def own_policy(self) -> GroupPolicy | None:
        """What `policy` says, as a mapping."""
        return GroupPolicy(name=self.policy) if isinstance(self.policy, str) else self.policy


Chance = Annotated[float, Strict(), Field(ge=0, le=1, allow_inf_nan=False)]


class StopsSection(Section):
    """Agents that stop for a while."""

    every: Seconds
    """Mean simulated seconds from the end of an agent's stop to its next one; the times are exponential."""
    seconds: Seconds
    """How long each stop is, simulated seconds."""


class FaultsSection(Section):
    """What goes wrong, and how often."""

    seed: Seed = 0
    """Together with the run's seed it makes the random streams of the faults."""
    move_fails: Chance = 0.0
    """Chance that a move fails: its time passes, and nothing has moved."""
    box_missed: Chance = 0.0
    """Chance, at each look, that an agent does not see a box within R."""
    node_misplaced: Annotated[float, Strict(), Field(ge=0, le=1e6, allow_inf_nan=False)] = 0.0
    """Standard deviation, along x and along y, of where nodes seem to lie at each look, graph units."""
    mark_lost: Chance = 0.0
    """Chance that an agent that is to leave marks of a field leaves none."""
    mark_noise: Chance = 0.0
    """Relative standard deviation of a field's value as an agent reads it, one error for each look."""
    stops: StopsSection | None = None
    """Agents that end their move and stand still for a while, again and again."""


class GroundSection(Section):
    """A flat level, in metres."""

    xmin: Metres
    """West edge."""
    ymin: Metres
    """South edge."""
    xmax: Metres
    """East edge."""
    ymax: Metres
    """North edge."""
    z: Metres
    """Height of its surface."""


class PitSection(Section):
    """A square pit cut out of the ground, in metres and radians."""

    x: Metres
    """Centre."""
    y: Metres
    """Centre."""
    yaw: Annotated[float, Strict(), Field(ge=-100, le=100, allow_inf_nan=False)] = 0.0
    """Direction of its axis."""
    side: Size = 1.2
    """Length of its sides."""
    rim: Metres = 0.0
    """Height of the ground round it."""
    depth: Size
    """How far its floor lies below the rim."""


class RampSection(Section):
    """A ramp between two points of its centre line, in metres."""

    x0: Metres
    """Lower or upper end."""
    y0: Metres
    """Lower or upper end."""
    z0: Metres
    """Height there."""
    x1: Metres
    """The other end."""
    y1: Metres
    """The other end."""
    z1: Metres
    """Height there."""
    half_width: Size = 2.2
    """Half its width."""


class TerrainSection(Section):
    """The ground in full, in metres; instead of what is derived from the graph."""

    grounds: Annotated[list[GroundSection], Field(min_length=1, max_length=MAX_PARTS)]
    """Flat levels."""
    pits: Annotated[list[PitSection], Field(max_length=MAX_PARTS)] = []
    """Pits."""
    ramps: Annotated[list[RampSection], Field(max_length=MAX_PARTS)] = []
    """Ramps."""


class PhysicsSection(Section):
    """How a physics backend builds the place; whatever is absent is derived from the graph."""

    engine: EngineName | None = None
    """The engine of `--backend physics`; no other backend of rigid bodies runs the scenario then."""
    robot: RobotChoice | None = None
    """The robot: a preset (standard, half), an installed one's name, "package.module:NAME", or {preset, numbers...}."""
    xy_scale: Scale | None = None
    """Metres per graph unit in the plane."""
    z_scale: Scale | None = None
    """Metres per graph unit of height; pit depths are rounded to whole multiples of the box height."""
    box_length: Size | None = None
    """Side of a box, metres."""
    box_height: Size | None = None
    """Height of every box, metres, instead of its height in the scenario times z_scale."""
    box_mass: Annotated[float, Strict(), Field(ge=0.01, le=1e4, allow_inf_nan=False)] | None = None
    """Mass of a box, kg."""
    box_friction: Annotated[float, Strict(), Field(ge=0.001, le=100, allow_inf_nan=False)] | None = None
    """Lateral friction of a box."""
    pit_side: Size | None = None
    """Side of a pit, metres."""
    ramp_half_width: Size | None = None
    """Half the width of a ramp, metres."""
    margin: Annotated[float, Strict(), Field(ge=0, le=1e3, allow_inf_nan=False)] | None = None
    """How far the ground reaches beyond the outermost nodes, metres."""
    terrain: TerrainSection | None = None
    """Ground, pits and ramps in full instead of derived ones."""


class ScenarioFile(Section):
    """A colony: the place, what stands in it, who acts, and what counts as done."""

    name: Annotated[str, Strict(), Field(min_length=1, max_length=MAX_NAME), AfterValidator(_name)] = "scenario"
    """Short name, shown everywhere; the file's name unless given."""
    description: Text = ""
    """One line for listings."""
    nodes: Annotated[list[Node], Field(min_length=1)] | None = None
    """The nodes: [id, x, y], [id, x, y, z] or {id, at: [x, y], z}; with `edges`, instead of `topology`."""
    edges: Edges | None = None
    """The edges: a list of [from, to], or {radius, include, exclude}."""
    topology: Topology | None = None
    """A generated place, instead of `nodes` and `edges`."""
    holes: list[Hole] = []
    """Nodes whose floor lies below their rim: a number (the node's z is the floor, the rim is the highest z
    of its neighbours that are no holes), or {node, depth} (the node's z is the rim)."""
    slopes: list[Pair] = []
    """Edges [from, to] whose difference of height is a ramp that can be travelled."""
    boxes: list[Box] = []
    """The boxes: [node, height] or {node, height}."""
    agents: Agents | None = None
    """Start node of each agent, or {count, seed, within} for nodes that are drawn."""
    groups: Annotated[list[GroupSection], Field(min_length=1, max_length=MAX_GROUPS)] | None = None
    """Agents that differ, instead of `agents`; numbered group after group."""
    goal: NodeId
    """The node that all agents must reach."""
    no_push: list[Pair] = []
    """Directed edges [from, to] over which no box may be pushed."""
    detection_radius: Length = 5.0
    """How far an agent sees in the xy plane (R), graph units."""
    reach: Length = 0.3
    """Two surfaces whose heights differ by less than this are level, graph units."""
    max_steps: Count = 50
    """Edges an agent may begin in an episode."""
    episodes: Count = 30
    """Episodes of a run unless the caller says otherwise."""
    mode: Literal["asynchronous", "synchronous"] = "asynchronous"
    """Whether agents act whenever they are ready, or all at once in ticks."""
    stall_seconds: Seconds = 600.0
    """Simulated seconds without any outcome after which an episode ends as deadlock."""
    time_limit: Seconds | None = None
    """Simulated seconds after which an episode ends as timeout; null for no limit."""
    timing: TimingSection = TimingSection()
    """Durations for backends without a clock of their own."""
    policy: Policy = PolicySection()
    """The policy: a name, or {name, parameters...}."""
    faults: FaultsSection | None = None
    """What goes wrong: moves, sensors, marks, stops; nothing unless given."""
    physics: PhysicsSection = PhysicsSection()
    """Scales, boxes and terrain for physics backends."""
    changes: Annotated[list[ChangeSection], Field(max_length=MAX_CHANGES)] = []
    """What changes while the colony is under way, in the order of their numbers."""
    variants: dict[str, dict[str, Any] | None] = {}
    """Named changes to the fields above; mappings are merged, everything else is replaced."""
