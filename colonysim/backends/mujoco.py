"""The physics backend on MuJoCo, `--backend mujoco`."""

from __future__ import annotations

from colonysim.backends.physics import Physics

__all__ = ["Mujoco"]


class Mujoco(Physics):
    """Drives robots as rigid bodies on MuJoCo.

    Args:
        push: As for [`Physics`][colonysim.backends.physics.Physics].
        model: As for `Physics`.
        feasibility: As for `Physics`.

    Raises:
        MissingExtraError: MuJoCo is not installed.
        ColonysimError: As for `Physics`.
    """

    name = "mujoco"

    def __init__(self, push: str = "staged", model: str | None = None, feasibility: str | None = None) -> None:
        super().__init__(push, model, feasibility, engine="mujoco")
