"""Learning from mirror images: a reflected push must be one that the physics could have shown."""

import numpy as np
import pytest

from colonysim.push.controls import CONTROLS, Control, control_speeds
from colonysim.push.network import INPUTS, Inputs, encode
from colonysim.push.state import State
from colonysim.push.training.mirror import mirror_signs, mirrored, mirrored_control
from colonysim.push.training.replay import Batch

RNG = np.random.default_rng(3)
STATES = [
    State(*RNG.uniform((-2, -2, -0.2, -0.3, -3, -3, -3, -0.3, -3), (2, 2, 0.2, 0.3, 3, 3, 3, 0.3, 3)).tolist())
    for _ in range(200)
]


def reflected(state: State) -> State:
    """The state as a robot on the other side of the push line would see it."""
    return state._replace(
        y_box=-state.y_box, yaw_box=-state.yaw_box, y_node=-state.y_node, yaw_agent=-state.yaw_agent
    )


@pytest.mark.parametrize("inputs", INPUTS)
def test_signs_give_what_the_reflected_state_is_encoded_to(inputs: Inputs) -> None:
    for state in STATES:
        expected = encode(inputs, reflected(state))
        np.testing.assert_allclose(encode(inputs, state) * mirror_signs(inputs), expected, atol=1e-5)


@pytest.mark.parametrize("control", Control)
def test_the_mirrored_control_swaps_the_wheels(control: Control) -> None:
    for state in STATES:
        left, right = control_speeds(control, state)
        assert control_speeds(mirrored_control(control), reflected(state)) == pytest.approx((right, left), abs=1e-9)


def test_a_batch_is_half_mirrored_and_otherwise_untouched() -> None:
    n = 1_000
    states = encode("line", np.array([STATES[i % len(STATES)] for i in range(n)]))
    actions = RNG.integers(CONTROLS, size=n)
    batch = Batch(states, actions, np.arange(n, dtype=np.float32), states + 1, np.ones(n, dtype=np.float32))
    made = mirrored(batch, mirror_signs("line"), np.random.default_rng(0))
    turned = np.any(made.states != batch.states, axis=1)
    assert 400 < turned.sum() < 600
    assert np.array_equal(made.states[turned], states[turned] * mirror_signs("line"))
    assert np.array_equal(made.next_states[turned], (states[turned] + 1) * mirror_signs("line"))
    assert [mirrored_control(a) for a in actions[turned]] == made.actions[turned].tolist()
    assert np.array_equal(made.actions[~turned], actions[~turned])
    assert np.array_equal(made.returns, batch.returns)
