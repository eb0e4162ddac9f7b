"""The Q network's forward pass in NumPy: running a push needs no learning library."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from colonysim.files import read_file
from colonysim.learning.cards import MOST_BYTES, ModelError, load_model
from colonysim.learning.layers import Float, Layer, arrays_of, forward, layers_from_arrays
from colonysim.learning.onnx import OnnxGraph
from colonysim.push.controls import CONTROLS
from colonysim.push.judging import STEP_TICKS
from colonysim.push.state import FEATURES, features

__all__ = [
    "INPUTS",
    "Inputs",
    "Network",
    "QNetwork",
    "encode",
    "load_network",
    "network_from_arrays",
    "network_ticks",
    "open_network",
    "random_network",
]

Inputs = Literal["state", "line"]
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
        return forward(self.layers, encoded)

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """The layers as named arrays."""
        return arrays_of(self.layers)


class Network(Protocol):
    """What chooses controls by their values: a `QNetwork`, or one in an ONNX file."""

    @property
    def inputs(self) -> Inputs:
        """What it reads."""
        ...

    def values(self, states: npt.ArrayLike) -> Float:
        """Q of every control, see `QNetwork.values`."""
        ...


@dataclass(frozen=True, slots=True)
class _OnnxNetwork:
    """A Q network in an ONNX file."""

    inputs: Inputs
    graph: OnnxGraph

    def values(self, states: npt.ArrayLike) -> Float:
        return self.graph.forward(encode(self.inputs, states))


def network_from_arrays(inputs: Inputs, arrays: Mapping[str, npt.NDArray[Any]]) -> QNetwork:
    """The network that `QNetwork.arrays` gave.

    Raises:
        ModelError: The arrays do not fit together.
    """
    return QNetwork(inputs, layers_from_arrays(arrays, INPUTS[inputs], CONTROLS, _LARGEST_INPUT))


def open_network(source: str | Path = "push") -> tuple[Network, int]:
    """A network, and T of its training: control ticks of one action.

    Args:
        source: Name of a shipped one, the path of a card, or an ONNX file. An ONNX file reads the nine numbers of
            paper Eq. 4 (input of shape (n, 9)) or the features that are made from them (n, 23), and gives a value for
            each of the eight controls; its metadata may say `ticks`, which are else those of `colonysim/Push-v0`.

    Raises:
        MissingExtraError: It is an ONNX file, and ONNX Runtime is not installed.
        ModelError: It is missing, damaged, or of the wrong shape.
    """
    file = Path(source)
    if file.suffix != ".onnx":
        return load_network(source), network_ticks(source)
    graph = OnnxGraph(file, read_file(file, ModelError, MOST_BYTES), tuple(INPUTS.values()), CONTROLS)
    inputs = next(name for name, width in INPUTS.items() if width == graph.inputs)
    told = graph.metadata.get("ticks", str(STEP_TICKS))
    ticks = int(told) if told.isdecimal() and len(told) < 9 else 0
    return _OnnxNetwork(inputs, graph), _checked_ticks(ticks or told, file)


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
    return _checked_ticks(model.card.get("ticks"), model.file)


def _checked_ticks(ticks: Any, file: Path) -> int:
    if type(ticks) is not int or not 1 <= ticks <= _MOST_TICKS:
        raise ModelError(f"{file}: ticks is {ticks!r:.80}, expected 1 to {_MOST_TICKS} control ticks")
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
