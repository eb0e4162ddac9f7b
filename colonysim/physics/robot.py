"""What a robot is: sizes, masses, motors and grip, in SI units, and the units in which a scene counts.

Everything that drives and pushes was tuned, and its network trained, on one robot, the standard one. A robot of
another size uses all of it unchanged, because a scene counts in *units of its robot*: lengths in `scale` metres, times
in sqrt(scale) seconds, masses in scale³ kilograms. In these units gravity is 9.81 again, and coefficients of friction
have none: bodies that are alike in shape, mass and speed move alike (Froude's law of similarity). A robot of half the
size is the standard robot in a world whose metre is .5 m and whose second is .71 s: it falls, slips and turns that much
sooner, its wheels turn 1.41 times as fast, and it is controlled 85 instead of 60 times a second.

So only what is *not* alike (a longer chassis, slower motors, a heavier load) asks anything new of the controls;
`LIMITS` say how much of that they were found to bear.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from numbers import Real

__all__ = ["HALF", "LIMITS", "SCALES", "STANDARD", "Robot"]

SCALES = (0.2, 4.0)
"""Least and largest `Robot.scale`. Similarity knows no bounds, but tyres, motors and floors do."""


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot with four wheels, driven from the left and the right, and a chassis that pushes with its front.

    The defaults are the standard robot's.

    Attributes:
        scale: How many times as large as the standard robot it counts: the length of its unit in metres.
        length: Of the chassis, from the bumper to the tail, metres.
        width: Of the chassis, metres.
        clearance: Height of the chassis' underside over the ground, metres.
        height: Height of the chassis' upper side over the ground, metres.
        wheel_radius: Metres.
        track: Distance of the left from the right wheels, metres.
        wheelbase: Distance of the front from the rear axle, metres.
        chassis_mass: With everything on it but the wheels, kg.
        wheel_mass: Of each of the four wheels, kg.
        wheel_speed: The fastest that the motors turn the wheels, rad/s.
        grip: Friction coefficient between tyres and ground.
        bumper_friction: Friction coefficient of the chassis; that of a contact is the product with the other body's.
    """

    scale: float = 1.0
    length: float = 0.72
    width: float = 0.61
    clearance: float = 0.05
    height: float = 0.34
    wheel_radius: float = 0.12
    track: float = 0.50
    wheelbase: float = 0.44
    chassis_mass: float = 42.0
    wheel_mass: float = 2.0
    wheel_speed: float = 8.0
    grip: float = 0.8
    bumper_friction: float = 1.0

    def scaled(self, ratio: float) -> Robot:
        """A robot `ratio` times as large that moves alike: masses grow with its volume, speeds with sqrt(ratio)."""
        if ratio == 1.0:
            return self
        return replace(self, **{name: getattr(self, name) * ratio**power for name, power in _POWERS.items()})

    def in_units(self) -> Robot:
        """The same robot in its own units: lengths in `scale` metres, and so on; its scale is 1."""
        return self.scaled(1.0 / self.scale)

    @property
    def time_unit(self) -> float:
        """Seconds that pass while a scene of such robots counts one."""
        return math.sqrt(self.scale)

    @property
    def mass_unit(self) -> float:
        """Kilograms in the unit of mass of a scene of such robots."""
        return self.scale**3

    @property
    def bumper(self) -> float:
        """How far the bumper stands ahead of the robot's origin, and the tail behind it, metres."""
        return self.length / 2

    @property
    def half_width(self) -> float:
        """Half the width over the wheels or the chassis, whichever is wider, metres."""
        return max(self.track / 2 + self.wheel_radius, self.width / 2)

    @property
    def radius(self) -> float:
        """Radius of the disc that it sweeps when it turns on the spot, metres."""
        wheels = math.hypot(self.wheelbase, self.track) / 2 + self.wheel_radius
        return max(math.hypot(self.length, self.width) / 2, wheels)

    @property
    def centre(self) -> float:
        """Height of the chassis' centre over the ground, metres."""
        return (self.clearance + self.height) / 2

    @property
    def mass(self) -> float:
        """Of all of it, kg."""
        return self.chassis_mass + 4 * self.wheel_mass

    @property
    def yaw_inertia(self) -> float:
        """Moment of inertia about the vertical through its origin, kg m², the wheels being points."""
        chassis = self.chassis_mass * (self.length**2 + self.width**2) / 12
        return chassis + self.wheel_mass * (self.wheelbase**2 + self.track**2)

    def trouble(self) -> tuple[str, str] | None:
        """A field that the controls cannot handle, and what is wrong with it, in words; None if there is none."""
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
                return field.name, f"got {value!r:.80}, expected a number"
        if not SCALES[0] <= self.scale <= SCALES[1]:
            return "scale", f"got {self.scale:g}, expected {SCALES[0]:g} to {SCALES[1]:g}"
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "scale":
                continue
            low, high = (bound * self.scale ** _POWERS[field.name] for bound in LIMITS[field.name])
            if field.name == "wheel_speed":
                # What the controls ask for is a speed over the ground, which smaller wheels reach by turning faster.
                high *= max(1.0, STANDARD.wheel_radius * self.scale / self.wheel_radius)
            if not low * (1 - _ROUNDING) <= value <= high * (1 + _ROUNDING):
                size = "" if self.scale == 1.0 else f" at scale {self.scale:g}"
                expected = f"{low:.4g} to {high:.4g}{size}, with which the controls work"
                if field.name == "wheel_speed" and value > high:
                    expected += "; they ask for no more, so faster motors would change nothing"
                return field.name, f"got {value:g}, expected {expected}"
        most = self.length - 2 * (self.wheel_radius + _BEHIND * self.scale)
        if self.wheelbase > most * (1 + _ROUNDING):
            behind = "so that the wheels are behind the bumper"
            return "wheelbase", f"got {self.wheelbase:g}, expected at most {most:.4g}, {behind}"
        most = _LARGER * STANDARD.radius * self.scale
        if self.radius > most:
            return "length", (
                f"got {self.length:g}: on the spot, the robot turns in a disc of {self.radius:.4g} m, expected at most"
                f" {most:.4g} m; a larger scale keeps it further from all else"
            )
        return None


_ROUNDING = 1e-9
_BEHIND = 0.01
"""Wheels that stand out beyond the bumper touch the box, and have no friction: it slides off. Metres, at scale 1."""
_LARGER = 1.02
"""Ways are planned for the disc that the standard robot sweeps."""
_POWERS = {
    "scale": 1.0, "length": 1.0, "width": 1.0, "clearance": 1.0, "height": 1.0, "wheel_radius": 1.0, "track": 1.0,
    "wheelbase": 1.0, "chassis_mass": 3.0, "wheel_mass": 3.0, "wheel_speed": -0.5, "grip": 0.0, "bumper_friction": 0.0,
}  # fmt: skip
"""With which power of its size each number of a robot grows, so that it moves alike."""

STANDARD = Robot()
"""The robot that everything was tuned on, of the size of a Summit-XL."""
LIMITS = {
    "length": (0.5, 0.8), "width": (0.45, 0.7), "clearance": (0.01, 0.1), "height": (0.2, 0.5),
    "wheel_radius": (0.08, 0.15), "track": (0.3, 0.6), "wheelbase": (0.2, 0.5), "chassis_mass": (8.0, 200.0),
    "wheel_mass": (0.5, 8.0), "wheel_speed": (3.0, STANDARD.wheel_speed), "grip": (0.4, 1.2),
    "bumper_friction": (0.3, 2.0),
}  # fmt: skip
"""Least and most of each number, at scale 1, with which single pushes were found to succeed as they do with the
standard robot, one number changed at a time. Slower wheels are slower than the controls push; with less grip robots of
a colony get stuck as they turn. Faster motors change nothing: the controls ask for no more than the standard robot's
reach; smaller wheels may turn as much faster as they are smaller."""

HALF = STANDARD.scaled(0.5)
"""A robot of half its size that moves alike: an eighth of the mass, wheels that turn up to 11.3 rad/s."""
