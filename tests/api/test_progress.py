"""Progress: plain lines now and then where there is no terminal, none of them broken; a bar in a notebook."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from types import ModuleType

import pytest

import colonysim
from colonysim import progress
from colonysim.progress import Bar
from colonysim.sweep import run_sweep


def test_a_log_file_gets_a_line_now_and_then(monkeypatch: pytest.MonkeyPatch) -> None:
    log, now = io.StringIO(), [0.0]
    monkeypatch.setattr(sys, "stderr", log)
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    with Bar("sweep", 1.0) as bar:
        for second in range(1, 601):
            now[0] = float(second)
            bar.move(second / 1200)
        bar.line("failed: " + "x" * 200)
    lines = log.getvalue().splitlines()
    assert lines[0] == "sweep: 1%, 0:00:10, 0:22:02 left" and lines[-1] == "failed: " + "x" * 200
    assert 10 <= len(lines) <= 31 and "\r" not in log.getvalue() and "\x1b" not in log.getvalue()


def test_none_when_quiet(monkeypatch: pytest.MonkeyPatch) -> None:
    log, now = io.StringIO(), [0.0]
    monkeypatch.setattr(sys, "stderr", log)
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    with Bar("sweep", 1.0, quiet=True) as bar:
        now[0] = 1000.0
        bar.move(0.5)
    assert log.getvalue() == ""


class Cell:
    """What stands below a cell of a notebook: as many outputs as were displayed, each as it was updated last."""

    kernel = True

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.outputs: list[dict[str, str]] = []
        python = ModuleType("IPython")
        python.get_ipython = lambda: self  # type: ignore[attr-defined]
        python.display = ModuleType("IPython.display")  # type: ignore[attr-defined]
        python.display.display = self.display  # type: ignore[attr-defined]
        monkeypatch.setitem(sys.modules, "IPython", python)
        monkeypatch.setitem(sys.modules, "IPython.display", python.display)  # type: ignore[attr-defined]

    def display(self, data: dict[str, str], *, raw: bool, display_id: bool) -> Cell:
        assert raw and display_id
        self.outputs.append(data)
        return self

    def update(self, data: dict[str, str], *, raw: bool) -> None:
        assert raw
        self.outputs[-1] = data


def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every bar shows at once."""
    for name in ("PATIENCE", "_PAUSE", "BETWEEN_LINES"):
        monkeypatch.setattr(progress, name, 0.0)


def test_a_run_in_a_notebook_has_one_bar_which_stays(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    quick(monkeypatch)
    cell, events = Cell(monkeypatch), []
    run = colonysim.run("sanity", episodes=3, trace=False, on_event=lambda event, run: events.append(event))
    [output] = cell.outputs
    assert output["text/plain"].startswith("sanity on nodeworld: 100%, 0:00:0")
    assert '<progress value="1.0000"' in output["text/html"]
    assert sum(event.kind == "episode" for event in events) == 3 == len(run.episodes)
    colonysim.run("sanity", episodes=1, trace=False, progress=False)
    assert len(cell.outputs) == 1 and capsys.readouterr().err == ""


def test_a_bar_that_nobody_had_to_wait_for_does_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    cell = Cell(monkeypatch)
    colonysim.run("sanity", episodes=1, trace=False)
    assert cell.outputs == []


def test_a_bar_stays_where_it_was_when_the_work_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    quick(monkeypatch)
    cell = Cell(monkeypatch)
    with pytest.raises(ZeroDivisionError):
        colonysim.run("sanity", episodes=2, trace=False, on_begin=lambda colony: colony.on("episode", lambda *_: 1 / 0))
    assert "100%" not in cell.outputs[-1]["text/plain"]


def test_a_script_shows_progress_where_it_asks_for_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    quick(monkeypatch)
    run = colonysim.run("sanity", episodes=2, trace=False)
    assert capsys.readouterr().err == ""
    assert colonysim.run("sanity", episodes=2, trace=False, progress=True).trace_sha256 == run.trace_sha256
    said = capsys.readouterr().err.splitlines()
    assert said and all(line.startswith("sanity on nodeworld: ") and "%, 0:00:0" in line for line in said)
    with pytest.raises(colonysim.ColonysimError, match="progress: 'yes', expected true, false or None"):
        colonysim.run("sanity", progress="yes")  # type: ignore[arg-type]


def test_a_sweep_names_the_trial_that_failed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    quick(monkeypatch)
    file = tmp_path / "sweep.yaml"
    file.write_text("scenarios: [sanity]\nseeds: {count: 1}\nepisodes: 1\nlimits: {seconds: 0.001}\n")
    run_sweep(file, tmp_path / "out", workers=1, progress=True)
    said = capsys.readouterr().err
    assert "sweep: " in said and "failed: scenario sanity, " in said and "took longer than 0.001 s" in said
    run_sweep(file, tmp_path / "again", workers=1)
    assert capsys.readouterr().err == ""
