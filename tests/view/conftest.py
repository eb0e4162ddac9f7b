from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from chromium import chromium

import colonysim


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    with chromium() as session:
        yield session


@pytest.fixture(scope="session")
def hard(tmp_path_factory: pytest.TempPathFactory) -> colonysim.Run:
    out: Path = tmp_path_factory.mktemp("runs") / "hard"
    return colonysim.run("hard", variant="r5-4", seed=10, episodes=3, out=out)
