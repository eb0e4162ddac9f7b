from __future__ import annotations

from pathlib import Path

import pytest

import colonysim


@pytest.fixture(scope="session")
def easy(tmp_path_factory: pytest.TempPathFactory) -> colonysim.Run:
    out: Path = tmp_path_factory.mktemp("runs") / "easy"
    return colonysim.run("easy", seed=10, episodes=2, out=out)
