"""The forward pass in NumPy, and how its values become controls."""

import numpy as np
import pytest

from colonysim.push.choosing import boltzmann, constant, network_chooser
from colonysim.push.controls import CONTROLS, Control
from colonysim.push.network import QNetwork, load_network, random_network
from colonysim.push.state import State


def test_numpy_and_torch_agree() -> None:
    torch = pytest.importorskip("torch")
    from colonysim.push.training.dqn import DoubleDQN
    from colonysim.push.training.presets import LearnerConfig

    start = load_network()
    learner = DoubleDQN(start, LearnerConfig())
    states = np.random.default_rng(1).normal(size=(64, 9))
    from colonysim.push.network import encode

    with torch.no_grad():
        wanted = learner._online(torch.from_numpy(encode(start.inputs, states))).numpy()
    assert np.allclose(start.values(states), wanted, rtol=1e-4, atol=1e-4)


def test_one_state_and_many_states_agree() -> None:
    network = random_network("line", (16, 16), np.random.default_rng(0))
    states = np.random.default_rng(1).normal(size=(5, 9))
    one_by_one = np.stack([network.values(s) for s in states])
    assert np.allclose(one_by_one, network.values(states), atol=1e-5)


def test_boltzmann_is_paper_equation_11() -> None:
    values = np.array([0.1, 0.3, 0.0, 0.2, 0.25, 0.3, 0.1, 0.05], dtype=np.float32)
    rng = np.random.default_rng(0)
    drawn = np.bincount([boltzmann(values, rng, 8.0) for _ in range(4000)], minlength=CONTROLS) / 4000
    wanted = np.exp(8 * values) / np.exp(8 * values).sum()
    assert drawn == pytest.approx(wanted, abs=0.03)


def test_boltzmann_survives_large_values() -> None:
    values = np.array([900, 1000, 0, 0, 0, 0, 0, -1e9], dtype=np.float32)
    assert boltzmann(values, np.random.default_rng(0)) is Control.APPROACH


def _favouring(control: Control, second: Control) -> QNetwork:
    bias = np.zeros(CONTROLS, dtype=np.float32)
    bias[control], bias[second] = 1.0, 0.9
    return QNetwork("state", ((np.zeros((CONTROLS, 9), dtype=np.float32), bias),))


def test_greedy_takes_the_best_and_draws_only_when_a_state_comes_back() -> None:
    choose = network_chooser(_favouring(Control.ALIGN, Control.BACK), np.random.default_rng(0))
    moving = [choose(State(1.0 + 0.1 * i, 0, 0, 0, 0, 2, 0, 0, 0)) for i in range(50)]
    assert set(moving) == {Control.ALIGN}
    stuck = [choose(State(1.0, 0, 0, 0, 0, 2, 0, 0, 0)) for _ in range(50)]
    assert len(set(stuck)) > 1


def test_going_back_and_forth_counts_as_stuck() -> None:
    choose = network_chooser(_favouring(Control.ALIGN, Control.BACK), np.random.default_rng(0))
    chosen = [choose(State(1.0, 0, 0, 0, 0, 2, 0, 0, 0.5 * (i % 2))) for i in range(60)]
    assert len(set(chosen)) > 1


def test_a_constant_choice() -> None:
    choose = constant(Control.PUSH_IN)
    assert choose(State(*[0.0] * 9)) is Control.PUSH_IN
