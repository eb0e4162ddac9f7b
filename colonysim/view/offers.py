"""Which parameters of a colony's policies a page offers to change, from the one place that says what they are."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from colonysim.errors import PluginError
from colonysim.policies.described import describe
from colonysim.policies.parameters import parameters_of
from colonysim.policies.settings import OF_A_RUN, OF_FIELDS, PRESETS, StigmergySettings
from colonysim.scenario.changes import FIXED

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.policies.parameters import Parameter
    from colonysim.scenario.scenario import Scenario

__all__ = ["offers"]

_STEPS = 20
"""At least so many steps has a slider, each a power of ten."""
_WIDEST = 1000.0
"""A larger bound is no end of a slider: it then goes to a few times the default."""
_TIMES, _LEAST = 3.0, 10.0
"""So many times the default, and at least up to here."""
_OPEN = 40.0
"""Stands for the default of a parameter that has none, such as a half-life in simulated seconds."""
_PRESET = "preset"


def offers(scenario: Scenario, policy: str) -> list[dict[str, Any]]:
    """For all agents and for each group the parameters that a control can set, as plain data for the page.

    A parameter is offered if its values are numbers, words or yes and no; none of the others (lists, mappings) is, nor
    those that cannot change under way.

    Args:
        scenario: What is run.
        policy: Name of the policy of all agents.
    """
    found = [{"group": "", "policy": policy, "parameters": _offered(policy, scenario.parameters, ())}]
    for number, group in enumerate(scenario.groups):
        own = scenario.of_group(number)
        shared = OF_FIELDS if group.policy is None else ()
        name = policy if group.policy is None else group.policy
        found.append({"group": group.name, "policy": name, "parameters": _offered(name, own.parameters, shared)})
    return [each for each in found if each["parameters"] or not each["group"]]


def _offered(policy: str, given: Mapping[str, Any], without: Sequence[str]) -> list[dict[str, Any]]:
    try:
        parameters = describe(policy).parameters or ()
    except PluginError:  # it was given as an object, or says nothing of what it has
        return []
    if any(each.name == _PRESET for each in parameters) and given.get(_PRESET) in PRESETS:
        parameters = tuple(parameters_of(StigmergySettings, PRESETS[given[_PRESET]]))
    names = (*FIXED, *OF_A_RUN, *without)
    forms = [(each, _control(each)) for each in parameters if each.name not in names]
    return [
        {"name": each.name, "value": given.get(each.name, each.default), "default": each.default,
         "meaning": each.meaning, "paper": each.paper, **control}
        for each, control in forms if control is not None
    ]  # fmt: skip


def _control(parameter: Parameter) -> dict[str, Any] | None:
    """What sets a parameter: its kind and, of a number, the ends and the step of its slider."""
    schema = parameter.schema
    forms = schema.get("anyOf") or [schema]
    null = any(form.get("type") == "null" for form in forms)
    rest = [form for form in forms if form.get("type") != "null"]
    if len(rest) != 1:
        return None
    [form] = rest
    if form.get("type") == "boolean":
        return {"kind": "flag"}
    if "enum" in form:
        return {"kind": "word", "words": list(form["enum"])}
    if form.get("type") not in ("number", "integer"):
        return None
    whole = form["type"] == "integer"
    default = parameter.default if isinstance(parameter.default, int | float) else _OPEN
    least, above, most = form.get("minimum"), form.get("exclusiveMinimum"), form.get("maximum", _WIDEST + 1.0)
    low = next((bound for bound in (least, above) if bound is not None and abs(bound) <= _WIDEST), 0)
    bounded = most <= _WIDEST
    high = most if bounded else max(_LEAST, _TIMES * default)
    step = 1.0 if whole else 10.0 ** math.floor(math.log10((high - low) / _STEPS))
    begin = max(low, step) if low > 0 or (least is None and above is not None) else low
    bounds = parameter.values if bounded else ""
    return {"kind": "number", "low": begin, "high": high, "step": step, "null": null, "values": bounds}
