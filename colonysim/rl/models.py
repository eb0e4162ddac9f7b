"""Files of learned policies: a network, what it is told, and how its values become actions. They hold no code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from colonysim.files import replace_file
from colonysim.learning.cards import (
    MOST_BYTES,
    ModelError,
    as_finite,
    check_place,
    load_model,
    read_card,
    read_content,
    save_model,
    write_card,
)
from colonysim.learning.layers import ACTIVATIONS, Activation, Float, Layer, arrays_of, forward, layers_from_arrays
from colonysim.learning.onnx import OnnxGraph
from colonysim.plugins import available, called, make_policy
from colonysim.policies.choice import sample, softmax
from colonysim.provenance import MODELS
from colonysim.rl.moves import PARTS
from colonysim.rl.options import WORDS
from colonysim.rl.spaces import sizes_of
from colonysim.suggest import nearest

if TYPE_CHECKING:
    import random

    from numpy.typing import ArrayLike, NDArray

    from colonysim.rl.aec import ColonyAEC
    from colonysim.rl.parallel import ColonyParallel
    from colonysim.rl.rllib import ColonyMultiAgent

    Environment: TypeAlias = ColonyAEC | ColonyParallel | ColonyMultiAgent

__all__ = ["CHOICES", "PolicyModel", "load_policy", "save_policy", "shipped_policies"]

KIND = "colony-policy"
CHOICES = ("greedy", "sampled")
"""How values become an action: the one of the largest among those allowed, or by chance in proportion to exp(value)."""
SHIPPED = Path(__file__).parent / "shipped"
"""Where the policies are that come with the package."""
_LARGEST = 1e9
"""No number of an observation is further from 0."""
_SIZES = {"neighbours": 1, "boxes": 0, "holes": 0}
"""The numbers of rows of an observation, and the least of each."""
_MOST_ROWS = 100_000


@dataclass(frozen=True)
class PolicyModel:
    """A learned policy: its network and all that is needed to run it.

    Attributes:
        file: Path of its card.
        network: The layers of a perceptron, or an ONNX graph.
        activation: What stands between two layers.
        observation: `parts`, `neighbours`, `boxes`, `holes` (rows), `hole` and `fields`, as of `Observer.options`.
        marks: The policy whose marks the agents leave.
        choice: How values become actions unless the scenario says otherwise, see `CHOICES`.
        card: The whole card.
    """

    file: Path
    network: tuple[Layer, ...] | OnnxGraph
    activation: Activation
    observation: Mapping[str, Any]
    marks: str
    choice: str
    card: Mapping[str, Any]

    @property
    def sha256(self) -> str:
        """SHA-256 of the file of the network."""
        return str(self.card["sha256"])

    def values(self, observation: ArrayLike) -> Float:
        """The value of each action.

        Args:
            observation: In the flat form, shape (k,) or (n, k).

        Returns:
            Shape (actions,) or (n, actions).

        Raises:
            ModelError: A value is no finite number.
        """
        told = np.asarray(observation, np.float32)
        if isinstance(self.network, OnnxGraph):
            return self.network.forward(told)
        found = forward(self.network, told, self.activation)
        if not np.isfinite(found).all():
            raise ModelError(f"{self.file}: gives a value that is no finite number")
        return found

    def act(self, observation: ArrayLike, mask: ArrayLike, random: random.Random | None = None) -> int:
        """An action that is allowed.

        Args:
            observation: In the flat form, shape (k,).
            mask: For each action whether it is allowed; at least one is.
            random: Draws the action, see `CHOICES`; None for the one of the largest value, the first if there are more.
        """
        values, allowed = self.values(observation), np.flatnonzero(mask)
        if random is None:
            return int(allowed[values[allowed].argmax()])
        return int(allowed[sample(softmax(values[allowed].tolist()), random)])


def save_policy(
    path: str | Path,
    network: Sequence[tuple[ArrayLike, ArrayLike]] | bytes,
    env: Environment | Mapping[str, Any],
    *,
    activation: str = "relu",
    choice: str = "greedy",
    marks: str | None = None,
    about: Mapping[str, Any] | None = None,
) -> Path:
    """Writes a learned policy, which `colonysim run SCENARIO --policy learned --set policy.model=FILE` runs.

    The network reads an observation in its flat form and gives a value for each action, for instance the logits of an
    actor or the Q of each action. An action to do nothing (`busy`, in parallel environments the last) is left out.

    Args:
        path: The file: `.npz` for layers, `.onnx` for an ONNX file. A card (`.json`) is written beside it.
        network: For each layer its weights (outputs x inputs, as PyTorch has them) and biases, first layer first; or
            the content of an ONNX file with an input of shape (n, numbers) and an output of shape (n, actions).
        env: The environment that it was trained in, or its `turns.observer.options`.
        activation: What stands between two layers: "relu" or "tanh".
        choice: How values become actions: "greedy" (the largest of those allowed) or "sampled" (by chance, in
            proportion to exp(value)).
        marks: The policy whose marks the agents leave; the environment's by default.
        about: How the policy was trained and how well it does, for the card: JSON values.

    Returns:
        Path of the card.

    Raises:
        ColonysimError: Something does not fit, or cannot be written.
    """
    file = Path(path)
    ending = ".onnx" if isinstance(network, bytes) else ".npz"
    if file.suffix != ending:
        raise ModelError(f"{file}: expected a name that ends in {ending}")
    card_file = file.with_suffix(".json")
    if isinstance(env, Mapping):
        told = dict(env)
    else:
        told, marks = env.turns.observer.options, marks or _marks_of(env)
    if marks is None:
        raise ModelError("marks: expected the name of the policy whose marks the agents leave")
    card = {
        "about": "Policy of a colony's agents: the value of each action for an observation",
        "observation": told, "network": ending[1:], "activation": activation, "choice": choice,
        "marks": marks, **({} if about is None else {"how": dict(about)}),
    }  # fmt: skip
    _check_card(card, card_file)
    check_place(file)
    inputs, outputs = sizes_of(told)
    if isinstance(network, bytes):
        OnnxGraph(file, network, (inputs,), outputs)
        replace_file(file, network, ModelError)
        write_card(card_file, KIND, {**card, "arrays": {}}, network)
        return card_file
    try:
        arrays = arrays_of([(np.asarray(weights), np.asarray(biases)) for weights, biases in network])
        _layers(arrays, inputs, outputs, file)
    except (TypeError, ValueError) as error:
        raise ModelError(f"{file}: network: {error}; expected weights and biases of each layer") from None
    save_model(file, KIND, arrays, card)
    return card_file


def shipped_policies() -> tuple[str, ...]:
    """Names of the learned policies that come with the package."""
    return tuple(sorted(file.stem for file in SHIPPED.glob("*.json")))


def load_policy(path: str | Path) -> PolicyModel:
    """Reads what `save_policy` wrote, or a policy that comes with the package.

    Args:
        path: The card, or the file of the network beside it; or a name of `shipped_policies`.

    Raises:
        MissingExtraError: It is an ONNX file, and ONNX Runtime is not installed.
        ModelError: It is missing, damaged, or of another kind.
    """
    file = Path(path)
    if str(path) in shipped_policies():
        file = SHIPPED / f"{path}.json"
    if file.suffix not in MODELS:
        known = ", or ".join(["the path of a card, which ends in .json", *shipped_policies()])
        raise ModelError(f"{file}: is no model; expected {known}")
    card_file = file.with_suffix(".json")
    card = read_card(card_file, KIND)
    _check_card(card, card_file)
    stored = f".{card['network']}"
    if file.suffix not in (".json", stored):
        raise ModelError(f"{file}: its card tells of {card_file.with_suffix(stored).name}")
    inputs, outputs = sizes_of(card["observation"])
    data = card_file.with_suffix(stored)
    network: tuple[Layer, ...] | OnnxGraph
    if stored == ".onnx":
        network = OnnxGraph(data, read_content(data, card), (inputs,), outputs)
    else:
        network = _layers(load_model(card_file, KIND).arrays, inputs, outputs, data)
    return PolicyModel(card_file, network, card["activation"], card["observation"], card["marks"], card["choice"], card)


def _layers(arrays: Mapping[str, NDArray[Any]], inputs: int, outputs: int, file: Path) -> tuple[Layer, ...]:
    """The layers of a perceptron that reads so many numbers and gives a value for so many actions."""
    try:
        for name, array in arrays.items():
            as_finite(array, np.float32, name)
        return layers_from_arrays(arrays, inputs, outputs, _LARGEST)
    except ModelError as error:
        expected = f"observations have {inputs} numbers, and there are {outputs} actions"
        raise ModelError(f"{file}: {error}; {expected}") from None


def _marks_of(env: Environment) -> str:
    """The name of the policy whose marks the agents of an environment leave."""
    turns = env.turns
    given = turns.scenario.policy if turns.options["policy"] is None else turns.options["policy"]
    return called("policies", given, make_policy(given, turns.scenario))


def _check_card(card: Mapping[str, Any], file: Path) -> None:
    """Refuses what no policy can be made of.

    Raises:
        ModelError: The first field that is wrong.
    """

    def fault(name: str, value: Any, expected: str) -> ModelError:
        return ModelError(f"{file}: {name}: is {value!r:.80}, expected {expected}")

    words: dict[str, tuple[str, ...]] = {"network": ("npz", "onnx"), "activation": ACTIVATIONS, "choice": CHOICES}
    for name, known in words.items():
        if card.get(name) not in known:
            raise fault(name, card.get(name), f"one of {', '.join(known)}")
    marks = card.get("marks")
    if not isinstance(marks, str) or marks == "learned" or marks not in available("policies"):
        # No file has code of others imported, so that one of "module:Name" is not among them.
        raise fault("marks", marks, f"a policy that leaves marks; {nearest(str(marks), available('policies'))}")
    told = card.get("observation")
    if not isinstance(told, dict) or set(told) != {*_SIZES, "parts", "hole", "fields"}:
        raise fault("observation", told, f"{', '.join(('parts', *_SIZES, 'hole', 'fields'))}")
    for name, least in _SIZES.items():
        if type(told[name]) is not int or not least <= told[name] <= _MOST_ROWS:
            raise fault(f"observation.{name}", told[name], f"a number of rows, {least} to {_MOST_ROWS}")
    if told["hole"] not in WORDS["hole"]:
        raise fault("observation.hole", told["hole"], f"one of {', '.join(WORDS['hole'])}")
    if not isinstance(told["parts"], list) or [part for part in PARTS if part in told["parts"]] != told["parts"]:
        raise fault("observation.parts", told["parts"], f"some of {', '.join(PARTS)}, in this order")
    if not isinstance(told["fields"], list) or not all(isinstance(name, str) for name in told["fields"]):
        raise fault("observation.fields", told["fields"], "names of pheromone fields")
    inputs, outputs = sizes_of(told)
    if not 0 < inputs * outputs <= MOST_BYTES:
        raise fault("observation", told, "numbers to decide from, and no more than a model can hold")
