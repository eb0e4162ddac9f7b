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


@pytest.fixture
def large(tmp_path: Path) -> Path:
    """A scenario with numbers of nodes up to 10**15 and edges that take a month."""
    file = tmp_path / "large.yaml"
    nodes = [f"[{10**15 - 4 + i}, {i}, 0]" for i in range(5)]
    file.write_text(
        f"nodes: [{', '.join(nodes)}]\nedges: {{radius: 1.1}}\nagents: [{10**15 - 4}, {10**15 - 3}]\ngoal: {10**15}\n"
        "timing: {travel: 3.0e+6}\nstall_seconds: 1.0e+9\n"
    )
    return file
