"""A recording for the Rerun viewer; skipped where that is not installed."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.installing import install_command


def test_a_run_becomes_a_recording(hard: colonysim.Run, tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    out = tmp_path / "run.rrd"
    done = CliRunner().invoke(app, ["export", str(hard.path), "-o", str(out)])
    assert done.exit_code == 0, done.output
    whole = out.read_bytes()
    assert whole.startswith(b"RRF2") and [path.name for path in tmp_path.iterdir()] == ["run.rrd"]
    for path in ("place/nodes", "agent/3", "box/3", "results/steps", "events"):
        assert path.encode() in whole
    part = tmp_path / "part.rrd"
    assert CliRunner().invoke(app, ["export", str(hard.path), "-o", str(part), "--episodes", "2"]).exit_code == 0
    assert part.stat().st_size < len(whole)
    wrong = CliRunner().invoke(app, ["export", str(hard.path), "poses", "-o", str(out)])
    assert wrong.exit_code == 2 and "the whole run" in wrong.output


def test_poses_become_a_recording_too(engine: str, tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    run = colonysim.run("sanity", backend=engine, seed=10, episodes=1, out=tmp_path / "run")
    out = tmp_path / "run.rrd"
    done = CliRunner().invoke(app, ["export", str(run.path), "-o", str(out)])
    assert done.exit_code == 0 and b"Transform3D" in out.read_bytes()


def test_without_the_package_the_command_to_install_it_is_named(
    hard: colonysim.Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    done = CliRunner().invoke(app, ["export", str(hard.path), "-f", "rrd", "-o", str(tmp_path / "x.rrd")])
    assert done.exit_code == 2 and install_command("rerun") in done.output and not list(tmp_path.iterdir())
