"""A disk without room, a place that takes no file, a name that is none: one message, and nothing is left there."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from full_disk import small_disk
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.push.cards import ModelError, save_model

WRITERS = {
    "page.html": ["view", "RUN", "--no-open", "-o", "FILE"],
    "film.mp4": ["video", "RUN", "FILE", "--seconds", "1"],
    "film.gif": ["video", "RUN", "FILE", "--seconds", "1"],
    "figures": ["plot", "RUN", "-o", "FILE"],
    "rows.csv": ["export", "RUN", "decisions", "-o", "FILE"],
    "rows.parquet": ["export", "RUN", "decisions", "-o", "FILE"],
}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out: Path = tmp_path_factory.mktemp("runs") / "hard"
    colonysim.run("hard", seed=3, episodes=4, out=out)
    return out


def call(command: list[str], run: Path, file: Path) -> str:
    """The one message of a command that cannot write its file."""
    words = [{"RUN": str(run), "FILE": str(file)}.get(word, word) for word in command]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 2, (done.output, done.exception)
    last = done.output.strip().splitlines()[-1]
    assert last.startswith("Error: ") and "Traceback" not in done.output
    return last


@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk(name: str, recorded: Path, tmp_path: Path) -> None:
    pytest.importorskip("av" if name.startswith("film") else "matplotlib")
    with small_disk(tmp_path / "disk", 8 if name.startswith(("film", "rows")) else 16) as disk:
        message = call(WRITERS[name], recorded, disk / name)
        assert re.search(f"{name}.*: cannot be written: .*No space left", message)
        assert not any(path.is_file() for path in disk.rglob("*"))


@pytest.mark.parametrize("name", WRITERS)
def test_a_name_that_is_too_long_or_leads_through_a_file(name: str, recorded: Path, tmp_path: Path) -> None:
    pytest.importorskip("av" if name.startswith("film") else "matplotlib")
    (tmp_path / "file").write_text("")
    for file in (tmp_path / f"{'x' * 300}{name}", tmp_path / "file" / name):
        assert "cannot be written" in call(WRITERS[name], recorded, file)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_a_model_on_a_full_disk(tmp_path: Path) -> None:
    with small_disk(tmp_path / "disk") as disk:
        with pytest.raises(ModelError, match=r"m\.npz: cannot be written: No space left"):
            save_model(disk / "m.npz", "forest", {"a": np.zeros(10_000)}, {})
        assert list(disk.iterdir()) == []
