"""The Q network's forward pass in NumPy: running a push needs no learning library."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from colonysim.push.cards import ModelError, as_finite, load_model
from colonysim.push.controls import CONTROLS
from colonysim.push.state import FEATURES, features

__all__ = [
    "INPUTS",
    "Inputs",
    "QNetwork",
    "encode",
    "load_network",
    "network_from_arrays",
    "network_ticks",
    "random_network",
]

Inputs = Literal["state", "line"]
Float = npt.NDArray[np.float32]
Layer = tuple[Float, Float]

INPUTS: dict[Inputs, int] = {"state": 9, "line": FEATURES}
"""Width of the input: the nine numbers of paper Eq. 4 as they are, or in the frame of the push line."""


_LARGEST_INPUT = 1e3
"""No state is further from 0: metres, radians and their squares at a box in reach."""
_MOST_TICKS = 10_000


def encode(inputs: Inputs, states: npt.ArrayLike) -> Float:
    """States (shape (9,) or (n, 9)) as the network wants to see them."""
    return features(states) if inputs == "line" else np.asarray(states, dtype=np.float32)


@dataclass(frozen=True, slots=True)
class QNetwork:
    """A multilayer perceptron with ReLUs; gives one value for each control.

    Attributes:
        inputs: What the network reads.
        layers: Weights (outputs x inputs) and biases, first layer first.
    """

    inputs: Inputs
    layers: tuple[Layer, ...]

    def values(self, states: npt.ArrayLike) -> Float:
        """Q of every control.

        Args:
            states: Shape (9,) or (n, 9), paper Eq. 4.

        Returns:
            Shape (8,) or (n, 8).
        """
        return self.forward(encode(self.inputs, states))

    def forward(self, encoded: Float) -> Float:
        """Q of every control for states that are encoded already."""
        hidden = encoded
        last = len(self.layers) - 1
        for i, (weights, biases) in enumerate(self.layers):
            hidden = hidden @ weights.T
            hidden += biases
            if i < last:
                np.maximum(hidden, 0.0, out=hidden)
        return hidden

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """The layers as named arrays."""
        made: dict[str, npt.NDArray[Any]] = {}
        for i, (weights, biases) in enumerate(self.layers):
            made[f"w{i}"], made[f"b{i}"] = weights, biases
        return made


def network_from_arrays(inputs: Inputs, arrays: Mapping[str, npt.NDArray[Any]]) -> QNetwork:
    """The network that `QNetwork.arrays` gave.

    Raises:
        ModelError: The arrays do not fit together.
    """
    layers: list[Layer] = []
    width = INPUTS[inputs]
    while f"w{len(layers)}" in arrays:
        weights = arrays[f"w{len(layers)}"]
        biases = arrays.get(f"b{len(layers)}", np.zeros(0))
        if weights.ndim != 2 or weights.shape[1] != width or biases.shape != weights.shape[:1]:
            raise ModelError(
                f"layer {len(layers)} has weights {weights.shape} and biases {biases.shape}, "
                f"expected (n, {width}) and (n,)"
            )
        width = weights.shape[0]
        number = len(layers)
        layers.append((as_finite(weights, np.float32, f"w{number}"), as_finite(biases, np.float32, f"b{number}")))
    if not layers or width != CONTROLS or len(arrays) != 2 * len(layers):
        raise ModelError(f"{len(layers)} layers with {width} outputs, expected {CONTROLS} outputs")
    _check_range(layers)
    return QNetwork(inputs, tuple(layers))


def _check_range(layers: Sequence[Layer]) -> None:
    """Refuses weights with which the values of a state may not be finite numbers."""
    largest = np.full(layers[0][0].shape[1], _LARGEST_INPUT)
    for number, (weights, biases) in enumerate(layers):
        largest = np.abs(weights.astype(np.float64)) @ largest + np.abs(biases)
        if largest.max(initial=0.0) > np.finfo(np.float32).max:
            raise ModelError(f"layer {number} has weights so large that values of controls would be infinite")


def load_network(source: str | Path = "push") -> QNetwork:
    """A shipped network by name, or one by the path of its card.

    Raises:
        ModelError: It is missing, damaged, or of the wrong shape.
    """
    model = load_model(source, "q-network")
    inputs = model.card.get("inputs")
    if not isinstance(inputs, str) or inputs not in INPUTS:
        raise ModelError(f"{model.file}: inputs {inputs!r:.80} are unknown, expected one of {', '.join(INPUTS)}")
    try:
        return network_from_arrays(inputs, model.arrays)
    except ModelError as error:
        raise ModelError(f"{model.file.with_suffix('.npz')}: {error}") from None


def network_ticks(source: str | Path = "push") -> int:
    """T of a network's training: control ticks of one action.

    Raises:
        ModelError: The model is missing or damaged, or its card does not say.
    """
    model = load_model(source, "q-network")
    ticks = model.card.get("ticks")
    if type(ticks) is not int or not 1 <= ticks <= _MOST_TICKS:
        raise ModelError(f"{model.file}: ticks is {ticks!r:.80}, expected 1 to {_MOST_TICKS} control ticks")
    return ticks


def random_network(inputs: Inputs, hidden: Sequence[int], rng: np.random.Generator) -> QNetwork:
    """An untrained network: uniform within 1 / sqrt(fan-in), biases too."""
    widths = [INPUTS[inputs], *hidden, CONTROLS]
    layers: list[Layer] = []
    for i in range(len(widths) - 1):
        bound = 1 / math.sqrt(widths[i])
        weights = rng.uniform(-bound, bound, (widths[i + 1], widths[i])).astype(np.float32)
        biases = rng.uniform(-bound, bound, widths[i + 1]).astype(np.float32)
        layers.append((weights, biases))
    return QNetwork(inputs, tuple(layers))
