"""One program on the package as it is installed, and on a copy of it without its compiled modules."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import colonysim

PACKAGE = Path(colonysim.__file__).parent


def compiled_and_plain(program: str, folder: Path) -> tuple[list[str], list[str]]:
    """The lines that a program prints with either; its first one must be the file of a module that is compiled."""
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()
    shutil.copytree(PACKAGE, folder / "colonysim", ignore=shutil.ignore_patterns("*.so", "*.pyd", "__pycache__"))
    if not (folder / "colonysim" / "scenarios").exists():
        shutil.copytree(PACKAGE.parent / "scenarios", folder / "scenarios")
    outputs = []
    for place in (PACKAGE.parent, folder):
        done = subprocess.run(
            [sys.executable, "-W", "ignore", "-c", program], cwd=elsewhere,
            env={**os.environ, "PYTHONPATH": str(place)}, capture_output=True, text=True, check=True,
        )  # fmt: skip
        outputs.append(done.stdout.splitlines())
    (first, *lines), (second, *again) = outputs
    assert not first.endswith(".py") and second.endswith(".py")
    return lines, again
