"""Places in which bodies would begin in each other, or boxes and pits that no robot can use, are refused by name."""

from __future__ import annotations

from typing import Any

import pytest

import colonysim
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.geometry.layout import lay_out
from colonysim.geometry.robot_choice import with_robot
from colonysim.physics import STANDARD
from colonysim.scenario.invent import invent

BRIDGE: dict[str, Any] = {
    "name": "bridge", "nodes": [[0, 0, 0, 1], [1, 1.5, 0, 1], [2, 3, 0, 0.65], [3, 4.5, 0, 1]],
    "edges": {"radius": 1.6}, "holes": [2], "boxes": [[1, 0.35]], "agents": [0], "goal": 3,
}  # fmt: skip
GROUND = {"xmin": -4, "ymin": -4, "xmax": 12, "ymax": 4, "z": 0}


def refused(**changed: Any) -> str:
    with pytest.raises(ScenarioError) as found:
        lay_out(colonysim.scenario_from_document({**BRIDGE, **changed}))
    return str(found.value)


def test_robots_that_would_begin_in_each_other_are_refused_without_an_edge_between_them() -> None:
    said = refused(
        nodes=[[0, 0, 0], [1, 0, 2], [2, 0.3, 0], [3, 2, 2], [4, 3.5, 3], [5, 0.3, -2]],
        edges=[[0, 1], [2, 5], [1, 3], [3, 4], [5, 3]], holes=[], boxes=[], agents=[0, 2], goal=4,
    )  # fmt: skip
    assert "the robots on nodes 0 and 2 begin 0.48 m from each other" in said and "xy_scale" in said


def test_boxes_that_would_begin_in_each_other_are_refused() -> None:
    said = refused(
        nodes=[[0, 0, 0], [1, 0, 2], [2, 0.2, 2], [3, 2, 2], [4, 3.5, 3]],
        edges=[[0, 1], [1, 3], [3, 4], [2, 3]], holes=[], boxes=[[1, 1], [2, 1]], goal=4,
    )  # fmt: skip
    assert "the boxes at nodes 1 and 2 begin in each other" in said


@pytest.mark.parametrize(
    ("physics", "said"),
    [
        ({"box_height": 0.01}, "physics.box_height: the box at node 1 is 0.01 m high, expected at least 0.05 m"),
        ({"box_mass": 0.1}, "physics.box_mass: the box at node 1 has 0.1 kg, expected at least 1 kg"),
        ({"box_mass": 0.1, "robot": "half"}, "has 0.1 kg, expected at least 0.125 kg"),
        (
            {"terrain": {"grounds": [GROUND], "pits": [{"x": 4.8, "y": 0, "depth": 0.25, "side": 0.3}]}},
            "the pit at hole 2 is 0.3 m wide, expected at least 1.031 m",
        ),
        (
            {"terrain": {"grounds": [GROUND], "pits": [{"x": 5.2, "y": 0, "depth": 0.25}]}},
            "the pit of hole 2 lies 0.40 m off its node, expected at most 0.10 m",
        ),
    ],
)
def test_boxes_and_pits_that_no_robot_can_use_are_refused(physics: dict[str, Any], said: str) -> None:
    assert said in refused(physics=physics)


@pytest.mark.parametrize("wrong", ["a", None, [1], float("nan"), True])
def test_numbers_of_a_robot_of_others_are_checked(wrong: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    monkeypatch.setattr("colonysim.geometry.robot_choice.load", lambda group, name: replace(STANDARD, grip=wrong))
    scenario = colonysim.scenario_from_document({**BRIDGE, "physics": {"robot": "bots:ODD"}})
    with pytest.raises(ColonysimError, match=r"physics\.robot.*grip.*expected a number"):
        with_robot(scenario)
    monkeypatch.setattr("colonysim.geometry.robot_choice.load", lambda group, name: replace(STANDARD, scale=0.0))
    with pytest.raises(ColonysimError, match="expected a number above 0"):
        with_robot(scenario)


def test_worlds_that_new_strews_at_random_can_be_built_with_all_defaults() -> None:
    for seed in (5003, 5059, 5099):
        document = invent("geometric", columns=5, rows=5, agents=4, seed=seed)
        assert lay_out(colonysim.scenario_from_document(document)).robots
