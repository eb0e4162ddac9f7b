"""Pheromones of another run to start with."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from colonysim.errors import ColonysimError
from colonysim.pheromones.field import Write

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from colonysim.pheromones.field import Field
    from colonysim.trace.schema import Frame
    from colonysim.world.state import World

__all__ = ["load_fields"]


def load_fields(world: World, fields: Mapping[str, Field], initial: Mapping[str, Iterable[Frame]]) -> None:
    """Puts another run's key frames into the fields; numbers of the file become indices again."""
    index = world.topology.index
    if not fields.keys() & initial.keys():
        names = ", ".join(fields) or "none"
        raise ColonysimError(
            f"pheromones {', '.join(initial)} to start with: this policy would not see them, its own are: {names}"
        )
    hole_key = {world.topology.ids[hole.node]: key for key, hole in enumerate(world.scenario.holes)}
    for name, frames in initial.items():
        field = fields.get(name)
        if field is None:
            continue
        writes = []
        for frame in frames:
            node = frame.node if field.by_box else index.get(frame.node, -1)
            key = hole_key.get(frame.key, -1) if frame.key >= 0 else -1
            if node < 0 or (frame.key >= 0 and key < 0):
                raise ColonysimError(f"the other run's {name} speaks of node {frame.node}; this map has no such node")
            if field.by_box and node >= len(world.scenario.boxes):
                raise ColonysimError(f"the other run's {name} speaks of box {node}; there is no such box here")
            if not math.isfinite(frame.value):
                raise ColonysimError(
                    f"the other run's {name} holds {frame.value} at {frame.node}, expected a finite number"
                )
            writes.append(Write(node, key, frame.value))
        field.load(writes)
        # The frames were taken before the end of their episode did its work.
        field.end_episode()
