"""Experience replay with n-step returns."""

from collections import deque
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from colonysim.learning.layers import Float
from colonysim.push.controls import CONTROLS

__all__ = ["Batch", "NStep", "Replay"]


class Batch(NamedTuple):
    """Transitions of shape (n, ...): `discount` is gamma to the power of the steps taken, 0 at an end."""

    states: Float
    actions: npt.NDArray[np.int64]
    returns: Float
    next_states: Float
    discounts: Float


class Replay:
    """A ring of transitions with room for `capacity` of them, each state an array of `width` numbers."""

    def __init__(self, capacity: int, width: int) -> None:
        self.capacity = capacity
        self.states = np.zeros((capacity, width), dtype=np.float32)
        self.actions = np.zeros(capacity, dtype=np.int64)
        self.returns = np.zeros(capacity, dtype=np.float32)
        self.next_states = np.zeros((capacity, width), dtype=np.float32)
        self.discounts = np.zeros(capacity, dtype=np.float32)
        self.added = 0

    def __len__(self) -> int:
        return min(self.added, self.capacity)

    def add(self, state: Float, action: int, gained: float, next_state: Float, discount: float) -> None:
        """Store a transition in place of the oldest one."""
        i = self.added % self.capacity
        self.states[i], self.actions[i], self.returns[i] = state, action, gained
        self.next_states[i], self.discounts[i] = next_state, discount
        self.added += 1

    def sample(self, size: int, rng: np.random.Generator) -> Batch:
        """Draw transitions uniformly, with repetition."""
        i = rng.integers(len(self), size=size)
        return Batch(self.states[i], self.actions[i], self.returns[i], self.next_states[i], self.discounts[i])

    def dump(self) -> dict[str, npt.NDArray[Any]]:
        """What a checkpoint needs."""
        n = len(self)
        return {
            "replay_states": self.states[:n],
            "replay_actions": self.actions[:n],
            "replay_returns": self.returns[:n],
            "replay_next_states": self.next_states[:n],
            "replay_discounts": self.discounts[:n],
            "replay_added": np.array(self.added),
        }

    @property
    def nbytes(self) -> int:
        """Bytes that a full replay takes."""
        columns = (self.states, self.actions, self.returns, self.next_states, self.discounts)
        return sum(column.nbytes for column in columns)

    def restore(self, arrays: dict[str, npt.NDArray[Any]]) -> None:
        """Take back what `dump` gave.

        Raises:
            ValueError: The arrays do not fit together, or hold a control that there is not.
            KeyError: One is missing.
        """
        actions, added = arrays["replay_actions"], int(arrays["replay_added"])
        n = len(actions)
        if added < 0 or n != min(added, self.capacity):
            raise ValueError(f"a replay of {n} transitions, {added} of which were added; it holds {self.capacity}")
        if actions.dtype.kind not in "iu" or not ((actions >= 0) & (actions < CONTROLS)).all():
            raise ValueError(f"replay_actions holds numbers other than 0 to {CONTROLS - 1}")
        self.states[:n] = arrays["replay_states"]
        self.actions[:n] = arrays["replay_actions"]
        self.returns[:n] = arrays["replay_returns"]
        self.next_states[:n] = arrays["replay_next_states"]
        self.discounts[:n] = arrays["replay_discounts"]
        self.added = added


@dataclass(slots=True)
class _Pending:
    state: Float
    action: int
    gained: float
    steps: int


class NStep:
    """Gathers the rewards of n actions before a transition goes into the replay.

    Args:
        replay: Where transitions go.
        steps: n; 1 stores every action by itself.
        gamma: Discount of one action.
    """

    def __init__(self, replay: Replay, steps: int, gamma: float) -> None:
        self._replay = replay
        self._steps = steps
        self._gamma = gamma
        self._pending: deque[_Pending] = deque()

    def add(self, state: Float, action: int, reward: float, next_state: Float, *, terminal: bool, over: bool) -> None:
        """Add one action.

        Args:
            state: Encoded state before it.
            action: The control.
            reward: What it was worth.
            next_state: Encoded state after it.
            terminal: Whether the episode ended for good, so that nothing follows.
            over: Whether the episode ended, be it by the step limit: what follows is then estimated.
        """
        self._pending.append(_Pending(state, action, 0.0, 0))
        for waiting in self._pending:
            waiting.gained += self._gamma**waiting.steps * reward
            waiting.steps += 1
        while self._pending and (over or self._pending[0].steps == self._steps):
            done = self._pending.popleft()
            discount = 0.0 if terminal else self._gamma**done.steps
            self._replay.add(done.state, done.action, done.gained, next_state, discount)
