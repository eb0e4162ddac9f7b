"""The physics backend on PyBullet, `--backend bullet`."""

from __future__ import annotations

from colonysim.backends.physics import Physics

__all__ = ["Bullet"]


class Bullet(Physics):
    """Drives robots as rigid bodies on PyBullet.

    Args:
        push: As for [`Physics`][colonysim.backends.physics.Physics].
        gui: Whether to open the engine's window.
        model: As for `Physics`.
        feasibility: As for `Physics`.

    Raises:
        MissingExtraError: PyBullet is not installed.
        ColonysimError: As for `Physics`, or there is no display for the window.
    """

    name = "bullet"

    def __init__(
        self, push: str = "staged", gui: bool = False, model: str | None = None, feasibility: str | None = None
    ) -> None:
        super().__init__(push, model, feasibility, engine="bullet", gui=gui)
