"""Rigid bodies with the hot modules compiled and as plain Python: the same traces, bit for bit."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import colonysim
from colonysim.push import driving

PACKAGE = Path(colonysim.__file__).parent
PROGRAM = """
import colonysim
from colonysim.push import driving
print(driving.__file__)
for name, push in (("hard", "staged"), ("easy", "rl")):
    run = colonysim.run(name, backend="bullet", episodes=1, seed=5, trace=False, backend_options={"push": push})
    print(run.trace_sha256)
"""
PLAIN = str(driving.__file__).endswith(".py")


@pytest.mark.skipif(PLAIN, reason="colonysim was installed where there is no C compiler")
def test_compiled_and_plain_python_drive_and_push_alike(tmp_path):
    plain, elsewhere = tmp_path / "colonysim", tmp_path / "elsewhere"
    elsewhere.mkdir()
    shutil.copytree(PACKAGE, plain, ignore=shutil.ignore_patterns("*.so", "*.pyd", "__pycache__"))
    if not (plain / "scenarios").exists():
        shutil.copytree(PACKAGE.parent / "scenarios", tmp_path / "scenarios")
    outputs = []
    for place in (PACKAGE.parent, tmp_path):
        done = subprocess.run(
            [sys.executable, "-W", "ignore", "-c", PROGRAM], cwd=elsewhere,
            env={**os.environ, "PYTHONPATH": str(place)}, capture_output=True, text=True, check=True,
        )  # fmt: skip
        outputs.append(done.stdout.splitlines())
    (first, *hashes), (second, *again) = outputs
    assert not first.endswith(".py") and second.endswith(".py")
    assert len(hashes) == 2 and hashes == again
