"""Adapters that check the answers of third parties' policies, fields and backends against the protocols.

Each answer is checked once, where it comes in: compiled code does not check indices, so none that is out of range may
reach it. Parts of this package are not checked, nor are classes derived from them that replace no method.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, cast

import colonysim
from colonysim.errors import PASSED_ON, PluginError, told
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
_OPTIONAL = {"feasible_way"}
"""Methods of the protocols that a part need not have: to add one changes what it answers."""
_INSTEAD = {
    "needs": "footprint", "undertake": "start", "think": "decide", "mark": "deposit", "place": "deposit",
    "key": "deposit", "value": "deposit", "gather": "keys",
}  # fmt: skip
"""How the simulation calls what is built in, and the method of the protocol that means the same."""


def _own(what: str, thing: object) -> bool:
    """Whether a part is one of this package, or derived from one without replacing any of its methods.

    Raises:
        PluginError: One is replaced that only the built-in part itself calls. Compiled code would not see it.
    """
    kinds = type(thing).__mro__
    ours = next((kind for kind in kinds if f"{kind.__module__}:{kind.__qualname__}" in _OWN), None)
    if ours is None:
        return False
    changed = {name for kind in kinds[: kinds.index(ours)] for name in vars(kind)}
    changed = {name for name in changed | getattr(thing, "__dict__", {}).keys() if not name.startswith("__")}
    for name in sorted(changed):
        if name in _INSTEAD and hasattr(ours, name):
            why = f"which the simulation calls of built-in parts alone: replace {_INSTEAD[name]!r} instead"
        elif name in _private_methods(ours):
            why = "a private method, which compiled code calls without looking further: replace a public one"
        else:
            continue
        raise PluginError(f"{what}: {type(thing).__name__} replaces {name!r} of {ours.__name__}, {why}")
    return not any(hasattr(ours, name) or name in _OPTIONAL for name in changed - {"name", "preset"})


@cache
def _private_methods(kind: type) -> frozenset[str]:
    """The methods of a class of ours and those it derives from whose names begin with an underscore.

    Read from the source, which is there in both forms: of a compiled class they cannot be asked for.
    """
    found: set[str] = set()
    for each in kind.__mro__:
        source = Path(colonysim.__file__).parents[1] / f"{each.__module__.replace('.', '/')}.py"
        if not each.__module__.startswith("colonysim.") or not source.is_file():
            continue
        for node in ast.parse(source.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef) and node.name == each.__name__:
                found |= {method.name for method in node.body if isinstance(method, ast.FunctionDef)}
    return frozenset(name for name in found if name.startswith("_") and not name.startswith("__"))


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
        if field.name != name:
            raise PluginError(f"policy {policy.name!r}: its field {name!r} calls itself {SHOWN.repr(field.name)}")
        found[name] = cast("Marks", field) if _own(f"field {name!r}", field) else ForeignField(field, world, rows)
    return found


def checked_policy(policy: Policy, world: World, rows: Rows) -> Decider:
    """The policy itself if it is one of ours, else what looks at its answers."""
    own = _own(f"policy {policy.name!r}", policy) and isinstance(policy, Decider)
    return cast("Decider", policy) if own else ForeignPolicy(policy, world, rows)


def checked_backend(backend: Backend, world: World, rows: Rows, *, recording: bool) -> Backend:
    """The backend itself if it is one of ours, else what looks at its answers; told whether its rows are wanted.

    Raises:
        PluginError: It says that it records, but cannot be told.
    """
    if hasattr(backend, "recording"):
        try:
            backend.recording = recording
        except PASSED_ON:
            raise
        except BaseException as error:
            raise PluginError(f"backend {backend.name!r}: recording cannot be set: {told(error)}") from error
    own = _own(f"backend {backend.name!r}", backend)
    return backend if own else cast("Backend", ForeignBackend(backend, world, rows))
