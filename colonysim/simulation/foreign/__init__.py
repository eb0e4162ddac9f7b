"""Adapters that check the answers of third parties' policies, fields and backends against the protocols.

Each answer is checked once, where it comes in: compiled code does not check indices, so none that is out of range may
reach it. Parts of this package are not checked, nor are classes derived from them that replace no method.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, cast

from colonysim.errors import PluginError
from colonysim.pheromones import BoxWorth, Distance, Exploration, HoleTrail
from colonysim.plugins import BUILT_IN, lacking
from colonysim.policies.decision import Decider
from colonysim.simulation.foreign.answers import SHOWN, is_text
from colonysim.simulation.foreign.backend import ForeignBackend
from colonysim.simulation.foreign.field import ForeignField
from colonysim.simulation.foreign.policy import ForeignPolicy

if TYPE_CHECKING:
    from colonysim.backends.protocol import Backend
    from colonysim.pheromones.marks import Marks
    from colonysim.policies.policy import Policy
    from colonysim.trace.rows import Rows
    from colonysim.world.state import World

__all__ = ["ForeignBackend", "ForeignField", "ForeignPolicy", "checked_backend", "checked_fields", "checked_policy"]

_OWN = {place for group in ("backends", "policies") for name, place in BUILT_IN[group].items() if name != "mock"}
_OWN |= {f"{kind.__module__}:{kind.__qualname__}" for kind in (BoxWorth, Distance, Exploration, HoleTrail)}
"""A script of the mock backend may answer as it likes."""


def _own(thing: object) -> bool:
    """Whether a part is one of this package, or derived from one without replacing any of its methods."""
    kinds = type(thing).__mro__
    ours = next((kind for kind in kinds if f"{kind.__module__}:{kind.__qualname__}" in _OWN), None)
    if ours is None:
        return False
    changed = {name for kind in kinds[: kinds.index(ours)] for name in vars(kind)}
    changed |= getattr(thing, "__dict__", {}).keys()
    return not any(hasattr(ours, name) for name in changed - {"name", "preset"} if not name.startswith("__"))


def checked_fields(policy: Policy, world: World, rows: Rows) -> dict[str, Marks]:
    """The fields of a policy by name; those of others, whoever carries them along, are looked at when they answer.

    Raises:
        PluginError: One is no field, or has a name that no trace could hold.
    """
    made = policy.fields(world)
    if not isinstance(made, Mapping):
        raise PluginError(f"policy {policy.name!r}: fields returns {SHOWN.repr(made)}, expected fields by name")
    found: dict[str, Marks] = {}
    for name, field in made.items():
        if not is_text(name):
            raise PluginError(f"policy {policy.name!r}: a field's name is {SHOWN.repr(name)}, expected some text")
        if missing := lacking("fields", field):
            raise PluginError(f"policy {policy.name!r}: field {name!r} {missing}")
        found[name] = cast("Marks", field) if _own(field) else ForeignField(field, world, rows)
    return found


def checked_policy(policy: Policy, world: World, rows: Rows) -> Decider:
    """The policy itself if it is one of ours, else what looks at its answers."""
    return policy if isinstance(policy, Decider) and _own(policy) else ForeignPolicy(policy, world, rows)


def checked_backend(backend: Backend, world: World, rows: Rows) -> Backend:
    """The backend itself if it is one of ours, else what looks at its answers."""
    return backend if _own(backend) else cast("Backend", ForeignBackend(backend, world, rows))
