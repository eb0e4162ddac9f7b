"""The scenario format as a JSON Schema, and in words; `policies/schema.py` adds the parameters of policies."""

from __future__ import annotations

import ast
import inspect
from functools import cache
from itertools import pairwise
from typing import Any

from colonysim.scenario import format as scenario_format
from colonysim.scenario import timeline
from colonysim.scenario.format import ScenarioFile

__all__ = ["field_descriptions", "format_schema"]


@cache
def field_descriptions() -> dict[str, dict[str, str]]:
    """What the text below each field says of it, by class and field.

    Read from the source when somebody asks: pydantic's own `use_attribute_docstrings` reads it once for each class
    on import, which every command would pay for.
    """
    found: dict[str, dict[str, str]] = {}
    for module in (timeline, scenario_format):
        for node in ast.parse(inspect.getsource(module)).body:
            if isinstance(node, ast.ClassDef):
                own = found[node.name] = {}
                for base in node.bases:
                    own.update(found.get(ast.unparse(base), {}))
                for field, text in pairwise(node.body):
                    if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr):
                        own[ast.unparse(field.target)] = " ".join(str(ast.literal_eval(text.value)).split())
    return found


@cache
def format_schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of scenario files, with any parameters of the policy."""
    schema = ScenarioFile.model_json_schema()
    for owner, fields in field_descriptions().items():
        described = schema if owner == "ScenarioFile" else schema["$defs"].get(owner, {})
        for name, text in fields.items():
            if name in described.get("properties", {}):
                described["properties"][name]["description"] = text
    variants = schema["properties"]["variants"]
    schema["properties"]["variants"] = {**variants, "additionalProperties": {"$ref": "#/$defs/Variant"}}
    fields = {name: field for name, field in schema["properties"].items() if name != "variants"}
    schema["$defs"]["Variant"] = {
        "description": "Any of the scenario's fields, or nothing.",
        "type": ["object", "null"],
        "properties": fields,
        "additionalProperties": False,
    }
    schema["oneOf"] = [{"required": ["agents"]}, {"required": ["groups"]}]
    schema["title"] = "colonysim scenario"
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **_tidy(schema)}


def _tidy(node: Any) -> Any:
    """Leaves out the titles that only repeat field names."""
    if isinstance(node, dict):
        return {
            key: _tidy(value)
            for key, value in node.items()
            if not (key == "title" and isinstance(value, str) and "properties" not in node)
        }
    return [_tidy(item) for item in node] if isinstance(node, list) else node
