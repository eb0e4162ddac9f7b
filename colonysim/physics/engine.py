"""The seam between the scene and the rigid-body engine beneath it, and the one place where engines are made."""

from __future__ import annotations

import importlib
import importlib.metadata
import importlib.util
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, cast

from colonysim.engines import PACKAGES, EngineName
from colonysim.installing import install_command

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.engines import EnginePackage
    from colonysim.physics.shapes import Quat, Slab, Vec3

__all__ = [
    "ENGINES",
    "GRAVITY",
    "STEP_SECONDS",
    "UPWARDS",
    "Engine",
    "EngineFacts",
    "EngineName",
    "MissingEngineError",
    "default_engine",
    "engine_facts",
    "engine_trouble",
    "engine_version",
    "make_engine",
    "window_trouble",
]

STEP_SECONDS = 1 / 120
"""Seconds of one physics step."""
GRAVITY = 9.81
"""Metres per second squared."""
UPWARDS = 0.5
"""A contact carries a wheel when its normal points up by at least this much."""


class MissingEngineError(ImportError):
    """A rigid-body engine cannot be loaded; the message says why and how to install one."""


@dataclass(frozen=True, slots=True)
class EngineFacts:
    """What a manifest says of an engine.

    Attributes:
        name: One of `ENGINES`.
        version: Of the package.
        settings: Whatever of its settings decides what moves how.
        exact_state: Whether running on from a saved state gives the same bits as never having stopped.
    """

    name: str
    version: str
    settings: Mapping[str, object]
    exact_state: bool


class Engine(Protocol):
    """What a scene asks of a rigid-body engine. Bodies are named by the integers it gives out.

    All bodies are added before anything else is asked for: an engine may compile its world at the first such call.

    Friction: where two bodies touch, the coefficient is the product of both bodies' coefficients, in all directions
    alike (Coulomb, without rolling or spinning friction). Wheels have none: traction is a force. An engine with
    another rule of its own has to be told each pair's product.

    Attributes:
        facts: Its name, version and settings, for the manifest.
    """

    facts: EngineFacts

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

    def save(self) -> bytes:
        """The state between two steps; `facts.exact_state` says whether all of it is in there."""
        ...

    def load(self, state: bytes) -> None:
        """Go on from a saved state of an engine with the same bodies, perhaps of another process.

        Raises:
            ValueError: It is no state of such an engine.
        """
        ...

    def close(self) -> None:
        """Free the engine; calling it twice is allowed."""
        ...


_CLASSES = {
    "bullet": "colonysim.physics.bullet:BulletEngine",
    "mujoco": "colonysim.physics.mujoco:MujocoEngine",
}
ENGINES = tuple(PACKAGES)
"""Names of the engines, the first that is installed being the default."""
_NO_BULLET = (3, 14)
"""From this version of Python on there is no wheel of PyBullet."""


def make_engine(name: str, *, gui: bool = False) -> Engine:
    """An engine without bodies that steps `STEP_SECONDS`.

    Args:
        name: One of `ENGINES`.
        gui: Show a window (Bullet only).

    Raises:
        MissingEngineError: It is not installed.
        ValueError: There is no such engine, or it has no window.
    """
    if trouble := engine_trouble(name):
        raise MissingEngineError(trouble)
    if gui and (trouble := window_trouble(name)):
        raise ValueError(trouble)
    module, _, attribute = _CLASSES[name].partition(":")
    make: Any = getattr(importlib.import_module(module), attribute)
    return cast("Engine", make(dt=STEP_SECONDS, gui=True) if gui else make(dt=STEP_SECONDS))


def engine_facts(name: str) -> EngineFacts:
    """What a manifest says of an engine.

    Raises:
        MissingEngineError: It is not installed.
        ValueError: There is no such engine.
    """
    engine = make_engine(name)
    try:
        return engine.facts
    finally:
        engine.close()


def engine_trouble(name: str) -> str:
    """What keeps an engine from being used, and what to install, in words; "" if nothing does. Nothing is imported.

    Raises:
        ValueError: There is no such engine.
    """
    source = _known(name)
    if importlib.util.find_spec(source.module) is not None:
        return ""
    running = f"{sys.version_info.major}.{sys.version_info.minor}"
    if name == "bullet" and sys.version_info >= _NO_BULLET:
        return (
            f"the engine 'bullet' needs PyBullet, which has no wheel for Python {running}; 'mujoco' runs here:"
            f" {install_command('mujoco')}"
        )
    return f"the engine {name!r} needs {source.packages[0]}, which is not installed: {install_command(name)}"


def window_trouble(name: str) -> str:
    """What keeps an engine from showing a scene in a window of its own, in words; "" if nothing does.

    Whether there is a display is found out by Bullet, when it opens its window.

    Raises:
        ValueError: There is no such engine.
    """
    _known(name)
    return "" if name == "bullet" else f"{name} has no window; take bullet, or follow the run in the browser (--live)"


def engine_version(name: str) -> str:
    """The installed version of an engine, with the package it comes from; "" if there is none.

    Raises:
        ValueError: There is no such engine.
    """
    for package in _known(name).packages:
        try:
            return f"{package} {importlib.metadata.version(package)}"
        except importlib.metadata.PackageNotFoundError:
            continue
    return ""


def default_engine() -> str:
    """The engine for whoever names none: the first of `ENGINES` that is installed, else the first."""
    return next((name for name in ENGINES if not engine_trouble(name)), ENGINES[0])


def _known(name: str) -> EnginePackage:
    if name not in PACKAGES:
        raise ValueError(f"no engine {name!r}, expected one of {', '.join(PACKAGES)}")
    return PACKAGES[name]
