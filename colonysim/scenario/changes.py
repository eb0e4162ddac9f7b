"""The timeline of a scenario: what becomes different while a colony is under way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

from colonysim.scenario.scenario import BoxStart
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from colonysim.scenario.places import Places
    from colonysim.scenario.scenario import Scenario
    from colonysim.scenario.timeline import ChangeSection, ConditionSection
    from colonysim.world.topology import Topology

__all__ = ["CHANGES", "Change", "Condition", "Newcomers", "read_changes", "read_newcomers", "refuse_unknown_marks"]

Kind: TypeAlias = Literal[
    "add_edge", "remove_edge", "set_surface", "add_box", "remove_box", "move_goal", "add_agent", "fail", "wipe",
    "policy",
]  # fmt: skip
CHANGES: tuple[Kind, ...] = get_args(Kind)
"""What a change can do."""
FIXED = ("name", "preset", "extra_fields", "model")
"""What no change of `policy` can set: it would be another policy, have other fields, or be made of another file."""


@dataclass(frozen=True, slots=True)
class Condition:
    """What must be so before a change happens.

    Attributes:
        what: "filled" (a hole is level with its rim), "at_goal" (so many agents are), or "seated" (so many boxes lie in
            holes).
        value: The key of the hole, or how many.
    """

    what: Literal["filled", "at_goal", "seated"]
    value: int


@dataclass(frozen=True, slots=True)
class Change:
    """One change; nodes and holes are indices.

    Attributes:
        number: Its position in the file.
        kind: What it does, one of `CHANGES`.
        time: Simulated seconds of the episode at which it happens, or from which on `condition` counts.
        first: The first episode in which it happens.
        last: The last one, None for no end.
        condition: What must be so first, if anything.
        node: The node concerned, one end of the edge, or -1.
        target: The other end of the edge, or -1.
        box: The box that appears or disappears, or -1.
        z: The new height of the node's bare surface, graph units.
        agents: The agents that join or fail.
        seconds: How long they fail, simulated seconds; None for the rest of the episode.
        fields: The fields whose marks go, None for all.
        nodes: The nodes whose marks go.
        parameters: The parameters of the policy that get other values, with these.
        group: Name of the group whose policy it is, "" for that of all.
    """

    number: int
    kind: Kind
    time: float = 0.0
    first: int = 1
    last: int | None = None
    condition: Condition | None = None
    node: int = -1
    target: int = -1
    box: int = -1
    z: float = 0.0
    agents: tuple[int, ...] = ()
    seconds: float | None = None
    fields: tuple[str, ...] | None = None
    nodes: tuple[int, ...] = ()
    parameters: Mapping[str, Any] | None = None
    group: str = ""

    def happens_in(self, episode: int) -> bool:
        """Whether it can happen in the episode of a number."""
        return self.first <= episode and (self.last is None or episode <= self.last)


@dataclass(frozen=True, slots=True)
class Newcomers:
    """What a timeline brings that is not there when an episode begins; nodes are indices.

    Attributes:
        edges: Edges (i, j), i < j.
        boxes: Boxes, numbered after those of the file.
        agents: Where agents join, numbered after those of the file.
    """

    edges: frozenset[tuple[int, int]] = frozenset()
    boxes: tuple[BoxStart, ...] = ()
    agents: tuple[int, ...] = ()


def _path(number: int, field: str = "") -> str:
    return f"changes.{number}.{field}" if field else f"changes.{number}"


def _kind(section: ChangeSection, number: int, places: Places) -> Kind:
    """What a change does; exactly one thing."""
    given = [kind for kind in CHANGES if getattr(section, kind) is not None]
    if len(given) == 1:
        return given[0]
    if given:
        raise places.fault(_path(number, given[1]), f"stands beside `{given[0]}`, expected one of them in each change")
    raise places.fault(_path(number), f"says not what happens, expected one of {', '.join(CHANGES)}")


def read_newcomers(
    sections: Sequence[ChangeSection],
    places: Places,
    edges: set[tuple[int, int]],
    pair: Callable[[tuple[int, int], str], tuple[int, int]],
    node: Callable[[int, str], int],
) -> Newcomers:
    """What the changes bring.

    Args:
        sections: The timeline.
        places: Where it stands.
        edges: The edges that are there to begin with, (i, j) with i < j.
        pair: The indices of two nodes by number, and where they stand.
        node: The index of a node likewise.

    Raises:
        ScenarioError: A change does not do exactly one thing, or names a node that there is not.
    """
    more: set[tuple[int, int]] = set()
    boxes: list[BoxStart] = []
    agents: list[int] = []
    for number, section in enumerate(sections):
        kind = _kind(section, number, places)
        if kind == "add_edge" and section.add_edge is not None:
            i, j = pair(section.add_edge, _path(number, kind))
            if (edge := (min(i, j), max(i, j))) not in edges:
                more.add(edge)
        elif kind == "add_box" and section.add_box is not None:
            at = node(section.add_box.node, _path(number, "add_box.node"))
            boxes.append(BoxStart(at, float(section.add_box.height)))
        elif kind == "add_agent" and section.add_agent is not None:
            agents.append(node(section.add_agent, _path(number, kind)))
    return Newcomers(frozenset(more), tuple(boxes), tuple(agents))


def read_changes(
    sections: Sequence[ChangeSection],
    places: Places,
    topology: Topology,
    rims: Mapping[int, float],
    goal: int,
    boxes: int,
    agents: int,
    node: Callable[[int, str], int],
    edge: Callable[[tuple[int, int], str], tuple[int, int]],
    groups: Sequence[str] = (),
) -> tuple[Change, ...]:
    """The timeline of a scenario.

    Args:
        sections: As it stands in the file.
        places: Where that is.
        topology: The place, with the edges that come.
        rims: The height of each hole's rim, in the order of the holes, graph units.
        goal: The goal to begin with.
        boxes: How many there are, those that come included.
        agents: How many there are, those that join included.
        node: The index of a node by number, and where that stands.
        edge: The indices of two nodes that an edge joins likewise.
        groups: The names of the groups of agents.

    Raises:
        ScenarioError: A change cannot be.
    """
    reader = _Reader(places, topology, rims, {goal}, boxes, agents, node, edge, groups)
    for number, section in enumerate(sections):
        if section.move_goal is not None:
            reader.goals.add(reader.node(section.move_goal, _path(number, "move_goal")))
    next_box = boxes - sum(section.add_box is not None for section in sections)
    next_agent = agents - sum(section.add_agent is not None for section in sections)
    found = []
    for number, section in enumerate(sections):
        change = reader.change(number, section, next_box, next_agent)
        next_box += change.kind == "add_box"
        next_agent += change.kind == "add_agent"
        found.append(change)
    return tuple(found)


class _Reader:
    """Reads changes one by one.

    Args:
        places: Where they stand.
        topology: The place, with the edges that come.
        rims: The height of each hole's rim by its node, in the order of the holes, graph units.
        goals: All nodes that are the goal at some time.
        boxes: How many there are.
        agents: How many there are.
        node: See `read_changes`.
        edge: The same.
        groups: The same.
    """

    def __init__(
        self,
        places: Places,
        topology: Topology,
        rims: Mapping[int, float],
        goals: set[int],
        boxes: int,
        agents: int,
        node: Callable[[int, str], int],
        edge: Callable[[tuple[int, int], str], tuple[int, int]],
        groups: Sequence[str],
    ) -> None:
        self._places, self._topology, self._rims, self.goals = places, topology, rims, goals
        self._boxes, self._agents, self.node, self._edge, self._groups = boxes, agents, node, edge, groups

    def change(self, number: int, section: ChangeSection, next_box: int, next_agent: int) -> Change:
        """A change; a box or an agent that it brings gets the next number."""
        kind, fault = _kind(section, number, self._places), self._places.fault
        if section.group is not None and kind != "policy":
            raise fault(_path(number, "group"), f"stands beside `{kind}`, expected it beside `policy`")
        first, last = self._episodes(number, section)
        more: dict[str, object] = {}
        if (pair := section.add_edge or section.remove_edge) is not None:
            i, j = self._edge(pair, _path(number, kind))
            more = {"node": i, "target": j}
        elif section.set_surface is not None:
            node = self.node(section.set_surface.node, _path(number, "set_surface.node"))
            z = float(section.set_surface.z)
            if node in self._rims and not z < self._rims[node]:
                why = f"the floor of a hole would be {z:g}, not below its rim {self._rims[node]:g}"
                raise fault(_path(number, "set_surface.z"), why)
            more = {"node": node, "z": z}
        elif section.add_box is not None:
            node = self.node(section.add_box.node, _path(number, "add_box.node"))
            if node in self.goals:
                raise fault(_path(number, "add_box.node"), "a box appears on the goal, expected another node")
            more = {"node": node, "box": next_box}
        elif section.remove_box is not None:
            more = {"box": self._number(section.remove_box, self._boxes, "box", _path(number, kind))}
        elif section.move_goal is not None:
            node = self.node(section.move_goal, _path(number, kind))
            if node in self._rims:
                raise fault(_path(number, kind), f"node {section.move_goal} is a hole, expected a node beside it")
            more = {"node": node}
        elif section.add_agent is not None:
            node = self.node(section.add_agent, _path(number, kind))
            if node in self._rims:
                raise fault(_path(number, kind), f"an agent joins in the hole {section.add_agent}")
            more = {"node": node, "agents": (next_agent,)}
        elif section.fail is not None:
            path = _path(number, "fail.agents")
            agents = [
                self._number(agent, self._agents, "agent", f"{path}.{n}") for n, agent in enumerate(section.fail.agents)
            ]
            seconds = section.fail.seconds
            more = {"agents": tuple(agents), "seconds": None if seconds is None else float(seconds)}
        elif section.policy is not None:
            more = self._of_policy(number, section, section.policy)
        else:
            more = self._wiped(number, section)
        return Change(number, kind, float(section.time), first, last, self._condition(number, section.when), **more)  # type: ignore[arg-type]

    def _number(self, number: int, count: int, what: str, path: str) -> int:
        if number < count:
            return number
        there = f"expected 0 to {count - 1}" if count else "there is none"
        raise self._places.fault(path, f"there is no {what} {number}, {there}")

    def _episodes(self, number: int, section: ChangeSection) -> tuple[int, int | None]:
        fault = self._places.fault
        if section.episode is not None:
            for field in ("from_episode", "to_episode"):
                if getattr(section, field) is not None:
                    raise fault(_path(number, field), "stands beside `episode`, expected one of them")
            return section.episode, section.episode
        first, last = section.from_episode or 1, section.to_episode
        if last is not None and last < first:
            raise fault(_path(number, "to_episode"), f"{last} is before from_episode {first}")
        return first, last

    def _condition(self, number: int, section: ConditionSection | None) -> Condition | None:
        if section is None:
            return None
        given = [name for name in ("filled", "at_goal", "seated") if getattr(section, name) is not None]
        if len(given) != 1:
            path = _path(number, f"when.{given[1]}" if given else "when")
            raise self._places.fault(path, "expected exactly one of filled, at_goal and seated")
        if section.filled is not None:
            node = self.node(section.filled, _path(number, "when.filled"))
            if node not in self._rims:
                raise self._places.fault(_path(number, "when.filled"), f"node {section.filled} is no hole")
            return Condition("filled", list(self._rims).index(node))
        if section.at_goal is not None:
            if section.at_goal > self._agents:
                path = _path(number, "when.at_goal")
                raise self._places.fault(path, f"{section.at_goal} agents, but there are only {self._agents}")
            return Condition("at_goal", section.at_goal)
        return Condition("seated", section.seated or 0)

    def _of_policy(self, number: int, section: ChangeSection, given: Mapping[str, Any]) -> dict[str, object]:
        """Parameters and whose they are; whether there are such, the policy itself says."""
        for name in given:
            if name in FIXED:
                path = _path(number, f"policy.{name}")
                raise self._places.fault(path, "cannot change under way, expected other parameters of the policy")
        group = section.group or ""
        if section.group is not None and group not in self._groups:
            raise self._places.fault(_path(number, "group"), f"no group {group!r}; {nearest(group, self._groups)}")
        return {"parameters": dict(given), "group": group}

    def _wiped(self, number: int, section: ChangeSection) -> dict[str, object]:
        assert section.wipe is not None
        wipe, topology = section.wipe, self._topology
        path = _path(number, "wipe")
        if wipe.nodes is not None and wipe.within is not None:
            raise self._places.fault(f"{path}.within", "stands beside `nodes`, expected one of them")
        if wipe.nodes is not None:
            nodes = [self.node(each, f"{path}.nodes.{n}") for n, each in enumerate(wipe.nodes)]
        else:
            nodes = list(range(len(topology)))
            if wipe.within is not None:
                xmin, ymin, xmax, ymax = wipe.within
                nodes = [i for i in nodes if xmin <= topology.x[i] <= xmax and ymin <= topology.y[i] <= ymax]
                if not nodes:
                    raise self._places.fault(f"{path}.within", "there is no node within these borders")
        return {"fields": None if wipe.fields is None else tuple(wipe.fields), "nodes": tuple(nodes)}


def refuse_unknown_marks(scenario: Scenario, fields: Collection[str]) -> None:
    """Refuses a timeline that wipes marks of fields that there are not.

    Raises:
        ScenarioError: It does.
    """
    for change in scenario.changes:
        for n, name in enumerate(change.fields or ()):
            if name not in fields:
                path = f"changes.{change.number}.wipe.fields.{n}"
                raise scenario.fault(path, f"the policy has no field {name!r}; {nearest(name, fields)}")
