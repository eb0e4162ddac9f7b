"""Finding policies, fields and backends by name, by entry point or as "package.module:Name"."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError, PluginError
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from colonysim.backends.protocol import Backend
    from colonysim.policies.policy import Policy
    from colonysim.world.scenario import Scenario

__all__ = ["BUILT_IN", "available", "field_class", "load", "locate", "make_backend", "make_policy"]

BUILT_IN: dict[str, dict[str, str]] = {
    "backends": {
        "nodeworld": "colonysim.backends.nodeworld:NodeWorld",
        "bullet": "colonysim.backends.bullet:Bullet",
        "mock": "colonysim.backends.mock:Mock",
    },
    "policies": {
        "stigmergy": "colonysim.policies.stigmergy:Stigmergy",
        "colony": "colonysim.policies.presets:Colony",
        "paper": "colonysim.policies.presets:Paper",
        "oracle": "colonysim.policies.presets:Oracle",
        "random": "colonysim.policies.uniform:Uniform",
    },
    "fields": {},
}


def available(group: str) -> dict[str, str]:
    """Names and "module:Name" of everything in a group: our own and what is installed under `colonysim.<group>`.

    Args:
        group: "backends", "policies" or "fields".
    """
    found = {point.name: point.value for point in entry_points(group=f"colonysim.{group}")}
    return {**found, **BUILT_IN[group]}


def locate(group: str, name: str) -> str:
    """The "package.module:Name" of what is called `name` in a group; nothing is imported.

    Raises:
        PluginError: There is no such name; the nearest one is named.
    """
    # Looking through what is installed takes milliseconds, and nothing there goes before our own.
    place = name if ":" in name else BUILT_IN[group].get(name) or available(group).get(name)
    if place is None:
        names = sorted(available(group))
        raise PluginError(f"no {'policy' if group == 'policies' else group[:-1]} {name!r}; {nearest(name, names)}")
    return place


def load(group: str, name: str) -> Any:
    """The class or factory called `name` in a group, or at "package.module:Name".

    Raises:
        PluginError: There is no such name (the nearest one is named), or its module cannot be imported.
    """
    place = locate(group, name)
    module, _, attribute = place.partition(":")
    try:
        found: Any = importlib.import_module(module)
        for part in attribute.split("."):
            found = getattr(found, part)
    except ColonysimError:
        raise  # it says already what is missing
    except Exception as error:  # another's module may fail in any way; ours still owes a message
        raise PluginError(f"{name!r} ({place}) cannot be loaded: {type(error).__name__}: {error}") from error
    return found


def field_class(name: str) -> Any:
    """The pheromone field called `name`: built with the world."""
    return load("fields", name)


def make_backend(name: str | Backend, options: Mapping[str, Any] | None = None) -> Backend:
    """The backend called `name`, built with its options; a backend itself is handed back.

    Raises:
        PluginError: There is no such backend.
        ColonysimError: It does not know one of the options.
        MissingExtraError: It needs a package that is not installed.
    """
    if not isinstance(name, str):
        return name
    factory = load("backends", name)
    try:
        backend: Backend = factory(**dict(options or {}))
    except TypeError as error:
        raise ColonysimError(f"backend {name!r} does not take these options: {error}") from None
    return backend


def make_policy(policy: str | Policy | Callable[[Scenario], Policy] | None, scenario: Scenario) -> Policy:
    """The policy called `policy` (or the scenario's own), built for `scenario`; a policy itself is handed back.

    Raises:
        PluginError: There is no such policy.
        ScenarioError: The scenario's parameters do not fit it.
    """
    if policy is None:
        policy = scenario.policy
    if isinstance(policy, str):
        policy = load("policies", policy)
    built: Policy = policy(scenario) if callable(policy) else policy  # type: ignore[assignment]
    return built
