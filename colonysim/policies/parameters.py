"""The parameters of a policy, from the one place that says what they are: a pydantic model or dataclass of them.

A policy's class names that model in its attribute `parameters`. From it come the checks of a scenario's `policy:`
section, what `colonysim policies` prints, the tables of docs/policies.md and the JSON Schema of scenario files.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass as checked
from pydantic.dataclasses import is_pydantic_dataclass

from colonysim.characters import printable
from colonysim.errors import PluginError, told
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.scenario.scenario import Scenario

__all__ = ["NoParameters", "Parameter", "about", "parameters_of", "read_parameters", "shown"]

Model = TypeVar("Model")


def about(meaning: str, paper: str = "") -> Any:
    """What a parameter means, and the algorithm or section of the paper that has it, for its `Annotated` type."""
    return Field(description=meaning, json_schema_extra={"paper": paper} if paper else None)


@checked(frozen=True, config=ConfigDict(extra="forbid"))
class NoParameters:
    """Of a policy that has none."""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a policy.

    Attributes:
        name: As in the `policy:` section of a scenario.
        schema: JSON Schema of its values.
        default: Its value where a scenario gives none; None also where it has to be given, see `required`.
        required: Whether a scenario has to give it.
        meaning: What it does, in words.
        paper: The algorithm or section of the paper that has it, "" if none.
    """

    name: str
    schema: Mapping[str, Any]
    default: Any = None
    required: bool = False
    meaning: str = ""
    paper: str = ""

    @property
    def kind(self) -> str:
        """Its type in words, such as "number or null"."""
        return " or ".join(dict.fromkeys(_kind(each) for each in _forms(self.schema)))

    @property
    def values(self) -> str:
        """Its bounds in words, such as "0 to 1", or the words that it may be; "" if any value will do."""
        return " or ".join(text for each in _forms(self.schema) if (text := _values(each)))


def parameters_of(model: type, start: Mapping[str, Any] | None = None) -> list[Parameter]:
    """The parameters that a model holds, in its order.

    Args:
        model: A pydantic model or dataclass.
        start: Defaults that take the place of the model's own.

    Raises:
        PluginError: It is neither, or its fields have no JSON Schema.
    """
    if not (isinstance(model, type) and (issubclass(model, BaseModel) or is_pydantic_dataclass(model))):
        raise PluginError(f"parameters: {model!r}, expected a class that is a pydantic model or dataclass"[:300])
    try:
        whole = TypeAdapter(model).json_schema()
    except Exception as error:  # of others' models, whatever pydantic says
        raise PluginError(f"{model.__name__}: its parameters have no JSON Schema: {told(error)}") from error
    found = []
    for name, schema in whole.get("properties", {}).items():
        rest = {key: value for key, value in schema.items() if key not in ("title", "default", "description", "paper")}
        default = (start or {}).get(name, schema.get("default", {} if schema.get("type") == "object" else None))
        found.append(
            Parameter(
                name, rest, default, name in whole.get("required", ()), schema.get("description", ""),
                str(schema.get("paper", "")),
            )
        )  # fmt: skip
    return found


def shown(value: Any) -> str:
    """A parameter's value as a scenario file has it."""
    return f"{value:g}" if isinstance(value, float) else value if isinstance(value, str) else json.dumps(value)


def read_parameters(
    model: type[Model], scenario: Scenario, start: Mapping[str, Any] | None = None, besides: Sequence[str] = ()
) -> Model:
    """The parameters that a scenario's `policy:` section gives, checked by a model.

    Args:
        model: A pydantic model or dataclass; its fields are the parameters.
        scenario: The scenario.
        start: Values of parameters that the scenario does not give, where they are not the model's defaults.
        besides: Names in the section that are not the model's, and are left out.

    Raises:
        ScenarioError: A parameter is unknown, missing or out of its range; the message says where and what was
            expected.

    Example:
        ```python
        class Patience(pydantic.BaseModel):
            seconds: float = pydantic.Field(5.0, gt=0, description="How long an agent waits.")

        class Patient:
            parameters = Patience

            def __init__(self, scenario):
                self.settings = read_parameters(Patience, scenario)
        ```
    """
    names: list[str] = [*getattr(model, "__pydantic_fields__", getattr(model, "model_fields", ()))]
    values = dict(start or {})
    for name, value in scenario.parameters.items():
        if name in besides:
            continue
        if name not in names:
            raise scenario.fault(f"policy.{name}", f"no such parameter; {nearest(name, [*names, *besides])}")
        values[name] = value
    try:
        return model(**values)
    except ValidationError as error:
        first = error.errors()[0]
        name = ".".join(part for part in first["loc"] if isinstance(part, str)) or "policy"
        if first["type"] == "missing":
            raise scenario.fault(f"policy.{name}", "is missing") from None
        raise scenario.fault(f"policy.{name}", f"{first['msg']}, not {printable(repr(first['input']))}") from None


def _forms(schema: Mapping[str, Any]) -> Sequence[Mapping[str, Any]]:
    """The forms that a value may have."""
    forms: Sequence[Mapping[str, Any]] = schema.get("anyOf") or schema.get("oneOf") or [schema]
    return forms


_KINDS = {
    "number": "number", "integer": "whole number", "boolean": "true or false", "string": "text", "null": "null",
    "array": "list", "object": "mapping",
}  # fmt: skip


def _kind(schema: Mapping[str, Any]) -> str:
    kind = schema.get("type", "string" if "enum" in schema or "const" in schema else "")
    inner = schema.get({"array": "items", "object": "additionalProperties"}.get(kind, ""))
    of_what = f" of {_kind(inner)}s" if isinstance(inner, dict) and inner.get("type") in ("number", "string") else ""
    return f"{_KINDS.get(kind, 'any value')}{of_what}"


def _values(schema: Mapping[str, Any]) -> str:
    words = schema.get("enum", [schema["const"]] if "const" in schema else [])
    if words:
        return " or ".join(f'"{word}"' if isinstance(word, str) else str(word) for word in words)
    low, above, high, below = (
        schema.get(name) for name in ("minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum")
    )
    if low is not None and high is not None:
        return f"{low:g} to {high:g}"
    bounds = (("at least", low), ("above", above), ("at most", high), ("below", below))
    return ", ".join(f"{word} {bound:g}" for word, bound in bounds if bound is not None)
