"""The format of `changes:`, the timeline of a scenario: what becomes different, and when."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from colonysim.scenario.sections import Coordinate, Count, Length, NodeId, NotNegative, Pair, Seconds, Section, Text

__all__ = ["ChangeSection", "ConditionSection"]

Number = Annotated[int, Field(strict=True, ge=0, le=10**9)]
"""Of an agent or a box, counted from 0."""


class ConditionSection(Section):
    """What must be so before a change happens; exactly one field."""

    filled: NodeId | None = None
    """The surface of this hole is level with its rim."""
    at_goal: Count | None = None
    """At least so many agents are at the goal."""
    seated: Count | None = None
    """At least so many boxes lie in holes."""


class SurfaceSection(Section):
    """A node and the height of its bare surface."""

    node: NodeId
    """Which node."""
    z: Coordinate
    """Its height, or that of a hole's floor, graph units."""


class NewBoxSection(Section):
    """A box that appears."""

    node: NodeId
    """Where it appears."""
    height: Length
    """How high it is, graph units."""


class FailureSection(Section):
    """Agents that can do nothing any more, or not for a while."""

    agents: Annotated[list[Number], Field(min_length=1)]
    """Which agents."""
    seconds: Seconds | None = None
    """For how many simulated seconds they stand still; absent: they are lost for the rest of the episode."""


class WipeSection(Section):
    """Marks that are wiped away."""

    fields: Annotated[list[Text], Field(min_length=1)] | None = None
    """Names of pheromone fields; absent: all."""
    nodes: Annotated[list[NodeId], Field(min_length=1)] | None = None
    """The nodes whose marks go; absent: all nodes, or those within the borders."""
    within: tuple[Coordinate, Coordinate, Coordinate, Coordinate] | None = None
    """[xmin, ymin, xmax, ymax]: the marks on nodes inside go, borders included."""


class ChangeSection(Section):
    """A change of the place, boxes, agents or their policy: when it happens, and exactly one thing that it does.

    Each episode begins as the rest of the file describes it, and goes through the changes anew. Only what `policy`
    has changed stays so, as what the agents remember does.
    """

    time: NotNegative = 0.0
    """Simulated seconds of the episode at which it happens; with `when`, those before which it does not."""
    episode: Count | None = None
    """Only in the episode of this number."""
    from_episode: Count | None = None
    """Only from the episode of this number on."""
    to_episode: Count | None = None
    """Only up to the episode of this number."""
    when: ConditionSection | None = None
    """What must be so first; the change happens once an episode."""
    add_edge: Pair | None = None
    """An edge comes, between two nodes that had none or whose edge was taken away."""
    remove_edge: Pair | None = None
    """An edge goes: nobody begins to move along it any more, in either direction."""
    set_surface: SurfaceSection | None = None
    """A node's bare surface gets another height; what stands on it moves along."""
    add_box: NewBoxSection | None = None
    """A box appears on top of what stands on a node, once no agent is there. It is numbered after those of the file."""
    remove_box: Number | None = None
    """The box of this number disappears, once nobody holds it."""
    move_goal: NodeId | None = None
    """Another node becomes the goal, also for the agents that are not there yet."""
    add_agent: NodeId | None = None
    """An agent joins on this node, once it is free. It is numbered after those of the file."""
    fail: FailureSection | None = None
    """Agents fail, each when its move under way has ended."""
    wipe: WipeSection | None = None
    """Pheromones go."""
    policy: Annotated[dict[Text, Any], Field(min_length=1)] | None = None
    """Parameters of the policy get other values from then on, in the episodes that follow too."""
    group: Text | None = None
    """With `policy`: only for the agents of the group of this name."""
