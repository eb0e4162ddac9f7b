"""The pheromones of a run: every value that a field ever had, and what the ends of episodes did to them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from colonysim.errors import ColonysimError
from colonysim.pheromones.field import Write
from colonysim.plugins import make_policy
from colonysim.world.state import World

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import NDArray

    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Frame
    from colonysim.view.columns import Columns
    from colonysim.view.packing import Block

__all__ = ["add_marks"]

_Mark = tuple[str, int, int, float]
"""Field, place (a node's index, or a box), key (a hole's node's index, or -1), value."""


def add_marks(
    block: Block, run: Run, episodes: Sequence[int], deposits: Columns, index: Callable[[Any], NDArray[np.int64]]
) -> None:
    """Adds the fields: places to write to ("slots"), their values as each episode began, and every deposit.

    What evaporates between two episodes is in no row, so the fields themselves are asked, filled with the key
    frames of the episode before; of a policy that is not installed here, the key frames are taken as they are.
    """
    names, field = deposits.words("field")
    by_box = _by_box(run)
    before = [_at_start(run, episode, by_box) for episode in episodes]
    names += sorted({mark[0] for marks in before for mark in marks} - set(names))
    at = deposits.column("node")
    boxed = np.isin(field, [names.index(name) for name in by_box if name in names])
    rows = np.column_stack([field, np.where(boxed, at, index(at)), index(deposits.column("key"))])
    starts = np.array([[names.index(m[0]), m[1], m[2]] for marks in before for m in marks], dtype=np.int64)
    slots, which = np.unique(np.vstack([starts.reshape(-1, 3), rows]), axis=0, return_inverse=True)
    which = which.ravel()
    block.head["fields"] = names
    block.head["byBox"] = [name for name in names if name in by_box]
    for i, name in enumerate(("field", "place", "key")):
        block.ints(f"slots.{name}", slots[:, i], steps=True)
    block.ints("starts.first", np.cumsum([0, *map(len, before)]))
    block.ints("starts.slot", which[: len(starts)], steps=True)
    block.reals("starts.value", [mark[3] for marks in before for mark in marks])
    block.ints("deposits.first", deposits.first)
    block.ints("deposits.time", deposits.milliseconds(), steps=True)
    block.ints("deposits.slot", which[len(starts) :])
    block.reals("deposits.value", deposits.column("value"))


def _by_box(run: Run) -> frozenset[str]:
    """The fields whose values belong to boxes instead of nodes; the paper's if the policy is not installed here."""
    try:
        fields = make_policy(run.manifest["policy"], run.scenario).fields(World(run.scenario))
    except (ColonysimError, ValueError):
        return frozenset({"B"})
    return frozenset(name for name, field in fields.items() if field.by_box)


def _at_start(run: Run, episode: int, by_box: frozenset[str]) -> list[_Mark]:
    """Every value as the episode began."""
    if episode == run.episodes[0].episode:
        return []
    frames = run.frames(episode - 1)
    try:
        return _carried_over(run, frames, by_box)
    except (ColonysimError, ValueError):
        return [_mark_of(run, frame, by_box) for frame in frames]


def _carried_over(run: Run, frames: Iterable[Frame], by_box: frozenset[str]) -> list[_Mark]:
    """What the fields make of the end of the episode whose key frames these are."""
    world = World(run.scenario)
    fields = make_policy(run.manifest["policy"], run.scenario).fields(world)
    holes = {hole.node: key for key, hole in enumerate(run.scenario.holes)}
    writes: dict[str, list[Write]] = {}
    for frame in frames:
        name, place, key, value = _mark_of(run, frame, by_box)
        writes.setdefault(name, []).append(Write(place, holes.get(key, -1), value))
    marks: list[_Mark] = []
    for name, field in fields.items():
        field.load(writes.get(name, []))
        field.end_episode()
        marks += [
            (name, place, run.scenario.holes[key].node if key >= 0 else -1, value)
            for place, key, value in field.frame()
        ]
    return marks


def _mark_of(run: Run, frame: Frame, by_box: frozenset[str]) -> _Mark:
    index = run.scenario.topology.index
    place = frame.node if frame.field in by_box else index[frame.node]
    return frame.field, place, index[frame.key] if frame.key >= 0 else -1, frame.value
