"""The stigmergic policy under the names of its presets."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.policies.settings import settings_for
from colonysim.policies.stigmergy import Stigmergy

if TYPE_CHECKING:
    from colonysim.scenario.scenario import Scenario

__all__ = ["Colony", "Oracle", "Paper"]


class Colony(Stigmergy):
    """The recommended rule set, whatever preset the scenario's file names; one that was set besides is refused."""

    preset = "colony"

    def __init__(self, scenario: Scenario) -> None:
        named = scenario.parameters.get("preset", self.preset)
        if "policy.preset" in scenario.overrides and named != self.preset:
            raise scenario.fault("policy.preset", f"contradicts the policy {self.preset!r}; leave out either")
        super().__init__(scenario, settings_for(scenario, self.preset, override=True))
        self.name = self.preset


class Paper(Colony):
    """The paper with only its contradictions repaired."""

    preset = "paper"


class Oracle(Colony):
    """The colony with D and H updated everywhere at each step: a yardstick that knows what no agent could."""

    preset = "oracle"
