"""The tutorial runs as it stands, and shows what its commands print."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from doc_pages import blocks, play

pytest.importorskip("matplotlib")


def test_the_tutorial_runs_and_shows_what_comes_of_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    _, printed = play("tutorial", tmp_path)
    sys.modules.pop("rules", None)
    assert printed == "best weight: 0.5\n"
    assert "<svg" in (tmp_path / "weights.svg").read_text(encoding="utf-8")
    for named in ("F", "trajectories"):
        assert (tmp_path / "runs" / "pocket-nodeworld-s1-2" / "plots" / f"{named}.png").stat().st_size > 5000


def test_every_block_of_it_is_run_but_the_installation() -> None:
    kept = [block.language for block in blocks("tutorial") if not block.title]
    assert kept.count("sh") == 1 and set(kept) == {"sh", "console", "python"}


def test_what_a_page_shows_and_no_command_prints_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = tmp_path / "faulty.md"
    monkeypatch.setattr("doc_pages.DOCS", tmp_path)
    page.write_text("```console\n$ colonysim --version\ncolonysim 7.0 ...\n```\n", "utf-8")
    with pytest.raises(AssertionError, match=r"no 'colonysim 7\.0 \.\.\.'"):
        play("faulty", tmp_path)
    page.write_text("```console\n$ colonysim run no-such-place\n```\n", "utf-8")
    with pytest.raises(AssertionError, match="no-such-place"):
        play("faulty", tmp_path)
