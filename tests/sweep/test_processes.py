"""Processes for the work: they end with their parent, tell how a task ended, and are not started from a bad script."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from colonysim.errors import ColonysimError
from colonysim.processes import results, run_tasks
from colonysim.sweep import Store, run_sweep

HERE = Path(__file__).parent
HANGING = ("Hangs", "Spins", "Holds", "Shuts")
SCRIPT = """
import sys, time
from colonysim.processes import results
from faulty_tasks import hang

if __name__ == "__main__":
    list(results(hang, sys.argv[1:], 2))
"""
only_linux = pytest.mark.skipif(sys.platform != "linux", reason="looks at /proc")


def environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")])}


def alive(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def workers_of(parent: int) -> list[int]:
    children = Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
    return [int(child) for child in children if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()]


def wait_until(happened, seconds: float) -> bool:
    end = time.monotonic() + seconds
    while not happened():
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


@only_linux
@pytest.mark.parametrize("kills", [3, pytest.param(40, marks=pytest.mark.slow)])
def test_workers_end_with_their_parent_whatever_they_are_doing(tmp_path, kills):
    rng = random.Random(0)
    for number in range(kills):
        first, second = HANGING[number % 4], rng.choice(HANGING)
        out = tmp_path / f"out-{number}"
        file = tmp_path / "hanging.yaml"
        names = ", ".join(f"faulty_trials:{name}" for name in dict.fromkeys((first, second)))
        file.write_text(f"scenarios: [sanity]\npolicies: [{names}]\nseeds: {{count: 2}}\nlimits: {{seconds: 600}}\n")
        command = [sys.executable, "-m", "colonysim", "sweep", str(file), "-o", str(out), "-w", "2", "-q"]
        process = subprocess.Popen(command, env=environment(), start_new_session=True)
        journal = out / "journal.jsonl"
        begun = wait_until(lambda journal=journal: journal.exists() and journal.read_text().count("running") == 2, 60)
        workers = workers_of(process.pid)
        time.sleep(0.3 + rng.random() * 0.4)  # into the trial itself
        assert begun and len(workers) == 2 and all(map(alive, workers))
        process.send_signal(rng.choice((signal.SIGKILL, signal.SIGKILL, signal.SIGTERM)))
        assert wait_until(lambda workers=workers: not any(map(alive, workers)), 3), (first, second)
        process.wait()
        with Store(out, write=True) as store:  # the next one goes on at once
            assert {entry["status"] for entry in store.entries.values()} == {"interrupted"}


@only_linux
@pytest.mark.parametrize("how", ["sleep", "spin", "hold"])
def test_so_do_those_of_other_work(tmp_path, how):
    script = tmp_path / "work.py"
    script.write_text(SCRIPT)
    process = subprocess.Popen([sys.executable, str(script), how, how], env=environment(), cwd=tmp_path)
    assert wait_until(lambda: len(list(tmp_path.glob("begun-*"))) == 2, 60)
    workers = [int(path.name.partition("-")[2]) for path in tmp_path.glob("begun-*")]
    process.kill()
    process.wait()
    assert wait_until(lambda: not any(map(alive, workers)), 3)


def test_a_trial_that_raises_system_exit_or_keyboard_interrupt_is_told_as_that(tmp_path):
    file = tmp_path / "leaving.yaml"
    file.write_text("scenarios: [sanity]\npolicies: ['faulty_trials:Leaves', 'faulty_trials:Interrupts', colony]\n")
    _, store = run_sweep(file, tmp_path / "out", workers=1)
    ends = [(e["status"], e.get("error", "").strip().splitlines()[-1:]) for e in store.entries.values()]
    (left, why), *others = ends
    assert left == "failed" and why[0].endswith("agent 0 at 0 s: decide raises SystemExit: 3")
    assert others == [("failed", ["KeyboardInterrupt"]), ("succeeded", [])]


def test_tasks_have_what_they_return_or_why_they_failed():
    from faulty_tasks import half, number_of_process

    assert dict(results(half, [2, 4, 6], 2)) == {2: 1.0, 4: 2.0, 6: 3.0}
    with pytest.raises(RuntimeError, match=r"(?s)x: .*TypeError"):
        list(results(half, [2, "x"], 1))
    assert len({process for _, process in results(number_of_process, range(3), 1)}) == 1
    assert len({process for _, process in results(number_of_process, range(3), 1, fresh=True)}) == 3
    reports = list(run_tasks(half, [], workers=2))
    assert not reports


GUARDLESS = {
    "sweep": "from colonysim.sweep import run_sweep; run_sweep('s.yaml', 'out', workers=2)",
    "tune": "from colonysim.sweep.tuning import tune; tune('t.yaml', 'out', workers=2)",
    "run and sweep": "import colonysim; colonysim.run('sanity', episodes=1)\n"
    "from colonysim.sweep import run_sweep; run_sweep('s.yaml', 'out', workers=2)",
    "other work": "from faulty_tasks import half; from colonysim.processes import results; list(results(half, [1], 1))",
    "own fault": "import multiprocessing\nif multiprocessing.current_process().name != 'MainProcess': 1 / 0\n"
    "from colonysim.sweep import run_sweep; run_sweep('s.yaml', 'out', workers=1)",
}


def in_folder(folder: Path, words: list[str], text: str | None = None) -> subprocess.CompletedProcess[str]:
    (folder / "s.yaml").write_text("scenarios: [sanity]\nseeds: {count: 3}\nepisodes: 1\n")
    (folder / "t.yaml").write_text(
        "scenarios: [sanity]\nsample: {count: 2, ranges: {policy.beta: [1, 2]}}\nepisodes: 1\n"
    )
    return subprocess.run(
        [sys.executable, *words], cwd=folder, env=environment(), input=text, capture_output=True, text=True, timeout=100
    )


@pytest.mark.parametrize("kind", GUARDLESS)
def test_a_script_without_a_guard_is_one_error_and_nothing_is_recorded(tmp_path, kind):
    if kind == "tune":
        pytest.importorskip("optuna")
    (tmp_path / "script.py").write_text(GUARDLESS[kind])
    answer = in_folder(tmp_path, ["script.py"])
    assert answer.returncode == 1 and answer.stderr.count("ColonysimError: ") == 1, answer.stderr
    assert 'below `if __name__ == "__main__":`' in answer.stderr.splitlines()[-1]
    assert answer.stderr.count("Traceback") == (2 if kind == "own fault" else 1)
    assert not (tmp_path / "out").exists() or not Store(tmp_path / "out").entries
    assert len(list(tmp_path.glob("runs/*"))) == (kind == "run and sweep"), "not run once more by a worker"
    if kind == "sweep":  # mended, it goes on
        (tmp_path / "script.py").write_text(f"if __name__ == '__main__':\n    {GUARDLESS[kind]}\n")
        assert in_folder(tmp_path, ["script.py"]).returncode == 0
        assert {entry["status"] for entry in Store(tmp_path / "out").entries.values()} == {"succeeded"}


def test_a_script_on_standard_input_says_so_and_a_session_works(tmp_path):
    answer = in_folder(tmp_path, ["-"], GUARDLESS["sweep"])
    assert answer.returncode == 1 and "is no file: save it as one" in answer.stderr, answer.stderr
    assert not (tmp_path / "out").exists()
    answer = in_folder(tmp_path, ["-c", GUARDLESS["sweep"]])
    assert answer.returncode == 0, answer.stderr
    assert {entry["status"] for entry in Store(tmp_path / "out").entries.values()} == {"succeeded"}
    with pytest.raises(ColonysimError, match="holds no sweep"):
        Store(tmp_path)
