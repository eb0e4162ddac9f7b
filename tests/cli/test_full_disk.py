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
from colonysim.learning.cards import ModelError, save_model

WRITERS = {
    "page.html": ["view", "RUN", "--no-open", "-o", "FILE"],
    "film.mp4": ["video", "RUN", "FILE", "--seconds", "1"],
    "film.gif": ["video", "RUN", "FILE", "--seconds", "1"],
    "figures": ["plot", "RUN", "-o", "FILE"],
    "rows.csv": ["export", "RUN", "decisions", "-o", "FILE"],
    "rows.parquet": ["export", "RUN", "decisions", "-o", "FILE"],
}
_OVER = {".mp4": ["--overwrite"], ".gif": ["--overwrite"]}


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


@pytest.mark.parametrize("name", WRITERS)
def test_what_is_part_of_the_run_is_not_overwritten(name: str, recorded: Path, tmp_path: Path) -> None:
    pytest.importorskip("av" if name.startswith("film") else "matplotlib")
    ending = "" if name == "figures" else Path(name).suffix
    before = {path: path.read_bytes() for path in recorded.rglob("*") if path.is_file()}
    (tmp_path / "link").symlink_to(recorded, target_is_directory=True)
    (tmp_path / f"manifest{ending}").symlink_to(recorded / "manifest.json")
    for file in (recorded / "events" / name, tmp_path / "link" / "poses" / name, tmp_path / f"manifest{ending}"):
        if name != "figures" or file.name == name:
            assert "is part of the run" in call([*WRITERS[name], *_OVER.get(ending, ())], recorded, file)
    assert {path: path.read_bytes() for path in recorded.rglob("*") if path.is_file()} == before


def test_a_recording_is_not_written_over_the_run(recorded: Path) -> None:
    assert "is part of the run" in call(["export", "RUN", "-f", "rrd", "-o", "FILE"], recorded, recorded / "events/a")


def test_a_name_that_says_another_format_than_was_asked_for(recorded: Path, tmp_path: Path) -> None:
    for name, asked in (("a.parquet", "csv"), ("a.rrd", "json"), ("a.CSV", "rrd")):
        message = call(["export", "RUN", "-f", asked, "-o", "FILE"], recorded, tmp_path / name)
        assert f"--format says {asked}" in message
    assert not list(tmp_path.iterdir())


def test_a_model_on_a_full_disk(tmp_path: Path) -> None:
    with small_disk(tmp_path / "disk") as disk:
        with pytest.raises(ModelError, match=r"m\.npz: cannot be written: No space left"):
            save_model(disk / "m.npz", "forest", {"a": np.zeros(10_000)}, {})
        assert list(disk.iterdir()) == []
