"""A command that is told to stop ends in order, with the exit code that says who told it, and never as a traceback."""

from __future__ import annotations

import fcntl
import os
import pty
import random
import signal
import subprocess
import sys
import termios
import time
from pathlib import Path
from typing import Any

import pytest

import colonysim
from colonysim.sweep.tables import read_table
from colonysim.trace.manifest import prepare_directory
from colonysim.trace.reader import Run

COLONYSIM = [sys.executable, "-m", "colonysim"]
ENDLESS = [*COLONYSIM, "run", "sanity", "-n", "1000000", "--record", "decisions,deposits,frames", "--out", "run"]


def begun(folder: Path, command: list[str] = ENDLESS, **more: object) -> subprocess.Popen[str]:
    """A command that has told three lines."""
    process = subprocess.Popen(  # type: ignore[call-overload]
        command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more
    )
    for _ in range(3):
        process.stderr.readline()
    return process


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_run_that_is_asked_to_end_is_interrupted(number: signal.Signals, tmp_path: Path) -> None:
    process = begun(tmp_path)
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 128 + number, err
    assert "Interrupted after" in err and "Traceback" not in err and not out
    run = Run.open(tmp_path / "run")
    assert run.status == "interrupted" and len(run.episodes) >= 3 and run.verify()


def test_impatience_changes_nothing(tmp_path: Path) -> None:
    process = begun(tmp_path)
    for _ in range(2000):
        process.send_signal(signal.SIGINT)
        time.sleep(0.001)
        if process.poll() is not None:
            break
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130 and err.count("Interrupted") == 1 and "Traceback" not in err
    run = Run.open(tmp_path / "run")
    assert run.status == "interrupted" and run.verify()


def test_a_closed_terminal_ends_what_runs_in_front_of_it(tmp_path: Path) -> None:
    ours, theirs = pty.openpty()

    def in_front() -> None:
        os.setsid()
        fcntl.ioctl(theirs, termios.TIOCSCTTY, 0)

    process = subprocess.Popen(
        ENDLESS, cwd=tmp_path, stdin=theirs, stdout=theirs, stderr=theirs, preexec_fn=in_front, pass_fds=[theirs]
    )
    os.close(theirs)
    said = b""
    while said.count(b"episode") < 3:
        said += os.read(ours, 4096)
    os.close(ours)
    assert process.wait(timeout=60) == 128 + signal.SIGHUP
    run = Run.open(tmp_path / "run")
    assert run.status == "interrupted" and run.verify()


def test_under_nohup_a_run_goes_on(tmp_path: Path) -> None:
    command = [*COLONYSIM, "run", "sanity", "-n", "200", "--out", "run"]
    process = begun(tmp_path, command, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
    for _ in range(20):
        process.send_signal(signal.SIGHUP)
    process.communicate(timeout=60)
    assert process.returncode == 0
    run = Run.open(tmp_path / "run")
    assert run.status == "finished" and len(run.episodes) == 200 and run.verify()


def test_a_sweep_that_is_terminated_can_go_on(tmp_path: Path) -> None:
    (tmp_path / "sweep.yaml").write_text("scenarios: [sanity]\nseeds: {count: 400}\nepisodes: 2\n")
    command = [*COLONYSIM, "sweep", "sweep.yaml", "--out", "out", "--workers", "1"]
    process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    journal = tmp_path / "out" / "journal.jsonl"
    while not (journal.exists() and journal.read_text().count("succeeded") > 2):
        time.sleep(0.02)
    process.terminate()
    _, err = process.communicate(timeout=60)
    assert process.returncode == 143 and "Run the same command again" in err and "Traceback" not in err
    statuses = read_table(tmp_path / "out", "trials")["status"].to_pylist()
    assert {"succeeded", "interrupted", "pending"} == set(statuses) and statuses.count("interrupted") == 1


def stop_once_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C comes right after a run's first manifest has been written."""

    def prepared(*given: Any) -> Path:
        directory = prepare_directory(*given)
        signal.raise_signal(signal.SIGINT)
        return directory

    monkeypatch.setattr(colonysim.recording, "prepare_directory", prepared)


def test_a_run_that_is_stopped_before_it_begins_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    colonysim.run("sanity", episodes=1, out=tmp_path / "whole")
    stop_once_made(monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        colonysim.run("sanity", episodes=1, out=tmp_path / "run")
    with pytest.raises(KeyboardInterrupt):
        colonysim.repeat(tmp_path / "whole", out=tmp_path / "again")
    for name in ("run", "again"):
        run = Run.open(tmp_path / name)
        assert run.status == "interrupted" and not run.episodes and run.verify()


def test_a_run_that_is_stopped_before_it_goes_on_is_as_it_was(tmp_path: Path) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    def stop_after_two(event: object, run: Run) -> None:
        if len(run.episodes) == 2:
            stop()

    path = tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        colonysim.run("sanity", episodes=3, out=path, on_event=stop_after_two)
    before = (path / "manifest.json").read_bytes()
    with pytest.raises(KeyboardInterrupt):
        colonysim.resume(path, on_start=stop)
    assert (path / "manifest.json").read_bytes() == before
    assert Run.open(path).verify() and len(colonysim.resume(path).episodes) == 3


def stopped_at_random(folder: Path, count: int, seed: int, words: list[str]) -> None:
    draws = random.Random(seed)
    for i in range(count):
        here = folder / str(i)
        here.mkdir()
        # Python says what it imports: `signal` is the first thing that the command does.
        process = subprocess.Popen(
            [sys.executable, "-X", "importtime", "-m", "colonysim", *words],
            cwd=here, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        assert process.stderr is not None
        while not process.stderr.readline().endswith("| signal\n"):
            pass
        number = draws.choice([signal.SIGINT, signal.SIGINT, signal.SIGTERM])
        moment = draws.uniform(0.0, 2.0)
        time.sleep(moment)
        process.send_signal(number)
        for _ in range(draws.choice([0, 1, 5])):
            time.sleep(draws.uniform(0.0, 0.05))
            process.send_signal(number)
        _, err = process.communicate(timeout=60)
        said = [line for line in err.splitlines() if not line.startswith("import time:")]
        assert process.returncode in (128 + number, 130), (i, moment, said)
        assert not any("Traceback" in line or "ignored" in line for line in said), (i, moment, said)
        if (here / "run" / "manifest.json").exists():
            run = Run.open(here / "run")
            assert run.status == "interrupted" and run.verify(), (i, moment, run.status)


def test_ctrl_c_at_some_moments_from_the_first_on(tmp_path: Path) -> None:
    stopped_at_random(tmp_path, 3, 1, ENDLESS[3:])


@pytest.mark.slow
def test_ctrl_c_at_any_moment_from_the_first_on(tmp_path: Path) -> None:
    stopped_at_random(tmp_path, 100, 2, ENDLESS[3:])


@pytest.mark.slow
@pytest.mark.parametrize("words", ["run sanity -b physics -n 1000", "train push --out model"])
def test_ctrl_c_at_any_moment_of_heavier_commands(words: str, tmp_path: Path) -> None:
    stopped_at_random(tmp_path, 20, 3, words.split())
