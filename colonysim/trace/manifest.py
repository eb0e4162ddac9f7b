"""The manifest of a run: what was run, with which versions, and how far it came."""

from __future__ import annotations

import json
import os
import platform
import re
from collections.abc import Mapping
from dataclasses import asdict, is_dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from colonysim.arguments import plain, shown
from colonysim.built import build
from colonysim.engines import PACKAGES
from colonysim.errors import TraceError
from colonysim.files import create_file, read_json, replace_file
from colonysim.trace.fields import check_manifest, is_a
from colonysim.trace.schema import VERSION

if TYPE_CHECKING:
    from colonysim.scenario.scenario import Scenario

__all__ = [
    "MANIFEST", "begin_manifest", "is_run", "now", "prepare_directory", "read_manifest", "versions", "write_manifest",
]  # fmt: skip

MANIFEST = "manifest.json"
FORMAT = "colonysim run"
_LONGEST_NAME = 255
"""Bytes that file systems take for a name."""
_ENGINE_PACKAGES = tuple(package for engine in PACKAGES.values() for package in engine.packages)
_PACKAGES = ("colonysim", "numpy", "simpy", "networkx", "pyarrow", *_ENGINE_PACKAGES, "torch")


def versions() -> dict[str, str]:
    """Those of the interpreter and of the packages that a run may depend on, as far as they are installed."""
    found = {"python": platform.python_version(), "build": build()}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    return found


def _plain(value: Any) -> Any:
    """The same value in types that JSON knows; of anything else what it looks like."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, set, frozenset)):
        return [_plain(item) for item in (sorted(value, key=str) if isinstance(value, (set, frozenset)) else value)]
    value = plain(value)
    if value is None or isinstance(value, (bool, int, float, str, list)):
        return value
    return str(value) if isinstance(value, Path) else shown(value)


def now() -> str:
    """The time of day, as manifests write it."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def begin_manifest(
    name: str,
    *,
    backend: str,
    policy: str,
    mode: str,
    episodes: int,
    seed: int,
    scenario: Scenario | None = None,
    variant: str | None = None,
    options: Mapping[str, Any] | None = None,
    recorded: Mapping[str, Any] | None = None,
    engine: Any = None,
) -> dict[str, Any]:
    """The manifest of a run that is about to start (status "running"); some runs have no scenario."""
    manifest = {
        "format": FORMAT,
        "schema": VERSION,
        "status": "running",
        "name": name,
        "variant": variant,
        "backend": backend,
        "policy": policy,
        "mode": mode,
        "episodes": episodes,
        "seed": seed,
        "options": _plain(options or {}),
        "started": now(),
        "finished": None,
        "rows": {},
        "trace_sha256": None,
        "versions": versions(),
        "platform": {
            "system": platform.system(),
            "machine": platform.machine(),
            "implementation": platform.python_implementation(),
        },
    }
    if is_dataclass(engine) and not isinstance(engine, type):
        engine = asdict(engine)
    if isinstance(engine, Mapping):
        manifest["engine"] = _plain(engine)
    if recorded is not None:
        manifest["recorded"] = _plain(recorded)
    if scenario is not None:
        manifest |= {"scenario_sha256": scenario.digest, "scenario": _plain(scenario.document)}
    return manifest


def finish_manifest(manifest: dict[str, Any], status: str, rows: Mapping[str, int], digest: str) -> None:
    """Writes down how the run ended; the caller stores the manifest."""
    manifest.update(status=status, finished=now(), rows=dict(rows), trace_sha256=digest)


def write_manifest(directory: Path, manifest: Mapping[str, Any]) -> None:
    """Replaces the manifest in one step.

    Raises:
        TraceError: It cannot be written.
    """
    replace_file(directory / MANIFEST, _text(manifest), TraceError)


def _text(manifest: Mapping[str, Any]) -> str:
    text = json.dumps(manifest, indent=2, ensure_ascii=False) + "\n"
    return text.encode(errors="replace").decode()  # names of files may hold what is no text


def is_run(directory: Path) -> bool:
    """Whether a directory looks like that of a run: whether there is anything under the name of a manifest."""
    try:
        return os.path.lexists(directory / MANIFEST)
    except ValueError:
        return False


def read_manifest(directory: Path) -> dict[str, Any]:
    """The manifest of the run in `directory`; every field that a reader asks for is there and of its kind.

    Raises:
        TraceError: There is no such directory, it is not a run's, a newer version wrote it, or a field is wrong.
    """
    try:
        if not directory.is_dir():
            kind = "is a file, not a run directory" if directory.exists() else "no such run directory"
            raise TraceError(f"{directory}: {kind}")
        if not is_run(directory):
            raise TraceError(f"{directory}: not a run directory (it holds no {MANIFEST})")
    except (OSError, ValueError) as error:  # a loop of links, a name that is too long
        raise TraceError(f"{directory}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    manifest = read_json(directory / MANIFEST, TraceError)
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        raise TraceError(f"{directory}: not a run directory ({MANIFEST} is not that of a {FORMAT})")
    if not is_a(manifest.get("schema"), int) or manifest["schema"] > VERSION:
        raise TraceError(
            f"{directory}: written by a newer colonysim (trace schema {str(manifest.get('schema'))[:20]}, "
            f"this one reads up to {VERSION}); upgrade with: pip install -U colonysim"
        )
    check_manifest(manifest, directory / MANIFEST)
    return manifest


def prepare_directory(out: Path | None, manifest: Mapping[str, Any]) -> Path:
    """Makes the directory for a run and puts its first manifest there; without `out`, a new one below `runs/`.

    Of several processes that ask for the same `out` at the same moment exactly one gets it: the one that creates the
    manifest.

    Raises:
        TraceError: `out` holds files already, or cannot be made or written to.
    """
    try:
        directory = _named_after(manifest) if out is None else _empty(out)
    except OSError as error:
        raise TraceError(f"{error.filename or out}: cannot be made: {error.strerror or error}") from error
    except ValueError as error:
        raise TraceError(f"{out}: cannot be made: {error}") from error
    try:
        create_file(directory / MANIFEST, _text(manifest), TraceError)
    except FileExistsError:
        raise _taken(directory) from None
    return directory


def _empty(out: Path) -> Path:
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise _taken(out)
    out.mkdir(parents=True, exist_ok=True)
    return out


def _taken(out: Path) -> TraceError:
    return TraceError(f"{out}: exists already and is not empty; a run never overwrites anything")


def _named_after(manifest: Mapping[str, Any]) -> Path:
    words = [manifest["name"], manifest["variant"] or "", manifest["backend"]]
    stem = "-".join(word for word in (re.sub(r"[^\w.-]+", "_", text).strip("_-.") for text in words) if word)
    for number in range(1, 1_000_000):
        end = f"-s{manifest['seed']}-{number}"
        path = Path("runs") / f"{_cut(stem, _LONGEST_NAME - len(end))}{end}"
        try:
            path.mkdir(parents=True)
        except FileExistsError:
            continue
        return path
    raise TraceError(f"{path.parent / path.name.rpartition('-')[0]}: too many runs of this name")


def _cut(text: str, most: int) -> str:
    """The beginning of a text that takes at most so many bytes in the name of a file, in whole letters."""
    return text.encode()[:most].decode(errors="ignore")
