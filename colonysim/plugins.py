"""Finding policies, fields and backends by name, by entry point or as "package.module:Name"."""

from __future__ import annotations

import difflib
import importlib
from importlib.metadata import entry_points
from typing import Any

from colonysim.errors import PluginError

__all__ = ["BUILT_IN", "available", "field_class", "load"]

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


def load(group: str, name: str) -> Any:
    """The class or factory called `name` in a group, or at "package.module:Name".

    Raises:
        PluginError: There is no such name (the nearest one is named), or its module cannot be imported.
    """
    place = name if ":" in name else available(group).get(name)
    if place is None:
        names = sorted(available(group))
        near = difflib.get_close_matches(name, names, 1)
        hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(names) or 'none'}"
        raise PluginError(f"no {'policy' if group == 'policies' else group[:-1]} {name!r}; {hint}")
    module, _, attribute = place.partition(":")
    try:
        found: Any = importlib.import_module(module)
        for part in attribute.split("."):
            found = getattr(found, part)
    except (ImportError, AttributeError, ValueError) as error:
        raise PluginError(f"{name!r} ({place}) cannot be loaded: {error}") from error
    return found


def field_class(name: str) -> Any:
    """The pheromone field called `name`: built with the world."""
    return load("fields", name)
