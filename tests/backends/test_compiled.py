"""Rigid bodies with the hot modules compiled and as plain Python: the same traces, bit for bit."""

from __future__ import annotations

import pytest
from plain_python import compiled_and_plain

from colonysim.push import driving

PROGRAM = """
import colonysim
from colonysim.push import driving
print(driving.__file__)
from colonysim.physics import engine_trouble
for engine, name, push in (("bullet", "hard", "staged"), ("bullet", "easy", "rl"), ("mujoco", "easy", "staged")):
    if engine_trouble(engine):
        continue
    run = colonysim.run(name, backend=engine, episodes=1, seed=5, trace=False, backend_options={"push": push})
    print(run.trace_sha256)
"""
PLAIN = str(driving.__file__).endswith(".py")


@pytest.mark.skipif(PLAIN, reason="colonysim was installed where there is no C compiler")
def test_compiled_and_plain_python_drive_and_push_alike(tmp_path):
    hashes, again = compiled_and_plain(PROGRAM, tmp_path)
    assert hashes and hashes == again
