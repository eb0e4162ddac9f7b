"""Scenarios for the physics backend's tests."""

from __future__ import annotations

import math
from typing import Any

from colonysim.backends.physics import Physics
from colonysim.randomness import Streams
from colonysim.scenario.loading import scenario_from_document
from colonysim.scenario.scenario import Scenario
from colonysim.world.state import World

LANE: dict[str, Any] = {
    "name": "lane",
    "nodes": [[0, 0, 0], [1, 1.2, 0], [2, 2.4, 0], [3, 3.6, 0], [4, 4.8, 0]],
    "edges": [[0, 1], [1, 2], [2, 3], [3, 4]],
    "holes": [{"node": 2, "depth": 0.35}],
    "boxes": [[1, 0.35]],
    "agents": [0],
    "goal": 4,
    "max_steps": 20,
    "episodes": 1,
}
"""A box, and behind it the hole that parts the agent from its goal."""

FORK: dict[str, Any] = {
    "name": "fork",
    "nodes": [[0, 0, 0], [1, 1.4, 0], [2, 2.8, 0], [3, 1.4, 1.4], [4, 1.4, -1.4], [5, 0, 1.4]],
    "edges": [[0, 1], [1, 2], [1, 3], [1, 4], [0, 5], [3, 5]],
    "holes": [],
    "boxes": [[1, 0.35]],
    "agents": [0, 5],
    "goal": 2,
    "max_steps": 20,
    "episodes": 1,
}
"""A box where four ways meet, and two agents."""


def place(document: dict[str, Any], **changes: Any) -> Scenario:
    """A scenario from a document with some of its fields replaced."""
    return scenario_from_document(document | changes)


def two_levels(direction: float, lower: int = 3, upper: int = 3) -> Scenario:
    """A row of nodes that climbs a ramp in its middle, turned to a direction (radians)."""
    c, s = math.cos(direction), math.sin(direction)
    count = lower + upper
    nodes = [[i, round(1.6 * i * c, 6), round(1.6 * i * s, 6), 1.0 if i < lower else 1.5] for i in range(count)]
    return place(
        {
            "name": "two-levels",
            "nodes": nodes,
            "edges": [[i, i + 1] for i in range(count - 1)],
            "slopes": [[lower - 1, lower]],
            "boxes": [[1, 0.35]],
            "agents": [0],
            "goal": count - 1,
        }
    )  # fmt: skip


def started(scenario: Scenario, push: str = "scripted", seed: int = 0) -> tuple[Physics, World]:
    """A backend that has begun an episode."""
    backend, world = Physics(push=push), World(scenario)
    backend.reset(world, Streams(seed))
    return backend, world
