"""Which robots a scenario asks for, of all or by group: a preset, one of somebody's package, or its own numbers."""

from __future__ import annotations

from dataclasses import asdict, fields, replace
from typing import TYPE_CHECKING, Any, NamedTuple

from colonysim.errors import PluginError
from colonysim.plugins import BUILT_IN, load, locate

if TYPE_CHECKING:
    from collections.abc import Mapping

    from colonysim.physics import Robot
    from colonysim.scenario.scenario import Scenario

__all__ = ["of_others", "robot_of", "robots_of", "with_robot"]


def robot_of(scenario: Scenario) -> Robot:
    """The robot of all agents whose group has none of its own; nothing of others is imported.

    Raises:
        ScenarioError: The controls cannot handle such a robot, or others' code has to be loaded for it first, as
            `with_robot` does.
    """
    return _built_in(scenario, _asked(scenario))


def robots_of(scenario: Scenario) -> tuple[Robot, ...]:
    """What robot each agent is; all are of one scale, and nothing of others is imported.

    Raises:
        ScenarioError: As of `robot_of`, or a group's robot is of another scale than that of all.
    """
    main = robot_of(scenario)
    found = [main] * len(scenario.agents)
    for n, group in enumerate(scenario.groups):
        if group.robot is None:
            continue
        robot = _built_in(scenario, _asked(scenario, n))
        if robot.scale != main.scale:
            scale = f"groups.{n}.robot.scale" if "scale" in group.robot else f"groups.{n}.robot"
            raise scenario.fault(
                scale, f"a robot of scale {robot.scale:g} among robots of scale {main.scale:g} (physics.robot),"
                " expected the same scale: nodes, boxes and pits have the size of the robots",
            )  # fmt: skip
        for agent in group.agents:
            found[agent] = robot
    return tuple(found)


def of_others(scenario: Scenario) -> list[str]:
    """The "package.module:NAME" of each robot for which a run imports others' code.

    Raises:
        ScenarioError: There is none under a name.
    """
    return [*dict.fromkeys(locate("robots", asked.preset) for asked in _all_asked(scenario) if not asked.known)]


def with_robot(scenario: Scenario) -> Scenario:
    """The scenario with its robots in numbers where they are of others' code; their modules are imported.

    So a run's manifest says what a robot was, and whoever opens the run needs no code of others.

    Raises:
        ScenarioError: The controls cannot handle such a robot, or there is none under that name.
        PluginError: The module cannot be imported.
    """
    asked = _all_asked(scenario)
    numbers = {each.group: _imported(scenario, each) for each in asked if not each.known}
    found = _with_numbers(scenario, numbers) if numbers else scenario
    if len(asked) > 1 or asked[0].given:
        robots_of(found)
    return found


def _with_numbers(scenario: Scenario, numbers: Mapping[int | None, dict[str, float]]) -> Scenario:
    """The scenario with robots in numbers, by group; None for that of all others."""
    # Not on import: most runs have no robot of others.
    from colonysim.scenario.assemble import digest

    document, physics, groups = dict(scenario.document), scenario.physics, [*scenario.groups]
    for number, robot in numbers.items():
        if number is None:
            physics = {**physics, "robot": robot}
            document["physics"] = {**document["physics"], "robot": robot}
        else:
            groups[number] = replace(groups[number], robot=robot)
            sections = [*document["groups"]]
            sections[number] = {**sections[number], "robot": robot}
            document["groups"] = sections
    return replace(scenario, physics=physics, groups=tuple(groups), document=document, digest=digest(document))


class _Asked(NamedTuple):
    """A robot that a scenario asks for.

    Attributes:
        path: The field that does.
        place: Where the preset's name stands.
        preset: The robot whose numbers are changed.
        given: The numbers.
        group: The group that it is for, None for all others.
    """

    path: str
    place: str
    preset: str
    given: Mapping[str, Any]
    group: int | None

    @property
    def known(self) -> bool:
        """Whether the preset is one of ours."""
        return self.preset in BUILT_IN["robots"]


def _all_asked(scenario: Scenario) -> list[_Asked]:
    own = [_asked(scenario, n) for n, group in enumerate(scenario.groups) if group.robot is not None]
    return [_asked(scenario), *own]


def _asked(scenario: Scenario, group: int | None = None) -> _Asked:
    """The robot that the scenario asks for, or a group of it; what a group leaves open is as the scenario's is."""
    asked, path = scenario.physics.get("robot", "standard"), "physics.robot"
    given: Mapping[str, Any] = {"preset": asked} if isinstance(asked, str) else asked
    if group is not None:
        asked, path = scenario.groups[group].robot, f"groups.{group}.robot"
        own = {"preset": asked} if isinstance(asked, str) else asked or {}
        given = own if "preset" in own else {**given, **own}
    preset, place = given.get("preset", "standard"), path if isinstance(asked, str) else f"{path}.preset"
    if ":" not in preset and preset not in BUILT_IN["robots"]:
        try:
            locate("robots", preset)
        except PluginError as error:
            raise scenario.fault(place, str(error)) from None
    return _Asked(path, place, preset, {name: x for name, x in given.items() if name != "preset"}, group)


def _built_in(scenario: Scenario, asked: _Asked) -> Robot:
    if not asked.known:
        raise scenario.fault(asked.place, f"{asked.preset!r} is a robot of other code, which only a run imports")
    return _made(scenario, load("robots", asked.preset), asked)


def _imported(scenario: Scenario, asked: _Asked) -> dict[str, float]:
    """The numbers of a robot of others."""
    from colonysim.physics import Robot

    found = load("robots", asked.preset)
    if not isinstance(found, Robot):
        where, what = locate("robots", asked.preset), type(found).__name__
        raise scenario.fault(asked.place, f"{where} is {what}, expected a colonysim Robot")
    return {name: float(number) for name, number in asdict(_made(scenario, found, asked)).items()}


def _made(scenario: Scenario, preset: Robot, asked: _Asked) -> Robot:
    """The preset scaled to the size that is given, and then with the numbers that are."""
    given, path = asked.given, asked.path
    # A preset may be of others' code, and hold anything; its scale has to be a size before it is scaled.
    if (trouble := preset.trouble()) and trouble[1].endswith("expected a number"):
        raise scenario.fault(f"{path}.{trouble[0]}", trouble[1])
    if not preset.scale > 0.0:
        raise scenario.fault(f"{path}.scale", f"got {preset.scale:g}, expected a number above 0")
    size = float(given.get("scale", preset.scale))
    robot = preset.scaled(size / preset.scale)
    numbers = {field.name: float(given[field.name]) for field in fields(robot) if field.name in given}
    robot = replace(robot, **numbers)
    if trouble := robot.trouble():
        field, message = trouble
        raise scenario.fault(f"{path}.{field}", message)
    return robot
