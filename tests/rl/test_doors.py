"""Environments of colonies: PettingZoo's own tests, what they say and take, and that nothing of them stays behind."""

from __future__ import annotations

import gc
import math
import threading
import tracemalloc
import warnings

import pytest

pytest.importorskip("pettingzoo")

import numpy as np
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, seed_test

import colonysim
from colonysim import rl
from colonysim.errors import ColonysimError
from colonysim.scenario.loading import scenario_from_document
from colonysim.world.intents import Travel, Wait

EXPECTED = (
    "Observation is not a NumPy array|probably should be gymnasium.spaces|infinity|all zeros|a render|"
    "minimum and maximum|negative numbers|different classes"
)
"""What PettingZoo advises of that is as it should be here."""


@pytest.mark.parametrize("mode", ["asynchronous", "synchronous"])
@pytest.mark.parametrize("flat", [False, True])
def test_pettingzoo_s_own_tests_pass(mode, flat, capsys):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=f".*({EXPECTED})")
        warnings.filterwarnings("ignore", category=DeprecationWarning)
        api_test(rl.aec("hard", mode=mode, flat=flat), num_cycles=100)
        seed_test(lambda: rl.aec("hard", mode=mode, flat=flat), num_cycles=50)
        parallel_api_test(rl.parallel("hard", mode=mode, flat=flat), num_cycles=200)
        parallel_seed_test(lambda: rl.parallel("hard", mode=mode, flat=flat), num_cycles=50)


def episode(env, seed=None):
    """Plays an episode of the scenario's own policy; returns each agent's rewards and last info."""
    env.reset(seed=seed)
    paid, told = dict.fromkeys(env.agents, 0.0), {}
    for agent in env.agent_iter():
        _, reward, terminated, truncated, info = env.last()
        paid[agent] += reward
        told[agent] = (terminated, truncated, info)
        env.step(None if terminated or truncated else env.choice())
    return paid, told


def test_rewards_add_up_to_what_they_say():
    found = {}
    for reward in rl.REWARDS:
        env = rl.aec("medium", reward=reward, policy="colony", overrides={"max_steps": 300})
        found[reward], told = episode(env, seed=5)
        reached = {agent: info["t"] for agent, (terminated, _, info) in told.items() if terminated}
        unit, holes = env.turns.edge_seconds, int(env.colony.world.filled.sum())
        env.close()
    assert reached and holes
    for agent, time in reached.items():
        assert found["own_time"][agent] == pytest.approx(-time / unit)
        assert found["goal"][agent] == 1.0
    assert found["team_time"][max(reached, key=reached.get)] == pytest.approx(
        -sum(info["t"] for _, _, info in told.values()) / unit / len(told)
    )
    assert max(found["filled"].values()) == holes
    assert sum(found["difference"].values()) == len(reached) + holes


def test_a_reward_of_one_s_own_sees_every_event_once():
    seen = []

    def reward(stretch):
        seen.extend(stretch.events)
        return [1.0] * len(stretch.there)

    env = rl.aec("hard", reward=reward, seed=7, pheromones="keep", overrides={"episodes": 2})
    episode(env)
    episode(env)
    env.close()
    native = [*colonysim.simulate(colonysim.load_scenario("hard"), episodes=2, seed=7)]
    assert seen == native


def test_what_is_refused_changes_nothing():
    env = rl.aec("hard", seed=1)
    env.reset()
    agent, before = env.agent_selection, env.infos[env.agent_selection]
    with pytest.raises(ColonysimError, match="no edge leads there"):
        env.step(Travel(env.colony.view().node))
    assert (env.agent_selection, env.infos[agent]) == (agent, before)
    env.step(env.choice())
    env.close()


def test_observations_say_what_they_should():
    document = {
        "nodes": [[0, 0.0, 0.0, 0.0], [1, 2.0, 0.0, 0.0], [2, 4.0, 0.0, 0.0], [3, 6.0, 0.0, -0.359]],
        "edges": [[0, 1], [1, 2], [2, 3]],
        "holes": [3], "boxes": [[1, 0.359]], "agents": [0], "goal": 2, "detection_radius": 10.0, "max_steps": 10,
        "episodes": 1, "timing": {"jitter": 0.0},
    }  # fmt: skip
    env = rl.aec(scenario_from_document(document))
    env.reset()
    seen = env.last()[0]
    assert seen["self"].tolist() == [4.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]
    #                                     exists dx dy length passable free occupied wanted box graspable hole
    assert seen["neighbours"][0].tolist() == [1, 2, 0, 2, 0, 1, 0, 0, 1, 1, 0]
    assert not seen["neighbours"][1].any()
    assert seen["boxes"][0, :4].tolist() == pytest.approx([1, 2, 0, 0.359])
    assert seen["holes"][0].tolist() == pytest.approx([1, 6, 0, 0.359])
    assert seen["action_mask"].tolist() == [1, 0, 0, 0, 1, 1]
    env.step(0)  # takes the box
    seen = env.last()[0]
    assert seen["self"].tolist() == pytest.approx([2.0, 0.0, 1.0, 0.0, 0.0, 0.9, 1.0, 0.0, 0.0, 0.0])
    assert seen["action_mask"].tolist() == [1, 1, 1, 1, 1, 1]
    env.step(3)  # pushes it on
    seen = env.last()[0]
    assert env.colony.boxes.node.tolist() == [2] and seen["neighbours"][1, 10] == pytest.approx(0.359)
    assert env.infos["robot_0"]["outcome"] == "arrived" and env.infos["robot_0"]["dt"] > 0.0
    env.close()


def test_an_action_can_name_the_hole():
    scenario = colonysim.load_scenario("hard")
    ruled, named = rl.aec(scenario), rl.aec(scenario, hole="action")
    moves = named.turns.observer.moves
    assert moves.count == 2 * moves.neighbours * (1 + len(scenario.holes)) + 2
    assert ruled.turns.observer.moves.count == 2 * moves.neighbours + 2
    named.reset(seed=1)
    rng, holes = np.random.default_rng(1), set()
    for _ in named.agent_iter():
        _, _, terminated, truncated, info = named.last()
        if terminated or truncated:
            named.step(None)
            continue
        allowed = np.flatnonzero(info["action_mask"][: moves.wait])
        action = int(rng.choice(allowed)) if len(allowed) else moves.pause
        intent = named.turns.sight(named.turns.asked).intent(action)
        if getattr(intent, "hole", -1) >= 0:
            holes.add(intent.hole)
        named.step(action)
    assert holes


def test_who_is_busy_can_do_nothing():
    env = rl.parallel("hard", seed=1)
    observations, infos = env.reset()
    for _ in range(50):
        asked = [agent for agent in env.agents if infos[agent]["requires_decision"]]
        assert len(asked) == 1
        for agent in env.agents:
            mask = observations[agent]["action_mask"]
            assert mask[-1] == (agent not in asked) and (agent in asked or mask.sum() == 1)
        observations, _, _, _, infos = env.step({agent: env.choice(agent) for agent in asked})
    env.close()
    env = rl.parallel("hard", mode="synchronous")
    _, infos = env.reset()
    assert all(info["requires_decision"] for info in infos.values())
    env.close()


def test_rllib_s_dicts_hold_those_who_act_next():
    env = rl.multi_agent("hard", seed=1, reward="own_time", overrides={"max_steps": 30})
    observations, infos = env.reset()
    totals, done = dict.fromkeys(env.possible_agents, 0.0), False
    while not done:
        assert observations.keys() == infos.keys() and set(observations) & {*env.agents}
        actions = {agent: env.turns.choice() for agent in observations if agent in env.agents}
        assert len(actions) == 1
        observations, rewards, terminated, truncated, infos = env.step(actions)
        assert rewards.keys() == observations.keys()
        for agent, reward in rewards.items():
            totals[agent] += reward
        done = terminated["__all__"] or truncated["__all__"]
    assert not env.agents
    expected, _ = episode(rl.aec("hard", seed=1, reward="own_time", overrides={"max_steps": 30}))
    assert totals == pytest.approx(expected)


def test_marks_are_cleared_or_kept():
    for pheromones, kept in (("clear", False), ("keep", True)):
        env = rl.aec("hard", pheromones=pheromones, seed=1)
        episode(env)
        env.reset()
        assert (env.colony.episode == 2) == kept
        assert (len(env.colony.fields["D"].items()) > 10) == kept
        env.close()


def test_agents_that_join_and_fail():
    document = {
        "nodes": [[i, 2.0 * i, 0.0, 0.0] for i in range(6)], "edges": [[i, i + 1] for i in range(5)], "agents": [0, 1],
        "goal": 5, "episodes": 1, "max_steps": 50,
        "changes": [{"time": 5.0, "add_agent": 0}, {"time": 7.0, "fail": {"agents": [1]}}],
    }  # fmt: skip
    env = rl.aec(scenario_from_document(document), policy="random", reward="own_time")
    env.reset(seed=1)
    assert env.agents == ["robot_0", "robot_1", "robot_2"]
    assert not env.observe("robot_2")["self"].any()
    asked, ends = {}, {}
    for agent in env.agent_iter():
        *_, terminated, truncated, info = env.last()
        if terminated or truncated:
            ends[agent] = info["reason"]
            env.step(None)
        else:
            asked.setdefault(agent, info["t"])
            env.step(env.choice())
    assert ends["robot_1"] == "lost" and asked["robot_2"] >= 5.0


def test_a_fork_goes_its_own_way():
    env = rl.aec("hard", seed=1)
    env.reset()
    for _ in range(12):
        env.step(env.choice())
    twins = [env.fork(), env.fork(seed=2), env.fork(seed=3)]
    ends = []
    for twin in (*twins, env):
        for agent in twin.agent_iter():
            twin.step(None if twin.terminations[agent] or twin.truncations[agent] else twin.choice())
        ends.append(twin.colony.now)
        twin.close()
    assert ends[0] == ends[3] and len(set(ends)) == 3


def test_the_state_for_a_critic():
    for make in (rl.aec, rl.parallel):
        env = make("hard", seed=1)
        env.reset()
        state = env.state()
        assert env.state_space.contains(state)
        agent = env.turns.asked
        env.turns.answer(Wait())
        assert env.turns.asked != agent and (env.state()[0] > 0) == (env.colony.now > 0)
        env.close()


def test_misuse_is_answered():
    for options, message in (
        ({"rewards": "goal"}, "no option 'rewards'; did you mean 'reward'"),
        ({"reward": "gaol"}, "no reward 'gaol'; did you mean 'goal'"),
        ({"parts": ("selv",)}, "no part 'selv'; did you mean 'self'"),
        ({"pheromones": "klear"}, "pheromones: no 'klear'; did you mean 'clear'"),
    ):
        with pytest.raises(ColonysimError, match=message):
            rl.aec("hard", **options)
    env = rl.aec("hard", illegal="raise")
    with pytest.raises(ColonysimError, match="call reset first"):
        env.state()
    env.reset(seed=1)
    forbidden = int(np.flatnonzero(env.infos[env.agent_selection]["action_mask"] == 0)[0])
    wrong = ((forbidden, "not allowed"), (999, "no action 999"), ("left", "is no action"), (True, "is no action"))
    for action, message in wrong:
        with pytest.raises(ColonysimError, match=message):
            env.step(action)
    env.close()
    env = rl.aec("hard", overrides={"timing.jitter": 0.0})
    env.reset(seed=1)
    agent = env.agent_selection
    env.step(forbidden)
    while env.agent_selection != agent:
        env.step(env.choice())
    assert env.infos[agent]["illegal"] and env.infos[agent]["dt"] == pytest.approx(env.turns.edge_seconds)
    env.close()


def left_behind(times):
    """Bytes more than after a tenth of the times, of environments that are closed in the middle of an episode."""
    def once(number):
        env = rl.aec("hard", seed=number)
        env.reset()
        for _ in range(5):
            env.step(env.choice())
        env.close()

    for number in range(max(10, times // 10)):
        once(number)
    gc.collect()
    tracemalloc.start()
    before, count = tracemalloc.get_traced_memory()[0], len(gc.get_objects())
    for number in range(times):
        once(number)
    gc.collect()
    after = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    return after - before, len(gc.get_objects()) - count


def test_nothing_stays_of_environments_that_are_closed_in_the_middle():
    threads = threading.active_count()
    grown, objects = left_behind(30)
    assert grown < 30 * 1000 and objects < 30
    assert threading.active_count() == threads


@pytest.mark.slow
def test_nothing_stays_of_a_thousand():
    grown, objects = left_behind(1000)
    assert grown < 100_000 and objects < 100


@pytest.mark.parametrize(
    "answer", [[1.0], [1.0] * 5, {0: 1.0, 1: 1.0, 2: 1.0, 3: 1.0}, [1.0, 1.0, 1.0, math.nan], None, "abcd", [None] * 4]
)
def test_a_reward_of_one_s_own_that_is_none_is_told(answer):
    env = rl.aec("hard", reward=lambda stretch: answer, seed=1)
    with pytest.raises(ColonysimError, match=r"reward: .*expected 4 finite numbers, one for each agent"):
        env.reset()
        for _ in range(20):
            env.step(env.choice())


def test_a_step_together_is_taken_as_a_whole_or_not_at_all():
    env = rl.parallel("hard", mode="synchronous", illegal="raise", seed=1)
    with pytest.raises(ColonysimError, match="call reset"):
        env.step({})
    observations, _ = env.reset()
    asked = env.turns.together
    for wrong in (None, [], 3):
        with pytest.raises(ColonysimError, match="expected a mapping"):
            env.step(wrong)
    legal = {name: int(observations[name]["action_mask"].nonzero()[0][0]) for name in env.agents}
    forbidden = int((observations[env.agents[asked[1]]]["action_mask"] == 0).nonzero()[0][0])
    for wrong in (forbidden, 1.7, np.array(1.7), np.array([0]), np.array([0, 1]), np.array("x"), True, None):
        with pytest.raises(ColonysimError, match=r"not allowed|is no action"):
            env.step({**legal, env.agents[asked[1]]: wrong})
        assert env.turns.together == asked
    env.step(legal)


def test_before_a_reset_there_is_nothing_to_ask():
    env = rl.aec("sanity")
    for call in (lambda: env.step(0), env.fork):
        with pytest.raises(ColonysimError, match="call reset"):
            call()
