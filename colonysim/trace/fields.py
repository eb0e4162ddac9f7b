"""The fields of a manifest: which there are, and of what kind; what readers are told by one they need not doubt."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from colonysim.errors import TraceError
from colonysim.trace.schema import TABLES

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

__all__ = ["MOST", "STATUSES", "check_manifest", "is_a"]

STATUSES = ("running", "finished", "interrupted", "failed")
MOST = 2**53
"""No whole number in a run is larger: up to here a page's numbers are exact too."""
_LONGEST = 1000
"""Longest text of a field, characters."""
_LARGEST = 1e6
"""No place of a single push is further away, metres."""

_KINDS: dict[type, str] = {str: "a text", int: "a whole number", float: "a number", dict: "a mapping", list: "a list"}
_FIELDS: dict[str, type] = {
    "status": str, "name": str, "backend": str, "policy": str, "mode": str, "episodes": int, "seed": int,
    "options": dict, "rows": dict, "versions": dict,
}  # fmt: skip
_MAY_BE_NULL: dict[str, type] = {"variant": str, "trace_sha256": str, "scenario": dict, "scenario_sha256": str}
_RAMP = ("x0", "y0", "z0", "x1", "y1", "z1", "half_width")


def is_a(value: Any, kind: type) -> bool:
    """Whether a value read from JSON is of a kind; true and false are no numbers, whole numbers are numbers."""
    if isinstance(value, bool):
        return kind is bool
    return isinstance(value, (int, float) if kind is float else kind)


class _Fields:
    """Asks for fields by name; each mistake names the file and the field."""

    def __init__(self, file: Path) -> None:
        self._file = file

    def fault(self, where: str, found: Any, expected: str) -> TraceError:
        """An error about one field."""
        shown = repr(found) if isinstance(found, (str, int, float, bool)) or found is None else type(found).__name__
        return TraceError(f"{self._file}: {where}: is {shown[:60]}, expected {expected}")

    def of(self, value: Any, where: str, kind: type) -> Any:
        """A value, if it is of that kind."""
        if not is_a(value, kind):
            raise self.fault(where, value, _KINDS[kind])
        if kind is str and len(value) > _LONGEST:
            raise self.fault(where, value, f"at most {_LONGEST} characters, not {len(value)}")
        if kind is float and not abs(value) <= _LARGEST:
            raise self.fault(where, value, f"at most {_LARGEST:g}")
        return value

    def field(self, values: Mapping[str, Any], name: str, kind: type, within: str = "") -> Any:
        """A field that must be there."""
        where = f"{within}.{name}" if within else name
        if name not in values:
            raise TraceError(f"{self._file}: {where}: is missing, expected {_KINDS[kind]}")
        return self.of(values[name], where, kind)

    def numbers(self, value: Any, where: str, count: int) -> None:
        """A list of so many numbers."""
        if len(self.of(value, where, list)) != count:
            raise self.fault(where, value, f"{count} numbers")
        for i, number in enumerate(value):
            self.of(number, f"{where}.{i}", float)


def check_manifest(manifest: Mapping[str, Any], file: Path) -> None:
    """Checks that every field that a reader asks for is there and of its kind; what else there is, is left alone.

    Args:
        manifest: What the file holds.
        file: For messages.

    Raises:
        TraceError: The first field that is not as it should be.
    """
    fields = _Fields(file)
    for name, kind in _FIELDS.items():
        fields.field(manifest, name, kind)
    for name, kind in _MAY_BE_NULL.items():
        if manifest.get(name) is not None:
            fields.of(manifest[name], name, kind)
    if manifest["status"] not in STATUSES:
        raise fields.fault("status", manifest["status"], f"one of {', '.join(STATUSES)}")
    if not 0 <= manifest["episodes"] <= 10**9:
        raise fields.fault("episodes", manifest["episodes"], "0 to 1000000000")
    if abs(manifest["seed"]) >= 10**40:
        raise fields.fault("seed", manifest["seed"], "fewer than 40 digits")
    digest = manifest.get("trace_sha256")
    if digest is not None and not re.fullmatch("[0-9a-f]{64}", digest):
        raise fields.fault("trace_sha256", digest, "64 hexadecimal digits")
    if manifest["status"] != "running" and (digest is None or "episodes" not in manifest["rows"]):
        raise TraceError(f"{file}: rows: a run that is {manifest['status']} has its rows counted and a trace_sha256")
    for table, count in manifest["rows"].items():
        if table not in TABLES:
            raise TraceError(f"{file}: rows.{table[:60]}: no such table, expected one of {', '.join(TABLES)}")
        if not 0 <= fields.of(count, f"rows.{table}", int) <= MOST:
            raise fields.fault(f"rows.{table}", count, "0 or more")
    if "recorded" in manifest:
        _check_recorded(fields, fields.field(manifest, "recorded", dict))
    for name, told in fields.of(manifest.get("fields", {}), "fields", dict).items():
        where = f"fields.{name[:60]}"
        if not isinstance(fields.of(told, where, dict).get("by_box"), bool):
            raise fields.fault(f"{where}.by_box", told.get("by_box"), "true or false")
    _check_options(fields, manifest["options"])
    for name, version in manifest["versions"].items():
        fields.of(version, f"versions.{name[:60]}", str)
    if "evaluation" in manifest:
        _check_evaluation(fields, fields.field(manifest, "evaluation", dict), manifest["episodes"])


def _check_recorded(fields: _Fields, recorded: Mapping[str, Any]) -> None:
    """What the run was to keep."""
    tables = fields.field(recorded, "tables", list, "recorded")
    for i, table in enumerate(tables):
        if not isinstance(table, str) or table not in TABLES:
            raise fields.fault(f"recorded.tables.{i}", table, f"one of {', '.join(TABLES)}")
    if not {"events", "episodes"} <= {*tables}:
        raise fields.fault("recorded.tables", tables, "events and episodes among them")
    if fields.field(recorded, "frames", str, "recorded") not in ("all", "last", "none"):
        raise fields.fault("recorded.frames", recorded["frames"], "all, last or none")
    fields.field(recorded, "why", str, "recorded")


def _check_options(fields: _Fields, options: Mapping[str, Any]) -> None:
    if options.get("backend") is not None:
        fields.of(options["backend"], "options.backend", dict)
    overrides = options.get("overrides") or {}
    if not isinstance(overrides, dict):
        for i, word in enumerate(fields.of(overrides, "options.overrides", list)):
            if "=" not in fields.of(word, f"options.overrides.{i}", str):
                raise fields.fault(f"options.overrides.{i}", word, "FIELD=VALUE")


def _check_evaluation(fields: _Fields, evaluation: Mapping[str, Any], episodes: int) -> None:
    """What a run of single pushes says of each: where it begins and leads, and the ground around it."""
    fields.field(evaluation, "executor", str, "evaluation")
    fields.numbers(fields.field(evaluation, "robot_size", list, "evaluation"), "evaluation.robot_size", 2)
    pushes = fields.field(evaluation, "pushes", list, "evaluation")
    if len(pushes) != episodes:
        raise fields.fault("evaluation.pushes", len(pushes), f"one for each of {episodes} episodes")
    for i, push in enumerate(pushes):
        where = f"evaluation.pushes.{i}"
        fields.of(push, where, dict)
        if fields.field(push, "episode", int, where) != i + 1:
            raise fields.fault(f"{where}.episode", push["episode"], str(i + 1))
        fields.field(push, "terrain", str, where)
        fields.field(push, "box_length", float, where)
        for name in ("start", "goal"):
            fields.numbers(fields.field(push, name, list, where), f"{where}.{name}", 2)
        for name, parts in (("pits", ("x", "y", "yaw", "side")), ("ramps", _RAMP)):
            for j, part in enumerate(fields.field(push, name, list, where)):
                fields.of(part, f"{where}.{name}.{j}", dict)
                for word in parts:
                    fields.field(part, word, float, f"{where}.{name}.{j}")
