"""What goes wrong by chance (`faults:`): how often, on any backend, for anybody's policy, and not at all if off."""

from __future__ import annotations

import dataclasses
import math
from importlib.machinery import EXTENSION_SUFFIXES

import pytest
from plain_python import PACKAGE, compiled_and_plain
from small_worlds import Script, Scripted, Wrapped, line, play

import colonysim
from colonysim.backends.protocol import Done
from colonysim.policies.stigmergy import Stigmergy
from colonysim.policies.view import OutOfSightError
from colonysim.randomness import Streams
from colonysim.scenario.faults import Faults
from colonysim.scenario.invent import invent
from colonysim.simulation.faults import Breakdowns
from colonysim.states import Stored
from colonysim.testing.worlds import random_scenario
from colonysim.world.intents import Outcome, Travel, Wait

ALL = {
    "move_fails": 0.05, "box_missed": 0.2, "node_misplaced": 0.3, "mark_lost": 0.1, "mark_noise": 0.2,
    "stops": {"every": 20.0, "seconds": 3.0},
}  # fmt: skip
KINDS = ["move_fails", "box_missed", "node_misplaced", "mark_lost", "mark_noise", "stops"]


def near(share, chance, count, sigmas=5.0):
    """Whether a share of so many is what chance makes of it."""
    return abs(share - chance) < sigmas * math.sqrt(chance * (1.0 - chance) / count)


def to_and_fro(agent, view, count):
    return Travel(1 - view.node)


def pair(**fields):
    """One agent on two of three nodes; it never leaves."""
    return line(3, agents=[0], goal=2, **fields)


def with_faults(scenario, **faults):
    return colonysim.scenario_from_document({**scenario.document, "faults": faults})


def world(seed=3, **fields):
    document = invent("grid", columns=8, rows=8, holes=2, spare=2, agents=4, seed=seed)
    return colonysim.scenario_from_document({**document, **fields})


def sha(scenario, **options):
    return colonysim.run(scenario, trace=False, **{"seed": 1, "episodes": 3, **options}).trace_sha256


# -- off -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
@pytest.mark.parametrize("name", ["hard", "sanity"])
def test_a_section_with_nothing_in_it_changes_nothing(name, mode):
    without = colonysim.load_scenario(name)
    for off in ({}, {"seed": 9}, dict.fromkeys(KINDS[:5], 0.0)):
        assert sha(with_faults(without, **off), mode=mode) == sha(without, mode=mode)


def test_the_seed_of_the_faults_and_that_of_the_run_both_count():
    one, other = (world(faults={**ALL, "seed": seed}) for seed in (1, 2))
    assert len({sha(one, seed=1), sha(one, seed=2), sha(other, seed=1)}) == 3
    assert sha(one, seed=1) == sha(one, seed=1)


# -- moves -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("chance", [0.05, 0.5])
@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_so_many_moves_fail_take_their_time_and_move_nobody(chance, mode):
    scenario = pair(max_steps=4000, faults=Faults(move_fails=chance))
    events, _ = play(scenario, policy=Script(to_and_fro), episodes=1, mode=mode)
    ends = [event for event in events if event.kind == "end"]
    failed = [event for event in ends if event.status != "arrived"]
    assert near(len(failed) / len(ends), chance, len(ends))
    assert {(e.status, e.reason, e.now_at == e.node, round(e.time - e.began, 9)) for e in failed} == {
        ("failed", "fault", True, 1.0)
    }
    assert events[-1].time == pytest.approx(len(ends))


def test_a_backend_of_others_is_not_asked_twice_and_its_refusals_stay():
    def answer(agent, intent, now):
        asked.append(intent)
        if len(asked) % 2:
            return Done(2.0, Outcome("arrived", intent.node))
        return Done(0.5, Outcome("blocked", 1 - intent.node, reason="mud"))

    asked = []
    scenario = pair(max_steps=200, faults=Faults(move_fails=0.5))
    events, _ = play(scenario, policy=Script(to_and_fro), backend=Scripted(answer), episodes=1)
    ends = [event for event in events if event.kind == "end"]
    assert len(asked) == len(ends) == 200
    assert {(e.status, e.reason, e.time - e.began) for e in ends} == {
        ("arrived", "", 2.0), ("failed", "fault", 2.0), ("blocked", "mud", 0.5),
    }  # fmt: skip


def test_pushes_fail_too_and_the_box_stays():
    events, _ = play(world(faults={"move_fails": 0.3}), episodes=3, seed=1)
    failed = [e for e in events if e.kind == "end" and e.reason == "fault"]
    assert {"travel", "push"} <= {e.action for e in failed} and all(e.now_at == e.node for e in failed)


@pytest.mark.parametrize("backend", ["bullet", "mujoco"])
def test_on_rigid_bodies_the_robot_does_not_set_off(backend):
    pytest.importorskip({"bullet": "pybullet", "mujoco": "mujoco"}[backend])
    scenario = pair(max_steps=12, faults=Faults(move_fails=0.5))
    events, _ = play(scenario, policy=Script(to_and_fro), backend=backend, episodes=2, seed=1)
    ends = [event for event in events if event.kind == "end"]
    failed = [event for event in ends if event.reason == "fault"]
    assert {event.status for event in ends} == {"arrived", "failed"} and 4 < len(failed) < 20
    typical = {round(event.time - event.began, 6) for event in failed}
    took = [event.time - event.began for event in ends if event.status == "arrived"]
    assert len(typical) == 1 and 0.2 * min(took) < typical.pop() < 2.0 * max(took)
    assert all(event.now_at == event.node for event in failed)


# -- stops -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_an_agent_stops_so_often_and_for_so_long(mode):
    every, seconds = 20.0, 5.0
    scenario = pair(max_steps=20_000, faults=Faults(stop_every=every, stop_seconds=seconds))
    events, _ = play(scenario, policy=Script(to_and_fro), episodes=1, mode=mode)
    stops = [event for event in events if event.reason == "stopped"]
    assert {(event.kind, event.action) for event in stops} == {("wait", "wait")}
    ends = {event.time for event in events if event.kind == "end"}
    if mode == "synchronous":  # there a wait lasts for one tick
        assert near(len(stops) / events[-1].time, seconds / (every + seconds), events[-1].time / seconds)
        return
    assert {event.time for event in stops} <= ends, "a stop begins when the move under way has ended"
    begins = {event.began for event in events if event.kind == "end"}
    assert all(event.time + seconds in begins or event.time + seconds > events[-1].time for event in stops)
    # The move under way ends first: half of an edge's time more on average.
    cycle = every + 0.5 + seconds
    assert len(stops) == pytest.approx(events[-1].time / cycle, rel=5.0 / math.sqrt(len(stops)))


def test_who_waits_when_a_stop_is_due_is_not_woken_but_stands_still_if_woken():
    """Streams as they are drawn; nothing else: the stop is due at 1.5, and lasts to 4."""
    streams = Streams(0).within("episode/1")
    broken = Breakdowns(Faults(stop_every=5.0, stop_seconds=2.5), line(2).topology, 1, ())
    broken.begin(streams)
    broken._next_stop[0] = 1.5
    assert broken.still_until(0, 1.0, True) == 0.0
    assert broken.still_until(0, 3.0, True) == 4.0
    broken._next_stop[0] = 1.5
    assert broken.still_until(0, 3.0, False) == 5.5
    assert broken._next_stop[0] > 5.5


def test_a_deadlock_stays_one_in_spite_of_stops():
    scenario = line(4, agents=[0, 1], goal=3, faults=Faults(stop_every=1.0, stop_seconds=1.0))
    events, _ = play(scenario, policy=Script(lambda agent, view, n: Wait((2,))), episodes=1)
    assert events[-1].status == "deadlock"


# -- sensors ---------------------------------------------------------------------------------------------------------


def looks(scenario, see, count=4000, **options):
    """What a function of the view returns at each decision of agents that go to and fro."""
    seen = []

    def act(agent, view, n):
        seen.append(see(view))
        return Travel(1 - view.node)

    scenario = dataclasses.replace(scenario, max_steps=count)
    play(scenario, policy=Script(act), episodes=1, **options)
    return seen


def boxes_seen(view):
    """The boxes within R, by whatever way of asking."""
    found = view.boxes()
    assert view.box_in_sight() == bool(found)
    for box in (0, 1):
        if box in found:
            assert view.top_box(view.box_node(box)) == box
        else:
            with pytest.raises(OutOfSightError):
                view.box_node(box)
    nearest = view.nearest_box()
    assert (nearest is None and not found) or nearest[0] in found
    assert view.top_box(3) == (0 if 0 in found else -1) and view.top_box(4) == (1 if 1 in found else -1)
    assert view.boxes() == found, "the same throughout a look"
    return tuple(found)


def test_so_many_boxes_are_missed_each_by_itself():
    scenario = line(7, agents=[0], goal=6, boxes=[(3, 0.1), (4, 0.1)], faults=Faults(box_missed=0.3))
    seen = looks(scenario, boxes_seen)
    count = len(seen)
    for box in (0, 1):
        assert near(sum(box in found for found in seen) / count, 0.7, count)
    assert near(seen.count(()) / count, 0.09, count)


def test_what_is_missed_differs_from_agent_to_agent_and_not_with_more_of_them():
    few = line(9, agents=[0], goal=8, boxes=[(3, 0.1), (4, 0.1)], faults=Faults(box_missed=0.5))
    alone = looks(few, lambda view: (view.agent, tuple(view.boxes())), 200)
    more = dataclasses.replace(few, agents=(0, 6))

    def act(agent, view, n):
        seen[agent].append((agent, tuple(view.boxes())))
        return Travel(1 - view.node) if agent == 0 else Wait((), 1.0)

    seen = ([], [])
    more = dataclasses.replace(more, max_steps=200)
    play(more, policy=Script(act), episodes=1)
    assert seen[0][:150] == alone[:150]
    assert [found for _, found in seen[1][:150]] != [found for _, found in alone[:150]]


def test_a_box_that_is_held_is_felt_and_one_that_was_missed_is_looked_for_again():
    """With boxes missed at nine looks of ten, pushers finish what they have begun, and nobody waits for ever."""
    run = colonysim.run(world(faults={"box_missed": 0.9}), episodes=4, seed=2, trace=False)
    assert "deadlock" not in {episode.ended for episode in run.episodes}
    assert sum(episode.seated for episode in run.episodes) > 0


def test_nodes_seem_to_lie_so_far_off():
    sigma = 0.25
    scenario = line(4, agents=[0], goal=3, faults=Faults(node_misplaced=sigma))

    def see(view):
        assert view.position(view.node) == (float(view.node), 0.0), "an agent knows where it is itself"
        other = 1 - view.node
        x, y = view.position(other)
        at = view.neighbours.index(other)
        assert view.lengths[at] == dict(view.ways(view.node))[other] == pytest.approx(math.hypot(x - view.node, y))
        assert view.position(other) == (x, y)
        return x - other, y

    errors = [error for pair in looks(scenario, see) for error in pair]
    count = len(errors)
    assert abs(sum(errors) / count) < 5 * sigma / math.sqrt(count)
    assert sum(error * error for error in errors) / count == pytest.approx(sigma**2, rel=5 * math.sqrt(2 / count))


def test_with_nodes_misplaced_another_box_seems_nearer():
    """Between boxes at distances 3 and 4 the nearer one is chosen, unless lengths seem otherwise."""
    fields = {"agents": [3], "goal": 9, "boxes": [(0, 0.1), (7, 0.1)], "detection_radius": 10.0}

    def nearest(faults):
        def act(agent, view, n):
            found.append(view.nearest_box()[0])
            return Wait((), 1.0)

        found = []
        play(line(10, time_limit=500.0, faults=faults, **fields), policy=Script(act), episodes=1)
        return found

    assert set(nearest(None)) == {0}
    wrong = nearest(Faults(node_misplaced=0.5)).count(1)
    assert 20 < wrong < 250


def test_values_are_read_with_so_much_noise_and_left_without():
    noise = 0.1
    scenario = line(4, agents=[0], goal=3, faults=Faults(mark_noise=noise))
    policy = Stigmergy(scenario)

    class Reader(Script):
        def fields(self, world):
            return policy.fields(world)

    read = []

    def act(agent, view, n):
        field = view.fields["D"]
        value = field.at(1 - view.node)
        assert field.at(1 - view.node) == value == field.values([1 - view.node])[0] == view.d.read(1 - view.node)
        read.append((1 - view.node, value))
        return Travel(1 - view.node)

    long = dataclasses.replace(scenario, max_steps=4000)
    colony = colonysim.Colony(long, policy=Reader(act), episodes=1)
    list(colony)
    for node in (0, 1):
        true = colony.fields["D"].at(node)
        errors = [value / true - 1.0 for at, value in read[50:] if at == node]
        count = len(errors)
        assert abs(sum(errors) / count) < 5 * noise / math.sqrt(count)
        assert sum(e * e for e in errors) / count == pytest.approx(noise**2, rel=5 * math.sqrt(2 / count))


def test_so_many_marks_are_lost_in_each_field():
    counts = [left(world(faults=faults, episodes=10)) for faults in (None, {"mark_lost": 0.25})]
    for name, count in counts[0].items():
        assert count > 1000 and near(counts[1][name] / count, 0.75, count), name


def wander(agent, view, n):
    exits = view.exits()
    return Travel(exits[n % len(exits)]) if exits else Wait((), 1.0)


def left(scenario):
    """How often marks of each field were left at arrivals, by agents whose moves do not depend on them."""
    policy = Stigmergy(scenario)

    class Marker(Script):
        def fields(self, world):
            return policy.fields(world)

    _, rows = play(scenario, policy=Marker(wander), seed=1)
    found = {}
    for row in rows.tables["deposits"]:
        if row[2] in "DE":
            found[row[2]] = found.get(row[2], 0) + 1
    return found


# -- streams of their own --------------------------------------------------------------------------------------------


def broken(scenario, **faults):
    made = Breakdowns(Faults(**{"move_fails": 0.5, "mark_lost": 0.5, **faults}), scenario.topology, 3, "DE")
    made.begin(Streams(5).within("episode/1"))
    return made


def test_drawing_one_kind_does_not_shift_another():
    scenario = line(3)
    one, other = broken(scenario), broken(scenario)
    for _ in range(50):
        one.fails(0), one.mark_lost(0, 0)
    assert [one.fails(1) for _ in range(50)] == [other.fails(1) for _ in range(50)]
    assert [one.mark_lost(0, 1) for _ in range(50)] == [other.mark_lost(0, 1) for _ in range(50)]


def test_the_state_is_plain_data_from_which_it_goes_on():
    scenario = line(3)
    one, other = broken(scenario, box_missed=0.5, stop_every=3.0, stop_seconds=1.0), broken(scenario, box_missed=0.5)
    for _ in range(20):
        one.fails(0), one.mark_lost(2, 1), one.senses.look(1), one.still_until(0, 50.0, True)
    state = one.state()
    other = broken(scenario, box_missed=0.5, stop_every=3.0, stop_seconds=1.0)
    other.restore(Stored(state, "faults"))

    def draw(made):
        found = [(made.fails(0), made.mark_lost(2, 1), made.senses.look(1)) for _ in range(20)]
        return found, [made.still_until(0, 50.0 + 5.0 * n, True) for n in range(20)]

    assert draw(one) == draw(other)
    assert set(map(type, state.values())) <= {dict, type(state["next_stop"])}


# -- everybody's parts, in either form -------------------------------------------------------------------------------


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_a_policy_of_others_errs_as_ours_does(mode):
    for seed in range(40):
        scenario = with_faults(random_scenario(seed, max_nodes=30, max_agents=6), **ALL)
        ours = sha(scenario, seed=seed, mode=mode)
        assert sha(scenario, seed=seed, mode=mode, policy=Wrapped(Stigmergy(scenario))) == ours


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_by_itself_makes_a_difference(kind):
    some = world(faults={kind: ALL[kind] if kind == "stops" else 0.4})
    assert sha(some, episodes=5) != sha(world(), episodes=5)


@pytest.mark.parametrize("name", ["random", "paper", "oracle"])
def test_with_every_built_in_policy(name):
    for seed in range(10):
        scenario = with_faults(random_scenario(seed, max_nodes=20, max_agents=5), **ALL)
        ended = colonysim.run(scenario, policy=name, seed=seed, episodes=2, trace=False).episodes
        assert len(ended) == 2


PROGRAM = """
import colonysim
from colonysim.simulation import episode
from colonysim.testing.worlds import random_scenario
print(episode.__file__)
FAULTS = {"move_fails": 0.05, "box_missed": 0.2, "node_misplaced": 0.3, "mark_lost": 0.1, "mark_noise": 0.2,
          "stops": {"every": 20.0, "seconds": 3.0}}
for seed in range(150):
    document = dict(random_scenario(seed, max_nodes=40, max_agents=8).document)
    starts = document.pop("agents")
    document["groups"] = [{"name": "one", "agents": starts[:1], "speed": 1.5, "detection_radius": 2.5,
                           "pushes": seed % 2 == 0, "ignores": ["D", "E"][: seed % 3], "policy": {"beta": 1.0}}]
    if starts[1:]:
        document["groups"].append({"name": "others", "agents": starts[1:]})
    scenario = colonysim.scenario_from_document({**document, "faults": FAULTS})
    mode = ("asynchronous", "synchronous")[seed % 4 == 3]
    print(seed, colonysim.run(scenario, episodes=2, seed=seed, mode=mode, trace=False).trace_sha256)
"""


@pytest.mark.skipif(not any(PACKAGE.rglob(f"*{EXTENSION_SUFFIXES[0]}")), reason="not compiled")
def test_compiled_and_plain_python_with_groups_and_faults(tmp_path):
    hashes, again = compiled_and_plain(PROGRAM, tmp_path)
    assert hashes == again


def test_futures_of_other_seeds_have_other_faults():
    scenario = dataclasses.replace(random_scenario(3), faults=Faults(move_fails=0.5))
    with colonysim.Colony(scenario, seed=1, episodes=1) as colony:
        colony.run_until(time=2.0)
        futures = {tuple(event.reason for event in colony.fork(seed=seed) if event.kind == "end") for seed in range(4)}
    assert len(futures) == 4
