"""The push environments under Gymnasium's names, registered when `colonysim.rl` is imported."""

from __future__ import annotations

__all__ = ["PUSHES", "register"]

PUSHES = {
    f"Push{place}{kind}-v0": {"terrain": terrain, "controls": controls}
    for kind, controls in (("", "eight"), ("-wheels", "wheels"))
    for place, terrain in (("", "mixed"), ("-flat", "flat"), ("-slope", "slope"), ("-hole", "hole"))
}
"""Names, without the namespace, and what each is made with."""


def register() -> None:
    """Registers `colonysim/Push-v0` and its kinds, unless that was done."""
    from gymnasium.envs import registration

    for name, made_with in PUSHES.items():
        full = f"colonysim/{name}"
        if full not in registration.registry:
            registration.register(id=full, entry_point="colonysim.push.training.env:PushEnv", kwargs=dict(made_with))
