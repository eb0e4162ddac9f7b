from __future__ import annotations

import io
import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app, watch
from colonysim.trace.replay import follow


def test_the_board_is_where_the_trace_says(tmp_path: Path) -> None:
    run = colonysim.run("hard", seed=10, episodes=1, out=tmp_path / "run")
    board = watch.Board(run.scenario)
    for event in run.events(1):
        board.take(event)
    ways = follow(run.scenario, run.events(1))
    assert board.agents == {agent: way[-1] for agent, way in ways.agents.items() if agent not in ways.gone}
    assert board.boxes == {box: way[-1] for box, way in ways.boxes.items()}
    board.reset()
    lines = str(board.draw(80, 30)).split("\n")
    assert len(lines) <= 30 and max(map(len, lines)) <= 80
    assert sum(line.count("·") for line in lines) == 32 - 4 - 4 - 3 - 1  # the nodes on which nothing is drawn
    for sign in "0123":  # an agent and a box of each number
        assert sum(line.count(sign) for line in lines) == 2
    small = str(board.draw(20, 6)).split("\n")
    assert len(small) <= 6 and max(map(len, small)) <= 20


def test_watching_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    slept: list[float] = []
    monkeypatch.setattr(watch.time, "sleep", slept.append)
    plain = colonysim.run("sanity", seed=10, episodes=2, trace=False)
    console = Console(file=io.StringIO(), force_terminal=True, highlight=False, width=80, height=30)
    wait = watch.Pace(5.0)
    with watch.Watch(plain.scenario, 2, console=console) as shown:

        def slow(event: colonysim.Event, run: colonysim.Run) -> None:
            wait(event)
            shown(event, run)

        seen = colonysim.run("sanity", seed=10, episodes=2, trace=False, on_event=slow)
    assert seen.trace_sha256 == plain.trace_sha256
    assert isinstance(console.file, io.StringIO)
    said = console.file.getvalue()
    assert "episode 1 of 2" in said and "episode   2:" in said and "◆" in said
    whole = sum(episode.sim_seconds for episode in plain.episodes)
    assert sum(slept) == pytest.approx(whole / 5.0, rel=0.2) and min(slept) >= 0 and max(slept) <= 0.5


def test_it_needs_a_terminal() -> None:
    result = CliRunner().invoke(app, ["run", "sanity", "--watch", "--no-trace"])
    assert result.exit_code == 2 and "standard error is none" in result.output


def test_on_a_terminal_the_map_is_drawn() -> None:
    here, there = pty.openpty()
    command = [sys.executable, "-m", "colonysim", "run", "sanity", "-n", "1", "--no-trace", "--watch"]
    environment = os.environ | {"TERM": "xterm-256color", "COLUMNS": "80", "LINES": "30"}
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=there, env=environment) as run:
        os.close(there)
        said = b""
        while True:
            try:
                said += os.read(here, 4096)
            except OSError:  # Linux says so when the other end is closed
                break
        results = run.communicate()[0]
    os.close(here)
    assert run.returncode == 0
    assert "◆" in said.decode() and "episode 1 of 1" in said.decode()
    assert b"success" in results and b"\x1b" not in results
