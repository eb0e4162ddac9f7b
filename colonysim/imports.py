"""Which modules a source file imports, found in its text: nothing is imported or run."""

from __future__ import annotations

import ast
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

__all__ = ["imports_of"]

_IMPORTERS = {
    "import_module": ("name", "package"),
    "__import__": ("name", "globals", "locals", "fromlist", "level"),
    "runpy.run_module": ("mod_name",),
    "pkgutil.resolve_name": ("name",),
}
"""Functions that import what their first parameter names, with their parameters; the first two by any path."""
_OF_FILES = ("runpy.run_path", "importlib.util.spec_from_file_location")
"""Functions that import a file, whatever its name as a module is."""


def imports_of(source: bytes, module: str, is_package: bool) -> tuple[list[str], int | None]:
    """Modules that a source may import.

    Args:
        source: The text of the module.
        module: Its full name.
        is_package: Whether it is the `__init__` of a package.

    Returns:
        Their full names, some of which may be names inside a module; and the first line that imports something whose
        name is no constant, None if there is none.
    """
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return [], None  # a compiled module, or one that cannot be imported anyway
    package = module if is_package else module.rpartition(".")[0]
    called_as = _bound_names(tree)
    names: list[str] = []
    unknown: list[int] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = _absolute("." * node.level + (node.module or ""), package)
            if base:
                names += [base, *(f"{base}.{alias.name}" for alias in node.names if alias.name != "*")]
        elif isinstance(node, ast.Call):
            called = _dotted(node.func, called_as)
            last = called.rpartition(".")[2]
            parameters = _IMPORTERS.get(called) or _IMPORTERS.get(last)
            if parameters:
                found = list(_called_for(node, parameters, package))
                names += found
                unknown += [] if found else [node.lineno]
            elif called in _OF_FILES:
                unknown.append(node.lineno)
    return names, min(unknown, default=None)


def _called_for(node: ast.Call, parameters: tuple[str, ...], package: str) -> Iterator[str]:
    """Names of the modules that a call imports; none if they are no constants."""
    given = dict(zip(parameters, node.args, strict=False))
    given |= {each.arg: each.value for each in node.keywords if each.arg}
    name = _constant(given.get(parameters[0]))
    if not isinstance(name, str):
        return
    level = _constant(given["level"]) if "level" in given else 0
    anchor = given.get("package")
    if isinstance(anchor, ast.Name) and anchor.id in ("__package__", "__name__"):
        within: object = package
    else:
        within = package if anchor is None else _constant(anchor)
    parts = _constant(given["fromlist"]) if "fromlist" in given else ()
    if not (isinstance(level, int) and isinstance(parts, (list, tuple, type(None)))):
        return
    name = "." * level + name.partition(":")[0]
    if name.startswith(".") and not isinstance(within, str):
        return
    base = _absolute(name, str(within))
    if base:
        yield base
        yield from (f"{base}.{part}" for part in parts or () if isinstance(part, str))
        if parameters[0] == "mod_name":
            yield f"{base}.__main__"  # what is run of a package


def _absolute(name: str, package: str) -> str:
    """The full name of a module, of which each dot at the front but the first leads out of a package."""
    rest = name.lstrip(".")
    level = len(name) - len(rest)
    if not level or not package:
        return "" if level else rest
    above = package.split(".")
    return ".".join([*above[: len(above) - level + 1], *([rest] if rest else [])])


def _constant(node: ast.expr | None) -> object:
    """The value of an expression that is made of constants only; an `Ellipsis`, which names nothing, otherwise."""
    try:
        return ast.literal_eval(node) if node is not None else ...
    except (ValueError, TypeError, SyntaxError, MemoryError, RecursionError):
        return ...


def _bound_names(tree: ast.AST) -> dict[str, str]:
    """What names of a source stand for, as far as imports and plain assignments say so, anywhere in it."""
    bound: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            bound |= {alias.asname: alias.name for alias in node.names if alias.asname}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            bound |= {alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign) and isinstance(node.value, (ast.Name, ast.Attribute)):
            value = _dotted(node.value, bound)
            if value in _OF_FILES or value in _IMPORTERS or value.rpartition(".")[2] in _IMPORTERS:
                bound |= {target.id: value for target in node.targets if isinstance(target, ast.Name)}
    return bound


def _dotted(node: ast.expr, bound: dict[str, str]) -> str:
    """How a name or an attribute is called in full; of any other expression only what stands behind it."""
    if isinstance(node, ast.Attribute):
        return f"{_dotted(node.value, bound)}.{node.attr}"
    return bound.get(node.id, node.id) if isinstance(node, ast.Name) else ""
