"""Ways of boxes: out of sight of their hole followed to the end, never to and fro for ever, and never over the goal."""

from __future__ import annotations

import dataclasses
from collections import Counter

import pytest
from small_worlds import place, play

from colonysim.backends.mock import Mock
from colonysim.testing import random_scenario
from colonysim.world.intents import Outcome, Push

BEND = place(
    [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.4), (0.0, 2.4), (0.2, 0.6)],
    [(0, 1), (1, 2), (2, 3), (3, 4), (0, 5)],
    agents=(5,),
    goal=4,
    holes={3: (-1.0, 0.0)},
    boxes=[(0, 1.0)],
    detection_radius=1.5,
    max_steps=60,
)
"""The hole at 3 is in sight of all nodes but 1, over which the box must go."""


@pytest.mark.parametrize("seed", range(10, 15))
def test_the_way_is_followed_where_the_hole_is_out_of_sight(seed):
    events, _ = play(BEND, episodes=3, seed=seed)
    assert [event.status for event in events if event.kind == "episode"] == ["goal"] * 3
    for episode in (1, 2, 3):
        pushes = [(e.node, e.target) for e in events if e.episode == episode and e.action == "push" and e.kind == "end"]
        assert pushes == [(0, 1), (1, 2), (2, 3)]


def test_it_is_followed_after_a_push_that_was_blocked():
    def block_once(agent, intent, world):
        if isinstance(intent, Push) and intent.node == 2 and world.box_node[0] == 1 and not blocked:
            blocked.append(agent)
            return Outcome("blocked", 1, reason="stuck")
        return None

    blocked: list[int] = []
    events, _ = play(BEND, backend=Mock(script=block_once), episodes=1, seed=10)
    pushes = [(e.node, e.target, e.status) for e in events if e.action == "push" and e.kind == "end"]
    assert pushes == [(0, 1, "arrived"), (1, 2, "blocked"), (1, 2, "arrived"), (2, 3, "arrived")]


@pytest.mark.parametrize("number", [3, 12, 21, 30, 36, 41, 45])
def test_no_box_is_pushed_to_and_fro_for_ever(number):
    scenario = dataclasses.replace(random_scenario(number, max_agents=3), detection_radius=1.5, max_steps=80)
    events, _ = play(scenario, episodes=4, seed=10)
    pushed = Counter((e.episode, e.box, e.node, e.target) for e in events if e.kind == "end" and e.action == "push")
    assert not pushed or max(pushed.values()) < 10


def test_no_box_is_pushed_over_the_goal_and_nobody_walks_over_it_to_a_box():
    # The short way from the box to the hole leads over the goal 1, and one of two as short from agent 1 to the box.
    points = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)]
    edges = [(0, 1), (1, 2), (0, 3), (1, 4), (3, 4), (4, 5), (2, 5)]
    scenario = place(points, edges, goal=1, agents=(3, 4), holes={2: (-1.0, 0.0)}, boxes=[(0, 1.0)], max_steps=30)
    events, _ = play(scenario, episodes=5, seed=10)
    assert [event.status for event in events if event.kind == "episode"] == ["goal"] * 5
    pushed = {(e.node, e.target) for e in events if e.action == "push" and e.kind == "end"}
    assert {(0, 3), (3, 4), (4, 5), (5, 2)} <= pushed and (0, 1) not in pushed
