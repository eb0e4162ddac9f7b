"""The arrays that agents are told, and the spaces of observations and actions in which they lie."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from colonysim.errors import ColonysimError
from colonysim.rl.moves import OUTCOMES, PARTS, Moves
from colonysim.rl.sight import Sight
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from gymnasium import spaces
    from numpy.typing import NDArray

    from colonysim.scenario.scenario import Scenario

__all__ = ["Observation", "Observer", "rows_of", "sizes_of"]

Observation: TypeAlias = "NDArray[np.float32] | dict[str, NDArray[Any]]"
"""What an agent is told: in the flat form one array, else one array for each part, and the mask of actions."""

_INF = np.inf
_Row: TypeAlias = tuple[tuple[float, float], ...]
_SELF = ((-_INF, _INF),) * 2 + ((0, 1), (0, _INF), (0, _INF), (0, 1)) + ((0, 1),) * len(OUTCOMES)
_NEIGHBOUR = ((0, 1), (-_INF, _INF), (-_INF, _INF), (0, _INF), *((0, 1),) * 6, (-_INF, _INF))
_BOX = ((0, 1), (-_INF, _INF), (-_INF, _INF), (0, _INF), (-1, 1))
_HOLE = ((0, 1), (-_INF, _INF), (-_INF, _INF), (-_INF, _INF))
"""Least and greatest of each number."""


def sizes_of(options: Mapping[str, Any]) -> tuple[int, int]:
    """How many numbers an observation has, and how many actions there are.

    Args:
        options: As of `Observer.options`.
    """
    neighbours, boxes, holes = options["neighbours"], options["boxes"], options["holes"]
    rows = rows_of(neighbours, boxes, holes, len(options["fields"]))
    numbers = sum(count * len(row) for count, row in (rows[part] for part in options["parts"]))
    return numbers, Moves(neighbours, holes, options["hole"] == "action").count


def rows_of(neighbours: int, boxes: int, holes: int, fields: int) -> dict[str, tuple[int, _Row]]:
    """For each part of an observation how many rows it has, and the least and greatest number in each column."""
    any_number = (-_INF, _INF)
    return {
        "self": (1, _SELF), "neighbours": (neighbours, _NEIGHBOUR),
        "pheromones": (neighbours + 1, (any_number,) * fields),
        "boxes": (boxes, (*_BOX, *(any_number,) * holes)), "holes": (holes, _HOLE),
    }  # fmt: skip


class Observer:
    """Turns what an agent sees into arrays of one size.

    Args:
        scenario: The place; it gives the sizes.
        fields: The pheromone fields by name, and whether their values belong to boxes.
        parts: Which parts an observation has.
        flat: Whether it is one array instead of one for each part.
        boxes: Of the boxes in sight, so many are told of, the nearest first.
        holes: Of the holes in sight, so many, by their numbers.
        by_action: Whether the action says which hole a box is meant for.
        marks: Whether the action says if the agent leaves a mark.
        neighbours: Tell of so many neighbours, and of exactly so many boxes and holes, whatever the place has, so that
            one network fits many places; None for as many as the place has.
        busy: Whether there is one more action, the last: to do nothing, which is all that agents can do that are not
            asked.

    Attributes:
        moves: The actions.
        names: The fields whose values at nodes are told.
        size: How many numbers an observation has.
        actions: How many actions there are.

    Raises:
        ColonysimError: There is no such part, or a node has more neighbours.
    """

    def __init__(
        self, scenario: Scenario, fields: Mapping[str, bool], *, parts: Sequence[str] = PARTS, flat: bool = False,
        boxes: int = 8, holes: int = 8, by_action: bool = False, neighbours: int | None = None,
        marks: bool = False, busy: bool = False,
    ) -> None:  # fmt: skip
        for part in parts:
            if part not in PARTS:
                raise ColonysimError(f"observations have no part {part!r}; {nearest(str(part), PARTS)}")
        self._boxes, self._holes, most = boxes, holes, scenario.topology.most_neighbours
        if neighbours is None:
            neighbours = most
            self._boxes, self._holes = min(boxes, len(scenario.boxes)), min(holes, len(scenario.holes))
        elif neighbours < most:
            raise ColonysimError(
                f"scenario {scenario.name!r}: a node has {most} neighbours, and observations tell of {neighbours}"
            )
        self.moves, self.busy = Moves(neighbours, self._holes, by_action, marks), busy
        self.names = tuple(name for name, by_box in fields.items() if not by_box)
        rows = rows_of(neighbours, self._boxes, self._holes, len(self.names))
        bounds = {part: np.array((row,) * count, np.float32) for part, (count, row) in rows.items() if part in parts}
        self._bounds = {part: each for part, each in bounds.items() if each.size}
        self._shapes = {part: each.shape[:2] if part != "self" else each.shape[1:2] for part, each in bounds.items()}
        self.size, self._slices = 0, dict[str, slice]()
        for part, each in self._bounds.items():
            self._slices[part] = slice(self.size, self.size + each[..., 0].size)
            self.size += each[..., 0].size
        self._begins = [(part, cut.start) for part, cut in self._slices.items()]
        self._layout = np.dtype([(part, np.float32, self._shapes[part]) for part in self._slices])
        self._idle, self._rest = bytes(busy), bytearray(self.moves.count) + b"\1" * busy
        self.flat, self.actions = flat, self.moves.count + busy

    @property
    def options(self) -> dict[str, Any]:
        """What observations and actions are made of, as `colonysim.rl.save_policy` stores it.

        Raises:
            ColonysimError: Actions leave marks, which the policy `learned` cannot.
        """
        if self.moves.marks:
            raise ColonysimError("a policy is saved for a run, and in runs marks are left by rules: deposits='rule'")
        return {
            "parts": [*self._slices], "neighbours": self.moves.neighbours, "boxes": self._boxes, "holes": self._holes,
            "hole": "action" if self.moves.by_action else "rule", "fields": [*self.names],
        }  # fmt: skip

    @cached_property
    def action_space(self) -> spaces.Discrete:
        """Of one agent; needs Gymnasium."""
        from gymnasium import spaces

        return spaces.Discrete(self.actions)

    @cached_property
    def observation_space(self) -> spaces.Space[Any]:
        """Of one agent; needs Gymnasium."""
        from gymnasium import spaces

        low = np.concatenate([each[..., 0].ravel() for each in self._bounds.values()] or [np.zeros(0, np.float32)])
        high = np.concatenate([each[..., 1].ravel() for each in self._bounds.values()] or [np.zeros(0, np.float32)])
        if self.flat:
            return spaces.Box(low, high, dtype=np.float32)
        found: dict[str, spaces.Space[Any]] = {
            part: spaces.Box(low[cut].reshape(shape), high[cut].reshape(shape), dtype=np.float32)
            for (part, cut), shape in zip(self._slices.items(), map(self._shapes.get, self._slices), strict=True)
        }
        return spaces.Dict({**found, "action_mask": spaces.Box(0, 1, (self.actions,), np.int8)})

    def sight(self, view: Any) -> Sight:
        """What the agent of a view sees."""
        return Sight(view, self.moves, self._holes)

    def numbers(self, sight: Sight) -> NDArray[np.float32]:
        """All parts of an observation of what an agent sees, one after the other."""
        found = np.zeros(self.size, np.float32)
        sight.write(self._begins, self.names, self._boxes, self._holes, found)
        return found

    def mask(self, sight: Sight | None) -> NDArray[np.int8]:
        """For each action whether the agent can do that; without a sight it can do nothing."""
        if sight is None:
            return np.frombuffer(self._rest[:], np.int8)
        return np.frombuffer(sight.mask + self._idle, np.int8)

    def observation(self, numbers: NDArray[np.float32], mask: NDArray[np.int8]) -> Observation:
        """The observation of such numbers."""
        if self.flat:
            return numbers
        rows = np.ndarray((), self._layout, numbers)  # a structure, whose fields are parts of the same memory
        found: dict[str, NDArray[Any]] = {part: rows[part] for part in self._slices}
        found["action_mask"] = mask
        return found

    def nothing(self) -> NDArray[np.float32]:
        """The numbers of an agent that sees nothing: it is not there."""
        return np.zeros(self.size, np.float32)
