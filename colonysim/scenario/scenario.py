"""What a scenario says, validated and frozen: the input of everything else."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from colonysim.scenario.places import Places

if TYPE_CHECKING:
    from collections.abc import Mapping

    from colonysim.errors import ScenarioError
    from colonysim.scenario.changes import Change, Newcomers
    from colonysim.scenario.faults import Faults
    from colonysim.scenario.groups import Group
    from colonysim.world.topology import Topology

__all__ = ["BoxStart", "Hole", "Scenario", "Timing"]


@dataclass(frozen=True, slots=True)
class Hole:
    """A node whose floor lies below its rim; heights in graph units."""

    node: int
    floor: float
    rim: float

    @property
    def depth(self) -> float:
        """How far the floor lies below the rim."""
        return self.rim - self.floor


@dataclass(frozen=True, slots=True)
class BoxStart:
    """Where a box stands at the start of each episode, and how high it is, graph units."""

    node: int
    height: float


@dataclass(frozen=True, slots=True)
class Timing:
    """How long an action takes on a backend without a clock of its own.

    Attributes:
        travel: Seconds per graph unit of a travelled edge.
        push: Seconds per graph unit of a pushed edge.
        travel_fixed: Seconds added to each travelled edge.
        push_fixed: Seconds added to each pushed edge.
        jitter: Half-width of a uniform factor around 1, drawn for each action.
        travels: Measured durations of single edges (i, j), seconds; they take precedence.
        pushes: Measured durations of single pushed edges (i, j), seconds.
    """

    travel: float = 1.0
    push: float = 1.0
    travel_fixed: float = 0.0
    push_fixed: float = 0.0
    jitter: float = 0.1
    travels: Mapping[tuple[int, int], float] = field(default_factory=dict)
    pushes: Mapping[tuple[int, int], float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Scenario:
    """One colony, described once for every backend; all nodes are indices into `topology`.

    Attributes:
        name: Short name, shown everywhere.
        description: One line for listings.
        topology: The place.
        holes: In the order of the file; a hole's key is its position here.
        boxes: In the order of the file, then those that come later; a box's number is its position here.
        agents: Start node of each agent, group after group; those that join later stand behind the others.
        goal: The node that all agents must reach.
        no_push: Directed edges over which no box may be pushed.
        detection_radius: R, graph units.
        max_steps: Steps an agent may begin in an episode.
        episodes: Episodes of a run unless the caller says otherwise.
        mode: "asynchronous" or "synchronous".
        stall_seconds: Simulated seconds without any outcome, and with no action under way, after which an episode
            ends as deadlock.
        time_limit: Simulated seconds after which an episode ends as timeout; None for no limit.
        reach: Two surfaces that differ by less than this are level (paper Section 3.3).
        timing: Durations for backends without a clock.
        changes: What changes while the colony is under way, in the order of the file.
        newcomers: What these changes bring that is not there when an episode begins; None for nothing.
        policy: Name of the policy, or "package.module:Name".
        parameters: Parameters of the policy (`policy.*` in the file), still to be read by the policy itself.
        groups: Groups of agents that differ; none for a file with `agents`.
        faults: What goes wrong; None for nothing.
        physics: The `physics:` section, read by the physics backend.
        document: The resolved scenario as plain data, after variant and overrides; equal documents run alike.
        digest: SHA-256 of `document` in canonical JSON.
        source: Where it came from, for messages: a path or a name.
        positions: Line and column (from 1) of each field of the file, by dotted path ("policy.beta", "boxes.2").
        overrides: For each field set from outside the file, how that was said ("--set policy.beta=2").
        variant: The variant of the file that it is; None for the file as it stands.
        policy_path: Where `policy` and `parameters` stand in the file, see `of_group`.
    """

    name: str
    topology: Topology
    holes: tuple[Hole, ...]
    boxes: tuple[BoxStart, ...]
    agents: tuple[int, ...]
    goal: int
    description: str = ""
    no_push: frozenset[tuple[int, int]] = frozenset()
    detection_radius: float = 5.0
    max_steps: int = 50
    episodes: int = 30
    mode: str = "asynchronous"
    stall_seconds: float = 600.0
    time_limit: float | None = None
    reach: float = 0.3
    timing: Timing = field(default_factory=Timing)
    changes: tuple[Change, ...] = ()
    newcomers: Newcomers | None = None
    policy: str = "stigmergy"
    parameters: Mapping[str, Any] = field(default_factory=dict)
    groups: tuple[Group, ...] = ()
    faults: Faults | None = None
    physics: Mapping[str, Any] = field(default_factory=dict)
    document: Mapping[str, Any] = field(default_factory=dict)
    digest: str = ""
    source: str = "<scenario>"
    positions: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    overrides: Mapping[str, str] = field(default_factory=dict)
    variant: str | None = None
    policy_path: str = "policy"

    def of_group(self, number: int) -> Scenario:
        """The same scenario with the policy of a group, and its parameters, as those of all agents.

        Args:
            number: Place of the group in `groups`.
        """
        group = self.groups[number]
        parameters = dict(group.parameters)
        if group.policy is None:
            parameters = {**self.parameters, **parameters}
        policy = self.policy if group.policy is None else group.policy
        return replace(self, policy=policy, parameters=parameters, policy_path=f"groups.{number}.policy")

    @property
    def parts_of_groups(self) -> list[tuple[str | None, dict[str, Any]]]:
        """For each group the policy that it names, or None, and its parameters."""
        return [(group.policy, dict(group.parameters)) for group in self.groups]

    @property
    def settings(self) -> dict[str, Any]:
        """The fields set from outside the file, by dotted path, with the values that they have; null for none."""
        return {path: _found(self.document, path) for path in self.overrides}

    @property
    def boxes_at_start(self) -> tuple[BoxStart, ...]:
        """The boxes that are there when an episode begins."""
        return self.boxes[: len(self.boxes) - len(self.newcomers.boxes)] if self.newcomers else self.boxes

    @property
    def agents_at_start(self) -> tuple[int, ...]:
        """The start nodes of the agents that are there when an episode begins."""
        return self.agents[: len(self.agents) - len(self.newcomers.agents)] if self.newcomers else self.agents

    @property
    def goals(self) -> tuple[int, ...]:
        """The goal, and the nodes to which it is moved."""
        return (self.goal, *(change.node for change in self.changes if change.kind == "move_goal"))

    def __repr__(self) -> str:
        return (
            f"<Scenario {self.name!r}: {len(self.topology)} nodes, {len(self.holes)} holes, {len(self.boxes)} boxes,"
            f" {len(self.agents)} agents, {self.digest[:12] or 'no digest'}>"
        )

    def _repr_html_(self) -> str:
        """A notebook's picture: the map as an episode begins."""
        from colonysim.scenario.picture import picture

        return picture(self)

    def fault(self, path: str, message: str) -> ScenarioError:
        """An error that says where in the file `path` stands, or what stands nearest above it."""
        if path.partition(".")[0] == "policy":
            path = self.policy_path + path[len("policy") :]
        return Places(self.source, self.positions, self.overrides).fault(path, message)


def _found(document: Any, path: str) -> Any:
    """What stands at a path; None if nothing does, as null takes a field away."""
    for part in path.split("."):
        document = document[int(part)] if isinstance(document, (list, tuple)) else (document or {}).get(part)
    return document
