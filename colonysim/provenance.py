"""What code and files a result depends on besides colonysim itself: fingerprints of third-party parts.

A part is a policy, field or backend that somebody else wrote. Its result is determined by the module that defines it,
by the source files that this module imports, and by the packages that these import. All of that is found by reading
files: nothing is imported or run.
"""

from __future__ import annotations

import hashlib
import importlib.machinery
import json
import sys
import sysconfig
from functools import cache, partial
from importlib.metadata import Distribution, PackageNotFoundError, distribution, packages_distributions
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from colonysim.engines import PACKAGES
from colonysim.imports import imports_of
from colonysim.plugins import BUILT_IN, available

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from importlib.machinery import ModuleSpec

__all__ = ["MODELS", "TAG", "Sources", "files_of", "other_file", "parts_of", "sources_of", "telling", "unknown_in"]

TAG = "tag"
"""The name, among the fingerprints of a part, of what its user says of its version."""
UNKNOWN = "unknown"
"""How the fingerprint begins of what cannot be known; the reason follows."""
_STANDARD = tuple({sysconfig.get_path("stdlib"), sysconfig.get_path("platstdlib")})
_INSTALLED = frozenset({"site-packages", "dist-packages"})
"""Folders with one of these names hold what was installed."""
MODELS = (".json", ".npz", ".onnx")
"""How the names of models' files end: a card, and what it belongs to."""
Sources = dict[str, dict[str, str]]
Groups: TypeAlias = "Sequence[tuple[str | None, Mapping[str, Any]]]"


def parts_of(
    policy: Any,
    backend: Any,
    parameters: Mapping[str, Any],
    options: Mapping[str, Any] | None = None,
    groups: Groups = (),
) -> Sources:
    """What a run depends on besides colonysim and its scenario.

    Args:
        policy: Name of the policy, or what was handed over in its place.
        backend: The same of the backend.
        parameters: The scenario's parameters of the policy; extra fields are named there, and one may be the path of a
            model.
        options: The backend's options; one may be the path of a model, and `push` an executor of others.
        groups: For each group of agents the policy that it names, or None, and its parameters.

    Returns:
        For each third-party part, by its name, its `sources_of`; `files_of` options and parameters; for a backend of
        ours that wraps an engine, the engine. Empty if all is ours.
    """
    named = [("policies", policy), ("backends", backend), *_fields(parameters)]
    for own, its in groups:
        named += [("policies", own)] if own is not None else []
        named += _fields(its)
    if isinstance(push := (options or {}).get("push"), str):
        named.append(("executors", push))
    found: Sources = {}
    for group, part in named:
        name, sources = _named(group, part) if isinstance(part, str) else _handed_over(part)
        if sources:
            found[name] = sources
    return found | files_of(parameters, options, groups)


def files_of(parameters: Mapping[str, Any], options: Mapping[str, Any] | None = None, groups: Groups = ()) -> Sources:
    """The files that parameters of policies and options of a backend name, such as models.

    Args:
        parameters: As for `parts_of`, as all others.
        options: The same.
        groups: The same.

    Returns:
        By "option path", or "policy.parameter path": for each file of that name its SHA-256.
    """
    told = [*sorted((options or {}).items())]
    for its in (parameters, *(its for _, its in groups)):
        told += [(f"policy.{name}", value) for name, value in sorted(its.items())]
    paths = ((f"{name} {value}", value) for name, value in told if isinstance(value, (str, Path)))
    return {name: files for name, value in paths if (files := _content_of(value))}


def other_file(before: Mapping[str, Any], here: Sources) -> str:
    """Which of the files that were read before is another one now, in words; "" if none is.

    Args:
        before: What `files_of` said then; further parts may be among it.
        here: What it says now.
    """
    for name, files in here.items():
        then = before.get(name, files)
        for file, content in then.items() if isinstance(then, dict) else ():
            if files.get(file) != content:
                return f"{name.partition(' ')[2]}, whose file {file} is another one now (it was {content})"
    return ""


def telling(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Those of a policy's parameters that can make a difference to `parts_of`: names of fields, and paths."""
    return {name: value for name, value in parameters.items() if name == "extra_fields" or isinstance(value, str)}


def _fields(parameters: Mapping[str, Any]) -> list[tuple[str, Any]]:
    """The extra fields that parameters name."""
    extra = parameters.get("extra_fields") or ()
    return [("fields", name) for name in ([extra] if isinstance(extra, str) else extra)]


def _named(group: str, name: str) -> tuple[str, dict[str, str]]:
    if name in BUILT_IN[group]:
        # Another version of an engine gives other results.
        packages = PACKAGES[name].packages if group == "backends" and name in PACKAGES else ()
        engine = next((package for package in packages if _distribution(package)), next(iter(packages), None))
        return name, {engine: _package(engine)} if engine else {}
    place = name if ":" in name else available(group).get(name, "")
    return name, sources_of(place.partition(":")[0]) if place else {}


def _handed_over(part: Any) -> tuple[str, dict[str, str]]:
    while isinstance(part, partial):
        part = part.func
    made_by = part if hasattr(part, "__qualname__") else type(part)  # a class, a function, or an object
    module = str(getattr(made_by, "__module__", None) or "")
    return f"{module}:{made_by.__qualname__}", sources_of(module)


def _content_of(path: str | Path) -> dict[str, str]:
    """The SHA-256 of a file and of what stands beside it under the same name, as a model's card; of none if it is none.

    A number, or the name of something that is no file, is no path.
    """
    stem = Path(path)
    try:
        if not stem.is_file():
            return {}
        ends = MODELS if stem.suffix in MODELS else (stem.suffix,)
        files = [stem.with_suffix(end) for end in ends]
        found = {file.name: file.read_bytes() for file in files if file.is_file()}
        return {name: f"sha256 {hashlib.sha256(content).hexdigest()}" for name, content in found.items()}
    except (OSError, ValueError):
        return {}


def unknown_in(sources: Mapping[str, Mapping[str, str]]) -> list[str]:
    """A line for each part whose code cannot be known, and that has no tag: changes of it go unseen."""
    return [
        f"{part}: {reason.removeprefix(f'{UNKNOWN}: ')}"
        for part, modules in sources.items()
        for reason in modules.values()
        if reason.startswith(UNKNOWN) and TAG not in modules
    ]


def sources_of(module: str) -> dict[str, str]:
    """Fingerprints of a module, of all source files that it imports, one through the other, and of their packages.

    Modules of colonysim and of Python itself are left out. What is installed counts as a package: its version and a
    hash of its files as they were installed. Imports are found in the source text, inside functions too; of a name
    that is put together while the program runs it is only seen that there is one, and of a file that the code reads
    nothing.

    Args:
        module: Its full name, as in "package.module".

    Returns:
        By name of the module or package: "sha256 ..." of a source file, "1.2.3 sha256 ..." of a package, or
        "unknown: ..." with the reason; under "NAME imports" where a module imports what cannot be known.
    """
    found: dict[str, str] = {}
    waiting = [module]
    seen: set[str] = set()
    while waiting:
        name = waiting.pop()
        if name in seen or name.partition(".")[0] == "colonysim":
            continue
        seen.add(name)
        parent = name.rpartition(".")[0]
        if parent:
            waiting.append(parent)  # importing a module runs its packages first
        spec = _spec(name)
        if spec is None:
            if name == module:
                found[name] = f"{UNKNOWN}: {_why_not(name)}"
            continue  # a name inside a module, or what is not installed
        if _is_pythons(spec):
            continue
        owner = _owner(name, spec)
        if owner is not None:
            found[owner] = _package(owner)
            continue
        source = _content(name, spec)
        if source is None:
            if name == module:
                found[name] = f"{UNKNOWN}: {_why_not(name)}"
            continue
        found[name] = _hash(source)
        names, line = imports_of(source, name, bool(spec.submodule_search_locations))
        waiting.extend(names)
        if line is not None:
            found[f"{name} imports"] = f"{UNKNOWN}: what {name!r} imports in line {line} shows only while it runs"
    return dict(sorted(found.items()))


def _is_pythons(spec: ModuleSpec) -> bool:
    """Whether a module came with the interpreter; a name alone does not say so, for one's own folder goes first."""
    if spec.origin in ("built-in", "frozen"):
        return True
    file = Path(spec.origin or "")
    return any(file.is_relative_to(folder) for folder in _STANDARD) and not _INSTALLED & set(file.parts)


def _why_not(name: str) -> str:
    if name == "__main__":
        return "it is defined in a session, not in a file"
    return f"module {name!r} has no file that can be read" if name else "it does not say where it is defined"


def _spec(name: str) -> ModuleSpec | None:
    """Where a module is, found without importing its packages."""
    if name == "__main__":
        main = getattr(sys.modules["__main__"], "__file__", None)
        loader = importlib.machinery.SourceFileLoader(name, main) if main and Path(main).is_file() else None
        return importlib.machinery.ModuleSpec(name, loader, origin=main) if loader else None
    path: Sequence[str] | None = None
    spec: ModuleSpec | None = None
    parts = name.split(".")
    for count in range(1, len(parts) + 1):
        spec = _found_by_finders(".".join(parts[:count]), path)
        if spec is None or (count < len(parts) and spec.submodule_search_locations is None):
            return None
        path = _folders(spec)
    return spec


def _folders(spec: ModuleSpec) -> list[str]:
    locations = spec.submodule_search_locations
    try:
        return list(locations or ())
    except KeyError:  # a package without a file of its own asks its parent, which nobody has imported
        return list(getattr(locations, "_path", ()))


def _found_by_finders(name: str, path: Sequence[str] | None) -> ModuleSpec | None:
    for finder in sys.meta_path:
        find = getattr(finder, "find_spec", None)
        try:
            spec: ModuleSpec | None = find(name, path) if find else None
        except Exception:  # another's finder may fail in any way
            continue
        if spec is not None:
            return spec
    return None


def _content(name: str, spec: ModuleSpec) -> bytes | None:
    if spec.origin is not None and Path(spec.origin).is_file():
        try:
            return Path(spec.origin).read_bytes()
        except OSError:
            return None
    if spec.origin is None and spec.submodule_search_locations is not None:
        return b""  # a package without a file of its own
    try:  # in an archive
        source: str | None = spec.loader.get_source(name)  # type: ignore[union-attr]
    except (AttributeError, ImportError, OSError, SyntaxError, UnicodeError):
        return None
    return None if source is None else source.encode("utf-8", "surrogatepass")


def _owner(name: str, spec: ModuleSpec) -> str | None:
    """Name of the installed package that a module belongs to; None of a source file, an editable package's included."""
    places = [spec.origin] if spec.origin else _folders(spec)
    if not any(_INSTALLED & set(Path(place).parts) for place in places):
        return None
    top = name.partition(".")[0]
    if _distribution(top) is not None:
        return top
    return next(iter(_packages_by_module().get(top, ())), None)  # takes a third of a second


@cache
def _packages_by_module() -> Mapping[str, list[str]]:
    return packages_distributions()


@cache
def _distribution(name: str) -> Distribution | None:
    try:
        return distribution(name)
    except (PackageNotFoundError, ValueError):
        return None


@cache
def _package(name: str) -> str:
    """Version of an installed package, and a hash of what its list of installed files says of its code."""
    installed = _distribution(name)
    if installed is None:
        return "not installed"
    lines = sorted(
        line
        for line in (installed.read_text("RECORD") or "").splitlines()
        if "sha256=" in line and ".dist-info/" not in line and not line.startswith("..")
    )
    return f"{installed.version} {_hash(json.dumps(lines).encode())}" if lines else installed.version


def _hash(content: bytes) -> str:
    return f"sha256 {hashlib.sha256(content).hexdigest()[:32]}"
