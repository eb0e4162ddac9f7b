"""The commands that install more of the package, from where it came: a checkout, a repository, or an index."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from functools import cache
from pathlib import Path

__all__ = ["compile_command", "install_command"]

NAME = "colonysim"


def install_command(extra: str) -> str:
    """The command that installs an extra of the package.

    Args:
        extra: Name of the extra, as in pyproject.toml.

    Returns:
        It, as it is typed in a shell of this system.
    """
    folder, place = _source()
    if folder:
        return f"{_pip()} install {_quoted(f'{folder}[{extra}]')}"
    return f"{_pip()} install {_quoted(f'{NAME}[{extra}] @ {place}' if place else f'{NAME}[{extra}]')}"


def compile_command() -> str:
    """The command that installs the package anew, with its hot modules compiled or an error that says why not."""
    folder, place = _source()
    what = folder or (f"{NAME} @ {place}" if place else NAME)
    edit = "-e " if folder and _editable() else ""
    setting = "set COLONYSIM_COMPILE=1 && " if sys.platform == "win32" else "COLONYSIM_COMPILE=1 "
    return f"{setting}{_pip()} install --force-reinstall --no-deps {edit}{_quoted(what)}"


def _pip() -> str:
    """What runs pip for this interpreter: its name alone would be another's where no environment is activated."""
    if sys.prefix == sys.base_prefix or os.environ.get("VIRTUAL_ENV") == sys.prefix:
        return "pip"
    python = Path(sys.executable)
    if python.is_relative_to(Path.cwd()):
        python = python.relative_to(Path.cwd())
    return f"{_quoted(str(python))} -m pip"


def _source() -> tuple[str, str]:
    """The folder that the package was installed from, or else its address, or neither: then it is of an index."""
    checkout = Path(__file__).parents[1]
    if (checkout / "hatch_build.py").is_file():
        return _shown(checkout), ""
    # Not on import: these take as long as half the package, and only a message needs them.
    from urllib.parse import urlparse
    from urllib.request import url2pathname

    told = _told()
    address = str(told.get("url", ""))
    if isinstance(told.get("dir_info"), dict) and urlparse(address).scheme == "file":
        folder = Path(url2pathname(urlparse(address).path))
        if (folder / "hatch_build.py").is_file():
            return _shown(folder), ""
    repository = told.get("vcs_info")
    if isinstance(repository, dict) and address:
        return "", f"{repository.get('vcs', 'git')}+{address}"
    return "", ""


@cache
def _told() -> dict[str, object]:
    """What pip has written down of where the package came from (PEP 610); empty if nothing."""
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        found = json.loads(distribution(NAME).read_text("direct_url.json") or "{}")
    except (PackageNotFoundError, OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _editable() -> bool:
    told = _told().get("dir_info")
    return isinstance(told, dict) and told.get("editable") is True


def _shown(folder: Path) -> str:
    return "." if folder == Path.cwd() else str(folder)


def _quoted(word: str) -> str:
    return subprocess.list2cmdline([word]) if sys.platform == "win32" else shlex.quote(word)
