"""Training of a policy: what is learned from, what becomes of it, and that it goes on where it was stopped."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("torch")

import torch
from typer.testing import CliRunner

import colonysim
from colonysim import rl
from colonysim.cli import app
from colonysim.learning.cards import ModelError
from colonysim.learning.layers import forward
from colonysim.learning.seeds import Purpose
from colonysim.rl.training.games import MARKS, REWARD_UNIT, Decided, Game, Path, play
from colonysim.rl.training.imitation import gather
from colonysim.rl.training.network import layers_of, symmetries
from colonysim.rl.training.places import KINDS, place
from colonysim.rl.training.ppo import Learner, advantages
from colonysim.rl.training.presets import PRESETS
from colonysim.rl.training.trainer import train_policy
from colonysim.rl.turns import Turns

TINY = PRESETS["tiny"]


def options(config=TINY):
    return Game(place(Purpose.TRAIN, 0), 0, config).turns.observer.options


def rule(games):
    """The rule decides; nothing is learned from the numbers of its actions."""
    for game in games:
        game.told()
    return Decided([game.turns.choice() for game in games], [0] * len(games), [0.0] * len(games))


def of_the_rule(decide=rule, **ppo):
    """The only episode of a run of the rule on platforms: what is learned from it."""
    config = replace(TINY, ppo=replace(TINY.ppo, **ppo))
    game = Game(place(Purpose.TRAIN, 2), 4, config)
    play([game], decide)
    assert game.over and [episode.success for episode in game.episodes] == [1.0]
    return game


def arrivals():
    """When each agent reaches the goal in that run, by the simulation itself, and the seconds of an edge."""
    with colonysim.Colony(place(Purpose.TRAIN, 2), policy=MARKS, episodes=1, seed=4) as colony:
        found = {event.agent: event.time for event in colony if event.kind == "goal"}
        return [found[agent] for agent in sorted(found)], colony.seconds_of_an_edge


def test_places_of_one_purpose_are_none_of_another():
    digests = [place(purpose, n).digest for purpose in (Purpose.TRAIN, Purpose.TUNE, Purpose.JUDGE) for n in range(30)]
    assert len(set(digests)) == 90
    assert place(Purpose.JUDGE, 7).digest == place(Purpose.JUDGE, 7).digest
    assert [place(Purpose.TRAIN, n).name.split("-")[0] for n in range(3)] == list(KINDS)


def test_an_agent_is_paid_for_the_teams_time_and_for_its_own_until_it_arrives():
    game, (arrived, edge) = of_the_rule(discount=1.0, own_time=2.0), arrivals()
    assert game.episodes[0].seconds == pytest.approx(max(arrived))
    for path, until in zip(game.paths, arrived, strict=True):
        team = sum(min(until, other) for other in arrived) / len(arrived)
        assert sum(path.reward) * REWARD_UNIT == pytest.approx(-(team + 2.0 * until) / edge)
        assert path.discount[:-1] == [1.0] * (len(path.action) - 1) and path.discount[-1] == 0.0


def test_rewards_are_discounted_by_the_time_between_an_agents_own_decisions():
    times = {}

    def watched(games):
        for game in games:
            times.setdefault(game.turns.asked, []).append(game.turns.colony.now)
        return rule(games)

    game, (_, edge) = of_the_rule(watched, discount=0.9), arrivals()
    for agent, path in enumerate(game.paths):
        expected = 0.9 ** (np.diff(times[agent]) / edge)
        assert path.discount[:-1] == pytest.approx(expected.tolist()) and len(set(path.discount)) > 3


def test_a_wrong_dt_changes_the_returns(monkeypatch):
    def total():
        return [sum(advantages(path, [0.0] * len(path.action), 1.0)) for path in of_the_rule().paths]

    right = total()
    assert right == total()
    since = Turns.since
    monkeypatch.setattr(Turns, "since", lambda self, agent: 0.5 * since(self, agent))
    assert right != pytest.approx(total())


def test_the_advantage_is_that_of_a_chain_worked_out_by_hand():
    path = Path(action=[0, 0, 0], reward=[-1.0, -2.0, 3.0], discount=[0.9, 0.5, 0.0])
    errors = [-1.0 + 0.9 * 2.0 - 1.0, -2.0 + 0.5 * 4.0 - 2.0, 3.0 - 4.0]
    last, middle = errors[2], errors[1] + 0.5 * 0.8 * errors[2]
    assert advantages(path, [1.0, 2.0, 4.0], 0.8) == pytest.approx([errors[0] + 0.9 * 0.8 * middle, middle, last])


def test_plain_layers_are_the_network_and_the_order_of_neighbours_does_not_matter():
    learner = Learner(options(), replace(TINY, hidden=(12, 10, 8)), 3)
    torch.nn.init.normal_(learner.policy.scores.weight)
    columns, layers = learner.policy.columns, layers_of(learner.policy)
    told = np.random.default_rng(0).normal(size=(20, columns.size)).astype(np.float32)
    values = forward(layers, told)
    assert values == pytest.approx(learner.policy(torch.from_numpy(told)).detach().numpy(), abs=1e-4)
    order = np.random.default_rng(1).permutation(columns.neighbours)
    moved = told.copy()
    for part in (columns.rows, columns.marks):
        moved[:, part] = told[:, part[order]]
    of_neighbours = np.concatenate([order, columns.neighbours + order, [-2, -1]])
    assert forward(layers, moved) == pytest.approx(values[:, of_neighbours], abs=1e-4)
    assert np.ptp(values, axis=1).min() > 0.1


def test_what_is_told_is_turned_and_mirrored_as_a_whole():
    learner = Learner(options(), TINY, 0)
    found = symmetries(learner.policy.columns)
    told = np.random.default_rng(0).normal(size=learner.policy.columns.size).astype(np.float32)
    seen = {tuple((told[order] * signs).tolist()) for order, signs in found}
    assert len(found) == len(seen) == 8
    vectors = learner.policy.columns.vectors
    for order, signs in found:
        turned = told[order] * signs
        # Lengths and angles between all vectors stay, so that it is one turn or mirror for all of them.
        assert turned[vectors] @ turned[vectors].T == pytest.approx(told[vectors] @ told[vectors].T, abs=1e-5)
        rest = np.setdiff1d(np.arange(len(told)), vectors)
        assert (turned[rest] == told[rest]).all()


def test_imitation_agrees_with_the_rule_on_runs_that_it_has_not_seen():
    config = replace(TINY, hidden=(32, 32), imitation=replace(TINY.imitation, runs=30, held_out=0.2))
    lessons, held_out = gather([place(Purpose.TRAIN, n) for n in range(6)], config, 1)
    learner, rng = Learner(options(), config, 0), np.random.default_rng(0)
    chance = (1.0 / held_out.mask.sum(axis=1)).mean()
    for _ in range(12):
        learner.imitate(lessons, 1.0, rng)
    assert len(held_out) > 200 and learner.agreement(held_out) > 0.55 > 2 * chance


def test_a_training_that_is_stopped_goes_on_to_the_same_network(tmp_path):
    whole = train_policy("tiny", tmp_path / "whole", 5)
    parts = None
    for rounds in (1, 2, 9):
        parts = train_policy("tiny", tmp_path / "parts", 5, resume=True, stop_after_rounds=rounds)
    for one, other in ((whole.card, parts.card), (whole.last, parts.last), (whole.imitated, parts.imitated)):
        assert json.loads(one.read_text())["sha256"] == json.loads(other.read_text())["sha256"]
    assert whole.history == parts.history
    assert json.loads(whole.last.read_text())["sha256"] != json.loads(whole.imitated.read_text())["sha256"]
    with pytest.raises(ModelError, match="was made with another configuration or seed"):
        train_policy("tiny", tmp_path / "parts", 6, resume=True)


def test_the_command_trains_what_a_run_runs(tmp_path):
    out = tmp_path / "mine"
    asked = ["train", "policy", "--preset", "tiny", "--set", "ppo.iterations=1", "--out", str(out)]
    done = CliRunner().invoke(app, asked)
    assert done.exit_code == 0 and "policy.json: best after" in done.output, done.output
    assert CliRunner().invoke(app, asked).exit_code == 2  # there is one already
    wrong = CliRunner().invoke(app, ["train", "policy", "--set", "ppo.clp=1", "--out", str(tmp_path / "no")])
    assert wrong.exit_code == 2 and "did you mean 'clip'" in wrong.output
    model = rl.load_policy(out / "policy.json")
    assert model.card["how"]["config"]["ppo"]["iterations"] == 1 and model.marks == MARKS
    run = colonysim.run("hard", policy="learned", overrides={"policy.model": str(out / "policy.json")}, episodes=1)
    assert run.episodes[0].sim_seconds > 0.0
