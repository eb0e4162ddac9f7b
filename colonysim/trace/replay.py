"""Where agents and boxes were, step by step, as the events tell it."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from colonysim.errors import TraceError
from colonysim.world.changing import make
from colonysim.world.state import World

if TYPE_CHECKING:
    from collections.abc import Iterable

    from colonysim.scenario.changes import Change
    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.schema import Event

__all__ = ["Place", "Ways", "blocked_edges", "change_in_words", "follow", "places", "stops", "with_boxes"]


_BODILESS = ("add_edge", "remove_edge", "set_surface", "move_goal")
"""Changes that no body tells of."""


@dataclass(slots=True)
class Ways:
    """The nodes that each agent and box was on, in order; the last is where it ended.

    Attributes:
        agents: By agent, node numbers.
        boxes: By box, node numbers; none for a box that did not appear.
        gone: Agents that left at the goal.
        taken: Boxes that disappeared or have not appeared.
        changed: Positions in the scenario's timeline of the changes that happened, in order.
    """

    agents: dict[int, list[int]] = field(default_factory=lambda: defaultdict(list))
    boxes: dict[int, list[int]] = field(default_factory=dict)
    gone: set[int] = field(default_factory=set)
    taken: set[int] = field(default_factory=set)
    changed: list[int] = field(default_factory=list)

    def boxes_at_end(self) -> dict[int, int]:
        """The node number of each box that is there at the end."""
        return {box: way[-1] for box, way in self.boxes.items() if box not in self.taken}


def follow(scenario: Scenario, events: Iterable[Event]) -> Ways:
    """Follows the agents and boxes through the events of one episode."""
    ids = scenario.topology.ids
    ways = Ways()
    for agent, start in enumerate(scenario.agents_at_start):
        ways.agents[agent] = [ids[start]]
    for box in range(len(scenario.boxes)):
        ways.boxes[box] = []
        ways.taken.add(box)
    for box, place in enumerate(scenario.boxes_at_start):
        ways.boxes[box].append(ids[place.node])
        ways.taken.remove(box)
    for event in events:
        if event.kind == "goal":
            ways.gone.add(event.agent)
        elif event.kind == "start" and event.agent not in ways.agents:
            ways.agents[event.agent] = [event.node]
        elif event.kind == "change":
            ways.changed.append(event.step)
            if event.action == "add_box":
                ways.taken.discard(event.box)
                ways.boxes[event.box].append(event.node)
            elif event.action == "remove_box":
                ways.taken.add(event.box)
        if event.kind != "end":
            continue
        if event.now_at != ways.agents[event.agent][-1]:
            ways.agents[event.agent].append(event.now_at)
        # Taking hold of a box does not move it; what a failed push did to it only the poses know.
        if event.action == "push" and event.status == "arrived":
            ways.boxes[event.box].append(event.target)
    return ways


def with_boxes(scenario: Scenario, boxes: dict[int, int], changed: Iterable[int] = ()) -> World:
    """The place with its boxes elsewhere, and its agents where they start.

    Args:
        scenario: The place.
        boxes: The node number that each box is on; others are not there.
        changed: Positions in the scenario's timeline of the changes that the place has gone through.

    Raises:
        TraceError: There is no such change.
    """
    world = World(scenario)
    for number in changed:
        if (change := _change(scenario, number)).kind in _BODILESS:
            make(world, change)
    for box in range(len(scenario.boxes)):
        if box not in boxes and world.box_node[box] >= 0:
            world.remove_box(box)
        elif box in boxes and world.box_node[box] < 0:
            world.add_box(box)
    for box, node in boxes.items():
        world.move_box(box, scenario.topology.index[node])
    return world


def _change(scenario: Scenario, number: int) -> Change:
    if not 0 <= number < len(scenario.changes):
        raise TraceError(f"events: a change {number}, but the scenario's timeline has {len(scenario.changes)}")
    return scenario.changes[number]


def blocked_edges(scenario: Scenario, boxes: dict[int, int], changed: Iterable[int] = ()) -> list[tuple[int, int]]:
    """The edges that nobody can pass: their ends are not level (paper Section 3.3), or they are not there.

    Args:
        scenario: The place.
        boxes: The node number that each box is on.
        changed: As for `with_boxes`.
    """
    world, topology = with_boxes(scenario, boxes, changed), scenario.topology
    return [
        (topology.ids[i], topology.ids[j])
        for i, others in enumerate(topology.neighbours)
        for j in others
        if i < j and not world.reachable(i, j)
    ]


class Place(NamedTuple):
    """What a place is like from one moment on, without its boxes; nodes are indices.

    Attributes:
        since: The moment, simulated seconds.
        edges: The edges (i, j), i < j, that are there.
        steps: Those of them that nobody can pass as the surface at one end has changed; holes have none.
        goal: The goal.
        floor: Height of each node's bare surface, graph units.
    """

    since: float
    edges: list[tuple[int, int]]
    steps: list[tuple[int, int]]
    goal: int
    floor: list[float]


def places(scenario: Scenario, events: Iterable[Event]) -> list[Place]:
    """The place as one episode began, and after each change of it, in order.

    Raises:
        TraceError: The events tell of a change that is not in the scenario's timeline.
    """
    world, topology = with_boxes(scenario, {}), scenario.topology
    pairs = [(i, j) for i, others in enumerate(topology.neighbours) for j in others if i < j]
    holes = {hole.node for hole in scenario.holes}

    def now(since: float) -> Place:
        moved = {node for node, z in enumerate(topology.z) if world.floor[node] != z and node not in holes}
        there = [edge for edge in pairs if world.terrain.has_edge(*edge)]
        steps = [
            edge for edge in (there if moved else ())
            if not moved.isdisjoint(edge) and holes.isdisjoint(edge) and not world.reachable(*edge)
        ]  # fmt: skip
        return Place(since, there, steps, world.goal, list(world.floor))

    found = [now(0.0)]
    for event in events:
        if event.kind == "change":
            change = _change(scenario, event.step)
            if change.kind in _BODILESS:
                make(world, change)
                found.append(now(event.time))
    return found


def stops(events: Iterable[Event]) -> list[tuple[int, float, float]]:
    """When agents stood still in one episode: who, from when and until when, infinity for the rest of it."""
    found: list[tuple[int, float, float]] = []
    since: dict[int, float] = {}
    for event in events:
        if event.agent in since and event.kind in ("end", "wait", "goal", "spent", "lost"):
            found.append((event.agent, since.pop(event.agent), event.began if event.kind == "end" else event.time))
        if event.kind == "lost" or (event.kind == "wait" and event.reason == "stopped"):
            since[event.agent] = event.time
    return [*found, *((agent, begun, math.inf) for agent, begun in since.items())]


def change_in_words(event: Event) -> str:
    """What an event of kind "change" does."""
    box = f"box {event.box}"
    return {
        "add_edge": f"edge {event.node}-{event.target} comes",
        "remove_edge": f"edge {event.node}-{event.target} goes",
        "set_surface": f"the surface of {event.node} changes",
        "add_box": f"{box} appears at {event.node}",
        "remove_box": f"{box} disappears at {event.node}",
        "move_goal": f"the goal is {event.node} now",
        "add_agent": f"an agent joins at {event.node}",
        "fail": f"agent {event.agent} fails at {event.node}",
        "wipe": "marks are wiped away",
        "policy": "parameters of the policy change",
    }.get(event.action, event.action)
