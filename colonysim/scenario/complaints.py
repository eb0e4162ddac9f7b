"""Turns what pydantic finds wrong with a document into one message in the user's words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.characters import printable
from colonysim.scenario.format import FORM_TAGS, PhysicsSection, TimingSection
from colonysim.scenario.places import Places, nearest_word
from colonysim.scenario.schema import field_descriptions, format_schema

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from pydantic import ValidationError
    from pydantic_core import ErrorDetails

    from colonysim.errors import ScenarioError

__all__ = ["complaint", "unknown_field", "wrong_value"]

_FORMS = {
    "nodes": "[id, x, y], [id, x, y, z] or {id: ..., at: [x, y], z: ...}",
    "at": "[x, y]",
    "edges": "[from, to]",
    "include": "[from, to]",
    "exclude": "[from, to]",
    "slopes": "[from, to]",
    "no_push": "[from, to]",
    "add_edge": "[from, to]",
    "remove_edge": "[from, to]",
    "within": "[xmin, ymin, xmax, ymax]",
    "holes": "a node's number, or {node: ..., depth: ...}",
    "boxes": "[node, height] or {node: ..., height: ...}",
    "travels": "[from, to, seconds]",
    "pushes": "[from, to, seconds]",
}
_WHOLE = {
    "edges": "a list of [from, to], or {radius: ..., include: ..., exclude: ...}",
    "agents": "a list of nodes, or {count: ..., seed: ..., within: [xmin, ymin, xmax, ymax]}",
    "policy": "a policy's name, or {name: ..., parameters}",
    "groups": "a list of {name: ..., agents: ...}",
    "ignores": "a list of fields' names",
    "robot": "a robot's name, or {preset: ..., numbers}",
    "topology": "a mapping with a `kind`: grid, line, ring, geometric or rooms",
}
_ELSEWHERE = {
    "seed": "the seed belongs to the run, not to the scenario",
    "r": "did you mean 'detection_radius'?",
    "radius": "did you mean 'detection_radius', or 'edges.radius'?",
    "<<": "merge keys are no part of the format; `variants` can change fields",
}


_SECTIONS = {"groups": "GroupSection", "stops": "StopsSection"}
_OF_GROUPS = {
    "seed": "the seed belongs to the run; that of drawn start nodes stands in `agents`",
}


def complaint(error: ValidationError, document: Mapping[str, Any], places: Places) -> ScenarioError:
    """One message for the most telling of the mistakes found, and how many there are besides it."""
    faults = error.errors(include_url=False)
    # A misspelt field is also a missing one: the spelling is the cause.
    first = min(faults, key=lambda fault: _ORDER.get(fault["type"], 1))
    path = _path(first["loc"])
    message = _message(first, path, document)
    if path == "topology" and first["type"] == "union_tag_invalid":
        path = "topology.kind"
    if first["type"] in ("missing", "missing_argument") and path.rpartition(".")[2].isdigit():
        path = path.rpartition(".")[0]
    others = len({_path(fault["loc"]) for fault in faults}) - 1
    if others > 0 and first["type"] != "extra_forbidden":
        message += f" (and {others} more)"
    return places.fault(path, message)


_ORDER = {"extra_forbidden": 0, "missing": 2}


def _path(loc: Sequence[int | str]) -> str:
    """The dotted path in the file; names of union members are not in the file."""
    return ".".join(_parts(loc))


def _parts(loc: Sequence[int | str]) -> list[str]:
    parts = [str(part) for part in loc if part not in FORM_TAGS]
    if parts[:1] == ["topology"] and len(parts) > 1:
        del parts[1]
    return parts


def _message(fault: ErrorDetails, path: str, document: Mapping[str, Any]) -> str:
    kind, value, context = fault["type"], fault.get("input"), fault.get("ctx", {})
    names = [part for part in path.split(".") if not part.isdigit()]
    name = names[-1] if names else ""
    in_list = path.rpartition(".")[2].isdigit()
    # What a change names are no start nodes.
    form = _FORMS.get(name) if in_list else None if names[:1] == ["changes"] else _WHOLE.get(name)
    if kind == "extra_forbidden":
        return unknown_field(_parts(fault["loc"]), document)
    if kind in ("missing", "missing_argument"):
        if in_list:
            return f"a value is missing, expected {form or 'more values'}"
        above = names[-2] if len(names) > 1 else ""
        return f"is missing, expected {_described(name, _SECTIONS.get(above, 'ScenarioFile'))}"
    if kind == "union_tag_invalid":
        words = [word.strip(" '") for word in str(context.get("expected_tags", "")).split(",")]
        if name == "topology":
            chosen = str(context.get("tag", ""))
            return f"unknown kind '{printable(chosen)}', expected {_either(words)}{nearest_word(chosen, words)}"
        return f"got {_shown(value)}, expected {form or _FORMS.get(name, 'another form')}"
    if kind == "union_tag_not_found" and name == "topology" and isinstance(value, dict):
        return "the `kind` is missing, expected grid, line, ring, geometric or rooms"
    return wrong_value(fault, None if kind in _SCALARS else form)


def wrong_value(fault: ErrorDetails, form: str | None = None) -> str:
    """What to say of a value that is none of those which may stand there.

    Args:
        fault: What pydantic found.
        form: What may stand there, if there are words for it.
    """
    kind, value, context = fault["type"], fault.get("input"), fault.get("ctx", {})
    if form:
        return f"got {_shown(value)}, expected {form}"
    if kind == "literal_error":
        words = _words(str(context["expected"]))
        hint = nearest_word(value, words) if isinstance(value, str) else ""
        return f"got {_shown(value)}, expected {_either(words)}{hint}"
    expected = _EXPECTED.get(kind, fault["msg"][:1].lower() + fault["msg"][1:])
    return f"got {_shown(value)}, expected {expected.format(**context)}"


_SCALARS = {
    "int_type", "int_from_float", "int_parsing", "float_type", "float_parsing", "finite_number", "greater_than",
    "greater_than_equal", "less_than", "less_than_equal", "too_short",
}  # fmt: skip
_EXPECTED = {
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "int_parsing_size": "a smaller whole number",
    "float_type": "a number",
    "finite_number": "a finite number",
    "string_type": "text",
    "string_too_short": "at least {min_length} character",
    "string_too_long": "at most {max_length} characters",
    "bool_type": "true or false",
    "greater_than": "more than {gt:g}",
    "greater_than_equal": "at least {ge:g}",
    "less_than": "less than {lt:g}",
    "less_than_equal": "at most {le:g}",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a mapping",
    "model_type": "a mapping",
    "model_attributes_type": "a mapping",
    "too_short": "at least {min_length}",
    "too_long": "at most {max_length} values",
}


def unknown_field(parts: Sequence[str], document: Mapping[str, Any]) -> str:
    """What to say of a field that the format does not know: the nearest right word.

    Args:
        parts: The path of the field, part by part.
        document: What it stands in.
    """
    name = parts[-1]
    known = _siblings(parts, document)
    if len(parts) == 1 and name.lower() in _ELSEWHERE:
        return f"unknown field; {_ELSEWHERE[name.lower()]}"
    if len(parts) == 3 and parts[0] == "groups" and name in _OF_GROUPS:
        return f"unknown field; {_OF_GROUPS[name]}"
    hint = nearest_word(name, known)
    if not hint and len(parts) == 1:
        inner = {field: f"timing.{field}" for field in TimingSection.model_fields}
        inner |= {field: f"physics.{field}" for field in PhysicsSection.model_fields}
        if name not in inner:
            return f"unknown field, expected {_either(known)}; a parameter of the policy would be 'policy.{name}'"
        hint = f"; did you mean '{inner[name]}'?"
    return f"unknown field, expected {_either(known)}{hint}" if len(known) <= 6 or not hint else f"unknown field{hint}"


def _siblings(parts: Sequence[str], document: Mapping[str, Any]) -> list[str]:
    """The fields that may stand beside the last of `parts`, from the schema of the format."""
    schema = format_schema()
    here: dict[str, Any] = schema
    value: Any = document
    for part in parts[:-1]:
        if isinstance(value, list):
            value = value[int(part)]
            here = _resolve(schema, here["items"], value)
        else:
            value = value[part]
            here = _resolve(schema, here["properties"][part], value)
    return list(here.get("properties", ()))


def _resolve(schema: Mapping[str, Any], node: dict[str, Any], value: Any) -> dict[str, Any]:
    """Follows references, and picks among alternatives the one that `value` was read as."""
    options = [node]
    leaves: list[dict[str, Any]] = []
    while options:
        option = options.pop(0)
        if "$ref" in option:
            options.insert(0, schema["$defs"][option["$ref"].rpartition("/")[2]])
        elif "anyOf" in option or "oneOf" in option:
            options[:0] = option.get("anyOf") or option["oneOf"]
        else:
            leaves.append(option)
    wanted = "object" if isinstance(value, dict) else "array"
    fitting = [leaf for leaf in leaves if leaf.get("type") == wanted] or leaves
    if len(fitting) > 1:  # generated places differ by their kind
        return next(leaf for leaf in fitting if leaf["properties"]["kind"]["const"] == value["kind"])
    return fitting[0]


def _described(name: str, section: str) -> str:
    """What a field of a section holds, in the words of its documentation."""
    text = field_descriptions()[section].get(name, "").rstrip(".")
    return text[:1].lower() + text[1:] if text else f"a value for {name}"


def _either(words: Sequence[str]) -> str:
    return ", ".join(words[:-1]) + " or " + words[-1] if len(words) > 1 else "".join(words)


def _words(expected: str) -> list[str]:
    return [word.strip(" '") for word in expected.replace(" or ", ",").split(",")]


def _shown(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f"'{printable(value, 43)}'"
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}" if value else "an empty list"
    return str(value)
