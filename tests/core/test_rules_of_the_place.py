"""What can be reached, pushed and reserved, on the four maps and on small ones."""

from __future__ import annotations

import pytest
from small_worlds import Script, line, place, play, push, stand

from colonysim import load_scenario
from colonysim.backends.nodeworld import NodeWorld
from colonysim.randomness import Streams
from colonysim.world.intents import BoxPlace, Outcome, Push, Travel, Wait
from colonysim.world.state import AgentStatus, World

MAPS = ("sanity", "easy", "medium", "hard")


def carry(world: World, agent: int, box: int, *nodes: int) -> None:
    """Lets an agent take a box (from whatever node) and push it along nodes, given by their numbers here."""
    world.agent_from[agent] = world.agent_node[agent]
    for node in nodes:
        push(world, agent, box, node)


@pytest.mark.parametrize("name", MAPS)
def test_on_the_maps_holes_and_cliffs_cut_and_everything_else_is_joined(name):
    scenario = load_scenario(name)
    world, topology = World(scenario), scenario.topology
    holes = {hole.node for hole in scenario.holes}
    boxes = {box.node for box in scenario.boxes}
    for i in range(len(topology)):
        for j in topology.neighbours[i]:
            plain = not {i, j} & (holes | boxes)
            assert world.reachable(i, j) == plain, (topology.ids[i], topology.ids[j])
            assert world.reachable(i, j) == world.reachable(j, i)


def test_tolerance_of_reach():
    world = World(place([(0, 0, 0), (1, 0, 0.29), (2, 0, 0.6)], [(0, 1), (1, 2)], agents=[0]))
    assert world.reachable(0, 1) and world.reachable(1, 0)
    assert not world.reachable(1, 2) and not world.reachable(2, 1)
    wider = World(place([(0, 0, 0), (1, 0, 0.29), (2, 0, 0.6)], [(0, 1), (1, 2)], agents=[0], reach=0.32))
    assert wider.reachable(1, 2)


def test_a_slope_s_rise_is_taken_off_first():
    hard = load_scenario("hard")
    world = World(hard)
    foot, top = hard.topology.index[30], hard.topology.index[17]
    assert hard.topology.z[top] - hard.topology.z[foot] == pytest.approx(0.5)
    world.apply(0, Push(3, foot, 2), Outcome("arrived", foot))  # an agent shares the foot's node with its box
    assert world.passable(world.level(0), foot, top)
    assert world.can_slide(world.box_base[3], foot, top)
    assert not world.falls(world.box_base[3], foot, top)
    points = [(0, 0, 0), (1, 0, 0.5)]
    assert not World(place(points, [(0, 1)], agents=[0])).reachable(0, 1)
    slope = World(place(points, [(0, 1)], agents=[0], slopes=[(0, 1)]))
    assert slope.reachable(0, 1) and slope.reachable(1, 0)


def test_a_box_is_taken_from_its_own_level_on_top_and_unclaimed():
    world = World(line(4, goal=3, agents=[0, 2], boxes=[(1, 1.0)]))
    assert world.graspable(0, 0, world.level(0), 0)
    world.claim(0, 0)
    assert world.graspable(0, 0, world.level(0), 0)
    assert not world.graspable(1, 0, world.level(1), 2)
    stacked = World(line(3, goal=2, agents=[0], holes={1: (-1.0, 0.0)}, boxes=[(1, 1.0), (1, 1.0)]))
    assert stacked.surface[1] == 1.0
    assert stacked.graspable(0, 1, 0.0, 0)  # the upper box stands on the rim's level
    assert not stacked.graspable(0, 0, -1.0, 0)  # the lower one is covered


def test_a_sunk_box_is_a_floor_and_no_box_to_push():
    world = World(line(4, goal=3, agents=[0], holes={2: (-1.0, 0.0)}, boxes=[(1, 1.0)]))
    push(world, 0, 0, 1)
    push(world, 0, 0, 2)
    assert world.agent_node[0] == 1 and world.agent_box[0] == -1 and world.box_claim[0] == -1
    assert list(world.surface) == [0.0, 0.0, 0.0, 0.0]
    assert world.seated() == 1
    assert not world.graspable(0, 0, 0.0, 1)
    stand(world, 0, 2)
    assert not world.graspable(0, 0, world.level(0), 2)
    assert world.reachable(2, 3)


def test_a_box_goes_down_or_level_never_up():
    world = World(place([(0, 0, 0), (1, 0, 0), (2, 0, 0.1), (1, 1, -0.2)], [(0, 1), (1, 2), (1, 3)],
                        goal=2, agents=[0], boxes=[(1, 1.0)]))  # fmt: skip
    assert world.can_slide(0.0, 1, 0)
    assert not world.can_slide(0.0, 1, 2)
    assert world.can_slide(0.0, 1, 3) and not world.falls(0.0, 1, 3)


def test_a_drop_of_just_reach_is_a_drop():
    """As nobody can walk over a difference of just `reach`, a box that drops so far is lost to its pusher."""
    world = World(place([(0, 0, 0), (1, 0, 0), (2, 0, -0.25), (1, 1, -0.249)], [(0, 1), (1, 2), (1, 3)], goal=0,
                        agents=[0], boxes=[(1, 1.0)], reach=0.25))  # fmt: skip
    assert world.falls(0.0, 1, 2) and not world.passable(0.0, 1, 2)
    assert not world.falls(0.0, 1, 3) and world.passable(0.0, 1, 3)


def test_at_a_drop_the_pusher_stays_behind_else_it_goes_with_the_box():
    world = World(line(5, goal=4, agents=[0], holes={3: (-1.0, 0.0)}, boxes=[(1, 1.0)]))
    push(world, 0, 0, 1)
    assert (world.agent_node[0], world.agent_box[0], world.box_claim[0]) == (1, 0, 0)
    push(world, 0, 0, 2)
    assert (world.agent_node[0], world.box_node[0]) == (2, 2)
    assert world.falls(world.box_base[0], 2, 3)
    push(world, 0, 0, 3)
    assert (world.agent_node[0], world.box_node[0]) == (2, 3)


def test_forbidden_pushes_go_one_way():
    medium = load_scenario("medium")
    world, index = World(medium), medium.topology.index
    base = world.box_base[0]
    assert not world.can_slide(base, index[3], index[2])
    assert world.can_slide(base, index[3], index[4])
    world.apply(0, Wait(), Outcome("arrived", world.agent_node[0], (BoxPlace(0, index[2]),)))
    assert world.can_slide(world.box_base[0], index[2], index[3])
    hard = load_scenario("hard")
    pairs = {(hard.topology.ids[i], hard.topology.ids[j]) for i, j in hard.no_push}
    assert pairs == {(3, 2), (25, 24), (17, 16), (16, 18)}


def test_two_boxes_fill_hole_29_and_a_third_makes_a_hill():
    hard = load_scenario("hard")
    world, index = World(hard), hard.topology.index
    hole, rim = index[29], index[13]
    agent = 2
    carry(world, agent, 1, index[18], rim)
    push(world, agent, 1, hole)
    assert world.surface[rim] - world.surface[hole] == pytest.approx(0.341)
    assert not world.reachable(rim, hole)
    stand(world, agent, index[31])
    carry(world, agent, 3, index[30], index[17], index[26], index[18], rim)
    assert world.falls(world.box_base[3], rim, hole)
    push(world, agent, 3, hole)
    assert world.stacks[hole] == [1, 3]
    assert world.surface[hole] - world.surface[rim] == pytest.approx(0.018)
    assert world.reachable(rim, hole) and world.reachable(hole, index[9])
    assert world.box_base[3] == pytest.approx(4.34 + 0.359)
    third = World(hard)
    for box in (1, 3, 2):
        third.apply(agent, Wait(), Outcome("arrived", third.agent_node[agent], (BoxPlace(box, hole),)))
    assert not third.reachable(rim, hole)
    bases = [third.box_base[box] for box in (1, 3, 2)]
    assert bases == pytest.approx([4.34, 4.699, 5.058])
    # The hill's topmost box stands on the rim's level: it can be taken away again.
    assert third.graspable(agent, 2, third.surface[rim], rim) and not third.graspable(agent, 3, third.surface[rim], rim)
    third.apply(agent, Wait(), Outcome("arrived", third.agent_node[agent], (BoxPlace(2, rim),)))
    assert third.stacks[hole] == [1, 3] and third.reachable(index[9], hole)
    assert [third.box_base[box] for box in (1, 3)] == pytest.approx(bases[:2]), "what lies below has not moved"
    third.apply(agent, Wait(), Outcome("arrived", third.agent_node[agent], (BoxPlace(1, rim, True),)))
    assert third.box_base[3] == pytest.approx(4.34), "a box pulled out from below lets the others sink"


def test_reservations_are_all_or_none_edges_included():
    world = World(line(6, goal=5, agents=[0, 2, 4]))
    assert world.reserve(0, [1, (0, 1)])
    assert (world.node_holder[1], world.edge_holder[0, 1]) == (0, 0)
    assert not world.reserve(1, [3, 1])
    assert world.node_holder[3] == -1 and world.reserved[1] == ()
    assert not world.reserve(1, [3, (0, 1)])
    assert world.node_holder[3] == -1
    assert sorted(world.blockers(1, [3, 1, (0, 1)])) == [0, 1, 1]
    assert not world.reserve(1, [4]), "an occupied node is taken"
    assert world.reserve(2, [5]) and world.reserve(2, [3])
    assert world.node_holder[5] == -1, "a new reservation replaces the old one"
    assert world.free(0, 1) and not world.free(1, 1)
    world.apply(0, Travel(1), Outcome("arrived", 1))
    assert world.node_holder[1] == -1 and (0, 1) not in world.edge_holder
    assert list(world.occupant[:3]) == [-1, 0, 1]
    assert world.release(2) == [3] and world.node_holder[3] == -1


def test_who_arrives_keeps_nothing_reserved():
    world = World(line(4, goal=3, agents=[0], boxes=[(2, 1.0)]))
    body = NodeWorld()
    body.reset(world, Streams(0))
    for node, box in ((1, -1), (2, 0), (1, -1)):
        assert world.reserve_node(0, node) and world.reserved[0] == (node,)
        world.claim(0, box)
        world.arrive(0, node, box, node)
        assert (world.reserved[0], list(world.node_holder)) == ((), [-1] * 4)
    assert world.reserve(0, {2, (1, 2)})
    world.apply(0, Travel(2), Outcome("arrived", 2))
    assert (world.reserved[0], list(world.node_holder), world.edge_holder) == ((), [-1] * 4, {})


def test_claims_end_when_the_box_is_left_sunk_or_its_holder_is_done():
    def carrier() -> World:
        world = World(line(5, goal=4, agents=[0, 3], boxes=[(1, 1.0)]))
        push(world, 0, 0, 1)
        assert world.box_claim == [0]
        return world

    world = carrier()
    world.claim(0, -1)
    assert world.box_claim == [-1]
    world = carrier()
    world.spend(0)
    assert world.box_claim == [-1] and world.occupant[1] == 0
    world = carrier()
    world.apply(0, Push(0, 2, -1), Outcome("failed", 1, reason="tipped", lost=True))
    assert world.box_claim == [-1] and world.agent_status[0] is AgentStatus.LOST and world.occupant[1] == 0
    world = carrier()
    world.leave(0)
    assert world.box_claim == [-1] and world.occupant[1] == -1
    world = carrier()
    world.apply(0, Push(0, 2, -1), Outcome("failed", 1, (BoxPlace(0, 2, True),), reason="stray"))
    assert world.box_claim == [-1] and world.box_stray == [True] and list(world.agent_box) == [-1, -1]
    world = carrier()
    world.apply(0, Push(0, 2, -1), Outcome("blocked", 1, reason="blocked"))
    assert world.box_claim == [0], "a blocked pusher still holds its box"


def test_a_box_that_somebody_shoves_away_is_no_longer_held():
    world = World(line(6, goal=5, agents=[0, 4], boxes=[(1, 1.0)]))
    push(world, 0, 0, 1)
    assert world.held_box(0) == 0
    world.apply(1, Travel(3), Outcome("arrived", 3, (BoxPlace(0, 2, True),)))
    assert (world.held_box(0), list(world.agent_box), world.box_claim) == (-1, [-1, -1], [-1])
    world = World(line(6, goal=5, agents=[0, 4], boxes=[(1, 1.0)]))
    push(world, 0, 0, 1)
    world.apply(1, Travel(3), Outcome("arrived", 3, (BoxPlace(0, 1, True),)))
    assert world.held_box(0) == 0, "moved a little, and still there"


def test_another_agent_takes_over_a_dropped_box():
    world = World(line(6, goal=5, agents=[0, 4], boxes=[(1, 1.0)]))
    push(world, 0, 0, 1)
    push(world, 0, 0, 2)
    stand(world, 1, 3)
    assert not world.graspable(1, 0, world.level(1), 3)
    world.claim(0, -1)
    world.apply(0, Travel(1), Outcome("arrived", 1))
    assert world.agent_box[0] == -1
    assert world.graspable(1, 0, world.level(1), 3)
    push(world, 1, 0, 2)
    assert world.box_claim == [1] and world.agent_box[1] == 0


def test_the_node_world_answers_what_the_place_forbids():
    world = World(line(4, goal=3, agents=[0], holes={2: (-1.0, 0.0)}, boxes=[(1, 1.0)]))
    body = NodeWorld()
    body.reset(world, Streams(0))
    for intent, reason in (
        (Travel(1), "unreachable"), (Travel(3), "no such move"), (Wait(), "no such move"),
        (Push(0, 2, 0), "no such move"),
    ):  # fmt: skip
        done = body.start(0, intent, 0.0)
        assert done is not None and (done.outcome.status, done.outcome.reason) == ("blocked", reason)
    push(world, 0, 0, 1)
    push(world, 0, 0, 2)
    body.reset(world, Streams(0))
    done = body.start(0, Push(0, 2, 0), 0.0)
    assert done is not None and done.outcome.reason == "out of reach"


def test_timing_measured_edges_come_first_and_pushes_have_their_own_speed():
    from colonysim.scenario.scenario import Timing

    timing = Timing(travel=2.0, push=3.0, travel_fixed=0.5, push_fixed=1.0, jitter=0.0, travels={(1, 2): 9.0})
    scenario = line(4, goal=3, agents=[0], timing=timing)
    events, _ = play(scenario, policy=Script(lambda a, view, n: Travel(view.node + 1)), episodes=1)
    assert [e.time for e in events if e.kind == "end"] == [2.5, 11.5, 14.0]
    scenario = line(4, goal=0, agents=[0], timing=timing, boxes=[(1, 1.0)], max_steps=3)
    script = [Push(0, 1, -1), Push(0, 2, -1), Push(0, 3, -1)]
    events, _ = play(scenario, policy=Script(lambda a, view, n: Travel(1) if n > 2 else script[n]), episodes=1)
    # The agent starts on the goal here and is gone at once: nothing is pushed.
    assert [e.kind for e in events] == ["start", "goal", "episode"]
    scenario = line(5, goal=4, agents=[0], timing=timing, boxes=[(1, 1.0)], max_steps=3)
    events, _ = play(scenario, policy=Script(lambda a, view, n: script[n]), episodes=1)
    took = [(e.action, e.time - e.began) for e in events if e.kind == "end"]
    assert took == [("take", 2.5), ("push", 4.0), ("push", 4.0)]
