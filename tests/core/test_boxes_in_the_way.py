"""Boxes that keep each other, or their agents, from the holes: `colony` does what a walk at random comes upon."""

from __future__ import annotations

import pytest
from small_worlds import line, place, play

from colonysim.backends.nodeworld import NodeWorld
from colonysim.policies.presets import Colony
from colonysim.policies.settings import StigmergySettings
from colonysim.policies.stigmergy import Stigmergy
from colonysim.policies.view import LocalView
from colonysim.scenario.scenario import Scenario
from colonysim.world.state import World

BOX = 0.35


def plan(*rows: str, deep: int = 1, **fields) -> Scenario:
    """`.` floor, `b` box, `B` a box twice as high, `o` hole, `a` agent, `g` goal, blank no node."""
    at = {(x, y): sign for y, row in enumerate(rows) for x, sign in enumerate(row) if sign != " "}
    number = {spot: i for i, spot in enumerate(at)}
    edges = [(number[x, y], number[p]) for x, y in at for p in ((x + 1, y), (x, y + 1)) if p in at]
    where = {sign: [number[spot] for spot in at if at[spot] == sign] for sign in "bBoag"}
    return place(
        [(float(x), float(-y)) for x, y in at],
        edges,
        goal=where["g"][0],
        agents=where["a"],
        holes=dict.fromkeys(where["o"], (-deep * BOX, 0.0)),
        boxes=[(node, BOX) for node in where["b"]] + [(node, 2 * BOX) for node in where["B"]],
        **{"detection_radius": 20.0, "max_steps": 120, **fields},
    )


def solved(scenario: Scenario, episodes: int, policy: str = "colony") -> int:
    events, _ = play(scenario, policy=policy, episodes=episodes, seed=1, kinds={"episode"})
    return sum(event.status == "goal" for event in events)


@pytest.mark.parametrize(
    "scenario",
    [
        pytest.param(plan("abbb.og", deep=3), id="three in a row before a hole for three"),
        pytest.param(plan("a.bb..og"), id="two in a row, one of them of use"),
        pytest.param(plan("a.b.b..g"), id="boxes in a corridor without a hole"),
        pytest.param(plan("go.a.bb", deep=2), id="boxes behind the agent"),
        pytest.param(plan("  b  ", "abbog", "  b  ", deep=3), id="boxes on a junction"),
        pytest.param(plan("a.b.b.og", "      o "), id="two holes, one approach"),
        pytest.param(plan(" b b  ", "a.b..og", " b b  ", deep=3), id="boxes in dead ends"),
        pytest.param(plan("a.bb.og", "a      ", deep=2), id="two agents in a row"),
        pytest.param(plan("aabg"), id="two agents in a dead end behind a box"),
        pytest.param(plan("abbb.og", deep=3, detection_radius=1.5), id="three in a row, little in sight"),
    ],
)
def test_each_episode_ends_at_the_goal(scenario):
    assert solved(scenario, 8) >= 7


def test_the_case_of_three_in_a_row_is_done_from_the_first_episode_on():
    assert solved(plan("abbb.og", deep=3, max_steps=400), 10) == 10


def test_a_box_too_high_for_the_hole_is_moved_aside_by_trying():
    scenario = plan("    . ", "a.bB.og", max_steps=150)
    assert solved(scenario, 6) >= 3
    calm = Stigmergy(scenario, StigmergySettings(restless=None))
    events, _ = play(scenario, policy=calm, episodes=3, seed=1, kinds={"episode"})
    assert not [event for event in events if event.status == "goal"], "nothing else would move it"


def test_who_looks_on_goes_past_a_useless_box_to_the_one_before_the_hole():
    scenario = plan("abbb.og")
    for look_on, wanted in ((True, {2}), (False, set())):
        policy = Stigmergy(scenario, StigmergySettings(look_on=look_on, restless=None))
        events, _ = play(scenario, policy=policy, episodes=1, seed=1)
        assert {event.box for event in events if event.kind == "end" and event.action == "push"} == wanted


def test_ways_past_boxes_lead_over_their_nodes_and_only_if_asked_for():
    scenario = line(6, goal=5, agents=[0], boxes=[(1, BOX), (3, BOX)], detection_radius=20.0)
    view = LocalView(World(scenario), {}, NodeWorld(), 0)
    assert view.find_box(-1, 5) == (0, 1)
    assert view.find_box(-1, 5, [0]) == (-1, -1)
    assert view.find_box(-1, 5, [0], True) == (1, 1)
    view._world.box_claim[0] = 7
    assert view.find_box(-1, 5, [0], True) == (-1, -1), "nobody gets past a box that somebody else holds"


def test_the_paper_neither_looks_on_nor_grows_restless():
    scenario = plan("abbb.og", deep=3)
    assert Colony(scenario).settings.look_on and Colony(scenario).settings.restless == 3.0
    assert solved(scenario, 3, "paper") == 0
