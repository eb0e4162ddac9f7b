"""Which changes of a scenario's timeline a backend can follow."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Collection

    from colonysim.scenario.scenario import Scenario

__all__ = ["ANYWHERE", "refuse_changes"]

ANYWHERE = ("add_edge", "remove_edge", "move_goal", "fail", "wipe", "policy")
"""Kinds of changes that concern no body: every backend can follow them."""


def refuse_changes(scenario: Scenario, backend: str, changes: Collection[str]) -> None:
    """Refuses a timeline that a backend cannot follow.

    Args:
        scenario: The scenario.
        backend: The backend's name.
        changes: Kinds of changes that it can follow, besides those of `ANYWHERE`.

    Raises:
        ScenarioError: It has a change of another kind.
    """
    for change in scenario.changes:
        if change.kind not in ANYWHERE and change.kind not in changes:
            able = ", ".join(dict.fromkeys((*ANYWHERE, *changes)))
            raise scenario.fault(
                f"changes.{change.number}.{change.kind}", f"backend {backend!r} cannot follow this, expected {able}"
            )
