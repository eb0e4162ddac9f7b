"""Parameters of policies that change while a colony is under way: by its timeline, or by hand."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from colonysim.plugins import make_policy
from colonysim.simulation.groups import GroupPolicies

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping

    from colonysim.policies.policy import Policy
    from colonysim.scenario.changes import Change
    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.rows import Rows
    from colonysim.world.state import World

__all__ = ["Tuning", "check_tunings", "merged", "tuned"]

Tuning = dict[str, dict[str, Any]]
"""Parameters that have other values now than the scenario begins with: by group, "" for the policy of all."""


def merged(tuning: Mapping[str, Mapping[str, Any]], change: Change) -> Tuning:
    """What holds after a change of parameters."""
    found = {group: dict(parameters) for group, parameters in tuning.items()}
    found.setdefault(change.group, {}).update(change.parameters or {})
    return found


def tuned(scenario: Scenario, tuning: Mapping[str, Mapping[str, Any]]) -> Scenario:
    """The scenario whose policies have the parameters that hold now."""
    if not tuning:
        return scenario
    groups = tuple(
        replace(group, parameters={**group.parameters, **tuning[group.name]}) if group.name in tuning else group
        for group in scenario.groups
    )
    return replace(scenario, parameters={**scenario.parameters, **tuning.get("", {})}, groups=groups)


def check_tunings(
    scenario: Scenario,
    given: str | Policy | Callable[[Scenario], Policy] | None,
    world: World,
    rows: Rows,
    fields: Collection[str],
    first: int = 0,
) -> None:
    """Checks the parameters that a timeline changes, each change by itself.

    Args:
        scenario: The scenario.
        given: Name of the policy of all who have none of their own, a factory, or a policy; the scenario's if None.
        world: The world.
        rows: The trace.
        fields: Names of the fields that there are.
        first: Changes of smaller numbers have been checked.

    Raises:
        ScenarioError: A parameter is unknown, out of its range or fixed (see `Stigmergy.fixed`), belongs to fields that
            all agents share, or the policy was given as an object, which takes none.
    """
    for change in scenario.changes[first:]:
        if change.kind != "policy":
            continue
        path = f"changes.{change.number}.policy"
        number = next((n for n, group in enumerate(scenario.groups) if group.name == change.group), None)
        own = scenario if number is None else scenario.of_group(number)
        asked = given if number is None or scenario.groups[number].policy is None else scenario.groups[number].policy
        if asked is not None and not isinstance(asked, str) and not callable(asked):
            raise scenario.fault(path, "the policy was given as an object, whose parameters no scenario can set")
        parameters = {**own.parameters, **(change.parameters or {})}
        one = make_policy(asked, replace(own, parameters=parameters, policy_path=path))
        for name in change.parameters or ():
            if name in getattr(one, "fixed", ()):
                raise scenario.fault(f"{path}.{name}", "cannot change under way, as marks are kept by it")
        made = GroupPolicies(given, tuned(scenario, merged({}, change)), world, rows)
        if made.fields.keys() != set(fields):
            raise scenario.fault(path, "the policy would have other pheromone fields, which cannot come or go")
