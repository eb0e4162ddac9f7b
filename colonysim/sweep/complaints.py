"""Turns what pydantic finds wrong with a sweep file into one message in the user's words, as scenario files have it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.scenario.complaints import wrong_value
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from pydantic import ValidationError
    from pydantic_core import ErrorDetails

    from colonysim.errors import ScenarioError
    from colonysim.scenario.places import Places

__all__ = ["complaint"]

_FORMS = {
    ("scenarios", 2): "a scenario's name, or {scenario: ..., variants: [...]}",
    ("backends", 2): "a backend's name, or {name: ..., options}",
    ("policies", 2): "a policy's name",
    ("seeds", 1): "a list of seeds, or {count: ..., first: ...}",
    ("tags", 2): "text or a number",
    ("sample", 3): "[lowest, highest]",
}
"""What may stand at a place, by the first field of its path and how many parts that has."""


def complaint(
    error: ValidationError, document: Mapping[str, Any], places: Places, known: Mapping[str, Sequence[str]]
) -> ScenarioError:
    """One message for the most telling of the mistakes found.

    Args:
        error: What was found.
        document: The file's content.
        places: Where its fields stand.
        known: The fields of the file, under "", and those of its sections by their names.
    """
    # Of a field with several forms the one that the value was meant for went furthest.
    first = max(error.errors(include_url=False), key=lambda f: (f["type"] == "extra_forbidden", len(f["loc"])))
    parts = _parts(first, document)
    if first["type"] in ("missing", "missing_argument") and parts[:2] == ["sample", "ranges"] and len(parts) > 3:
        first, parts = first | {"type": "too_few"}, parts[:3]
    return places.fault(".".join(parts), _message(first, parts, known))


def _parts(fault: ErrorDetails, document: Mapping[str, Any]) -> list[str]:
    """The path in the file; names of forms are not in it."""
    parts: list[str] = []
    value: Any = document
    for part in fault["loc"]:
        inside = value[part] if isinstance(part, int) and isinstance(value, list) and part < len(value) else None
        if isinstance(value, dict) and part in value:
            inside = value[part]
        elif inside is None and (
            fault["type"] not in ("missing", "missing_argument", "extra_forbidden") or part != fault["loc"][-1]
        ):
            continue
        parts.append(str(part))
        value = inside
    return parts


def _message(fault: ErrorDetails, parts: Sequence[str], known: Mapping[str, Sequence[str]]) -> str:
    kind = fault["type"]
    if kind == "extra_forbidden":
        return f"unknown field; {nearest(parts[-1], known.get(parts[0] if len(parts) > 1 else '', ()))}"
    if kind == "missing":
        return "is missing"
    if kind == "value_error":
        return fault["msg"].removeprefix("Value error, ")
    form = _FORMS.get((parts[0] if parts else "", len(parts)))
    return wrong_value(fault, form if kind not in ("too_short", "too_long") else None)
