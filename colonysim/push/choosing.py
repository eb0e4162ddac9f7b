"""How a control is chosen from a state: the one seam at which a network, or nothing, decides."""

from collections import deque
from collections.abc import Callable
from typing import Literal

import numpy as np

from colonysim.learning.layers import Float
from colonysim.physics import wrap
from colonysim.push.controls import CONTROLS, Control
from colonysim.push.network import Network
from colonysim.push.state import State

__all__ = ["BOLTZMANN", "Choose", "Testing", "boltzmann", "constant", "network_chooser"]

BOLTZMANN = 8.0
"""beta of paper Eq. 11."""
Testing = Literal["greedy", "boltzmann"]
Choose = Callable[[State], Control]
_ALL = tuple(Control)  # Control(number) takes far longer than to look it up


def boltzmann(values: Float, rng: np.random.Generator, beta: float = BOLTZMANN) -> Control:
    """Paper Eq. 11: a control drawn with probability proportional to exp(beta Q)."""
    weights = np.exp(beta * (values.astype(np.float64) - float(values.max())))
    edges = np.cumsum(weights)
    drawn = int(np.searchsorted(edges, rng.random() * edges[-1], side="right"))
    return _ALL[min(drawn, CONTROLS - 1)]


_REMEMBERED = 12
_SAME_PLACE, _SAME_YAW = 0.03, 0.06
_SOFTEST = 0.5


class _Trail:
    """Remembers the last states, to tell whether the robot stands still or goes round in circles."""

    def __init__(self) -> None:
        self._last: deque[State] = deque(maxlen=_REMEMBERED)

    def visits(self, state: State) -> int:
        """How many of the last states were the same; the state is remembered."""
        found = 0
        x_box, y_box, x_node, y_node, yaw = state.x_box, state.y_box, state.x_node, state.y_node, state.yaw_agent
        for s in self._last:
            if (
                abs(x_box - s.x_box) < _SAME_PLACE
                and abs(y_box - s.y_box) < _SAME_PLACE
                and abs(x_node - s.x_node) < _SAME_PLACE
                and abs(y_node - s.y_node) < _SAME_PLACE
                and abs(wrap(yaw - s.yaw_agent)) < _SAME_YAW
            ):
                found += 1
        self._last.append(state)
        return found


def network_chooser(
    network: Network, rng: np.random.Generator, testing: Testing = "greedy", beta: float = BOLTZMANN
) -> Choose:
    """A trained network's choice, without exploration.

    Args:
        network: The network.
        rng: For the drawn choices.
        testing: `"boltzmann"` draws every control (the paper's testing, epsilon 0); `"greedy"` takes the
            best one, and draws only when a state comes back, the more freely the more often it does: the
            best control of one state and that of another may undo each other for ever.
        beta: Certainty of the draw.
    """
    trail = _Trail()

    def choose(state: State) -> Control:
        values = network.values(state)
        if testing == "boltzmann":
            return boltzmann(values, rng, beta)
        if visits := trail.visits(state):
            return boltzmann(values, rng, max(_SOFTEST, beta / 2.0 ** (visits - 1)))
        return _ALL[int(values.argmax())]

    return choose


def constant(control: Control) -> Choose:
    """The same control for ever, a yardstick for what learning adds."""
    return lambda _: control
