"""A backend that foresees whole ways: which way a box is pushed, and what is asked about."""

from __future__ import annotations

import dataclasses
import random
from itertools import pairwise
from typing import Any

import pytest
from small_worlds import place, push, stand

from colonysim.backends.nodeworld import NodeWorld
from colonysim.policies.settings import StigmergySettings
from colonysim.policies.stigmergy import Stigmergy
from colonysim.policies.view import LocalView, OutOfSightError
from colonysim.randomness import Streams
from colonysim.scenario.scenario import Scenario
from colonysim.world.intents import Push
from colonysim.world.state import World

# A box on 1 and a hole at 4; the short way leads over 2, a longer one over 5 and 6.
POINTS = [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (1.5, -1), (3, -1), (9, 9)]
EDGES = [(0, 1), (1, 2), (2, 3), (3, 4), (1, 5), (5, 6), (6, 4), (0, 7)]
SHORT, LONG = (1, 2, 3, 4), (1, 5, 6, 4)


class Foreseeing(NodeWorld):
    """The node world, but some pushes are known to be unlikely."""

    def __init__(self, **unlikely: float) -> None:
        super().__init__()
        self.unlikely = {(int(edge[1]), int(edge[2])): chance for edge, chance in unlikely.items()}
        self.asked: list[tuple[int, ...]] = []

    def feasible_way(self, agent: int, box: int, way: Any) -> list[float]:
        self.asked.append(tuple(way))
        return [self.unlikely.get(pair, 1.0) for pair in pairwise(way)]


class Mind:
    """An agent on 0 beside the box."""

    def __init__(self, body: NodeWorld, **changes: Any) -> None:
        scenario: Scenario = place(
            POINTS, EDGES, goal=7, agents=[0], holes={4: (-1.0, 0.0)}, boxes=[(1, 1.0)], **changes
        )
        self.policy = Stigmergy(scenario, StigmergySettings(epsilon=0.0, beta=50.0))
        self.world = World(scenario)
        body.reset(self.world, Streams(0))
        self.view = LocalView(self.world, self.policy.fields(self.world), body, 0)
        self.memory = self.policy.begin(0, None)

    def decide(self, **memory: Any) -> Any:
        self.view.look()
        return self.policy.decide(self.view, dataclasses.replace(self.memory, **memory), random.Random(0))

    def hold(self) -> None:
        push(self.world, 0, 0, 1, 0)


@pytest.mark.parametrize(
    ("unlikely", "first"),
    [({}, 2), ({"_23": 0.4}, 5), ({"_12": 0.7, "_34": 0.7}, 5), ({"_12": 0.8, "_34": 0.7}, 2)],
    ids=["all likely", "a later push", "their product", "likely enough"],
)
def test_a_box_goes_the_shortest_way_that_is_likely_as_a_whole(unlikely: dict[str, float], first: int) -> None:
    mind = Mind(Foreseeing(**unlikely))
    mind.hold()
    choice = mind.decide(box=0, hole=0)
    assert choice.intent == Push(0, first, 0)
    assert choice.memory.way == (SHORT if first == 2 else LONG)


def test_a_box_without_a_likely_way_is_neither_taken_nor_kept() -> None:
    mind = Mind(Foreseeing(_23=0.1, _56=0.1))
    assert not isinstance(mind.decide().intent, Push)
    assert isinstance(Mind(Foreseeing(_23=0.1)).decide().intent, Push)
    mind.hold()
    assert mind.decide(box=0, hole=0).memory.box == -1


def test_a_backend_without_foresight_is_asked_about_the_next_push_alone() -> None:
    mind = Mind(NodeWorld())
    assert not mind.view.foresees
    mind.hold()
    assert mind.decide(box=0, hole=0).intent == Push(0, 2, 0)
    assert list(mind.view.feasible_way(0, SHORT)) == [1.0, 1.0, 1.0]
    blind = Foreseeing()
    blind.feasible_way = None  # type: ignore[assignment]
    assert not Mind(blind).view.foresees


def test_the_chance_of_the_first_push_counts_where_no_other_is_known() -> None:
    mind = Mind(NodeWorld(), no_push=frozenset({(1, 2)}))
    assert list(mind.view.feasible_way(0, SHORT)) == [0.0, 1.0, 1.0]


def test_nothing_is_asked_about_what_is_out_of_sight() -> None:
    body = Foreseeing()
    mind = Mind(body, detection_radius=2.1)
    with pytest.raises(OutOfSightError):
        mind.view.feasible_way(0, SHORT)
    mind.hold()
    mind.decide(box=0, hole=0, way=SHORT)
    assert body.asked
    assert all(mind.view.sees(node) for way in body.asked for node in way)


def test_a_plan_is_kept_while_it_is_likely_and_never_leads_straight_back() -> None:
    for unlikely, node in (({}, 6), ({"_56": 0.1}, None)):
        mind = Mind(Foreseeing(**unlikely))
        mind.hold()
        push(mind.world, 0, 0, 5, 0)
        stand(mind.world, 0, 5)
        choice = mind.decide(box=0, hole=0, way=LONG)
        # From 5 the way back over 1 would be the only other one.
        assert choice.intent == Push(0, node, 0) if node else choice.memory.box == -1
