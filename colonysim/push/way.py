"""The chance that a box gets all along its way: a logistic regression on what can be foreseen of each push.

The way of a box is the sequence of nodes that it is to be pushed along, one push from each node to the next.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from colonysim.learning.cards import ModelError, as_finite, load_model
from colonysim.physics import Scene
from colonysim.push.foresight import Features, foresee
from colonysim.push.paths import Surroundings
from colonysim.push.task import PushTask

__all__ = ["WayChance", "chances_along", "load_way_chance"]


@dataclass(frozen=True, slots=True)
class WayChance:
    """A logistic regression that foresees whether one push of a way succeeds.

    Attributes:
        weights: One for each of the `Features`.
        bias: The log-odds where all features are 0.
    """

    weights: tuple[float, ...]
    bias: float

    def __call__(self, seen: Features) -> float:
        """The chance (0 to 1) that a push succeeds, given that those before it did.

        The chance of a way is the product over its pushes.
        """
        odds = self.bias + sum(w * x for w, x in zip(self.weights, seen, strict=True))
        return 1.0 / (1.0 + math.exp(-odds)) if odds > -700.0 else 0.0


def load_way_chance(source: str | Path = "way") -> WayChance:
    """A shipped model by name, or one by the path of its card.

    Raises:
        ModelError: It is missing, damaged, or was fitted to other features.
    """
    model = load_model(source, "logistic")
    if model.card.get("features") != list(Features._fields):
        names = ", ".join(Features._fields)
        raise ModelError(f"{model.file}: features: fitted to other features than {names}; fit it again")
    weights, bias = model.arrays.get("weights"), model.arrays.get("bias")
    if weights is None or bias is None or weights.shape != (len(Features._fields),) or bias.shape != (1,):
        raise ModelError(f"{model.file}: arrays: expected {len(Features._fields)} weights and a bias")
    try:
        weights, bias = as_finite(weights, np.float64, "weights"), as_finite(bias, np.float64, "bias")
    except ModelError as error:
        raise ModelError(f"{model.file}: {error}") from None
    return WayChance(tuple(map(float, weights)), float(bias[0]))


def chances_along(
    scene: Scene, robot: int, tasks: Sequence[PushTask], around: Surroundings, model: WayChance
) -> list[float]:
    """The chance (0 to 1) of each push of a box's way, in order, given that those before it succeed.

    Args:
        scene: The scene; nothing in it moves.
        robot: Index of the robot.
        tasks: The pushes of one box, in order.
        around: What to stay away from; robots are better left out: they move on.
        model: The regression.
    """
    return [model(seen) for seen in foresee(scene, robot, tasks, around)]
