"""What the paper says that happens in a run, each as a question that a recorded run answers with yes or no."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import networkx as nx

if TYPE_CHECKING:
    from collections.abc import Callable

    from colonysim.trace.reader import Run

__all__ = ["FACTS", "Fact"]


@dataclass(frozen=True)
class Fact:
    """A question to a run of `colonysim.reproduce.recorded.RUNS`.

    Attributes:
        study: Where it is asked.
        run: Of which run, with many seeds.
        place: The paper's figure.
        says: What the paper says.
        asked: What exactly is looked at.
        holds: The question.
    """

    study: str
    run: str
    place: str
    says: str
    asked: str
    holds: Callable[[Run], bool]


def _by_path_distance(run: Run, episode: int) -> bool:
    values, goal = run.field("D", episode), run.scenario.topology.ids[run.scenario.goal]
    if goal not in values:
        return False
    lengths = nx.single_source_dijkstra_path_length(run.scenario.topology.graph, goal, weight="length")
    return all(values[goal] - value >= lengths[node] - 1e-9 for node, value in values.items())


def _mean(run: Run, name: str, episode: int, nodes: tuple[int, ...]) -> float:
    values = run.field(name, episode)
    return sum(values.get(node, 0.0) for node in nodes) / len(nodes)


def _last(run: Run) -> int:
    return run.episodes[-1].episode


def _useless_box_decays(run: Run) -> bool:
    # B starts at twice d_max, which is D of the goal, under either preset.
    last, goal = _last(run), run.scenario.topology.ids[run.scenario.goal]
    d_max = run.field("D", last).get(goal, 0.0)
    return run.field("B", last).get((2, 20), 2.0 * d_max) < 2.0 * d_max


def _trail(run: Run, hole: int, node: int) -> bool:
    """Whether H of a hole is on a node at the end of most episodes."""
    there = [run.field("H", result.episode).get((node, hole), 0.0) > 0.0 for result in run.episodes]
    return 2 * sum(there) > len(there)


FACTS = (
    Fact(
        "pheromones-sanity", "sanity", "SanityDevelopment", "All nodes have D by path distance by episode 4.",
        "At the end of episode 4 no visited node has a distance below its path's.",
        lambda run: _by_path_distance(run, 4),
    ),
    Fact(
        "pheromones-sanity", "sanity", "SanityDevelopment", "E is higher on the left side, where the agent starts.",
        "Mean E of n0, n1, n2 above that of n4, n5, n6 at the end of episode 3.",
        lambda run: _mean(run, "E", 3, (0, 1, 2)) > _mean(run, "E", 3, (4, 5, 6)),
    ),
    Fact(
        "pheromones-sanity", "sanity", "SanityDevelopment", "B of the box at n2 learns to favour n7 over n3.",
        "Its B for n7 above that for n3 at the end of the last episode.",
        lambda run: run.field("B", _last(run)).get((1, 7), 0.0) > run.field("B", _last(run)).get((1, 3), 0.0),
    ),
    Fact(
        "hole-edge-case", "sanity-r3", "HPheromoneEdgeCase", "With a small radius H leads from n2 to n7.",
        "H of n7 on n2 at the end of most episodes.",
        lambda run: _trail(run, 7, 2),
    ),
    Fact(
        "pheromones-medium", "medium", "MediumBPheromone",
        "B of the upper right box for n20 decays, as n20 serves nothing.",
        "Its B for n20 below 2 d_max, where it starts, at the end of the last episode.",
        _useless_box_decays,
    ),
    Fact(
        "pheromones-hard", "hard-r5-4", "Hard4HPheromone", "With R=5 and 4 agents H of n29 does not reach n17.",
        "H of n29 absent from n17 at the end of most episodes.",
        lambda run: not _trail(run, 29, 17),
    ),
    Fact(
        "pheromones-hard", "hard-r5-6", "Hard6HPheromone", "With two more agents H of n29 reaches n17.",
        "H of n29 on n17 at the end of most episodes.",
        lambda run: _trail(run, 29, 17),
    ),
)  # fmt: skip
