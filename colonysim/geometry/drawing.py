"""A scenario's place and bodies in metres, for whoever draws a run."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

from colonysim.geometry.layout import lay_out
from colonysim.physics import BoxSpec, Ground, Pit, Ramp, Robot, Slab

if TYPE_CHECKING:
    from collections.abc import Mapping

    from colonysim.scenario.scenario import Scenario

__all__ = ["Drawing", "draw"]

_Part = TypeVar("_Part", Ground, Pit, Ramp, BoxSpec)
_UNSCALED = frozenset({"yaw", "mass", "friction"})


@dataclass(frozen=True, slots=True)
class Drawing:
    """A `Layout` in metres: poses in a trace are, and a layout counts in units of its robot.

    Attributes:
        places: x, y of each node.
        heights: Height of each node's ground; of a hole, of its rim.
        pit_at: For each hole's node, the index of its pit.
        grounds: The level grounds.
        ramps: The ramps.
        pits: The pits.
        slabs: The boxes that ground, ramps and pits are made of.
        boxes: The boxes where they start; masses are left in units.
        robot: What robot all are whose group has none of its own, in SI units.
        models: What robot each is, in SI units.
    """

    places: tuple[tuple[float, float], ...]
    heights: tuple[float, ...]
    pit_at: Mapping[int, int]
    grounds: tuple[Ground, ...]
    ramps: tuple[Ramp, ...]
    pits: tuple[Pit, ...]
    slabs: tuple[Slab, ...]
    boxes: tuple[BoxSpec, ...]
    robot: Robot
    models: tuple[Robot, ...]


def draw(scenario: Scenario) -> Drawing:
    """Lays a scenario out and measures it in metres.

    Raises:
        ScenarioError: The place cannot be built, or its robot is none that the controls can handle.
    """
    layout = lay_out(scenario)
    terrain, unit = layout.terrain, layout.robot.scale
    return Drawing(
        tuple((unit * x, unit * y) for x, y in layout.places),
        tuple(unit * z for z in layout.heights),
        layout.pit_at,
        tuple(_times(unit, ground) for ground in terrain.grounds),
        tuple(_times(unit, ramp) for ramp in terrain.ramps),
        tuple(_times(unit, pit) for pit in terrain.pits),
        tuple(_slab(unit, slab) for slab in terrain.slabs()),
        tuple(_times(unit, box) for box in layout.boxes),
        layout.robot,
        layout.models,
    )


def _slab(unit: float, slab: Slab) -> Slab:
    (x, y, z), (a, b, c) = slab.centre, slab.half
    return replace(slab, centre=(unit * x, unit * y, unit * z), half=(unit * a, unit * b, unit * c))


def _times(unit: float, part: _Part) -> _Part:
    lengths = {name: unit * getattr(part, name) for name in part.__dataclass_fields__ if name not in _UNSCALED}
    return replace(part, **lengths)
