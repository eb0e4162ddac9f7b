"""A recording for the Rerun viewer; skipped where that is not installed."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.installing import install_command
from colonysim.view.rrd import _Recording


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


class Recorder:
    """Stands for rerun and its stream: keeps what it is told."""

    def __init__(self) -> None:
        self.logged: list[tuple[dict[str, Any], str, Any]] = []
        self.columns: dict[str, list[tuple[list[float], Any]]] = {}
        self._now: dict[str, Any] = {}

    def set_time(self, name: str, **at: Any) -> None:
        self._now[name] = next(iter(at.values()))

    def log(self, path: str, what: Any, static: bool = False) -> None:
        self.logged.append(({} if static else dict(self._now), path, what))

    def send_columns(self, path: str, indexes: Any, columns: Any) -> None:
        self.columns.setdefault(path, []).append((list(indexes[0].given["duration"]), columns))

    def __getattr__(self, name: str) -> Any:
        return Told


class Told:
    def __init__(self, *plain: Any, **given: Any) -> None:
        self.plain, self.given, self.counts = plain, given, []

    @classmethod
    def columns(cls, **given: Any) -> Told:
        return cls(**given)

    from_fields = columns

    def partition(self, counts: list[int]) -> Told:
        self.counts = counts
        return self


def test_a_recording_shows_what_the_timeline_changes(tmp_path: Path) -> None:
    changes = [
        {"time": 1.5, "remove_edge": [1, 2]}, {"time": 2, "move_goal": 4},
        {"time": 3, "add_box": {"node": 0, "height": 0.7}},
        {"time": 3.5, "remove_box": 0}, {"time": 2.5, "set_surface": {"node": 5, "z": 2}},
    ]  # fmt: skip
    place = {"topology": {"kind": "line", "nodes": 7}, "agents": [2], "goal": 6, "boxes": [[5, 0.7]]}
    scenario = colonysim.scenario_from_document({**place, "changes": changes, "time_limit": 6.0, "policy": "random"})
    run = colonysim.run(scenario, seed=1, episodes=1, out=tmp_path / "run")
    told = Recorder()
    _Recording(told, told, run, run.episodes).write()
    edges = [(now["time"], len(what.plain[0])) for now, path, what in told.logged if path == "place/edges"]
    assert edges == [(0.0, 6), (1.5, 5), (2.0, 5), (2.5, 5)]
    nodes = [what for _, path, what in told.logged if path == "place/nodes"]
    green = [[tuple(colour) for colour in what.given["colors"]].index((0, 158, 115)) for what in nodes]
    assert green == [6, 6, 4, 4] and [what.plain[0][5][2] for what in nodes] == [0.0, 0.0, 0.0, 2.0]
    shown = {path: [(t, c.counts) for t, c in sent if c.counts] for path, sent in told.columns.items()}
    assert shown["box/0"] == [([0.0, 3.5], [1, 0])] and shown["box/1"] == [([0.0, 3.0], [0, 1])]
    lifted = next(c for _, c in told.columns["box/0"] if "translation" in c.given).given["translation"]
    assert lifted[0][2] == 0.35 and lifted[-1][2] == 2.35
    texts = told.columns["events"][0][1].given["text"]
    assert "edge 1-2 goes" in texts and "the goal is 4 now" in texts
