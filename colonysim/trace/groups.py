"""How a run went for each group of its agents."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from colonysim.arguments import wholes

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.reader import Run

__all__ = ["GroupResult", "group_at", "results_at_end", "results_of_groups"]


class GroupResult(NamedTuple):
    """How an episode went for a group of agents.

    Attributes:
        episode: Counted from 1.
        group: Name of the group.
        agents: How many agents it has.
        success: Share of them at the goal.
        steps: Largest count of steps among them if all of them came to the goal, else max_steps.
    """

    episode: int
    group: str
    agents: int
    success: float
    steps: int


def group_at(scenario: Scenario, agent: int) -> str:
    """The name of an agent's group; empty if it has none."""
    return next((group.name for group in scenario.groups if agent in group.agents), "")


def results_at_end(
    scenario: Scenario, episode: int, arrived: Sequence[bool], steps: Sequence[int]
) -> list[GroupResult]:
    """How an episode went for each group.

    Args:
        scenario: The scenario.
        episode: Its number.
        arrived: Whether each agent was at the goal at its end.
        steps: Steps that each agent has begun.
    """
    found = []
    for group in scenario.groups:
        there = sum(bool(arrived[agent]) for agent in group.agents)
        all_there = there == len(group.agents)
        most = max(int(steps[agent]) for agent in group.agents) if all_there else scenario.max_steps
        found.append(GroupResult(episode, group.name, len(group.agents), there / len(group.agents), most))
    return found


def results_of_groups(run: Run, episodes: Collection[int] | None = None) -> list[GroupResult]:
    """How each complete episode of a run went for each group, from its events.

    Args:
        run: The run.
        episodes: Only these.

    Raises:
        TraceError: A damaged part, or a run that kept no trace.
    """
    if episodes is not None:
        episodes = wholes("episodes", episodes)
    found: list[GroupResult] = []
    if run.manifest.get("scenario") is None or not run.scenario.groups:
        return found
    count = len(run.scenario.agents)
    run.check_places("events")
    arrived, steps = [False] * count, [0] * count
    for event in run.events():
        if event.kind == "episode":
            if episodes is None or event.episode in episodes:
                found += results_at_end(run.scenario, event.episode, arrived, steps)
            arrived, steps = [False] * count, [0] * count
        elif event.agent >= 0:
            steps[event.agent] = max(steps[event.agent], event.step)
            arrived[event.agent] = arrived[event.agent] or event.kind == "goal"
    return found
