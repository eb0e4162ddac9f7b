"""A model file from somebody else: whatever is in it, every reader accepts it or says in one message what is wrong."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
import tampered


@pytest.mark.parametrize("count", [12, pytest.param(200, marks=pytest.mark.slow)])
def test_a_tampered_model_is_accepted_or_refused_in_one_message(count: int, tmp_path: Path) -> None:
    pytest.importorskip("pybullet", reason="PyBullet is not installed")
    pytest.importorskip("sklearn", reason="scikit-learn is not installed")
    command = [sys.executable, tampered.__file__, str(tmp_path), "0", str(count)]
    command += ["push"] if count > 100 else []
    done = subprocess.run(command, capture_output=True, text=True, timeout=1800)
    assert done.returncode == 0, done.stderr[-2000:]
    *ends, about = [json.loads(line) for line in done.stdout.splitlines() if line[:1] in "[{"]
    assert len({seed for seed, *_ in ends}) == count
    for seed, reader, code, said in ends:
        assert code in (0, 2), (seed, reader, code, said)
        if code:
            assert said.startswith("Error: ") and "\n" not in said and len(said) < 1000, (seed, reader, said)
            assert f"{seed}." in said, (seed, reader, said)  # it names the file
    assert about["kilobytes"] < 1_000_000
