"""Policies by name, with what they say of themselves: the first line of their docstring, and their parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from colonysim.errors import PluginError
from colonysim.plugins import BUILT_IN, available, load, locate
from colonysim.policies.parameters import parameters_of
from colonysim.policies.settings import PRESET, PRESETS, StigmergySettings
from colonysim.policies.stigmergy import Stigmergy

if TYPE_CHECKING:
    from collections.abc import Iterator

    from colonysim.policies.parameters import Parameter

__all__ = ["DescribedPolicy", "describe", "list_policies"]


@dataclass(frozen=True)
class DescribedPolicy:
    """What is known of a policy.

    Attributes:
        name: Its name, or "package.module:Name".
        place: Where its class or factory is, "package.module:Name".
        summary: The first line of its docstring; "" if it has none, or if its module has not been imported.
        parameters: Its parameters; None if it does not say which it has, or if its module has not been imported.
        imported: Whether it has been imported.
    """

    name: str
    place: str
    summary: str = ""
    parameters: tuple[Parameter, ...] | None = None
    imported: bool = True


def list_policies() -> Iterator[DescribedPolicy]:
    """All policies that have a name, those of this package first; nothing of others is imported."""
    for name in BUILT_IN["policies"]:
        yield describe(name)
    for name, place in sorted(available("policies").items()):
        if name not in BUILT_IN["policies"]:
            yield DescribedPolicy(name, place, imported=False)


def describe(name: str) -> DescribedPolicy:
    """What a policy says of itself; its module is imported.

    Its parameters are those of the pydantic model that its class names in `parameters`, or of the stigmergic policy if
    it is derived from that one.

    Args:
        name: Name of a policy, or "package.module:Name".

    Raises:
        PluginError: There is no such policy, it cannot be imported, or its `parameters` are no pydantic model.
    """
    found = load("policies", name)
    summary = (getattr(found, "__doc__", None) or "").strip().partition("\n")[0]
    model, parameters = getattr(found, "parameters", None), None
    if model is not None:
        try:
            parameters = tuple(parameters_of(model))
        except PluginError as error:
            raise PluginError(f"policy {name!r}: {error}") from error
    elif isinstance(found, type) and issubclass(found, Stigmergy):
        preset = getattr(found, "preset", None)
        parameters = tuple(parameters_of(StigmergySettings, PRESETS.get(preset or "colony")))
        parameters = parameters if preset else (PRESET, *parameters)
    return DescribedPolicy(name, locate("policies", name), summary, parameters)
