"""Which robot a scenario asks for: a preset, one of somebody's package, or numbers of its own."""

from __future__ import annotations

from dataclasses import asdict, fields, replace
from typing import TYPE_CHECKING, Any

from colonysim.errors import PluginError
from colonysim.plugins import BUILT_IN, load, locate

if TYPE_CHECKING:
    from collections.abc import Mapping

    from colonysim.physics import Robot
    from colonysim.scenario.scenario import Scenario

__all__ = ["of_others", "robot_of", "with_robot"]


def robot_of(scenario: Scenario) -> Robot:
    """The robot that a scenario asks for; nothing of others is imported.

    Raises:
        ScenarioError: The controls cannot handle such a robot, or others' code has to be loaded for it first, as
            `with_robot` does.
    """
    preset, given, place = _asked(scenario)
    if preset not in BUILT_IN["robots"]:
        raise scenario.fault(place, f"{preset!r} is a robot of other code, which only a run imports")
    return _made(scenario, load("robots", preset), given)


def of_others(scenario: Scenario) -> str | None:
    """The "package.module:NAME" of the robot if a run imports others' code for it, else None.

    Raises:
        ScenarioError: There is none under that name.
    """
    preset, _, _ = _asked(scenario)
    return None if preset in BUILT_IN["robots"] else locate("robots", preset)


def with_robot(scenario: Scenario) -> Scenario:
    """The scenario with its robot in numbers, if that is one of others' code; their module is imported.

    So a run's manifest says what the robot was, and whoever opens it needs no code of others.

    Raises:
        ScenarioError: The controls cannot handle such a robot, or there is none under that name.
        PluginError: The module cannot be imported.
    """
    preset, given, place = _asked(scenario)
    if preset in BUILT_IN["robots"]:
        if given:
            robot_of(scenario)
        return scenario
    # Not on import: most runs have no robot of others.
    from colonysim.physics import Robot
    from colonysim.scenario.assemble import digest

    found = load("robots", preset)
    if not isinstance(found, Robot):
        raise scenario.fault(place, f"{locate('robots', preset)} is {type(found).__name__}, expected a colonysim Robot")
    numbers = {name: float(number) for name, number in asdict(_made(scenario, found, given)).items()}
    document = dict(scenario.document)
    document["physics"] = {**document["physics"], "robot": numbers}
    physics = {**scenario.physics, "robot": numbers}
    return replace(scenario, physics=physics, document=document, digest=digest(document))


def _asked(scenario: Scenario) -> tuple[str, Mapping[str, Any], str]:
    """Name of the preset, the numbers given besides it, and where the name stands."""
    asked = scenario.physics.get("robot", "standard")
    if isinstance(asked, str):
        preset, given, place = asked, {}, "physics.robot"
    else:
        preset, given, place = asked.get("preset", "standard"), asked, "physics.robot.preset"
    if ":" not in preset and preset not in BUILT_IN["robots"]:
        try:
            locate("robots", preset)
        except PluginError as error:
            raise scenario.fault(place, str(error)) from None
    return preset, given, place


def _made(scenario: Scenario, preset: Robot, given: Mapping[str, Any]) -> Robot:
    """The preset scaled to the size that is given, and then with the numbers that are."""
    # A preset may be of others' code, and hold anything; its scale has to be a size before it is scaled.
    if (trouble := preset.trouble()) and trouble[1].endswith("expected a number"):
        raise scenario.fault(f"physics.robot.{trouble[0]}", trouble[1])
    if not preset.scale > 0.0:
        raise scenario.fault("physics.robot.scale", f"got {preset.scale:g}, expected a number above 0")
    size = float(given.get("scale", preset.scale))
    robot = preset.scaled(size / preset.scale)
    numbers = {field.name: float(given[field.name]) for field in fields(robot) if field.name in given}
    robot = replace(robot, **numbers)
    if trouble := robot.trouble():
        field, message = trouble
        raise scenario.fault(f"physics.robot.{field}", message)
    return robot
