"""The pheromones of a run: every value that a field ever had, and what the ends of episodes did to them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from colonysim.errors import ColonysimError
from colonysim.pheromones.field import Write
from colonysim.plugins import BUILT_IN, make_policy
from colonysim.world.state import World

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from colonysim.pheromones.field import Field
    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Frame
    from colonysim.view.columns import Columns
    from colonysim.view.packing import Block

__all__ = ["Fields", "Mark", "add_marks"]

Mark = tuple[str, int, int, float]
"""Field, place (a node's index, or a box), key (a hole's node's index, or -1), value."""


def add_marks(
    block: Block,
    fields: Fields,
    before: Sequence[Sequence[Mark]],
    deposits: Columns,
    index: Callable[[Any], NDArray[np.int64]],
) -> None:
    """Adds the fields: places to write to ("slots"), their values as each episode began, and every deposit.

    Args:
        block: What to add to.
        fields: Of the run's policy.
        before: The values as each episode began.
        deposits: Of these episodes.
        index: From the numbers of nodes to their indices.
    """
    names, field = deposits.words("field")
    names += sorted({mark[0] for marks in before for mark in marks} - set(names))
    at = deposits.column("node")
    boxed = np.isin(field, [i for i, name in enumerate(names) if fields.by_box(name)])
    rows = np.column_stack([field, np.where(boxed, at, index(at)), index(deposits.column("key"))])
    starts = np.array([[names.index(m[0]), m[1], m[2]] for marks in before for m in marks], dtype=np.int64)
    slots, which = _distinct(np.vstack([starts.reshape(-1, 3), rows]))
    block.head["fields"] = names
    block.head["byBox"] = [name for name in names if fields.by_box(name)]
    for i, name in enumerate(("field", "place", "key")):
        block.ints(f"slots.{name}", slots[:, i], steps=True)
    block.ints("starts.first", np.cumsum([0, *map(len, before)]))
    block.ints("starts.slot", which[: len(starts)], steps=True)
    block.reals("starts.value", [mark[3] for marks in before for mark in marks])
    block.ints("deposits.first", deposits.first)
    block.ints("deposits.time", deposits.milliseconds(), steps=True)
    block.ints("deposits.slot", which[len(starts) :])
    block.reals("deposits.value", deposits.column("value"))


def _distinct(rows: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The different rows of a matrix of numbers from -1 on, in order, and for each of its rows which of them it is."""
    wide = rows.max(axis=0, initial=0) + 2
    # One number a row: of that many rows, rows themselves would take ten times as long to sort.
    packed = ((rows[:, 0] + 1) * wide[1] + rows[:, 1] + 1) * wide[2] + rows[:, 2] + 1
    _, first, which = np.unique(packed, return_index=True, return_inverse=True)
    return rows[first], which.ravel()


class Fields:
    """The pheromone fields of a run, asked what the end of an episode makes of them.

    What evaporates between two episodes is in no row, so fields of our own are filled with the key frames of the
    episode before and asked. No other code is loaded because a run names it: fields that are not ours begin an episode
    with their key frames as they are.

    Args:
        run: Whose fields.

    Attributes:
        by_box: Whether the values of a field belong to boxes instead of nodes, by its name.
    """

    def __init__(self, run: Run) -> None:
        self._scenario, self._policy = run.scenario, run.manifest["policy"]
        self.by_box = run.by_box

    def after(self, frames: Iterable[Frame]) -> list[Mark]:
        """Every value as an episode began, by the key frames of the one before."""
        scenario = self._scenario
        fields = _own_fields(self._policy, scenario)
        holes = {hole.node: key for key, hole in enumerate(scenario.holes)}
        marks: list[Mark] = []
        writes: dict[str, list[Write]] = {}
        for frame in frames:
            mark = self._mark_of(frame)
            name, place, key, value = mark
            if name in fields:
                writes.setdefault(name, []).append(Write(place, holes.get(key, -1), value))
            else:
                marks.append(mark)
        for name, field in fields.items():
            field.load(writes.pop(name, []))
            field.end_episode()
            marks += [
                (name, place, scenario.holes[key].node if key >= 0 else -1, value)
                for place, key, value in field.frame()
            ]
        return marks

    def _mark_of(self, frame: Frame) -> Mark:
        index = self._scenario.topology.index
        place = frame.node if self.by_box(frame.field) else index[frame.node]
        return frame.field, place, index[frame.key] if frame.key >= 0 else -1, frame.value


def _own_fields(policy: str, scenario: Scenario) -> Mapping[str, Field]:
    """The fields of a policy of ours, without those that it was asked to carry; of any other policy none."""
    if policy not in BUILT_IN["policies"]:
        return {}
    parameters = {name: value for name, value in scenario.parameters.items() if name != "extra_fields"}
    try:
        place = replace(scenario, parameters=parameters)
        return make_policy(policy, place).fields(World(place))
    except ColonysimError:  # another version had other parameters
        return {}
