"""Groups of agents that differ: what a scenario says of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from colonysim.scenario.format import ScenarioFile
    from colonysim.scenario.places import Places
    from colonysim.scenario.scenario import Scenario

__all__ = ["Group", "groups_of", "refuse_speeds", "refuse_unknown_fields"]


@dataclass(frozen=True, slots=True)
class Group:
    """Agents that have something in common in which they may differ from others.

    Attributes:
        name: Short name, shown in reports.
        agents: Which agents they are: groups are numbered one after another.
        detection_radius: R of these agents, graph units.
        speed: How many times as fast as the scenario's `timing` says they move, on backends without a clock.
        pushes: Whether they take hold of boxes and push them.
        ignores: Names of the fields that they do not read: they see nodes as if nobody had ever marked them.
        policy: Name of their own policy, or "package.module:Name"; None for the scenario's.
        parameters: Parameters of their policy that differ from the scenario's; all of them if `policy` is another one.
        robot: Their robot with physics: its name, or numbers that differ from that of all; None for that one.
    """

    name: str
    agents: range
    detection_radius: float
    speed: float = 1.0
    pushes: bool = True
    ignores: tuple[str, ...] = ()
    policy: str | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    robot: str | Mapping[str, Any] | None = None


def groups_of(file: ScenarioFile, counts: Sequence[int], main: str, places: Places) -> tuple[Group, ...]:
    """The groups that a scenario's file speaks of.

    Args:
        file: The file.
        counts: How many agents each has.
        main: Name of the scenario's policy.
        places: Where that stands.

    Raises:
        ScenarioError: Two have one name.
    """
    found: list[Group] = []
    first = 0
    for n, (section, count) in enumerate(zip(file.groups or (), counts, strict=True)):
        same = [m for m, group in enumerate(found) if group.name == section.name]
        if same:
            raise places.fault(f"groups.{n}.name", f"groups.{same[0]} is called {section.name!r} too")
        own, robot = section.own_policy(), section.robot
        name, parameters = (None, {}) if own is None else (own.name, dict(own.model_extra or {}))
        found.append(
            Group(
                section.name,
                range(first, first + count),
                float(file.detection_radius if section.detection_radius is None else section.detection_radius),
                float(section.speed),
                section.pushes,
                tuple(section.ignores),
                None if name == main else name,
                parameters,
                robot if robot is None or isinstance(robot, str) else robot.model_dump(exclude_none=True),
            )
        )
        first += count
    return tuple(found)


def refuse_speeds(scenario: Scenario) -> None:
    """Refuses groups that are said to be so many times as fast, for backends whose robots have motors.

    Raises:
        ScenarioError: There is one.
    """
    for n, group in enumerate(scenario.groups):
        if group.speed != 1.0:
            raise scenario.fault(
                f"groups.{n}.speed",
                f"{group.speed:g} is for backends without a clock of their own, such as the node world: on this one"
                " the motors say how fast robots are, so a group's `robot`, as {wheel_speed: 5}, does; expected 1",
            )


def refuse_unknown_fields(scenario: Scenario, known: Collection[str]) -> None:
    """Refuses groups that ignore a field which is not among those that are known by name.

    Raises:
        ScenarioError: There is one.
    """
    for n, group in enumerate(scenario.groups):
        for m, name in enumerate(group.ignores):
            if name not in known:
                raise scenario.fault(f"groups.{n}.ignores.{m}", f"no field {name!r}; {nearest(name, known)}")
