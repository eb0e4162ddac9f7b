"""The JSON Schema of scenario files, with the parameters of this package's policies in it."""

from __future__ import annotations

from copy import deepcopy
from functools import cache
from typing import Any

from colonysim.plugins import BUILT_IN
from colonysim.policies.described import describe
from colonysim.policies.parameters import shown
from colonysim.policies.settings import PRESET, PRESETS
from colonysim.scenario.schema import format_schema

__all__ = ["scenario_schema"]


@cache
def scenario_schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of scenario files.

    Under `policy:` the parameters of this package's policies are described and checked, by the policy's name; those of
    others are left open. In a group or a variant that names no policy it may be any: there the parameters of the
    stigmergic policy are described, and nothing is checked.
    """
    schema = deepcopy(format_schema())
    sections, names = schema["$defs"], [*BUILT_IN["policies"]]
    own: dict[str, dict[str, Any]] = {}
    cases = []
    for name in names:
        properties = _properties(name)
        section = next((each for each, those in own.items() if those == properties), f"{name.capitalize()}Policy")
        own[section] = properties
        named = {"properties": {"name": {"const": name}}, **({} if name == names[0] else {"required": ["name"]})}
        cases.append({"if": named, "then": {"$ref": f"#/$defs/{section}"}})
    for section, properties in own.items():
        sections[section] = {"type": "object", "properties": properties, "additionalProperties": False}
    open_ones = {name: {"description": each["description"]} for name, each in _properties(names[0]).items()}
    unknown = {"if": {"required": ["name"]}, "then": {"allOf": cases}, "else": {"properties": open_ones}}
    sections["PolicySection"]["allOf"] = cases
    sections["GroupPolicy"] |= unknown
    sections["VariantPolicy"] = {
        "description": "What differs in the policy, or another one by its name.", "type": "object", **unknown,
        "properties": {"name": sections["PolicySection"]["properties"]["name"]},
    }  # fmt: skip
    variant = sections["Variant"]["properties"]
    variant["policy"] = {**variant["policy"], "oneOf": [{"type": "string"}, {"$ref": "#/$defs/VariantPolicy"}]}
    for section in ("PolicySection", "GroupPolicy"):
        sections[section]["properties"]["name"]["examples"] = names
    return schema


def _properties(policy: str) -> dict[str, Any]:
    """What may stand in the section of a policy of this package."""
    parameters = [*(describe(policy).parameters or ())]
    if policy in PRESETS:  # whose files may name a preset, which another policy then takes
        parameters.insert(0, PRESET)
    found: dict[str, Any] = {"name": {"type": "string", "description": "The policy's name."}}
    for each in parameters:
        described = f"{each.meaning} ({each.paper} of the paper)" if each.paper else each.meaning
        for preset, values in PRESETS.items():
            if each.name in values and policy not in (preset, "paper"):
                described += f" Preset {preset}: {shown(values[each.name])}."
        found[each.name] = {**each.schema, "default": each.default, "description": described}
    return found
