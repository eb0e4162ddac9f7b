"""Settings that would not hold are refused, so that no result is labelled with what was never in force."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from typing import Any

    from colonysim.errors import ScenarioError
    from colonysim.scenario.scenario import Scenario

__all__ = ["refuse_contradictions", "refuse_set_twice"]


def refuse_contradictions(scenario: Scenario, given: Mapping[str, Any]) -> None:
    """Refuses fields that were set though something given besides them takes their place.

    Args:
        scenario: As it was loaded, with overrides.
        given: Policy, mode and number of episodes, None for the scenario's own; by their names, dashes before them.

    Raises:
        ScenarioError: One of these fields was set as well.
    """
    elsewhere = {said.lstrip("-"): said for said, value in given.items() if value is not None}
    refuse_set_twice(scenario.overrides, elsewhere, scenario.fault)


def refuse_set_twice(
    paths: Iterable[str], elsewhere: Mapping[str, str], fault: Callable[[str, str], ScenarioError]
) -> None:
    """Refuses fields that are set elsewhere too, and those whose parts were set before them.

    Args:
        paths: The fields that are set, in that order.
        elsewhere: For each field that something else sets, how that is said.
        fault: Makes the error of a field and a message.

    Raises:
        ScenarioError: One of these fields would not hold.
    """
    before: list[str] = []
    for path in paths:
        if said := elsewhere.get(path.removesuffix(".name")):
            raise fault(path, f"contradicts {said}, which sets that too; leave out either")
        if undone := next((earlier for earlier in before if earlier.startswith(f"{path}.")), None):
            raise fault(path, f"takes the place of {undone!r}, set before it; put it first")
        before.append(path)
