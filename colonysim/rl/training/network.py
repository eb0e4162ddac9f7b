"""The network of a colony's policy in PyTorch: one encoder for all neighbours, whose order does not matter."""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from colonysim.rl.spaces import rows_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from colonysim.learning.layers import Layer

    Affine: TypeAlias = Callable[[torch.Tensor], torch.Tensor]

__all__ = ["Columns", "Scorer", "layers_of", "symmetries"]

_SELF_UNITS = (10.0, 10.0, 1.0, 5.0, 3.0, 1.0, 1.0, 1.0, 1.0, 1.0)
_BOX_UNITS = (1.0, 5.0, 5.0, 1.0, 1.0)
_HOLE_UNITS = (1.0, 5.0, 5.0, 1.0)
_MARK_UNITS = {"D": 20.0, "E": 5.0}
_WORTH_UNIT = 40.0
"""What the numbers of an observation are divided by, so that most of them lie between -1 and 1."""


class Columns:
    """Where the numbers of an observation in the flat form stand.

    Args:
        options: As of `Observer.options`, with all parts, and with holes chosen by the rule.

    Attributes:
        neighbours: Rows of neighbours.
        own: Columns of what is not told of a neighbour: the agent, the marks on its node, boxes and holes.
        own_units: What these are divided by.
        rows: For each neighbour the columns of what is told of it, shape (neighbours, numbers of one).
        marks: For each neighbour the columns of the marks there, shape (neighbours, fields).
        own_marks: The columns of the marks on the agent's node, shape (fields,).
        vectors: The columns of all pairs dx, dy, shape (n, 2).
        size: How many numbers there are.
    """

    def __init__(self, options: Mapping[str, Any]) -> None:
        boxes, holes, fields = options["boxes"], options["holes"], options["fields"]
        self.neighbours, self.size, places = options["neighbours"], 0, dict[str, NDArray[np.intp]]()
        for part, (count, row) in rows_of(self.neighbours, boxes, holes, len(fields)).items():
            places[part] = self.size + np.arange(count * len(row)).reshape(count, len(row))
            self.size += count * len(row)
        self.rows, marks = places["neighbours"], places["pheromones"]
        self.marks, self.own_marks = marks[:-1], marks[-1]
        of_self, of_boxes, of_holes = (places[part] for part in ("self", "boxes", "holes"))
        self.own = np.concatenate([of_self[0], self.own_marks, of_boxes.ravel(), of_holes.ravel()])
        mark_units = [_MARK_UNITS.get(name, 1.0) for name in fields]
        box_units = (*_BOX_UNITS, *(_WORTH_UNIT,) * holes)
        self.own_units = np.array([*_SELF_UNITS, *mark_units, *box_units * boxes, *_HOLE_UNITS * holes], np.float32)
        self.vectors = np.concatenate([of_self[:, 0:2], self.rows[:, 1:3], of_boxes[:, 1:3], of_holes[:, 1:3]])


def symmetries(columns: Columns) -> list[tuple[NDArray[np.intp], NDArray[np.float32]]]:
    """The eight ways to turn and mirror what an agent is told: the order of the numbers, and their signs."""
    found = []
    x, y = columns.vectors.T
    for swapped in (False, True):
        for east in (1.0, -1.0):
            for north in (1.0, -1.0):
                order, signs = np.arange(columns.size), np.ones(columns.size, np.float32)
                if swapped:
                    order[x], order[y] = y, x
                signs[x], signs[y] = east, north
                found.append((order, signs))
    return found


class Scorer(nn.Module):
    """A network that looks at each neighbour with the same weights, and at all of them by their mean.

    Each layer is affine, and between layers stands a ReLU. Numbers that belong to no neighbour are part of what every
    neighbour is judged by; of marks on a neighbour's node the difference to those on the agent's own counts.

    Args:
        columns: Where the numbers of an observation stand.
        hidden: Widths of the hidden layers, for each neighbour.
        each: Outputs for each neighbour.
        common: Outputs for all neighbours together.
        more: How many further numbers are read, behind those of the observation.
    """

    def __init__(self, columns: Columns, hidden: Sequence[int], each: int, common: int, more: int = 0) -> None:
        super().__init__()
        self.columns, self.each, self.common = columns, each, common
        own = len(columns.own) + more
        self.near = nn.Linear(columns.rows.shape[1] + columns.marks.shape[1], hidden[0], bias=False)
        self.about = nn.Linear(own, hidden[0])
        widths = [*pairwise(hidden)]
        self.alone = nn.ModuleList(nn.Linear(i, o) for i, o in widths)
        self.others = nn.ModuleList(nn.Linear(i, o, bias=False) for i, o in widths)
        self.scores = nn.Linear(hidden[-1], each) if each else None
        self.whole = nn.Linear(hidden[-1], common)
        for layer in (self.scores, self.whole):
            if layer is not None:
                nn.init.orthogonal_(layer.weight, 0.01 if each else 1.0)
                nn.init.zeros_(layer.bias)
        near = np.concatenate([columns.rows, columns.marks], axis=1)
        self._near, self._near_size = torch.from_numpy(near.ravel()), near.shape
        self._own = torch.from_numpy(np.concatenate([columns.own, columns.size + np.arange(more)]))
        self._own_marks = torch.from_numpy(columns.own_marks)
        self._units = torch.from_numpy(np.concatenate([columns.own_units, np.ones(more, np.float32)]))

    def first(self, told: torch.Tensor) -> torch.Tensor:
        """The first layer: (n, numbers) to (n, neighbours, width)."""
        near = told.index_select(1, self._near).view(-1, *self._near_size)
        own = self.about(told.index_select(1, self._own) / self._units)
        # The layer of the neighbours reads the marks on the agent's own node too, with the opposite sign.
        own = own - told.index_select(1, self._own_marks) @ self.near.weight[:, -len(self._own_marks) :].T
        found: torch.Tensor = self.near(near) + own[:, None, :]
        return found

    def between(self, number: int, seen: torch.Tensor) -> torch.Tensor:
        """A further layer: (n, neighbours, width) to (n, neighbours, next width)."""
        found: torch.Tensor = self.alone[number](seen) + self.others[number](seen.mean(dim=1, keepdim=True))
        return found

    def last(self, seen: torch.Tensor) -> torch.Tensor:
        """The last layer: (n, neighbours, width) to (n, outputs), those of neighbours first, in groups."""
        whole: torch.Tensor = self.whole(seen.mean(dim=1))
        if self.scores is None:
            return whole
        return torch.cat([self.scores(seen).transpose(1, 2).flatten(1), whole], dim=1)

    def forward(self, told: torch.Tensor) -> torch.Tensor:
        """The outputs for observations, (n, numbers) to (n, each * neighbours + common)."""
        seen = torch.relu(self.first(told))
        for number in range(len(self.alone)):
            seen = torch.relu(self.between(number, seen))
        return self.last(seen)


def layers_of(network: Scorer) -> list[Layer]:
    """The same network as a perceptron, whose weights repeat for each neighbour: what `save_policy` takes."""
    count, widths = network.columns.neighbours, [network.near.out_features]
    widths += [layer.out_features for layer in network.alone]  # type: ignore[misc]
    further: list[Affine] = [*(partial(network.between, number) for number in range(len(network.alone)))]
    further.append(network.last)
    return [
        _dense(lambda told: network.first(told).flatten(1), network.columns.size),
        *(_dense(_apart(layer, count), count * width) for layer, width in zip(further, widths, strict=True)),
    ]


def _apart(layer: Affine, count: int) -> Affine:
    """A layer that reads and gives one row of numbers instead of one for each neighbour."""
    return lambda seen: layer(seen.reshape(len(seen), count, -1)).flatten(1)


def _dense(affine: Affine, inputs: int) -> Layer:
    """Weights (outputs x inputs) and biases of an affine function: what it makes of 0, and of each single input."""
    with torch.no_grad():
        bias = affine(torch.zeros(1, inputs))
        weights = affine(torch.eye(inputs)) - bias
    return np.ascontiguousarray(weights.T.numpy()), bias[0].numpy()
