"""Progress where there is no terminal: plain lines now and then, none of them broken."""

from __future__ import annotations

import io
import sys

import pytest

from colonysim.cli import progress
from colonysim.cli.progress import Bar


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
