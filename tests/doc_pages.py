"""Plays a page of the docs: its files are written, its commands and its Python run, one after the other.

A block with a title (```yaml title="bridge.yaml") is a file. In a `console` block what follows `$ ` is run, and the
lines below are what it must print among others, in that order; `...` stands for anything. Blocks in `sh` are not run.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
_FENCE = re.compile(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)


class Block(NamedTuple):
    """A block of code of a page."""

    language: str
    title: str
    code: str


def blocks(page: str) -> list[Block]:
    """The blocks of a page, named without its ending."""
    return [Block(*found) for found in _FENCE.findall((DOCS / f"{page}.md").read_text(encoding="utf-8"))]


def play(page: str, folder: Path) -> tuple[dict[str, Any], str]:
    """Plays a page in a folder, which has to be the working directory and on Python's path.

    Args:
        page: Its name, without the ending.
        folder: Where its files are written and its commands run.

    Returns:
        What its Python blocks defined, and what they printed.
    """
    names: dict[str, Any] = {"__name__": page}
    printed = io.StringIO()
    for language, title, code in blocks(page):
        if title:
            (folder / title).write_text(code, encoding="utf-8")
        elif language == "python":
            with contextlib.redirect_stdout(printed):
                exec(compile(code, f"{page}.md", "exec"), names)
        elif language == "console":
            for part in re.split(r"^\$ ", code, flags=re.MULTILINE)[1:]:
                command, _, shown = part.partition("\n")
                _expect(command, _run(command, folder), shown)
    return names, printed.getvalue()


def _run(command: str, folder: Path) -> str:
    """What a command printed; it must succeed."""
    words = shlex.split(command, comments=True)
    own = {}
    while "=" in words[0]:
        name, _, value = words.pop(0).partition("=")
        own[name] = value
    path = os.pathsep.join(filter(None, [own.pop("PYTHONPATH", ""), str(ROOT)]))
    # BROWSER: who has a page opened gets nothing to see here.
    environment = {**os.environ, **own, "PYTHONPATH": path, "BROWSER": "true", "COLUMNS": "120"}
    program = {"colonysim": ["-m", "colonysim"], "python": []}[words[0]]
    done = subprocess.run(
        [sys.executable, *program, *words[1:]], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


def _expect(command: str, said: str, shown: str) -> None:
    """Checks that the lines that a page shows were printed, in that order."""
    lines = iter([_plain(line) for line in said.splitlines()])
    for line in filter(None, map(_plain, shown.splitlines())):
        pattern = re.escape(line).replace(re.escape("..."), ".*")
        assert any(re.fullmatch(pattern, there) for there in lines), f"{command}: no {line!r} in\n{said}"


def _plain(line: str) -> str:
    return re.sub(r"[\s─]+", " ", line).strip()
