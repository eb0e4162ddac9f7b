"""Hypothesis strategies: random small scenarios that shrink to smaller ones.

from hypothesis import given
from colonysim.testing.strategies import scenarios

@given(scenarios(max_agents=2))
def test_my_policy(scenario): ...
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.errors import MissingExtraError
from colonysim.scenario.loading import scenario_from_document
from colonysim.testing.worlds import random_document

try:
    from hypothesis import strategies as st
except ModuleNotFoundError as error:
    if error.name != "hypothesis":
        raise
    raise MissingExtraError(
        "colonysim.testing.strategies needs Hypothesis: pip install hypothesis; without it,"
        " colonysim.testing.worlds.random_scenario(seed) gives random scenarios too"
    ) from None

if TYPE_CHECKING:
    from colonysim.scenario.scenario import Scenario

__all__ = ["documents", "scenarios"]


def documents(*, max_nodes: int = 12, max_agents: int = 4, max_holes: int = 3) -> st.SearchStrategy[dict[str, Any]]:
    """Random valid scenarios as plain data, for tests of what reads or changes documents.

    Args:
        max_nodes: Most nodes, at least 4.
        max_agents: Most agents, at least 1.
        max_holes: Most holes.
    """
    return st.randoms(use_true_random=False).map(
        lambda rng: random_document(rng, max_nodes=max_nodes, max_agents=max_agents, max_holes=max_holes)
    )


def scenarios(*, max_nodes: int = 12, max_agents: int = 4, max_holes: int = 3) -> st.SearchStrategy[Scenario]:
    """Random valid scenarios with 4 to `max_nodes` nodes; see `random_document` for what they contain.

    Args:
        max_nodes: Most nodes, at least 4.
        max_agents: Most agents, at least 1.
        max_holes: Most holes.
    """
    found = documents(max_nodes=max_nodes, max_agents=max_agents, max_holes=max_holes)
    return found.map(scenario_from_document)
