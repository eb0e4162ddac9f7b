"""Each row of docs/readings.md is an option: its two values differ as the row says."""

from __future__ import annotations

import dataclasses
import math
import random

import pytest
from small_worlds import Script, line, place, play, push, stand, visit

from colonysim import load_scenario
from colonysim.backends.nodeworld import NodeWorld
from colonysim.pheromones import BoxWorth, Distance, Exploration, HoleTrail, Write, extent
from colonysim.policies.settings import StigmergySettings
from colonysim.policies.stigmergy import Memory, Stigmergy
from colonysim.policies.view import LocalView
from colonysim.randomness import Streams
from colonysim.world.intents import BoxPlace, Outcome, Push, Travel, Wait
from colonysim.world.state import World

HOLE = (-1.0, 0.0)


class Mind:
    """One agent before a decision: its world, policy, fields and view."""

    def __init__(self, scenario, agent: int = 0, **options) -> None:
        self.scenario, self.agent = scenario, agent
        self.policy = Stigmergy(scenario, StigmergySettings(**options))
        self.world = World(scenario)
        self.fields = self.policy.fields(self.world)
        body = NodeWorld()
        body.reset(self.world, Streams(0))
        self.view = LocalView(self.world, self.fields, body, agent)
        self.memory = self.policy.begin(agent, None)

    def decide(self, seed: int = 0, **memory):
        self.view.look()
        memory.setdefault("epsilon", 0.0)
        return self.policy.decide(self.view, dataclasses.replace(self.memory, **memory), random.Random(seed))


# -- H ------------------------------------------------------------------------------------------------------------


def test_hole_rule_with_the_printed_minimum_there_is_no_trail():
    ends = {}
    for rule in ("max", "min"):
        world = World(line(6, goal=0, agents=[0], holes={5: HOLE}, detection_radius=1.1))
        field = HoleTrail(world, rule=rule)
        for _ in range(8):
            for node in (4, 3, 2, 1, 0, 1, 2, 3):
                field.deposit(visit(world, node))
        ends[rule] = [field.at(node, 0) for node in range(5)]
    assert ends["max"] == pytest.approx([math.exp(-4), math.exp(-3), math.exp(-2), math.exp(-1), 1.0])
    assert ends["min"] == [0.0] * 5


def test_hole_evaporation_resets_or_halves():
    for keep, left in ((0.0, 0.0), (0.5, 0.5)):
        world = World(line(2, agents=[0], holes={1: HOLE}))
        field = HoleTrail(world, evaporation=keep)
        field.deposit(visit(world, 0))
        field.end_episode()
        assert field.at(0, 0) == pytest.approx(left)
        assert list(field.keys(0)) == ([0] if left else [])


def test_beyond_r_a_carrier_climbs_h_one_neighbour_at_a_time():
    mind = Mind(line(8, goal=7, agents=[1], holes={6: HOLE}, boxes=[(2, 1.0)], detection_radius=1.5))
    mind.fields["H"].load([Write(2, 0, 0.10), Write(3, 0, 0.2), Write(1, 0, 0.05)])
    push(mind.world, 0, 0, 2, 0)
    choice = mind.decide(box=0, hole=0)
    assert choice.intent == Push(0, 3, 0)
    for level in (0.10, 0.09):
        mind.fields["H"].load([Write(3, 0, level)])
        choice = mind.decide(box=0, hole=0)
        assert not isinstance(choice.intent, Push), "where nothing is higher, the box is left"


def test_within_r_the_shortest_way_is_planned_whatever_h_says():
    points = [(0, 0), (1, 0), (2, 0), (3, 0), (2, 1), (9, 9)]
    edges = [(0, 1), (1, 2), (2, 3), (2, 4)]
    mind = Mind(place(points, edges, goal=5, agents=[0], holes={3: HOLE}, boxes=[(1, 1.0)]))
    push(mind.world, 0, 0, 1, 0)
    push(mind.world, 0, 0, 2, 0)
    mind.fields["H"].load([Write(2, 0, 0.5), Write(4, 0, 0.9)])
    assert mind.decide(box=0, hole=0).intent == Push(0, 3, 0)


# -- D ------------------------------------------------------------------------------------------------------------


def test_distance_rule_lrta_looks_ahead_before_the_goal_is_found():
    # Node 2 is nearer to the goal as the crow flies, but a dead end: 1-2 stands before a cliff.
    points = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.5, 0.0, 9.0)]
    ends = {}
    for rule in ("lrta", "literal"):
        world = World(place(points, [(0, 1), (1, 2), (2, 3)], goal=3, agents=[0]))
        field = Distance(world, d_max=10.0, rule=rule)
        for _ in range(3):
            for node in (1, 2):
                field.deposit(visit(world, node))
        ends[rule] = (field.d[1], field.d[2], field.official[2])
    assert ends["literal"] == (1.5, 0.5, False), "the straight distance stays, and draws everybody to the cliff"
    assert ends["lrta"][1] > 2.0 and not ends["lrta"][2]


def test_distance_overwrites_so_it_may_grow_when_a_hole_reopens():
    world = World(line(4, goal=3, agents=[0], holes={2: HOLE}, boxes=[(1, 1.0)]))
    field = Distance(world, d_max=10.0, rule="literal")
    stay = Outcome("arrived", 0, (BoxPlace(0, 2),))
    world.apply(0, Wait(), stay)
    for node in (3, 2, 1, 0):
        field.deposit(visit(world, node))
    assert list(field.d) == [3.0, 2.0, 1.0, 0.0]
    lrta = Distance(world, d_max=10.0)
    lrta.load(field.frame())
    world.reset()
    lrta.deposit(visit(world, 0))
    assert lrta.d[0] == 3.0, "no way out: as far as the crow flies"


def test_unvisited_nodes_look_as_near_as_they_lie_or_worthless():
    scenario = line(4, goal=3, agents=[1])
    straight, zero = Mind(scenario), Mind(scenario, unvisited="zero")
    d_max = straight.fields["D"].d_max
    assert [straight.fields["D"].at(n) for n in range(4)] == [d_max - 3, d_max - 2, d_max - 1, d_max]
    assert [zero.fields["D"].at(n) for n in range(4)] == [0.0] * 4
    assert straight.decide().probabilities[1] > 0.99
    assert zero.decide().probabilities == (0.5, 0.5)


def test_updates_on_the_occupied_node_or_everywhere():
    for updates, changed in (("occupied", {1}), ("everywhere", {0, 1})):
        mind = Mind(place([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1), (1, 2), (2, 3)], goal=3, agents=[1]),
                    updates=updates)  # fmt: skip
        # 2-3 is as far as the crow flies already; what changes elsewhere is the distance at 0.
        assert {write.node for write in mind.fields["D"].deposit(visit(mind.world, 1))} == changed
        holes = Mind(line(4, goal=0, agents=[0], holes={3: HOLE}, detection_radius=1.0), updates=updates)
        assert {w.node for w in holes.fields["H"].deposit(visit(holes.world, 0))} == (
            {2, 3} if updates == "everywhere" else set()
        )


def test_d_max_is_measured_along_edges_and_only_shifts_d():
    scenario = place([(0, 0), (4, 0), (4, 3)], [(0, 1), (1, 2)], goal=2, agents=[1])
    small, large = Mind(scenario, d_max=1.5), Mind(scenario, d_max=6.0)
    assert extent(small.world) == 7.0
    assert (small.fields["D"].d_max, large.fields["D"].d_max) == (10.5, 42.0)
    assert small.decide().probabilities == pytest.approx(large.decide().probabilities)
    assert small.fields["D"].at(0) > 0.0


# -- B ------------------------------------------------------------------------------------------------------------


def test_box_start_outweighs_every_d_or_boxes_are_left_alone():
    scenario = line(6, goal=0, agents=[2], holes={4: HOLE}, boxes=[(3, 1.0)])
    for start, taken in ((2.0, True), (0.5, False)):
        mind = Mind(scenario, box_start=start)
        assert isinstance(mind.decide().intent, Push) == taken
        assert (mind.fields["B"].at(0, 0) > mind.fields["D"].at(0)) == taken


def test_box_cap_holds_b_down():
    for cap, highest in ((None, 20.0 / 0.5**20), (4.0, 40.0)):
        world = World(line(4, goal=3, agents=[0], holes={2: HOLE}, boxes=[(2, 1.0)]))
        field = BoxWorth(world, start=20.0, decay=0.5, cap=math.inf if cap is None else cap * 10.0)
        for _ in range(20):
            field.deposit(visit(world, 3, left=2, before=1))
        assert field.at(0, 0) == highest
    scenario = line(4, goal=3, agents=[0], holes={2: HOLE}, boxes=[(1, 1.0)])
    assert Mind(scenario, box_cap=None).fields["B"]._cap == math.inf
    assert Mind(scenario, box_cap=3.0).fields["B"]._cap == 3.0 * 1.5 * 3.0


def test_box_decay_is_the_factor_of_claim_and_crossing():
    scenario = line(4, goal=3, agents=[0], holes={2: HOLE}, boxes=[(2, 1.0)])
    for decay in (0.95, 0.5):
        field = Mind(scenario, box_decay=decay).fields["B"]
        start = field.at(0, 0)
        field.deposit(visit(World(scenario), 0, "claim", box=0, hole=0))
        assert field.at(0, 0) == pytest.approx(start * decay)


def test_box_credit_on_entry_a_useless_box_rises_on_leaving_it_fades():
    """An agent pushes the box in, looks at the dead end behind it, and goes back where it came from."""
    ends = {}
    for credit in ("enter", "leave"):
        world = World(line(4, goal=0, agents=[0], holes={2: HOLE}, boxes=[(2, 1.0)]))
        field = BoxWorth(world, start=20.0, decay=0.5, credit=credit)
        field.deposit(visit(world, 1, "claim", box=0, hole=0))
        stand(world, 0, 1)
        for node in (2, 1):
            left, before = world.agent_node[0], world.agent_from[0]
            stand(world, 0, node)
            field.deposit(visit(world, node, left=left, before=before))
        ends[credit] = field.at(0, 0)
    assert ends == {"enter": 20.0, "leave": 10.0}


def test_stack_credit_all_or_the_top_one():
    for stack, values in (("all", [40.0, 40.0]), ("top", [20.0, 40.0])):
        world = World(line(4, goal=3, agents=[0], holes={2: (-2.0, 0.0)}, boxes=[(2, 1.0), (2, 1.0)]))
        field = BoxWorth(world, start=20.0, decay=0.5, stack=stack)
        field.deposit(visit(world, 3, left=2, before=1))
        assert [field.at(box, 0) for box in (0, 1)] == values


def test_a_box_that_is_carried_across_is_not_credited():
    world = World(line(5, goal=4, agents=[0], holes={2: HOLE}, boxes=[(2, 1.0), (1, 1.0)]))
    field = BoxWorth(world, start=20.0, decay=0.5, credit="enter")
    for node in (1, 2):
        push(world, 0, 1, node)
    assert [w.node for w in field.deposit(visit(world, 2, left=1, before=0))] == [0]


# -- E and exploration --------------------------------------------------------------------------------------------


def test_exploration_evaporates_or_loses_its_minimum():
    world = World(line(2, agents=[0]))
    halved, lowered = Exploration(world), Exploration(world, evaporation=None)
    for field in (halved, lowered):
        for node in (0, 0, 0, 1):
            field.deposit(visit(world, node))
        field.end_episode()
    assert [halved.at(n) for n in (0, 1)] == [1.5, 0.5]
    assert [lowered.at(n) for n in (0, 1)] == [2.0, 0.0]


def test_exploration_on_wait():
    policy = Script(lambda agent, view, n: Wait((), 1.0) if n < 3 else Travel(1))
    for on_wait, e in ((False, 1.0), (True, 4.0)):

        class Waits(Script):
            def fields(self, world, on_wait=on_wait):
                return {"E": Exploration(world, on_wait=on_wait)}

        _, rows = play(line(2, goal=1, agents=[0]), policy=Waits(policy.act), episodes=1)
        assert {f.node: f.value for f in rows.tables["frames"]}[0] == e
        mind = Mind(line(2, goal=1, agents=[0]), exploration_on_wait=on_wait)
        assert bool(mind.fields["E"].deposit(visit(mind.world, 0, "wait"))) == on_wait


def test_deposit_at_start_or_only_after_a_step():
    scenario = line(4, goal=3, agents=[1], holes={0: HOLE}, detection_radius=1.1)
    for at_start in (True, False):
        policy = Stigmergy(scenario, StigmergySettings(deposit_at_start=at_start))
        _, rows = play(scenario, policy=policy, episodes=1)
        first = [row for row in rows.tables["deposits"] if row[1] == 0.0]
        assert sorted((row[2], row[4]) for row in first) == ([("D", 1), ("E", 1), ("H", 1)] if at_start else [("H", 1)])
        assert {row[2] for row in rows.tables["deposits"] if row[1] > 0.0} >= {"D", "E"}


@pytest.mark.parametrize("per", ["choice", "episode"])
def test_epsilon_decays_per_choice_or_per_episode(per):
    mind = Mind(line(3, goal=2, agents=[1]), epsilon_per=per, epsilon_decay=0.5, epsilon=0.4, epsilon_floor=0.15)
    assert mind.memory.epsilon == 0.4
    explored = mind.decide(epsilon=1.0)
    assert explored.explored and explored.memory.epsilon == (0.5 if per == "choice" else 1.0)
    assert not mind.decide(epsilon=0.0).explored
    assert mind.decide(epsilon=0.0).memory.epsilon == 0.0
    following = mind.policy.begin(0, Memory(0.4))
    assert following.epsilon == (0.4 if per == "choice" else 0.2)
    assert mind.policy.begin(0, Memory(0.2)).epsilon == (0.2 if per == "choice" else 0.15)


def test_exploring_avoids_what_was_visited_and_offers_boxes_that_can_be_pushed():
    mind = Mind(place([(0, 0), (1, 0), (-1, 0), (0, 1), (0, 2)], [(0, 1), (0, 2), (0, 3), (3, 4)], goal=1,
                      agents=[0], holes={4: HOLE}, boxes=[(3, 1.0)]))  # fmt: skip
    mind.fields["E"].load([Write(1, -1, 1.0)])
    choice = mind.decide(epsilon=1.0)
    assert (choice.targets, choice.boxes) == ((1, 2, 3), (-1, -1, 0))
    assert choice.probabilities[0] == pytest.approx(math.exp(-4) / (2 + math.exp(-4)))
    picked = [mind.decide(seed, epsilon=1.0) for seed in range(20)]
    pushes = [c for c in picked if isinstance(c.intent, Push)]
    assert pushes and all(c.intent == Push(0, 3, 0) and (c.memory.box, c.memory.hole) == (0, 0) for c in pushes)


# -- choices ------------------------------------------------------------------------------------------------------


def test_a_higher_beta_is_more_decided():
    scenario = line(3, goal=2, agents=[1])
    certain = [Mind(scenario, beta=beta).decide().probabilities[1] for beta in (0.0, 1.0, 4.0)]
    assert certain == pytest.approx([0.5, 1 / (1 + math.exp(-2)), 1 / (1 + math.exp(-8))])


def test_overfill_allows_a_hill():
    for overfill, wanted in ((True, Push(0, 1, 0)), (False, None)):
        scenario = line(5, goal=4, agents=[0], holes={2: (-1.0, 0.0)}, boxes=[(1, 2.0)])
        mind = Mind(scenario, overfill=overfill, step_past=False)
        choice = mind.decide()
        assert (choice.intent if isinstance(choice.intent, Push) else None) == wanted
        assert mind.policy._has_room(mind.view, 0, 0) == overfill
    level = Mind(line(5, goal=4, agents=[0], holes={2: HOLE}, boxes=[(1, 1.2)]))
    assert level.policy._has_room(level.view, 0, 0), "within the tolerance of reach it is no hill"


def test_candidates_centre_box_or_agent():
    # The hole is 2 from the agent and 3 from the box beside it.
    points = [(0, 0), (1, 0), (-2, 0), (-1, 0)]
    scenario = place(points, [(0, 1), (0, 3), (3, 2)], goal=1, agents=[0], holes={2: HOLE}, boxes=[(1, 1.0)],
                     detection_radius=2.5)  # fmt: skip
    found = {}
    for centre in ("box", "agent"):
        mind = Mind(scenario, candidates_centre=centre)
        found[centre] = mind.policy._targets(mind.view, mind.memory, 0, 1)
    assert found == {"box": [], "agent": [(0, (1, 0, 3, 2))]}


def test_errands_the_hole_of_a_box_is_remembered_on_the_way_to_it():
    # From 3 the agent sees box and hole, from 4, on its way to the box, the hole no more. H is 1 round the hole, at the
    # box too, and says nothing.
    points = [(0, 0), (1, 0), (2, 0), (1, 1.2), (2.5, 1.8), (0, -1)]
    scenario = place(points, [(0, 1), (1, 2), (3, 4), (2, 4), (0, 5)], goal=5, agents=[3], holes={0: HOLE},
                     boxes=[(2, 1.0)], detection_radius=2.4)  # fmt: skip
    for errands, then in ((True, Push(0, 2, 0)), (False, Travel(3))):
        mind = Mind(scenario, errands=errands)
        mind.fields["H"].load([Write(1, 0, 1.0), Write(2, 0, 1.0)])
        first = mind.decide()
        assert first.intent == Travel(4)
        stand(mind.world, 0, 4)
        mind.memory = first.memory
        assert mind.decide().intent == then


def test_step_past_who_is_shut_in_leaves_a_box_on_another_side():
    scenario = line(5, goal=4, agents=[0], boxes=[(1, 1.0)], max_steps=9)
    for past, ended in ((True, "goal"), (False, "deadlock")):
        events, rows = play(scenario, policy=Stigmergy(scenario, StigmergySettings(step_past=past)), episodes=1)
        assert events[-1].status == ended
        assert not [row for row in rows.tables["deposits"] if row[2] == "B"], "B is not for boxes that are only passed"
    open_way = line(5, goal=4, agents=[1], boxes=[(2, 1.0)])
    assert Mind(open_way).decide().intent == Travel(0), "who has another way out takes that"


def test_collision_two_node_or_reservation():
    # The other agent stands two nodes away: taken is only its own node.
    scenario = line(5, goal=0, agents=[1, 3])
    assert Mind(scenario, collision="reservation").decide().targets == (0, 2)
    assert Mind(scenario, collision="two_node").decide().targets == (0,)
    reserved = Mind(scenario)
    reserved.world.reserve(1, [2])
    assert reserved.decide().targets == (0,)
    beyond_sight = Mind(line(5, goal=0, agents=[1, 3], detection_radius=0.5), collision="two_node")
    assert beyond_sight.decide().targets == (0, 2), "an agent that cannot be seen cannot be avoided"


def carrier(**options) -> Mind:
    """Agent 0 holds the box on 1 and wants to push it on to 2, where agent 1 stands."""
    points = [(0, 0), (1, 0), (2, 0), (3, 0), (2, 1), (9, 0)]
    scenario = place(points, [(0, 1), (1, 2), (2, 3), (2, 4)], goal=5, agents=[0, 2], holes={3: HOLE}, boxes=[(1, 1.0)])
    mind = Mind(scenario, **options)
    push(mind.world, 0, 0, 1, 0)
    return mind


def test_a_carrier_waits_and_asks_for_its_way_or_does_not_ask():
    assert carrier().decide(box=0, hole=0).intent == Wait((2,), 5.0, 2)
    assert carrier(ask_to_clear=False).decide(box=0, hole=0).intent == Wait((2,), 5.0, -1)
    assert carrier(patience=None).decide(box=0, hole=0).intent == Wait((2,), None, 2)
    asked = carrier()
    asked.world.clear_requests[2] = 0
    yields = LocalView(asked.world, asked.fields, NodeWorld(), 1)
    assert yields.asked_to_clear and not asked.view.asked_to_clear
    choice = asked.policy.decide(yields, Memory(1.0), random.Random(0))
    assert choice.intent == Travel(4) and not choice.explored, "it makes way instead of exploring"


def test_what_a_carrier_asks_for_is_left_to_it():
    for ask, left in ((True, (0,)), (False, (0, 2))):
        mind = Mind(line(4, goal=3, agents=[1, 3]), ask_to_clear=ask)
        mind.world.clear_requests[2] = 1
        assert mind.view.wanted(2) and not mind.view.wanted(0)
        assert mind.decide().targets == left
        mind.world.clear_requests[2] = 0
        assert mind.decide().targets == (0, 2), "what it asks for itself is its own"


def test_patience_a_carrier_drops_its_box_and_walks_off():
    for patience, leaves in ((5.0, True), (None, False)):
        mind = carrier(patience=patience)
        mind.view.waited = 5.0
        choice = mind.decide(box=0, hole=0)
        assert isinstance(choice.intent, Travel) == leaves
        if leaves:
            assert choice.intent == Travel(0)
            assert (choice.memory.box, choice.memory.shunned, choice.memory.shunned_at) == (-1, 0, 1)
            stand(mind.world, 0, 0)
            again = mind.decide(shunned=0, shunned_at=1)
            assert isinstance(again.intent, Push), "once it has moved the box may be taken again"


def test_patience_who_shares_a_node_with_a_box_that_it_does_not_hold_waits_no_longer_for_its_way():
    mind = carrier(epsilon=0.0, beta=50.0)
    mind.world.box_claim[0] = -1  # as after it has reached out for another box in vain
    first = mind.decide()
    assert first.intent == Wait((2,), 5.0) and first.memory.shunned == -1
    mind.view.waited = 5.0
    last = mind.decide()
    assert last.intent == Wait((2,), 1.0), "once more, and shortly"
    assert (last.memory.shunned, last.memory.shunned_at) == (0, 1)
    assert mind.decide(shunned=0, shunned_at=1).intent == Travel(0), "then it goes elsewhere"


def test_tries_a_carrier_gives_up_a_box_that_will_not_move():
    for tries, keeps in ((2, False), (None, True)):
        mind = carrier(tries=tries)
        stand(mind.world, 1, 4)
        mind.view.failures = 2
        assert (mind.decide(box=0, hole=0).intent == Push(0, 2, 0)) == keeps


def test_feasibility_pushes_below_the_least_chance_are_not_tried():
    mind = carrier(feasibility=0.5)
    stand(mind.world, 1, 4)
    for chance, pushed in ((0.49, False), (0.5, True)):
        class Unsure(NodeWorld):
            def feasible(self, agent, box, targets, chance=chance):
                return [chance] * len(targets)

        mind.view._backend = Unsure()
        assert isinstance(mind.decide(box=0, hole=0).intent, Push) == pushed


def test_pushing_is_a_step_onto_the_box_s_node_then_both_move():
    scenario = line(6, goal=5, agents=[0], holes={3: HOLE}, boxes=[(1, 1.0)], parameters={"epsilon": 0, "beta": 50})
    events, _ = play(scenario, episodes=1)
    ends = [(e.action, e.node, e.target, e.now_at) for e in events if e.kind == "end"]
    assert ends[:3] == [("take", 0, 1, 1), ("push", 1, 2, 2), ("push", 2, 3, 2)], "at the hole it stays behind"
    assert ends[3:] == [("travel", 2, 3, 3), ("travel", 3, 4, 4), ("travel", 4, 5, 5)]


def test_any_side_in_the_node_world_but_for_no_push():
    for forbidden, chances in (((), [1.0, 1.0]), (((1, 0),), [0.0, 1.0])):
        mind = Mind(line(3, goal=2, agents=[0], boxes=[(1, 1.0)], no_push=frozenset(forbidden)))
        assert list(mind.view.feasible(0, (0, 2))) == chances


def test_at_the_goal_the_agent_leaves_the_map():
    events, _ = play(line(4, goal=3, agents=[2, 1]), episodes=1, policy="paper", seed=1)
    assert [e.node for e in events if e.kind == "goal"] == [3, 3]


def test_the_nearest_box_by_path_is_the_candidate():
    # Box 1 is nearer as the crow flies, box 0 by path.
    points = [(0, 0), (2, 0), (0, 1), (3, 0), (4, 0), (9, 9), (1, 9), (0, 9), (-9, 1)]
    edges = [(0, 1), (1, 3), (0, 7), (7, 6), (6, 2), (3, 4), (2, 8)]
    mind = Mind(place(points, edges, goal=5, agents=[0], detection_radius=30.0, boxes=[(3, 1.0), (2, 1.0)],
                      holes={4: HOLE, 8: HOLE}))  # fmt: skip
    assert mind.view.nearest_box() == (0, 1)
    assert mind.view.nearest_box((0,)) == (1, 7)
    choice = mind.decide()
    assert choice.boxes[-1] == 0 and choice.intent == Travel(1)


def test_a_box_s_way_does_not_lead_through_an_open_hole():
    mind = Mind(line(6, goal=5, agents=[0], holes={2: HOLE, 4: HOLE}, boxes=[(1, 1.0)]))
    assert mind.view.way_to_hole(0, 0) == (1, 2)
    assert mind.view.way_to_hole(0, 1) == ()


@pytest.mark.parametrize("name", ["colony", "paper", "oracle", "random"])
def test_every_policy_runs_every_map(name):
    for place_name in ("sanity", "easy", "medium", "hard"):
        _, rows = play(load_scenario(place_name), policy=name, episodes=2, seed=1)
        assert len(rows.episodes) == 2
