"""The push environments under Gymnasium's names; light, for Gymnasium imports it whenever it is imported itself."""

from __future__ import annotations

__all__ = ["TERRAINS", "register"]

TERRAINS = {"Push-v0": "mixed", "Push-flat-v0": "flat", "Push-slope-v0": "slope", "Push-hole-v0": "hole"}
"""Names, without the namespace, and the terrain of each."""


def register() -> None:
    """Registers `colonysim/Push-v0` and its kinds, unless that was done."""
    from gymnasium.envs import registration

    for name, terrain in TERRAINS.items():
        full = f"colonysim/{name}"
        if full not in registration.registry:
            # Within a plugin's own namespace, which is that of the name, Gymnasium takes the name alone.
            namespace = registration.current_namespace
            registration.register(
                id=full if namespace is None else name,
                entry_point="colonysim.push.training.env:PushEnv",
                kwargs={"terrain": terrain},
            )
