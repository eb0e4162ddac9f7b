"""Which fields of a scenario may change while its colony is under way."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.errors import ScenarioError
from colonysim.scenario.loading import scenario_from_document
from colonysim.scenario.schema import format_schema

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.scenario.scenario import Scenario

__all__ = ["changed"]

MAY_CHANGE = ("episodes", "max_steps", "policy", "stall_seconds", "time_limit", "timing")
"""Fields, and sections all of whose fields, may change: they say how agents decide and move and how long it all goes
on, and nothing of what is where."""


def changed(scenario: Scenario, settings: Mapping[str, Any] | Sequence[str]) -> Scenario:
    """A scenario with other values of some fields.

    Args:
        scenario: The scenario.
        settings: Fields to set, as for `load_scenario`.

    Raises:
        ScenarioError: One of them is none, does not fit, or cannot change under way.
    """
    words = [settings] if isinstance(settings, str) else settings
    for path in [str(word).partition("=")[0].strip() for word in words]:
        section = path.split(".")[0]
        fixed = section in format_schema()["properties"] and section not in MAY_CHANGE
        if fixed or path in ("policy", "policy.name", "policy.preset"):
            raise ScenarioError(f"--set {path}: cannot change under way; expected a field of {', '.join(MAY_CHANGE)}")
    return scenario_from_document(scenario.document, overrides=settings, source=scenario.source)
