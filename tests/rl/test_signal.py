"""Marks that agents decide to leave: as part of an action, and natively of a policy's choice."""

from __future__ import annotations

import pytest

pytest.importorskip("pettingzoo")

import numpy as np

import colonysim
from colonysim import rl
from colonysim.errors import ColonysimError, PluginError
from colonysim.pheromones import Signal
from colonysim.policies import Choice, Outside
from colonysim.scenario.loading import scenario_from_document
from colonysim.testing import check_env
from colonysim.world.intents import Travel, Wait

DOCUMENT = {
    "nodes": [[n, 2.0 * n, 0.0, 0.0] for n in range(4)], "edges": [[0, 1], [1, 2], [2, 3]], "holes": [], "boxes": [],
    "agents": [0], "goal": 3, "detection_radius": 3.0, "max_steps": 10, "episodes": 2, "timing": {"jitter": 0.0},
}  # fmt: skip
LINE = scenario_from_document(DOCUMENT)


def test_an_action_leaves_a_mark_where_the_move_ends_and_it_fades():
    env = rl.aec(LINE, deposits="action", half_life=8.0, pheromones="keep")
    moves = env.turns.observer.moves
    assert env.action_space("robot_0").n == moves.count == 2 * moves.moves == 2 * (2 * 2 + 2)
    env.reset()
    assert [*env.colony.fields] == ["S"] and env.observation_space("robot_0")["pheromones"].shape == (3, 1)
    mask = env.last()[0]["action_mask"]
    assert (mask[: moves.moves] == mask[moves.moves :]).all()
    env.step(moves.moves)  # to node 1, and leaves a mark there
    assert env.colony.fields["S"].values().tolist() == [0.0, 1.0, 0.0, 0.0]
    assert env.last()[0]["pheromones"].ravel().tolist() == [0.0, 0.0, 1.0]  # of both neighbours and its own node
    before = env.colony.now
    env.step(1)  # to node 2, and leaves none
    left = 0.5 ** ((env.colony.now - before) / 8.0)
    assert env.colony.fields["S"].values() == pytest.approx([0.0, left, 0.0, 0.0])
    assert env.last()[0]["pheromones"].ravel() == pytest.approx([left, 0.0, 0.0])
    env.step(moves.moves + moves.pause)  # waits here, and leaves a mark
    assert env.colony.fields["S"].values()[2] == pytest.approx(0.5 ** (env.turns.edge_seconds / 8.0))
    at_end = env.colony.fields["S"].values()
    env.reset()  # the next episode of the same run
    assert env.colony.fields["S"].values() == pytest.approx(at_end)
    env.close()


@pytest.mark.parametrize("door", [rl.aec, rl.parallel])
def test_it_keeps_the_promises_of_an_environment(door):
    check_env(lambda: door("junction", deposits="action", half_life=20.0, policy="random"), episodes=1)


class Marking:
    """Goes to any neighbour, and leaves a mark if there is none where it stands."""

    name = "marking"

    def __init__(self, scenario):
        pass

    def fields(self, world):
        return {"S": Signal(world, half_life=30.0)}

    def begin(self, agent, memory):
        return None

    def decide(self, view, memory, random):
        ways = [node for node in view.exits() if not (view.top_box(node) >= 0)]
        intent = Travel(ways[int(random.random() * len(ways))]) if ways else Wait((), view.edge_seconds)
        return Choice(intent, memory, mark=0.0 if view.fields["S"].at(view.node) else 1.0)


def test_what_is_played_equals_a_policy_that_decides_the_same(tmp_path):
    options = {"overrides": {"max_steps": 60}, "deposits": "action", "half_life": 30.0, "policy": "random"}
    native = colonysim.run(
        "hard", policy=Marking, overrides=options["overrides"], seed=4, episodes=1, out=tmp_path / "native"
    )
    rows = native.table("deposits").to_pylist()
    assert len(rows) > 20 and {row["field"] for row in rows} == {"S"} and {row["value"] for row in rows} == {1.0}

    env = rl.aec("hard", seed=4, trace=tmp_path / "played", **options)
    env.reset()
    rule, moves = Marking(env.turns.scenario), env.turns.observer.moves
    for _ in env.agent_iter():
        _, _, terminated, truncated, info = env.last()
        if terminated or truncated:
            env.step(None)
            continue
        agent = env.turns.asked
        view, stream = env.colony.view(), env.colony._episode.random[agent].generator
        choice = rule.decide(view, None, stream)
        [action] = [
            action for action in range(moves.moves) if env.turns.sight(agent).intent(action) == choice.intent
        ] if isinstance(choice.intent, Travel) else [moves.pause]  # fmt: skip
        assert info["action_mask"][action]
        env.step(action + moves.moves if choice.mark else action)
    env.close()
    played = colonysim.Run.open(tmp_path / "played" / "run-000001")
    assert played.manifest["trace_sha256"] == native.manifest["trace_sha256"]


def test_a_decided_mark_is_saved_and_forked_with_the_move_under_way(tmp_path):
    def colony(**more):
        return colonysim.Colony(LINE, policy=Outside.over("random", signal=True), episodes=1, seed=1, **more)

    one = colony()
    while one.asked is None:
        one.step()
    one.answer(Travel(LINE.topology.index[1]), mark=0.5)
    twin = one.fork()
    one.save(tmp_path / "saved.npz")
    loaded = colonysim.Colony.load(tmp_path / "saved.npz", policy=Outside.over("random", signal=True))
    for each in (one, twin, loaded):
        while each.asked is None:
            each.step()
        assert each.fields["S"].values().tolist() == [0.0, 0.5, 0.0, 0.0]
        each.close()


def test_misuse_is_answered():
    with pytest.raises(ColonysimError, match="deposits: no 'actions'; did you mean 'action'"):
        rl.aec(LINE, deposits="actions")
    with pytest.raises(ColonysimError, match="half_life: only of marks that actions leave"):
        rl.aec(LINE, half_life=3.0)
    with pytest.raises(ColonysimError, match="half_life"):
        rl.aec(LINE, deposits="action", half_life=-3.0)
    env = rl.aec(LINE, deposits="action", policy="colony")
    env.reset()
    with pytest.raises(PluginError):  # there are none of the marks that it goes by
        env.choice()
    env.reset()
    with pytest.raises(PluginError, match=r"its mark is 2\.0, expected a number from 0 to 1"):
        env.step(Choice(Wait((), 1.0), None, mark=2.0))
    with pytest.raises(ColonysimError, match="marks are left by rules"):
        rl.save_policy("unused.npz", [(np.zeros((12, 3)), np.zeros(12))], env)
    env.close()
