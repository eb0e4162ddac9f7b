"""Whatever a scenario file says, it is refused with one message or it runs: no traceback, no hang, little memory."""

import resource
import signal
import subprocess
import sys
from contextlib import contextmanager

import pytest
import typer
from click.testing import CliRunner
from mutations import mutations

from colonysim.cli import app

SECONDS = 10
"""Of the processor; on a busy machine six times as many by the clock."""
MEGABYTES = 500
RUNS = {
    # Runs may be meant to be long; these are told to be short.
    "nodeworld": ["--episodes", "1", "--set", "max_steps=30"],
    "physics": ["--episodes", "1", "--set", "max_steps=3", "--set", "time_limit=60"],
}


COMMAND = typer.main.get_command(app)
"""Made once: that takes longer than to check a scenario."""


class TookTooLongError(BaseException):
    """Not an Exception: nothing between here and the alarm may swallow it."""


@contextmanager
def within(seconds):
    def stop(signum, frame):
        raise TookTooLongError(f"more than {seconds} s")

    timers = {signal.ITIMER_PROF: seconds, signal.ITIMER_REAL: 6 * seconds}
    old = {kind: signal.signal(kind, stop) for kind in (signal.SIGPROF, signal.SIGALRM)}
    for timer, most in timers.items():
        signal.setitimer(timer, most)
    try:
        yield
    finally:
        for timer in timers:
            signal.setitimer(timer, 0)
        for kind, handler in old.items():
            signal.signal(kind, handler)


def told(arguments, seconds=SECONDS):
    """Exit code and standard error of a command, which is either done or refused with one message."""
    with within(seconds):
        result = CliRunner().invoke(COMMAND, arguments)
    assert isinstance(result.exception, SystemExit | None), (arguments, result.exception)
    messages = [line for line in result.stderr.splitlines() if line and not line.startswith("Warning: ")]
    if result.exit_code:
        assert result.exit_code == 2, arguments
        assert len(messages) == 1, (arguments, messages)
        assert messages[0].startswith("Error: "), messages
        assert messages[0].isprintable(), messages
        assert len(messages[0]) < 2000, messages
    else:
        assert not messages, (arguments, messages)
    return result.exit_code, result.stderr


def peak():
    """Most memory that this process has had, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000


def accepted(folder, count, seed):
    """Which of so many mutations `validate` accepts."""
    found, before = [], peak()
    for number, data in enumerate(mutations(count, seed)):
        path = folder / f"m{number}.yaml"
        path.write_bytes(data)
        code, _ = told(["validate", str(path)])
        if code == 0:
            found.append(path)
        else:
            path.unlink()
    assert peak() - before < MEGABYTES
    return found


def run_some(paths, backend, seconds):
    """Runs files that `validate` accepts; how many were done and how many refused."""
    codes = [
        told(["run", str(path), "--backend", backend, "--no-trace", "--quiet", *RUNS[backend]], seconds)[0]
        for path in paths
    ]
    return codes.count(0), codes.count(2)


def test_a_few(tmp_path):
    found = accepted(tmp_path, 60, seed=1)
    assert 5 < len(found) < 55
    done, _ = run_some(found[:10], "nodeworld", SECONDS)
    assert done > 5


@pytest.mark.slow
def test_three_thousand(tmp_path, some_engine):
    found = accepted(tmp_path, 3000, seed=2)
    assert len(found) > 300
    done = run_some(found[:300], "nodeworld", 60), run_some(found[-60:], "physics", 120)
    print(f"\n3000 mutations, {len(found)} accepted, {peak():.0f} MB; done and refused by run: {done}")
    assert done[0][0] > 250
    assert done[1][0] > 20


@pytest.mark.slow
def test_some_in_a_process_of_their_own_with_little_memory(tmp_path):
    limits = f"import resource; resource.setrlimit(resource.RLIMIT_AS, ({MEGABYTES * 10**6},) * 2);"
    command = [sys.executable, "-c", f"{limits} from colonysim.cli import main; main()", "validate"]
    for number, data in enumerate(mutations(60, seed=3)):
        path = tmp_path / f"m{number}.yaml"
        path.write_bytes(data)
        ended = subprocess.run([*command, path], capture_output=True, text=True, timeout=60)
        assert ended.returncode in (0, 2), ended.stderr
        assert "Traceback" not in ended.stderr
