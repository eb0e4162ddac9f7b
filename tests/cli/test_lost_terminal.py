"""Whoever shows the progress may vanish: the work goes on and ends as it should. Lost results are told."""

from __future__ import annotations

import json
import os
import pty
import random
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from colonysim.cli import app
from colonysim.sweep.tables import read_table
from colonysim.trace.reader import Run

EPISODES = 60
# The bar is there from the start, and draws whenever it can.
EAGER = (
    "from colonysim import progress; from colonysim.cli import watch; "
    "progress.PATIENCE = progress._PAUSE = progress.BETWEEN_LINES = 0.0; "
    "watch._FRAME = 0.0; from colonysim.__main__ import main; main()"
)
SWEEP = "scenarios: [sanity]\ngrid: {policy.beta: [2, 4, 8]}\nseeds: {count: 4}\nepisodes: 2\n"
#: A log may grow to this size and some bytes; the parts of a run stay below it.
ROOM = 1 << 26

Lose = Callable[[int], None]


@contextmanager
def pipe(folder: Path, room: int) -> Iterator[tuple[dict[str, Any], Lose]]:
    """Standard error is a pipe whose reader leaves after so many bytes."""
    ours, theirs = os.pipe()
    with _losing(ours, theirs, room) as lose:
        yield {"stderr": theirs}, lose


@contextmanager
def terminal(folder: Path, room: int) -> Iterator[tuple[dict[str, Any], Lose]]:
    """Standard error is a terminal that is closed after so many bytes; the command was taken out of its session."""
    ours, theirs = pty.openpty()
    with _losing(ours, theirs, room) as lose:
        yield {"stderr": theirs, "start_new_session": True}, lose


@contextmanager
def log(folder: Path, room: int) -> Iterator[tuple[dict[str, Any], Lose]]:
    """Standard error is a file that cannot grow by more than so many bytes."""

    def narrow() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (ROOM + room, resource.RLIM_INFINITY))

    with (folder / "log").open("ab") as file:
        file.truncate(ROOM)
        yield {"stderr": file, "preexec_fn": narrow}, lambda _: None
        assert os.fstat(file.fileno()).st_size == ROOM + room


@contextmanager
def _losing(ours: int, theirs: int, room: int) -> Iterator[Lose]:
    closed: list[int] = []

    def lose(pid: int) -> None:
        os.close(theirs)
        left = room
        while left > 0:
            got = os.read(ours, left)
            assert got, "the command ended before its terminal did"
            left -= len(got)
        os.close(ours)
        closed.append(ours)

    yield lose
    assert closed


LOSSES = {"pipe": pipe, "terminal": terminal, "log": log}


def lost(kind: str, room: int, folder: Path, *words: object, **more: Any) -> subprocess.Popen[str]:
    """Runs a command whose standard error is lost after so many bytes; returns it when it has ended."""
    environment = os.environ | {"TERM": "xterm-256color", "COLUMNS": "100", "LINES": "30"}
    with LOSSES[kind](folder, room) as (how, lose):
        command = [sys.executable, "-c", EAGER, *map(str, words)]
        process = subprocess.Popen(
            command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, env=environment, text=True,
            **(how | more),
        )  # fmt: skip
        lose(process.pid)
        process.wait(timeout=300)
    return process


def run_is_whole(kind: str, room: int, folder: Path, *words: object) -> None:
    folder.mkdir(exist_ok=True)
    process = lost(kind, room, folder, "run", "sanity", "-n", EPISODES, "-o", "run", *words)
    run = Run.open(folder / "run")
    assert (process.returncode, run.status, len(run.episodes)) == (0, "finished", EPISODES), (kind, room)
    assert run.verify(), (kind, room)


def moments(count: int, seed: int) -> list[int]:
    """After how many bytes of progress it is lost; a whole run tells some 4,000 in a log, more on a terminal."""
    draws = random.Random(seed)
    return [draws.randrange(3500) for _ in range(count)]


@pytest.mark.parametrize("kind", LOSSES)
def test_a_run_goes_on_without_its_terminal(kind: str, tmp_path: Path) -> None:
    run_is_whole(kind, *moments(1, seed=1), tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("kind", LOSSES)
def test_a_run_goes_on_without_its_terminal_at_any_moment(kind: str, tmp_path: Path) -> None:
    for i, room in enumerate(moments(100, seed=2)):
        run_is_whole(kind, room, tmp_path / f"{i}-{room}")


def test_a_watched_run_goes_on_when_nobody_watches(tmp_path: Path) -> None:
    run_is_whole("terminal", 2000, tmp_path, "--watch", "--pace", 0)


@pytest.mark.slow
def test_a_run_shown_in_the_browser_goes_on_without_its_terminal(tmp_path: Path) -> None:
    run_is_whole("terminal", 10, tmp_path, "--live", "--no-open", "--pace", 0)


@pytest.mark.parametrize(
    "kind", ["terminal", pytest.param("pipe", marks=pytest.mark.slow), pytest.param("log", marks=pytest.mark.slow)]
)
def test_a_sweep_goes_on_without_its_terminal(kind: str, tmp_path: Path) -> None:
    (tmp_path / "sweep.yaml").write_text(SWEEP)
    # Less than one line: on a slow machine all trials may end before a second one is due.
    process = lost(kind, 20, tmp_path, "sweep", "sweep.yaml", "--out", "out", "--workers", 1)
    assert process.returncode == 0
    assert read_table(tmp_path / "out", "trials")["status"].to_pylist() == ["succeeded"] * 12


@pytest.mark.slow
@pytest.mark.parametrize("kind", LOSSES)
@pytest.mark.parametrize(
    ("words", "made"),
    [
        ("tune tune.yaml --out out --workers 1", "out/trials.parquet"),
        ("evaluate push --push scripted -n 2 --out out", "out/manifest.json"),
        ("video run film.gif --seconds 4", "film.gif"),
        ("bench hard travel-10 -n 1 --save bench.json", "bench.json"),
        ("train push --out model --set actions=300", "model/push.json"),
        ("train way --ways 20 --out way", "way/way.json"),
    ],
)
def test_other_long_commands_go_on_without_their_terminal(kind: str, words: str, made: str, tmp_path: Path) -> None:
    (tmp_path / "tune.yaml").write_text(
        "scenarios: [sanity]\nsample: {count: 4, ranges: {policy.beta: [1, 16]}}\nseeds: {count: 2}\nepisodes: 2\n"
    )
    assert run(tmp_path, "run sanity -n 2 -o run -q")[0] == 0
    process = lost(kind, 20, tmp_path, *words.split())
    assert process.returncode == 0 and (tmp_path / made).exists()


# Results


RESULTS = ["scenarios", "schema", "--help", "run --help", "scenarios --json", "new grid", "export run", "report run"]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recorded")
    run(folder, "run sanity -n 40 -o run -q")
    run(folder, "run sanity -n 2 --policy paper -o other -q")
    return folder


def run(folder: Path, words: str, redirected: str = "") -> tuple[int, str]:
    """The exit code, and what was said on standard error."""
    done = subprocess.run(
        ["sh", "-c", f'"$0" -m colonysim {words} {redirected}', sys.executable], cwd=folder, capture_output=True,
        text=True, timeout=120,
    )  # fmt: skip
    return done.returncode, done.stderr


@pytest.mark.parametrize("redirected", [">/dev/full", ">&-"])
@pytest.mark.parametrize("words", ["--help", "export run"])
def test_results_that_cannot_be_written_are_told_in_one_line(words: str, redirected: str, recorded: Path) -> None:
    code, said = run(recorded, words, redirected)
    assert code == 2 and said.count("\n") == 1 and said.startswith("Error: standard output cannot be written to")


@pytest.mark.slow
@pytest.mark.parametrize("redirected", [">/dev/full", ">&-", ">/dev/full 2>&1", ">&- 2>&-", ">&- 2>&- <&-"])
@pytest.mark.parametrize(
    "words", [*RESULTS, "--version", "backends", "validate hard", "view run --no-open", "compare run other"]
)
def test_results_of_any_command(words: str, redirected: str, recorded: Path) -> None:
    code, said = run(recorded, words, redirected)
    assert code == 2 and (not said or said.startswith("Error: standard output")) and said.count("\n") <= 1


def test_who_has_read_enough_hears_nothing(recorded: Path) -> None:
    for words in RESULTS[:1] + RESULTS[6:7]:
        ours, theirs = os.pipe()
        os.close(ours)
        done = subprocess.run(
            [sys.executable, "-m", "colonysim", *words.split()], cwd=recorded, stdout=theirs, stderr=subprocess.PIPE
        )
        os.close(theirs)
        assert (done.returncode, done.stderr) == (141, b"")
    code, said = run(recorded, "scenarios", "| head -1")
    assert (code, said) == (0, "")


def test_a_slow_reader_that_does_not_wait_gets_everything(recorded: Path) -> None:
    ours, theirs = os.pipe()
    os.set_blocking(theirs, False)
    command = [sys.executable, "-m", "colonysim", "export", "run", "-f", "json"]
    process = subprocess.Popen(command, cwd=recorded, stdout=theirs)
    os.close(theirs)
    time.sleep(2.0)
    with os.fdopen(ours, "rb") as file:
        got = file.read()
    assert process.wait() == 0 and len(got) > 1 << 16
    assert run(recorded, "export run -o events.json")[0] == 0
    assert got == (recorded / "events.json").read_bytes()


@pytest.mark.parametrize("redirected", [">/dev/full", "<&- >&- 2>&-"])
def test_a_run_is_whole_though_its_results_cannot_be_shown(redirected: str, tmp_path: Path) -> None:
    code, said = run(tmp_path, "run sanity -n 3 -o run", redirected)
    assert code == 2 and "Traceback" not in said
    done = Run.open(tmp_path / "run")
    assert done.status == "finished" and len(done.episodes) == 3 and done.verify()


def test_results_do_not_depend_on_standard_error(tmp_path: Path) -> None:
    for redirected in ("<&- 2>&-", "2>/dev/full"):
        done = subprocess.run(
            f"{sys.executable} -m colonysim run sanity -n 3 --no-trace --json {redirected}", shell=True,
            stdout=subprocess.PIPE, cwd=tmp_path, check=True,
        )  # fmt: skip
        assert len(json.loads(done.stdout)["episodes"]) == 3


# Logs


def test_a_log_holds_lines_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "sweep.yaml").write_text(SWEEP)
    for words in ("run sanity -n 5 -o run", "sweep sweep.yaml --out out --workers 1"):
        command: Sequence[str] = [sys.executable, "-c", EAGER, *words.split()]
        environment = os.environ | {"FORCE_COLOR": "1", "COLUMNS": "40"}
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True, env=environment)
        lines = done.stderr.splitlines()
        assert "\x1b" not in done.stderr and "\r" not in done.stderr and len(lines) >= 2
        assert any("%" in line and (words.startswith("run") or "left" in line) for line in lines), lines


# Files


LONG = "x" * 300


@pytest.mark.parametrize(
    "words",
    [
        "run sanity -n 1 -q -o {}", "run {}", "view run --no-open -o {}.html", "export run -o {}.csv",
        "video run {}.gif", "new grid -o {}.yaml", "sweep sweep.yaml --out {}", "results {}", "report {}",
    ],
)  # fmt: skip
def test_a_name_that_is_too_long_is_told_in_one_line(
    words: str, recorded: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(recorded)
    Path("sweep.yaml").write_text(SWEEP)
    result = CliRunner().invoke(app, words.format(LONG).split())
    assert result.exit_code == 2 and LONG in result.stderr
    assert "too long" in result.stderr or "holds no results" in result.stderr
    assert result.stderr.count("\n") == 1 and not result.stdout
