"""Replay, Double DQN, and short trainings."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from colonysim.learning.cards import ModelError, load_arrays
from colonysim.learning.seeds import Purpose, episode_rng
from colonysim.push.network import load_network
from colonysim.push.training.presets import PRESETS, READINGS, Ends, LearnerConfig, StartMix
from colonysim.push.training.replay import NStep, Replay
from colonysim.push.training.trainer import Progress, train_push

TINY = dataclasses.replace(
    PRESETS["improved"],
    hidden=(16, 16),
    actions=110,
    explore=40,
    update_from=32,
    batch=16,
    buffer=200,
    train_block=1,
    test_block=1,
    candidates=2,
    playoff=1,
    final=1,
    kinds=(("flat", 1.0),),
    starts=(StartMix("fine", 1.0, guards=True),),
)


def _encoded(*values: float) -> np.ndarray:
    return np.array(values, dtype=np.float32)


def test_replay_forgets_the_oldest() -> None:
    replay = Replay(3, 1)
    for i in range(5):
        replay.add(_encoded(i), i, float(i), _encoded(i + 1), 0.9)
    assert len(replay) == 3
    assert sorted(replay.actions) == [2, 3, 4]
    batch = replay.sample(50, np.random.default_rng(0))
    assert set(batch.actions) == {2, 3, 4}


def test_n_step_returns_and_what_follows_them() -> None:
    replay = Replay(10, 1)
    steps = NStep(replay, 3, 0.5)
    for i in range(4):
        steps.add(_encoded(i), i, 1.0, _encoded(i + 1), terminal=i == 3, over=i == 3)
    assert replay.returns[:4] == pytest.approx([1.75, 1.75, 1.5, 1.0])
    assert replay.discounts[:4] == pytest.approx([0.125, 0.0, 0.0, 0.0])
    assert replay.next_states[:4, 0] == pytest.approx([3, 4, 4, 4])


def test_a_time_out_is_not_an_end_its_future_is_estimated() -> None:
    replay = Replay(10, 1)
    steps = NStep(replay, 3, 0.5)
    for i in range(2):
        steps.add(_encoded(i), i, 1.0, _encoded(i + 1), terminal=False, over=i == 1)
    assert replay.discounts[:2] == pytest.approx([0.25, 0.5])


def test_both_forms_of_the_double_dqn_target() -> None:
    torch = pytest.importorskip("torch")
    from colonysim.push.training.dqn import double_dqn_target

    online = torch.tensor([[1.0, 5.0, 2.0]])
    target = torch.tensor([[7.0, 3.0, 4.0]])
    returns, discounts = torch.tensor([0.5]), torch.tensor([0.9])
    standard = double_dqn_target("standard", returns, discounts, online, target)
    printed = double_dqn_target("printed", returns, discounts, online, target)
    assert float(standard) == pytest.approx(0.5 + 0.9 * 3.0)
    assert float(printed) == pytest.approx(0.5 + 0.9 * 1.0)
    ended = double_dqn_target("standard", returns, torch.tensor([0.0]), online, target)
    assert float(ended) == pytest.approx(0.5)


@pytest.mark.parametrize("target", ["standard", "printed"])
def test_double_dqn_learns_a_toy_with_a_known_best_control(target: str) -> None:
    pytest.importorskip("torch")
    from colonysim.push.network import random_network
    from colonysim.push.training.dqn import DoubleDQN

    rng = np.random.default_rng(0)
    config = LearnerConfig(target=target, target_every=20, learning_rate=5e-3, learning_rate_end=5e-3)  # type: ignore[arg-type]
    learner = DoubleDQN(random_network("state", (32,), rng), config)
    replay = Replay(500, 9)
    for _ in range(500):
        state = rng.normal(size=9).astype(np.float32)
        action = int(rng.integers(8))
        # Control 2 is right where the first number is positive, control 5 elsewhere.
        replay.add(state, action, float(action == (2 if state[0] > 0 else 5)), state, 0.0)
    losses = [learner.update(replay.sample(64, rng), 0.0) for _ in range(400)]
    assert np.mean(losses[-20:]) < 0.3 * np.mean(losses[:20])
    states = rng.normal(size=(200, 9)).astype(np.float32)
    best = learner.network.forward(states).argmax(axis=1)
    assert np.mean(best == np.where(states[:, 0] > 0, 2, 5)) > 0.85


def test_what_is_tested_is_an_average_of_the_networks_so_far() -> None:
    pytest.importorskip("torch")
    from colonysim.push.network import random_network
    from colonysim.push.training.dqn import DoubleDQN

    rng = np.random.default_rng(0)
    learner = DoubleDQN(random_network("state", (4,), rng), LearnerConfig(average_share=0.25))
    replay = Replay(50, 9)
    for _ in range(50):
        replay.add(rng.normal(size=9).astype(np.float32), 0, 1.0, np.zeros(9, dtype=np.float32), 0.0)
    expected = learner.tested.arrays()["w0"].copy()
    for _ in range(3):
        learner.update(replay.sample(16, rng), 0.0)
        expected = 0.75 * expected + 0.25 * learner.network.arrays()["w0"]
    assert not np.array_equal(learner.tested.arrays()["w0"], learner.network.arrays()["w0"])
    assert learner.tested.arrays()["w0"] == pytest.approx(expected, abs=1e-6)


def test_the_paper_s_parameters() -> None:
    paper = PRESETS["paper"]
    assert (paper.inputs, paper.hidden) == ("state", (200, 200, 200))
    assert (paper.gamma, paper.buffer, paper.batch, paper.explore) == (0.975, 10_000, 128, 1_000)
    assert (paper.beta, paper.episodes, paper.steps) == (8.0, 400, 1)
    assert (paper.learner.learning_rate, paper.learner.target_every, paper.learner.target) == (3e-4, 300, "printed")
    assert (paper.train_block, paper.test_block, paper.testing) == (20, 20, "boltzmann")
    assert dict(paper.kinds) == {"flat": 0.3, "slope": 0.2, "hole": 0.5}
    assert (paper.rules.ticks, paper.rules.check_every, paper.rules.success_bonus) == (50, 50, 0.0)


def test_readings_keep_what_the_paper_prints() -> None:
    for name, reading in READINGS.items():
        if name == "improved":
            continue
        table = ("inputs", "hidden", "gamma", "buffer", "batch", "explore", "beta", "episodes", "train_block", "kinds")
        assert all(getattr(reading, what) == getattr(PRESETS["paper"], what) for what in table), name
        assert (reading.learner.learning_rate, reading.learner.target_every) == (3e-4, 300), name
        assert reading.demonstrations == 0.0, name
    assert len(set(READINGS.values())) == len(READINGS)


@pytest.mark.parametrize("ends", ["verdict", "limit", "none"])
def test_after_which_actions_nothing_is_expected(ends: Ends, tmp_path: Path) -> None:
    pytest.importorskip("torch")
    seen: list[Progress] = []
    config = dataclasses.replace(TINY, ends=ends, steps=1, actions=260, buffer=400)
    train_push(config, tmp_path, 3, on_progress=seen.append)
    path = tmp_path / "checkpoint.npz"
    alone = int((load_arrays(path.read_bytes(), str(path), most=10**8)["replay_discounts"] == 0.0).sum())
    assert seen[-1].actions <= 400, "the replay holds every action"
    if ends == "none":
        assert alone == 0
    elif ends == "limit":
        assert alone == seen[-1].episodes
    else:
        assert 0 <= alone <= seen[-1].episodes


def test_the_last_network_is_kept_beside_the_best(tmp_path: Path) -> None:
    pytest.importorskip("torch")
    trained = train_push(TINY, tmp_path, 3)
    assert trained is not None and trained.last == tmp_path / "push-last.json"
    path = tmp_path / "checkpoint.npz"
    kept = load_arrays(path.read_bytes(), str(path), most=10**8)
    assert np.array_equal(load_network(trained.last).arrays()["w0"], kept["average_0"])


def test_an_interrupted_training_ends_as_if_it_had_never_stopped(tmp_path: Path) -> None:
    pytest.importorskip("torch")
    seen: list[Progress] = []
    whole = train_push(TINY, tmp_path / "whole", 3, on_progress=seen.append)
    assert whole is not None and len(seen) == len(whole.history) > 2
    assert train_push(TINY, tmp_path / "parts", 3, stop_after_blocks=2) is None
    parts = train_push(TINY, tmp_path / "parts", 3, resume=True)
    assert parts is not None
    assert parts.history == whole.history
    assert (tmp_path / "parts/push.npz").read_bytes() == (tmp_path / "whole/push.npz").read_bytes()
    loaded = load_network(whole.card)
    assert np.array_equal(loaded.values(np.ones(9)), whole.network.values(np.ones(9)))


def test_a_checkpoint_of_another_seed_is_not_continued(tmp_path: Path) -> None:
    pytest.importorskip("torch")
    train_push(TINY, tmp_path, 3, stop_after_blocks=1)
    with pytest.raises(ModelError, match="another configuration or seed"):
        train_push(TINY, tmp_path, 4, resume=True)


def test_an_unknown_preset_is_answered_with_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no preset 'best'; there are paper, improved"):
        train_push("best", tmp_path, 0)


def test_seeds_of_different_purposes_never_meet() -> None:
    first = {float(episode_rng(purpose, seed, 0).random()) for purpose in Purpose for seed in range(20)}
    assert len(first) == len(Purpose) * 20
