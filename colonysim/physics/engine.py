"""The seam between the scene and the rigid-body engine beneath it."""

from collections.abc import Sequence
from typing import Protocol

from colonysim.physics.shapes import Quat, Slab, Vec3


class MissingEngineError(ImportError):
    """No rigid-body engine can be loaded; the message says why and how to install one."""


class Engine(Protocol):
    """What a scene asks of a rigid-body engine. Bodies are named by the integers it gives out."""

    def add_slab(self, slab: Slab, friction: float) -> int:
        """A body that never moves."""
        ...

    def add_box(self, half: Vec3, position: Vec3, rotation: Quat, mass: float, friction: float) -> int:
        """A free box; `position` is its centre."""
        ...

    def add_robot(
        self,
        chassis_half: Vec3,
        chassis_mass: float,
        bumper_friction: float,
        wheels: Sequence[Vec3],
        wheel_radius: float,
        wheel_mass: float,
        position: Vec3,
        rotation: Quat,
    ) -> int:
        """A chassis with frictionless spheres at `wheels`; places are relative to the chassis centre."""
        ...

    def pose(self, body: int) -> tuple[Vec3, Quat]:
        """Position and rotation of a body's frame."""
        ...

    def velocity(self, body: int) -> tuple[Vec3, Vec3]:
        """Linear and angular velocity of a body's frame, in the world's axes."""
        ...

    def push(self, body: int, force: Vec3, at: Vec3, torque: Vec3) -> None:
        """Act on a body during the next step only; everything in the body's own frame."""
        ...

    def stands(self, robot: int) -> bool:
        """Whether a wheel of the robot rests on something below it."""
        ...

    def touching(self, one: int, other: int) -> bool:
        """Whether two bodies pressed against each other in the last step."""
        ...

    def place(self, body: int, position: Vec3, rotation: Quat) -> None:
        """Put a body somewhere, at rest and awake."""
        ...

    def wake(self, body: int) -> None:
        """Keep a body from sleeping through the forces that follow."""
        ...

    def remove(self, body: int) -> None:
        """Take a body out of the world."""
        ...

    def step(self) -> None:
        """Advance by one physics step."""
        ...

    def close(self) -> None:
        """Free the engine; calling it twice is allowed."""
        ...
