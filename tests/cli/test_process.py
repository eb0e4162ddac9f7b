from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

from colonysim.trace.reader import Run

COLONYSIM = [sys.executable, "-m", "colonysim"]


def test_importing_the_package_is_free() -> None:
    heavy = "{'numpy', 'torch', 'pybullet', 'mujoco', 'matplotlib', 'pyarrow', 'simpy', 'networkx', 'yaml', 'pydantic'}"
    program = f"import sys, colonysim; assert not {heavy} & set(sys.modules); dir(colonysim); colonysim.run"
    subprocess.run([sys.executable, "-c", program], check=True)


def test_help_imports_nothing_heavy() -> None:
    program = (
        "import sys; from colonysim.cli import app\n"
        "for words in (['--help'], ['run', '--help'], ['plot', '--help'], ['train', 'push', '--help']):\n"
        "    try: app(words)\n"
        "    except SystemExit as end: assert end.code == 0\n"
        "heavy = {'numpy', 'torch', 'pybullet', 'mujoco', 'matplotlib', 'pyarrow', 'simpy', 'networkx', 'yaml'}\n"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)
    assert "colonysim run hard --variant" in done.stdout


def test_ctrl_c_leaves_a_readable_run(tmp_path: Path) -> None:
    command = [*COLONYSIM, "run", "sanity", "-n", "1000000", "--record", "decisions,deposits,frames", "--out", "run"]
    process = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stderr is not None
    for _ in range(3):
        process.stderr.readline()
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 130, stderr
    assert "Interrupted after" in stderr and "run so far is in run" in stderr and "Traceback" not in stderr
    assert not stdout
    run = Run.open(tmp_path / "run")
    assert run.status == "interrupted" and len(run.episodes) >= 3 and run.verify()


def test_a_killed_run_is_readable(tmp_path: Path) -> None:
    kept = ["--record", "decisions,deposits,frames"]
    command = [*COLONYSIM, "run", "sanity", "-n", "1000000", *kept, "--out", "run", "-q"]
    process = subprocess.Popen(command, cwd=tmp_path)
    deadline = time.monotonic() + 60
    while not any((tmp_path / "run" / "episodes").glob("part-*")) and time.monotonic() < deadline:
        time.sleep(0.05)
    process.kill()
    process.wait()
    run = Run.open(tmp_path / "run")
    assert run.status == "running" and run.episodes
    last = run.episodes[-1].episode
    assert run.field("D", episode=last) and any(event.kind == "goal" for event in run.events(last))
