"""Names of the rigid-body engines, and the packages that bring them; nothing is imported for it."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["ENGINES", "EnginePackage"]


class EnginePackage(NamedTuple):
    """What an engine is imported as, and who publishes it.

    Attributes:
        module: What is imported.
        packages: The packages that bring this module, the usual one first.
    """

    module: str
    packages: tuple[str, ...]


ENGINES = {
    "bullet": EnginePackage("pybullet", ("pybullet", "pybullet-arm64")),
    "mujoco": EnginePackage("mujoco", ("mujoco",)),
}
"""In the order in which one is chosen where none is named."""
