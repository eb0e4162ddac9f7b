"""Loads scenarios: finds the file, applies variant and overrides, and hands the result to `assemble`."""

from __future__ import annotations

import copy
import dataclasses
import itertools
import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from colonysim.arguments import plain
from colonysim.characters import printable
from colonysim.errors import ScenarioError
from colonysim.provenance import MODELS
from colonysim.scenario.assemble import assemble
from colonysim.scenario.complaints import unknown_field
from colonysim.scenario.format import MAX_NAME, ScenarioFile
from colonysim.scenario.places import Places, nearest_word
from colonysim.scenario.scenario import Scenario
from colonysim.scenario.source import (
    MAX_DEPTH,
    MAX_DIGITS,
    MAX_PATH,
    control_character,
    is_stream,
    read_file,
    read_text,
)

__all__ = [
    "list_scenarios",
    "load_scenario",
    "load_variants",
    "plain_data",
    "scenario_from_document",
    "with_changes",
]

Overrides = Mapping[str, Any] | Sequence[str]

_NUMBER = re.compile(r"[0-9]{1,9}")
MAX_VARIANTS = 1000
"""Most variants of a scenario: `colonysim validate` checks each of them."""


def load_scenario(path_or_name: str | Path, variant: str | None = None, overrides: Overrides | None = None) -> Scenario:
    """Loads and validates a scenario.

    Args:
        path_or_name: A YAML file, the bare name of a scenario that comes with the package ("hard"), or "-" for
            standard input.
        variant: One of the file's `variants`, applied first.
        overrides: Fields to set, applied last: {"policy.beta": 2} or ["policy.beta=2"], where the text
            after "=" is read as YAML. A number in a path is a place in a list ("agents.0").

    Raises:
        ScenarioError: One message that names file, line, column and field, what is wrong, what was
            expected, and the nearest right word.
    """
    document, positions, source = _opened(path_or_name)
    return _made(_Draft(document, positions, source), variant, overrides)


def load_variants(
    path_or_name: str | Path, overrides: Overrides | None = None
) -> Iterator[tuple[str | None, Scenario]]:
    """Loads a scenario as it stands (under None) and each of its variants; the file is read once.

    Raises:
        ScenarioError: As for `load_scenario`.
    """
    document, positions, source = _opened(path_or_name)
    names = _Draft(dict(document), positions, source).take_variants(None)
    for variant in (None, *names):
        own = copy.deepcopy(document) if names else document
        yield variant, _made(_Draft(own, positions, source), variant, overrides)


def scenario_from_document(
    document: Mapping[str, Any], *, variant: str | None = None, overrides: Overrides | None = None,
    source: str = "<document>",
) -> Scenario:  # fmt: skip
    """Builds a scenario from plain data: one made in Python, or the `document` of an earlier run.

    Args:
        document: What a scenario file would hold, as mappings, lists, text and numbers.
        variant: One of the document's `variants`, applied first.
        overrides: Fields to set, as for `load_scenario`.
        source: Its name in messages.

    Raises:
        ScenarioError: As for `load_scenario`, without line and column.
    """
    value = plain_data(document, source)
    if not isinstance(value, dict):
        raise ScenarioError(f"{source}: is a value of type {type(document).__name__}, expected a mapping of fields")
    return _made(_Draft(value, {}, source), variant, overrides)


def with_changes(scenario: Scenario, items: Sequence[Mapping[str, Any]], source: str) -> Scenario:
    """The same scenario with more changes at the end of its timeline; what it had keeps its place and its position.

    Args:
        scenario: The scenario.
        items: The changes, as they would stand in the file.
        source: Where they come from, for messages.

    Raises:
        ScenarioError: A change cannot be, or the scenario has no document that it could be written into.
    """
    if not scenario.document:
        raise ScenarioError(f"{source}: the scenario was made in Python, and has no document to add changes to")
    before = list(scenario.document.get("changes") or ())
    added = [plain_data(item, source, f"changes.{len(before) + n}") for n, item in enumerate(items)]
    document = {**scenario.document, "changes": [*before, *added]}
    made = assemble(document, Places(source))
    return dataclasses.replace(
        made, variant=scenario.variant, source=scenario.source, positions=scenario.positions,
        overrides=scenario.overrides,
    )  # fmt: skip


def _opened(path_or_name: str | Path) -> tuple[dict[str, Any], dict[str, tuple[int, int]], str]:
    """The plain document of a file, named, with the positions of its fields; and how messages name it."""
    path = _find(path_or_name)
    source = "<stdin>" if str(path) == "-" else _shown(path)
    document, positions = _read(path, source)
    if not is_stream(path):
        document.setdefault("name", printable(path.stem, MAX_NAME)[:MAX_NAME])
        _anchor(document, Path(source).parent)
    return document, positions, source


def _anchor(section: Any, folder: Path) -> None:
    """Has the paths of models, which a file says relative to its own folder, begin at the working folder."""
    if isinstance(section, list):
        for each in section:
            _anchor(each, folder)
    elif isinstance(section, dict):
        policy = section.get("policy")
        if isinstance(policy, dict):
            model = policy.get("model")
            if isinstance(model, str) and model.endswith(MODELS) and not Path(model).is_absolute():
                policy["model"] = (folder / model).as_posix()
        _anchor(section.get("groups"), folder)
        variants = section.get("variants")
        if isinstance(variants, dict):
            _anchor([*variants.values()], folder)


def _made(draft: _Draft, variant: str | None, overrides: Overrides | None) -> Scenario:
    draft.take_variants(variant)
    draft.override(overrides or ())
    return draft.scenario()


def list_scenarios() -> list[tuple[str, Path, str, tuple[str, ...]]]:
    """The scenarios that come with the package: name, file, description, names of variants."""
    listed = []
    for path in sorted(_shipped_folder().glob("*.yaml")):
        document, _ = _read(path, _shown(path))
        listed.append((path.stem, path, str(document.get("description", "")), tuple(document.get("variants") or ())))
    return listed


def _shipped_folder() -> Path:
    """Where the scenarios of the package are: inside an installed wheel, beside the package in a checkout."""
    package = Path(__file__).resolve().parent.parent
    inside = package / "scenarios"
    return inside if inside.is_dir() else package.parent / "scenarios"


def _find(path_or_name: str | Path) -> Path:
    path = Path(path_or_name)
    text = str(path_or_name)
    shown = printable(text, MAX_PATH)
    if "\0" in text:
        raise ScenarioError(f"{shown}: is no file name")
    if text == "-":
        return path
    bare = path.name == text and not path.suffix
    try:
        if not bare or path.is_file():
            if path.suffix and not path.exists():
                beside = path.parent
                near = nearest_word(path.name, [p.name for p in beside.glob("*.y*ml")] if beside.is_dir() else [])
                raise ScenarioError(f"{shown}: no such file{near}")
            return path
        shipped = _shipped_folder() / f"{text}.yaml"
        if shipped.is_file():
            return shipped
    except OSError as error:  # a name that is too long, a folder that may not be read
        raise ScenarioError(f"{shown}: cannot be read: {error.strerror or error}") from None
    names = [p.stem for p in sorted(_shipped_folder().glob("*.yaml"))]
    expected = f"expected a file or one of {', '.join(names)}"
    raise ScenarioError(f"{shown}: no such scenario, {expected}{nearest_word(text, names)}")


def _read(path: Path, source: str) -> tuple[dict[str, Any], dict[str, tuple[int, int]]]:
    """The plain document of a file, and the positions of its fields."""
    value, positions = read_file(path, source, streams=True)
    if value is None:
        raise ScenarioError(f"{source}: is empty, expected a scenario")
    if not isinstance(value, dict):
        kind = "a list" if isinstance(value, list) else "a single value"
        raise ScenarioError(f"{source}:1:1: {kind} stands at the top, expected fields such as `nodes:` and `goal:`")
    return value, positions


def _shown(path: Path) -> str:
    """A path for messages: relative if it lies below the working folder."""
    try:
        inside = path.is_absolute() and path != Path.cwd()
        shown = os.fspath(path.relative_to(Path.cwd()) if inside else path)
    except (ValueError, OSError):
        shown = os.fspath(path)
    return printable(shown, len(shown))


def plain_data(value: Any, source: str, path: str = "", depth: int = 0) -> Any:
    """A deep copy as plain, finite data; tuples and arrays become lists, numbers of NumPy those of Python.

    Raises:
        ScenarioError: Something in it is neither mapping, list, text, finite number, true, false nor null.
    """
    where = f"{source}: {path}" if path else source
    value = plain(value)
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str):
        if control := control_character(value):
            raise ScenarioError(f"{where}: the character {control} is not allowed")
        return value
    if isinstance(value, int):
        if not -(10**MAX_DIGITS) < value < 10**MAX_DIGITS:
            raise ScenarioError(f"{where}: a number is out of range, expected at most {MAX_DIGITS} digits")
        return value
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ScenarioError(f"{where}: {value} is not allowed, expected a finite number")
        return value
    if depth > MAX_DEPTH:
        raise ScenarioError(f"{where}: nested deeper than {MAX_DEPTH} levels")
    stem = f"{path}." if path else ""
    if isinstance(value, Mapping):
        for key in value:
            if not isinstance(key, str):
                raise ScenarioError(f"{where}: a key is a value of type {type(key).__name__}, expected text")
            _check_path(f"{stem}{key}", source)
        return {key: plain_data(item, source, f"{stem}{key}", depth + 1) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain_data(item, source, f"{stem}{n}", depth + 1) for n, item in enumerate(value)]
    raise ScenarioError(
        f"{where}: {type(value).__name__} is not allowed, expected mappings, lists, text, numbers, true, false or null"
    )


def _check_path(path: str, source: str) -> None:
    """Refuses names that no file could hold."""
    if control := control_character(path, in_name=True):
        raise ScenarioError(f"{source}: {printable(path)}: the character {control} is not allowed in a name")
    if len(path) > MAX_PATH:
        raise ScenarioError(f"{source}: {printable(path)}: is longer than {MAX_PATH} characters, expected a field")


class _Draft:
    """A document on its way: changed by a variant and by overrides, with the positions kept true."""

    def __init__(self, document: dict[str, Any], positions: dict[str, tuple[int, int]], source: str) -> None:
        self.document = document
        self._positions = positions
        self._source = source
        self._overrides: dict[str, str] = {}
        self._variant: str | None = None
        self._spell_out()

    def take_variants(self, variant: str | None) -> tuple[str, ...]:
        """Takes the variants out of the document, merges the chosen one into it, and returns all their names."""
        variants = self.document.pop("variants", None) or {}
        if not isinstance(variants, dict):
            raise self._places.fault("variants", "expected a mapping from names to fields")
        if len(variants) > MAX_VARIANTS:
            raise self._places.fault("variants", f"{len(variants)} variants, expected at most {MAX_VARIANTS}")
        known = list(ScenarioFile.model_fields)
        for name, changes in variants.items():
            path = f"variants.{name}"
            if changes is not None and not isinstance(changes, dict):
                raise self._places.fault(path, "expected a mapping of fields, or nothing")
            for field in changes or ():
                if field not in known or field == "variants":
                    message = "cannot stand in a variant" if field == "variants" else unknown_field([field], {})
                    raise self._places.fault(f"{path}.{field}", message)
        if variant is None:
            return tuple(variants)
        if variant not in variants:
            some = ", ".join([*itertools.islice(variants, 20), *(["..."] if len(variants) > 20 else [])])
            offered = f"expected one of {some}" if variants else "the scenario has none"
            near = nearest_word(variant, variants)
            raise ScenarioError(f"{self._source}: no variant '{printable(variant)}', {offered}{near}")
        self._variant = variant
        self._merge(self.document, variants[variant] or {}, "", f"variants.{variant}")
        self._spell_out()
        return tuple(variants)

    def override(self, overrides: Overrides) -> None:
        """Sets single fields."""
        pairs: list[tuple[str, Any, str]] = []
        if isinstance(overrides, Mapping):
            for path, value in overrides.items():
                given = plain_data(value, f"--set {printable(str(path))}=...")
                pairs.append((str(path), given, printable(f"--set {path}={given}")))
        else:
            for text in [overrides] if isinstance(overrides, str) else overrides:
                path, equals, value = text.partition("=")
                shown = printable(f"--set {text}")
                if not equals or not path.strip():
                    raise ScenarioError(f"{shown}: expected FIELD=VALUE, for example policy.beta=2")
                read, _ = read_text(value, shown, places=False)
                pairs.append((path.strip(), plain_data(read, shown), shown))
        for path, value, shown in pairs:
            self._set(path, value, shown)
            self._spell_out()

    def scenario(self) -> Scenario:
        """The scenario that the document now describes."""
        # Nothing after a colon, or null, takes a field away; a policy's parameters may well be null.
        groups, faults = self.document.get("groups"), self.document.get("faults")
        stops = faults.get("stops") if isinstance(faults, dict) else None
        for section in (
            self.document, self.document.get("timing"), self.document.get("physics"),
            *(groups if isinstance(groups, list) else ()), faults, stops,
        ):  # fmt: skip
            if isinstance(section, dict):
                for name in [name for name, value in section.items() if value is None]:
                    del section[name]
        return dataclasses.replace(assemble(self.document, self._places), variant=self._variant)

    @property
    def _places(self) -> Places:
        return Places(self._source, self._positions, self._overrides)

    def _spell_out(self) -> None:
        """Writes each `policy: NAME` as a mapping, so that parameters can be merged into it."""
        groups = self.document.get("groups")
        for section in (self.document, *(groups if isinstance(groups, list) else ())):
            if isinstance(section, dict) and isinstance(section.get("policy"), str):
                section["policy"] = {"name": section["policy"]}

    def _merge(self, into: dict[str, Any], changes: dict[str, Any], path: str, origin: str) -> None:
        for key, value in changes.items():
            here = f"{path}.{key}" if path else key
            old = into.get(key)
            if isinstance(old, dict) and isinstance(value, dict) and _same_kind(old, value):
                self._merge(old, value, here, f"{origin}.{key}")
            else:
                into[key] = value
                self._move_positions(here, f"{origin}.{key}")

    def _move_positions(self, path: str, origin: str | None) -> None:
        """Forgets the positions at and below `path`; those at and below `origin` take their place."""
        kept = {p: at for p, at in self._positions.items() if p != path and not p.startswith(f"{path}.")}
        if origin is not None:
            for p, at in self._positions.items():
                if p == origin or p.startswith(f"{origin}."):
                    kept[path + p[len(origin) :]] = at
        self._positions = kept

    def _set(self, path: str, value: Any, shown: str) -> None:
        here: Any = self.document
        parts = path.split(".")
        if control_character(path, in_name=True) or len(path) > MAX_PATH or len(parts) > MAX_DEPTH:
            raise ScenarioError(f"{shown}: is no field, expected a path such as policy.beta")
        if parts[0] == "variants":
            raise ScenarioError(f"{shown}: variants cannot be set, expected another field")
        for n, part in enumerate(parts):
            last = n == len(parts) - 1
            above = ".".join(parts[:n])
            if isinstance(here, list):
                if not _NUMBER.fullmatch(part) or int(part) >= len(here):
                    expected = f"a place from 0 to {len(here) - 1}" if here else "a list that is not empty"
                    raise ScenarioError(f"{shown}: {above} is a list of {len(here)}, expected {expected}")
                if last:
                    here[int(part)] = value
                else:
                    here = here[int(part)]
            elif isinstance(here, dict):
                if last:
                    here[part] = value
                else:
                    if here.get(part) is None:
                        here[part] = {}
                    here = here[part]
            else:
                raise ScenarioError(f"{shown}: {above} is no mapping or list, so it has no '{part}'")
        self._move_positions(path, None)
        self._overrides = {p: s for p, s in self._overrides.items() if not p.startswith(f"{path}.")}
        self._overrides[path] = shown


def _same_kind(old: dict[str, Any], new: dict[str, Any]) -> bool:
    """Whether two mappings describe the same kind of thing; a ring is no change of a grid."""
    return "kind" not in new or old.get("kind") == new["kind"]
