"""A scenario's lengths and masses, told in metres and kilograms, in the units that its robot counts in."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

    from colonysim.physics import Robot

__all__ = ["in_units"]

_LENGTHS = ("xy_scale", "z_scale", "box_length", "box_height", "pit_side", "ramp_half_width", "margin")
_ANGLES = frozenset({"yaw"})


def in_units(physics: Mapping[str, Any], robot: Robot) -> Mapping[str, Any]:
    """A scenario's `physics` in units of the robot; the very same for the standard one."""
    unit = robot.scale
    if unit == 1.0:
        return physics
    changed = {**physics, **{name: physics[name] / unit for name in _LENGTHS if physics.get(name) is not None}}
    if physics.get("box_mass") is not None:
        changed["box_mass"] = physics["box_mass"] / robot.mass_unit
    if physics.get("terrain"):
        changed["terrain"] = {
            kind: [{name: x if name in _ANGLES else x / unit for name, x in part.items()} for part in parts]
            for kind, parts in physics["terrain"].items()
        }
    return changed
