"""Where agents and boxes were, step by step, as the events tell it."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from colonysim.world.state import World

if TYPE_CHECKING:
    from collections.abc import Iterable

    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.schema import Event

__all__ = ["Ways", "blocked_edges", "follow", "with_boxes"]


@dataclass(slots=True)
class Ways:
    """The nodes that each agent and box was on, in order; the last is where it ended.

    Attributes:
        agents: By agent, node numbers.
        boxes: By box, node numbers.
        gone: Agents that left at the goal.
    """

    agents: dict[int, list[int]] = field(default_factory=lambda: defaultdict(list))
    boxes: dict[int, list[int]] = field(default_factory=dict)
    gone: set[int] = field(default_factory=set)


def follow(scenario: Scenario, events: Iterable[Event]) -> Ways:
    """Follows the agents and boxes through the events of one episode."""
    ids = scenario.topology.ids
    ways = Ways()
    for agent, start in enumerate(scenario.agents):
        ways.agents[agent] = [ids[start]]
    for box, place in enumerate(scenario.boxes):
        ways.boxes[box] = [ids[place.node]]
    for event in events:
        if event.kind == "goal":
            ways.gone.add(event.agent)
        if event.kind != "end":
            continue
        if event.now_at != ways.agents[event.agent][-1]:
            ways.agents[event.agent].append(event.now_at)
        # Taking hold of a box does not move it; what a failed push did to it only the poses know.
        if event.action == "push" and event.status == "arrived":
            ways.boxes[event.box].append(event.target)
    return ways


def with_boxes(scenario: Scenario, boxes: dict[int, int]) -> World:
    """The place with its boxes elsewhere, and its agents where they start.

    Args:
        scenario: The place.
        boxes: The node number that each box is on; boxes that are not named are where they start.
    """
    world = World(scenario)
    for box, node in boxes.items():
        world.move_box(box, scenario.topology.index[node])
    return world


def blocked_edges(scenario: Scenario, boxes: dict[int, int]) -> list[tuple[int, int]]:
    """The edges whose ends are not level: too high a step for anyone (paper Section 3.3).

    Args:
        scenario: The place.
        boxes: The node number that each box is on.
    """
    world, topology = with_boxes(scenario, boxes), scenario.topology
    return [
        (topology.ids[i], topology.ids[j])
        for i, others in enumerate(topology.neighbours)
        for j in others
        if i < j and not world.reachable(i, j)
    ]
