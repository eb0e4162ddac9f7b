"""The same trace, bit for bit, in any process: whatever the hash seed and the processor's features."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

PROGRAM = """
import numpy, colonysim
for name in ("sanity", "easy", "medium", "hard"):
    for policy, mode in (("colony", "asynchronous"), ("paper", "synchronous")):
        run = colonysim.run(name, policy=policy, mode=mode, episodes=2, seed=7, trace=False)
        print(name, policy, run.trace_sha256)
print(numpy.exp(numpy.linspace(-30, 3, 999)).sum().hex())
"""


def hashes(**environment: str) -> list[str]:
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", PROGRAM], env={**os.environ, **environment}, capture_output=True,
        text=True, check=True,
    )  # fmt: skip
    return done.stdout.splitlines()


@pytest.fixture(scope="module")
def plain() -> list[str]:
    found = hashes(PYTHONHASHSEED="0")
    assert len({row.split()[-1] for row in found[:8]}) == 8, "every map, policy and mode has a trace of its own"
    return found[:8]


def test_in_a_process_with_another_hash_seed(plain):
    assert hashes(PYTHONHASHSEED="1")[:8] == plain


def test_on_a_processor_with_fewer_features(plain):
    umath = getattr(np, "_core", None) or np.core
    have = [name for name, there in umath._multiarray_umath.__cpu_features__.items() if there]
    dispatched = [name for name in umath._multiarray_umath.__cpu_dispatch__ if name in have]
    assert hashes(PYTHONHASHSEED="0", NPY_DISABLE_CPU_FEATURES=" ".join(dispatched))[:8] == plain


def test_in_the_same_process_again():
    import colonysim

    first, again = (colonysim.run("hard", episodes=2, seed=3, trace=False).trace_sha256 for _ in range(2))
    assert first == again
    assert first != colonysim.run("hard", episodes=2, seed=4, trace=False).trace_sha256
