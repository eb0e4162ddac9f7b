"""Names of the rigid-body engines, and the packages that bring them; nothing is imported for it."""

from __future__ import annotations

from typing import Literal, NamedTuple

__all__ = ["PACKAGES", "EngineName", "EnginePackage"]

EngineName = Literal["bullet", "mujoco"]


class EnginePackage(NamedTuple):
    """What an engine is imported as, and who publishes it.

    Attributes:
        module: What is imported.
        packages: The packages that bring this module, the usual one first.
    """

    module: str
    packages: tuple[str, ...]


PACKAGES: dict[str, EnginePackage] = {
    "bullet": EnginePackage("pybullet", ("pybullet", "pybullet-arm64")),
    "mujoco": EnginePackage("mujoco", ("mujoco",)),
}
"""In the order in which one is chosen where none is named."""
