"""Whether the package runs compiled or as plain Python, and whether what is compiled is as new as its source."""

from __future__ import annotations

import hashlib
import json
import warnings
from functools import cache
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

__all__ = ["RECORD", "build", "digest"]

PACKAGE = Path(__file__).parent
RECORD = "compiled.json"
"""Written beside this file by `hatch_build.py`: for each compiled module (its path without a suffix) `digest`."""


def digest(module: Path) -> str:
    """SHA-256 over the sources of a module: what stands beside it under the same name and is Python or Cython."""
    found = hashlib.sha256()
    for suffix in (".py", ".pyx", ".pxd"):
        source = module.with_suffix(suffix)
        if source.exists():
            found.update(source.read_bytes())
    return found.hexdigest()


@cache
def build() -> str:
    """How the package runs: "compiled" or "plain Python"; warns of modules whose sources have changed since.

    If it was to be compiled and could not be, the text says why.
    """
    try:
        recorded = json.loads((PACKAGE / RECORD).read_bytes())
        modules = {str(name): str(made) for name, made in recorded.items()}
    except (OSError, ValueError, AttributeError):
        modules = {}
    if "failed" in modules:
        return f"plain Python, for compiling failed: {modules['failed']}"
    here = {name: made for name, made in modules.items() if _is_compiled(PACKAGE / name)}
    if not here:
        return "plain Python"
    stale = sorted(name for name, made in here.items() if digest(PACKAGE / name) != made)
    if stale:
        warnings.warn(
            f"{', '.join(stale)}: the source has changed since it was compiled, and the old form runs; install again",
            stacklevel=2,
        )
    return "compiled" if len(here) == len(modules) else f"{len(here)} of {len(modules)} modules compiled"


def _is_compiled(module: Path) -> bool:
    return any(module.with_name(module.name + suffix).exists() for suffix in EXTENSION_SUFFIXES)
