"""Multilayer perceptrons as plain arrays, and their forward pass in NumPy: to run one needs no learning library."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from colonysim.learning.cards import ModelError, as_finite

__all__ = ["ACTIVATIONS", "Activation", "Float", "Layer", "arrays_of", "forward", "layers_from_arrays"]

Float = npt.NDArray[np.float32]
Layer = tuple[Float, Float]
"""Weights (outputs x inputs) and biases."""
Activation = Literal["relu", "tanh"]
ACTIVATIONS: tuple[Activation, ...] = ("relu", "tanh")
"""What may stand between two layers; after the last one stands nothing."""


def forward(layers: Sequence[Layer], inputs: Float, activation: Activation = "relu") -> Float:
    """The outputs of a perceptron.

    Args:
        layers: First layer first.
        inputs: Shape (k,) or (n, k).
        activation: What stands between two layers.

    Returns:
        Shape (m,) or (n, m).
    """
    hidden = inputs
    last = len(layers) - 1
    for i, (weights, biases) in enumerate(layers):
        hidden = hidden @ weights.T
        hidden += biases
        if i < last:
            if activation == "relu":
                np.maximum(hidden, 0.0, out=hidden)
            else:
                np.tanh(hidden, out=hidden)
    return hidden


def arrays_of(layers: Sequence[Layer]) -> dict[str, npt.NDArray[Any]]:
    """The layers as named arrays: `w0`, `b0`, `w1` and so on."""
    made: dict[str, npt.NDArray[Any]] = {}
    for i, (weights, biases) in enumerate(layers):
        made[f"w{i}"], made[f"b{i}"] = weights, biases
    return made


def layers_from_arrays(
    arrays: Mapping[str, npt.NDArray[Any]], inputs: int, outputs: int, largest: float
) -> tuple[Layer, ...]:
    """The layers that `arrays_of` named.

    Args:
        arrays: Weights and biases by name.
        inputs: Width of the input.
        outputs: Width of the output.
        largest: No input is further from 0.

    Raises:
        ModelError: The arrays do not fit together, or a number in them or an output could be infinite.
    """
    layers: list[Layer] = []
    width = inputs
    while f"w{len(layers)}" in arrays:
        number = len(layers)
        weights, biases = arrays[f"w{number}"], arrays.get(f"b{number}", np.zeros(0))
        if weights.ndim != 2 or weights.shape[1] != width or biases.shape != weights.shape[:1]:
            raise ModelError(
                f"layer {number} has weights {weights.shape} and biases {biases.shape}, expected (n, {width}) and (n,)"
            )
        width = weights.shape[0]
        layers.append((as_finite(weights, np.float32, f"w{number}"), as_finite(biases, np.float32, f"b{number}")))
    if not layers or width != outputs or len(arrays) != 2 * len(layers):
        raise ModelError(f"{len(layers)} layers with {width} outputs, expected {outputs} outputs")
    _check_range(layers, largest)
    return tuple(layers)


def _check_range(layers: Sequence[Layer], largest: float) -> None:
    """Refuses weights with which the outputs may not be finite numbers."""
    bound = np.full(layers[0][0].shape[1], largest)
    for number, (weights, biases) in enumerate(layers):
        bound = np.abs(weights.astype(np.float64)) @ bound + np.abs(biases)
        if bound.max(initial=0.0) > np.finfo(np.float32).max:
            raise ModelError(f"layer {number} has weights so large that outputs would be infinite")
