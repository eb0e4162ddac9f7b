"""Whatever was done to a run directory: every reader shows it, or says in one message why not."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tampering import QUICK, SLOW, api, make_bases, tamper

from colonysim.errors import ColonysimError

LONGEST = 120
"""Seconds of wall clock within which a reader has to answer, on a machine that does much else."""


@pytest.fixture(scope="module")
def bases(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return make_bases(tmp_path_factory.mktemp("bases"))


def _readers(number: int) -> dict[str, Any]:
    """Of each directory the verification, what a program reads and two commands; of every 50th all of them."""
    if number % 50 == 0:
        return QUICK | SLOW
    names = [name for name in QUICK if name != "verify"]
    drawn = [*SLOW][number % len(SLOW)] if number % 5 == 0 else names[(number + 3) % len(names)]
    return {name: (QUICK | SLOW)[name] for name in {"verify": 0, names[number % len(names)]: 0, drawn: 0}}


@pytest.fixture(autouse=True)
def _impatient() -> Iterator[None]:
    def hangs(*_: object) -> None:
        raise TimeoutError(f"no answer within {LONGEST} s")

    before = signal.signal(signal.SIGALRM, hangs)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def _try(base: Path, here: Path, number: int) -> Counter[str]:
    directory, out = here / "run", here / "out"
    shutil.copytree(base, directory)
    rng = random.Random(number)
    told = f"{number}: {base.name}: {tamper(directory, rng)}"
    out.mkdir()
    (out / "other").symlink_to(base)
    ended: Counter[str] = Counter()
    for name, read in _readers(number).items():
        signal.alarm(LONGEST)
        result = read(directory, out)
        signal.alarm(0)
        said = f"{told}: {name}: {result.output[-600:]!r} {result.exception!r}"
        assert result.exit_code in (0, 2), said
        assert result.exception is None or isinstance(result.exception, SystemExit), said
        assert "\x1b" not in result.output and "Traceback" not in result.output, said
        if result.exit_code == 2:
            assert result.stderr.count("Error:") == 1 and len(result.stderr) < 2000, said
        ended[f"exit {result.exit_code}"] += 1
    signal.alarm(LONGEST)
    try:
        api(directory)
        ended["read"] += 1
    except ColonysimError:
        ended["refused"] += 1
    except BaseException as error:
        raise AssertionError(told) from error
    signal.alarm(0)
    assert not list(directory.rglob(".*.tmp")) and not list(out.rglob(".*.tmp")), told
    shutil.rmtree(here)
    return ended


@pytest.mark.parametrize("count", [60, pytest.param(2000, marks=pytest.mark.slow)])
def test_a_tampered_run_is_read_or_refused_by_every_reader(bases: list[Path], tmp_path: Path, count: int) -> None:
    ended: Counter[str] = Counter()
    # Tests before this one, in the same process, may have left hundreds of megabytes.
    Path("/proc/self/clear_refs").write_text("5")
    before = _peak()
    for number in range(count):
        here = tmp_path / str(number)
        here.mkdir()
        ended += _try(bases[number % len(bases)], here, number)
    print(dict(ended), f"{_peak() - before} MiB at most, besides {before}")
    assert _peak() - before < 1024, "more than a gibibyte"


def _peak() -> int:
    """The most memory that this process has held, MiB, since `clear_refs` was written to."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition("VmHWM:")[2].split()[0]) // 1024


@pytest.mark.parametrize("number", [1344])  # a footer that tells of integers of more than 64 bits
def test_what_was_found_once(bases: list[Path], tmp_path: Path, number: int) -> None:
    (tmp_path / "here").mkdir()
    _try(bases[number % len(bases)], tmp_path / "here", number)


def test_the_command_itself_answers_with_exit_code_2(bases: list[Path], tmp_path: Path) -> None:
    directory = tmp_path / "run"
    shutil.copytree(bases[0], directory)
    (directory / "manifest.json").unlink()
    os.mkfifo(directory / "manifest.json")
    for words in (("report",), ("view", "--no-open"), ("verify",), ("compare",)):
        done = subprocess.run(
            [sys.executable, "-m", "colonysim", words[0], str(directory), *words[1:]], capture_output=True, text=True,
            timeout=60,
        )  # fmt: skip
        assert done.returncode == 2 and not done.stdout
        assert done.stderr.startswith("Error: ") and done.stderr.count("\n") == 1 and "is a pipe" in done.stderr
