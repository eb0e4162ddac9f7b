"""Can this push succeed? The paper's random forest, as flat arrays and evaluated with NumPy alone."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from colonysim.learning.cards import Model, ModelError, as_finite, load_model
from colonysim.push.state import State

__all__ = ["Feasibility", "load_feasibility"]

_DEEPEST = 1000
"""Steps from a root to a leaf, at most."""
_INPUTS = 9
Array = npt.NDArray[Any]


@dataclass(frozen=True, slots=True)
class Feasibility:
    """A random forest as flat arrays: one entry per node, all trees in a row.

    Attributes:
        roots: First node of each tree.
        feature: Number of the state that a node looks at.
        threshold: Up to this value the way goes left.
        left: Next node; a leaf leads to itself.
        right: Next node.
        value: Chance of success at a leaf.
        depth: Steps from a root to the deepest leaf.
    """

    roots: Array
    feature: Array
    threshold: Array
    left: Array
    right: Array
    value: Array
    depth: int

    def __call__(self, state: State | Sequence[float] | Array) -> float:
        """The chance that `rl` succeeds from a state (the nine numbers of paper Eq. 4)."""
        x = np.asarray(state, dtype=np.float32)
        node = self.roots
        for _ in range(self.depth):
            goes_left = x.take(self.feature.take(node)) <= self.threshold.take(node)
            node = np.where(goes_left, self.left.take(node), self.right.take(node))
        return float(self.value.take(node).mean(dtype=np.float64))

    def many(self, states: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """The chances for states of shape (n, 9); shape (n,)."""
        # The forest was grown on single precision, so that is what its thresholds have to be compared with.
        x = np.asarray(states, dtype=np.float32)
        rows = np.arange(len(x))[:, None]
        node = np.broadcast_to(self.roots, (len(x), len(self.roots)))
        for _ in range(self.depth):
            goes_left = x[rows, self.feature[node]] <= self.threshold[node]
            node = np.where(goes_left, self.left[node], self.right[node])
        chances: npt.NDArray[np.float64] = self.value[node].mean(axis=1, dtype=np.float64)
        return chances


def load_feasibility(source: str | Path = "feasibility") -> Feasibility:
    """A shipped classifier by name, or one by the path of its card.

    Raises:
        ModelError: It is missing, damaged, or of the wrong shape.
    """
    model = load_model(source, "forest")
    return _checked(model)


def _checked(model: Model) -> Feasibility:
    wanted = {"roots", "feature", "threshold", "left", "right", "value"}
    if set(model.arrays) != wanted:
        raise ModelError(f"{model.file}: arrays {sorted(model.arrays)!s:.200}, expected {sorted(wanted)}")
    arrays = {key: model.arrays[key] for key in wanted}
    nodes = arrays["value"].size
    depth = model.card.get("depth")
    fits = all(a.ndim == 1 for a in arrays.values()) and all(len(arrays[k]) == nodes for k in wanted - {"roots"})
    if not fits or nodes == 0 or len(arrays["roots"]) == 0:
        raise ModelError(f"{model.file}: the arrays do not describe one forest")
    if type(depth) is not int or not 0 <= depth <= _DEEPEST:
        raise ModelError(f"{model.file}: depth is {depth!r:.80}, expected 0 to {_DEEPEST}")
    for key, end in (("roots", nodes), ("left", nodes), ("right", nodes), ("feature", _INPUTS)):
        if arrays[key].dtype.kind not in "iu" or arrays[key].min() < 0 or arrays[key].max() >= end:
            raise ModelError(f"{model.file}: array {key!r} points outside of 0 to {end - 1}")
        arrays[key] = arrays[key].astype(np.int32)
    if arrays["value"].min() < 0.0 or arrays["value"].max() > 1.0:
        raise ModelError(f"{model.file}: array 'value' holds a chance outside of 0 to 1")
    try:
        for key in ("threshold", "value"):
            arrays[key] = as_finite(arrays[key], np.float32, key)
    except ModelError as error:
        raise ModelError(f"{model.file}: {error}") from None
    return Feasibility(**arrays, depth=depth)
