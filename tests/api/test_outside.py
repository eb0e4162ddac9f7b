"""Decisions from outside: the colony stops where an agent has to decide, and goes on with the answer."""

from __future__ import annotations

import random

import pytest

import colonysim
from colonysim import Colony
from colonysim.errors import ColonysimError, PluginError
from colonysim.policies import Outside
from colonysim.scenario.loading import scenario_from_document
from colonysim.testing.promises import Recorder, same_traces
from colonysim.testing.timelines import random_changes
from colonysim.testing.worlds import random_document
from colonysim.world.intents import Travel, Wait


def driven(colony):
    """Answers every question with the colony's own choice."""
    asked = []
    while not colony.over:
        if colony.step() is None and colony.asked is not None:
            asked.append(colony.asked)
            colony.answer(colony.choice())
    return asked


def native(scenario, **more):
    rows = Recorder()
    for _ in colonysim.simulate(scenario, sink=rows, **more):
        pass
    return rows


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
@pytest.mark.parametrize("policy", ["colony", "paper", "random"])
def test_the_policy_driven_from_outside_gives_its_own_trace(policy, mode):
    scenario, rows = colonysim.load_scenario("hard"), Recorder()
    with colonysim.Colony(
        scenario, policy=Outside.over(policy), mode=mode, episodes=3, seed=4, sink=rows
    ) as colony:
        assert len(driven(colony)) > 100
    same_traces("native", "driven from outside", native(scenario, policy=policy, mode=mode, episodes=3, seed=4), rows)


@pytest.mark.parametrize("number", range(12))
def test_a_timeline_works_too(number):
    rng = random.Random(f"outside/{number}")
    document = random_document(rng)
    document["changes"] = [change for change in random_changes(rng, document) if "wipe" not in change]
    scenario, rows = scenario_from_document(document), Recorder()
    mode = rng.choice(["asynchronous", "synchronous"])
    with colonysim.Colony(scenario, policy=Outside, mode=mode, episodes=3, seed=2, sink=rows) as colony:
        driven(colony)
    same_traces("native", "driven from outside", native(scenario, mode=mode, episodes=3, seed=2), rows)


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_forks_at_a_question_do_what_the_colony_does(mode):
    def make(sink=None):
        return colonysim.Colony("hard", policy=Outside, mode=mode, episodes=1, seed=1, sink=sink)

    colony, questions = make(), 0
    while questions < 40:
        if colony.step() is None:
            colony.answer(colony.choice())
            questions += 1
    while colony.step() is not None:
        pass
    assert colony.asked is not None
    one, two = Recorder(), Recorder()
    twins = [colony.fork(sink=one), colony.fork().fork(sink=two)]
    assert [twin.asked for twin in twins] == [colony.asked] * 2
    asked = [driven(twin) for twin in twins]
    same_traces("fork", "a twin and a twin's twin differ", one, two)
    assert asked[0] == asked[1] == driven(colony)
    assert [twin.now for twin in twins] == [colony.now] * 2


def test_going_through_an_episode_again_gives_the_same_answers(tmp_path):
    """As of a backend of rigid bodies, which cannot say its state."""
    pytest.importorskip("mujoco")
    colony = colonysim.Colony("sanity", backend="mujoco", policy=Outside, episodes=1, seed=1)
    for _ in range(200):
        if colony.asked is not None and colony.step() is None:
            colony.answer(colony.choice())
        elif colony.step() is None and colony.asked is None:
            break
        if colony.now > 20 and colony.asked is not None:
            break
    while colony.step() is not None:
        pass
    assert colony.asked is not None
    colony.save(tmp_path / "colony.npz")
    twin, read = colony.fork(), colonysim.Colony.load(tmp_path / "colony.npz", policy=Outside)
    for other in (twin, read):
        assert (other.asked, other.now) == (colony.asked, colony.now)
        assert driven(other) == driven(colony.fork())
        other.close()
    colony.close()


def test_misuse_is_answered():
    colony = colonysim.Colony("hard", policy=Outside, episodes=1, seed=1)
    with pytest.raises(ColonysimError, match="no agent is asked"):
        colony.answer(Wait())
    while colony.step() is not None:
        pass
    agent = colony.asked
    assert colony.step() is None and colony.run_until(time=5) is None and colony.now == 0.0
    with pytest.raises(PluginError, match="no edge leads there"):
        colony.answer(Travel(colony.view().node))
    assert colony.asked == agent
    colony.answer(Travel(colony.view().exits()[0]))
    assert colony.asked is None
    colony.interrupt()
    last = colony.step()
    while (event := colony.step()) is not None:
        last = event
    assert (last.kind, last.status) == ("episode", "interrupted")
    assert colony.over
    with pytest.raises(ColonysimError, match="no agent is asked"):
        colonysim.Colony("hard", seed=1).choice()


ERRING = {"faults": {"box_missed": 0.3, "node_misplaced": 0.3, "mark_noise": 0.5}}


def _answered(colony):
    """What a colony does whose own policy answers each question."""
    events = []
    while not colony.over:
        if colony.asked is not None:
            colony.answer(colony.choice())
        elif (event := colony.step()) is not None:
            events.append(event)
    return events


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
def test_with_sensors_that_err_it_is_the_policy_s_own_trace_and_can_be_kept_at_a_question(mode, tmp_path):
    scenario = colonysim.load_scenario("hard", overrides=ERRING)
    asked = {"seed": 3, "episodes": 1, "mode": mode}
    own = list(Colony(scenario, policy="colony", **asked))
    assert _answered(Colony(scenario, policy=Outside, **asked)) == own
    for stop in range(1, 40, 6):
        colony, questions, seen = Colony(scenario, policy=Outside, **asked), 0, 0
        while questions < stop or colony.asked is None:
            if colony.asked is not None:
                questions += 1
                colony.answer(colony.choice())
            else:
                seen += colony.step() is not None
        colony.view()  # to look changes nothing
        colony.save(tmp_path / "saved.npz")
        for other in (Colony.load(tmp_path / "saved.npz", policy=Outside), colony.fork(), colony):
            assert _answered(other) == own[seen:], stop


def test_whoever_looks_through_an_agent_s_eyes_changes_nothing():
    scenario = colonysim.load_scenario("hard", overrides=ERRING)
    colony, events = Colony(scenario, seed=3, episodes=1), []
    while (event := colony.step()) is not None:
        events.append(event)
        if colony.now < 5.0 and not colony.over:
            colony.view(0)
    assert events == list(Colony(scenario, seed=3, episodes=1))


def test_a_timeline_that_sets_the_chance_to_explore_is_heeded_from_outside_too():
    changes = [{"time": 3.0, "policy": {"epsilon": 0.9}}, {"time": 9.0, "policy": {"beta": 1.0}}]
    scenario = colonysim.load_scenario("hard", overrides={"changes": changes})
    asked = {"seed": 3, "episodes": 1}
    own = list(Colony(scenario, policy="colony", **asked))
    assert _answered(Colony(scenario, policy=Outside, **asked)) == own
    assert own != list(Colony("hard", policy="colony", **asked))
