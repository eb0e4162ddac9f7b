"""How a control is chosen from a state: the one seam at which a network, or nothing, decides."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from colonysim.push.controls import CONTROLS, Control
from colonysim.push.network import Float, QNetwork
from colonysim.push.state import State

__all__ = ["BOLTZMANN", "Choose", "Testing", "boltzmann", "constant", "network_chooser"]

BOLTZMANN = 8.0
"""beta of paper Eq. 10."""
Testing = Literal["greedy", "boltzmann"]
Choose = Callable[[State], Control]


def boltzmann(values: Float, rng: np.random.Generator, beta: float = BOLTZMANN) -> Control:
    """Paper Eq. 10: a control drawn with probability proportional to exp(beta Q)."""
    weights = np.exp(beta * (values.astype(np.float64) - float(values.max())))
    edges = np.cumsum(weights)
    drawn = int(np.searchsorted(edges, rng.random() * edges[-1], side="right"))
    return Control(min(drawn, CONTROLS - 1))


@dataclass(slots=True)
class _Stuck:
    """Remembers the last state, to tell whether anything has moved since."""

    last: State | None = None

    def check(self, state: State) -> bool:
        last, self.last = self.last, state
        return (
            last is not None
            and abs(state.x_box - last.x_box) < 0.01
            and abs(state.y_box - last.y_box) < 0.01
            and abs(state.yaw_agent - last.yaw_agent) < 0.02
            and abs(state.x_node - last.x_node) < 0.01
        )


def network_chooser(
    network: QNetwork, rng: np.random.Generator, testing: Testing = "greedy", beta: float = BOLTZMANN
) -> Choose:
    """A trained network's choice, without exploration.

    Args:
        network: The network.
        rng: For the drawn choices.
        testing: `"boltzmann"` draws every control (the paper's testing, epsilon 0); `"greedy"` takes the
            best one, and draws only when nothing has moved since the last choice.
        beta: Certainty of the draw.
    """
    stuck = _Stuck()

    def choose(state: State) -> Control:
        values = network.values(state)
        if stuck.check(state) or testing == "boltzmann":
            return boltzmann(values, rng, beta)
        return Control(int(values.argmax()))

    return choose


def constant(control: Control) -> Choose:
    """The same control for ever, a yardstick for what learning adds."""
    return lambda _: control
