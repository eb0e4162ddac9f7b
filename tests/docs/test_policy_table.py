"""The table of policy parameters in docs/scenarios.md says what the settings model says."""

from __future__ import annotations

import dataclasses
import inspect
import re
from pathlib import Path

from pydantic import TypeAdapter

from colonysim.policies.settings import PRESETS, StigmergySettings

DOCS = Path(__file__).resolve().parents[2] / "docs" / "scenarios.md"
HEAD = "| parameter | values | `colony` | `paper` | |\n|---|---|---|---|---|\n"


def meanings() -> dict[str, str]:
    """What the docstring of the settings says of each parameter."""
    text = inspect.getdoc(StigmergySettings).partition("Attributes:")[2]
    found = re.findall(r"^    (\w+): (.*(?:\n     .*)*)", text, re.M)
    return {name: re.sub(r'"([\w.:]+)"', r"`\1`", " ".join(said.split())) for name, said in found}


def values(schema: dict) -> str:
    """A JSON schema in words."""
    if "anyOf" in schema:
        return " or ".join(values(each) for each in schema["anyOf"])
    if "enum" in schema:
        return " or ".join(f"`{word}`" for word in schema["enum"])
    kind = schema["type"]
    if kind in ("number", "integer"):
        words = "number" if kind == "number" else "whole number"
        low, above, high = (schema.get(name) for name in ("minimum", "exclusiveMinimum", "maximum"))
        if above is not None:
            return f"{words} above {above:g}" + ("" if high is None else f", at most {high:g}")
        return f"{words}, at least {low:g}" if high is None else f"{words}, {low:g} to {high:g}"
    return {"boolean": "true or false", "null": "null", "array": "list of names", "object": "numbers by name"}[kind]


def shown(value: object) -> str:
    if isinstance(value, dict):
        return "{}"
    words = {True: "true", False: "false"}[value] if isinstance(value, bool) else value
    return {None: "null", (): "[]"}.get(words, f"{words:g}" if isinstance(words, float) else str(words))


def table() -> str:
    said, schemas = meanings(), TypeAdapter(StigmergySettings).json_schema()["properties"]
    colony, paper = StigmergySettings(), StigmergySettings(**PRESETS["paper"])
    rows = []
    for name in (field.name for field in dataclasses.fields(StigmergySettings)):
        ours, theirs = shown(getattr(colony, name)), shown(getattr(paper, name))
        differs = "same" if ours == theirs else theirs
        rows.append(f"| `{name}` | {values(schemas[name])} | {ours} | {differs} | {said[name]} |")
    return HEAD + "\n".join(rows) + "\n"


def test_the_table_of_policy_parameters_is_that_of_the_settings():
    assert table() in DOCS.read_text(encoding="utf-8"), f"docs/scenarios.md should hold:\n\n{table()}"


def test_every_parameter_has_a_meaning():
    assert list(meanings()) and set(meanings()) == {field.name for field in dataclasses.fields(StigmergySettings)}
