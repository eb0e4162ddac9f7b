"""Shards: parts of a sweep that run apart, are killed and gone on with, and are merged to what one run would write."""

from __future__ import annotations

import errno
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from typer.testing import CliRunner

from colonysim import files
from colonysim.cli import app
from colonysim.errors import ColonysimError, ColonysimWarning
from colonysim.processes import attempt
from colonysim.sweep import load_sweep, merge_shards, run_sweep, running
from colonysim.sweep.shards import Shard, as_shard
from colonysim.sweep.tables import read_table
from colonysim.sweep.trial import run_trial
from colonysim.sweep.workers import Outcome

TEXT = "scenarios: [sanity, easy]\ngrid: {policy.beta: [2, 4]}\nseeds: {count: %d}\nepisodes: 2\n"
GROUPED = """\
name: two
nodes: [[0, 0, 0], [1, 1, 0], [2, 2, 0]]
edges: [[0, 1], [1, 2]]
groups: [{name: left, agents: [0]}, {name: right, agents: [2]}]
goal: 1
"""


def in_this_process(trials, limits, workers):
    """Runs trials without processes of their own, which take long to start."""
    for trial in trials:
        yield Outcome(trial, "running")
        word, value = attempt(run_trial, trial, None)
        yield Outcome(trial, word, value if word == "succeeded" else None, "" if word == "succeeded" else value, 0.1)


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "run_locally", in_this_process)


def written(folder: Path, text: str) -> Path:
    path = folder / "s.yaml"
    path.write_text(text)
    return path


def tables(directory: Path) -> list[object]:
    """All tables, with their schemas, but for wall clock."""
    names = [path.stem for path in sorted(directory.glob("*.parquet"))]
    found = [read_table(directory, name) for name in names]
    return [names, *(t.drop_columns(["seconds"]) if "seconds" in t.column_names else t for t in found)]


def ends(directory: Path) -> Counter[str]:
    """How often each trial has finished, over all journals below a directory."""
    lines = [json.loads(line) for path in directory.rglob("journal.jsonl") for line in path.read_text().splitlines()]
    return Counter(line["trial"] for line in lines if line["status"] == "succeeded")


def started(file: Path, out: Path, shard: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "colonysim", "sweep", str(file), "-o", str(out), "--shard", shard, "-w", "1", "-q"]
    return subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def refused(file: Path, out: Path) -> str:
    with pytest.raises(ColonysimError) as error:
        merge_shards(file, out)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_four_shards_two_at_once_two_of_them_killed_are_one_sweep(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent), prepend=os.pathsep)
    file, out = written(tmp_path, TEXT % 6 + "policies: ['faulty_trials:Dawdles']\n"), tmp_path / "out"
    run_sweep(file, tmp_path / "whole", workers=2)
    for shard, other in (("2/4", "1/4"), ("4/4", "3/4")):
        process, beside = started(file, out, shard), started(file, out, other)
        journal = as_shard(shard).directory(out) / "journal.jsonl"
        while not (journal.exists() and journal.read_bytes().count(b"succeeded") >= 2):
            assert process.poll() is None
            time.sleep(0.002)
        time.sleep(0.1 * random.random())
        os.killpg(process.pid, signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL and journal.read_bytes().count(b"succeeded") < 6
        assert started(file, out, shard).wait() == beside.wait() == 0
    planned, _, missing = merge_shards(file, out)
    assert not missing and len(planned.trials) == 24
    assert tables(out) == tables(tmp_path / "whole")
    assert sorted(ends(out / "shards").values()) == [1] * 24, "nothing is run twice"
    told = CliRunner().invoke(app, ["results", str(out), "--json"])
    assert [row["finished"] for row in json.loads(told.stdout)] == [6, 6, 6, 6]


def test_what_is_missing_is_told_and_merged_only_when_asked(tmp_path, quick):
    file, out = written(tmp_path, TEXT % 2), tmp_path / "out"
    with pytest.raises(ColonysimError, match="holds no shards to merge"):
        merge_shards(file, out)
    for shard in ("1/3", "3/3"):
        run_sweep(file, out, shard=shard)
    told = refused(file, out)
    assert told.startswith(f"{out}: 3 of 8 trials are missing: 3 of shard 2/3, which has not begun (scenario sanity, ")
    assert "policy.beta 2, seed 1; " in told and not (out / "journal.jsonl").exists()
    answer = CliRunner().invoke(app, ["results", str(out)])
    assert answer.exit_code == 2 and "but shards: `colonysim sweep --merge` joins them" in answer.stderr
    answer = CliRunner().invoke(app, ["sweep", str(file), "-o", str(out)])
    assert answer.exit_code == 2 and "holds shards; --shard goes on with one of them, --merge joins" in answer.stderr
    answer = CliRunner().invoke(app, ["sweep", str(file), "-o", str(out), "--merge", "--partial"])
    assert answer.exit_code == 0 and answer.stdout == f"5 trials succeeded, 0 failed, 3 missing: {out}\n"
    assert Counter(read_table(out, "trials")["status"].to_pylist()) == {"succeeded": 5, "pending": 3}
    run_sweep(file, out, shard=(2, 3))
    merge_shards(file, out)
    merge_shards(file, out)
    run_sweep(file, tmp_path / "whole")
    assert tables(out) == tables(tmp_path / "whole")
    assert set(ends(out).values()) == {2}, "in the journal of a shard, and of the sweep"
    assert (out / "sweep.yaml").read_text() == file.read_text()


def test_a_merged_sweep_goes_on_in_any_way_and_runs_nothing_twice(tmp_path, quick):
    file, out = written(tmp_path, TEXT % 2), tmp_path / "out"
    run_sweep(file, out, shard="1/2")
    merge_shards(file, out, partial=True)
    written(tmp_path, TEXT % 4)  # the division is another one then: half of what shard 1 has run is now of shard 2
    for shard in ("2/2", "1/2"):
        run_sweep(file, out, shard=shard)
    assert set(ends(out / "shards").values()) == {1} and len(ends(out / "shards")) == 16
    merge_shards(file, out)
    shutil.rmtree(out / "shards")
    begun: list[str] = []
    written(tmp_path, TEXT % 5)
    run_sweep(file, out, on_outcome=lambda outcome, done, total: begun.append(outcome.status))
    run_sweep(file, out, shard="1/3", on_outcome=lambda outcome, done, total: begun.append(outcome.status))
    assert Counter(begun) == {"running": 4, "succeeded": 4}
    run_sweep(file, tmp_path / "whole")
    assert tables(out) == tables(tmp_path / "whole")


def test_failures_are_merged_and_give_way_to_a_retry(tmp_path, quick, monkeypatch):
    text = "scenarios: [sanity]\npolicies: ['faulty_trials:Raises', colony]\nepisodes: 1\n"
    file, out = written(tmp_path, text), tmp_path / "out"
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    for shard in ("1/2", "2/2"):
        run_sweep(file, out, shard=shard)
    answer = CliRunner().invoke(app, ["sweep", str(file), "-o", str(out), "--merge"])
    assert answer.exit_code == 1 and answer.stdout.startswith("1 trials succeeded, 1 failed: ")
    monkeypatch.setattr("faulty_trials.Raises.decide", lambda self, view, memory, random: None)
    assert "out of ideas" in read_table(out, "trials")["error"].to_pylist()[0]
    run_sweep(file, out, shard="1/2", retry_failed=True)
    merge_shards(file, out)
    assert "out of ideas" not in read_table(out, "trials")["error"].to_pylist()[0]


def test_results_by_group_are_merged(tmp_path, quick):
    (tmp_path / "two.yaml").write_text(GROUPED)
    file = written(tmp_path, "scenarios: [two.yaml]\nseeds: {count: 3}\nepisodes: 2\n")
    for shard in ("1/2", "2/2"):
        run_sweep(file, tmp_path / "out", shard=shard)
    merge_shards(file, tmp_path / "out")
    run_sweep(file, tmp_path / "whole")
    assert tables(tmp_path / "out")[0] == ["episodes", "groups", "trials"]
    assert tables(tmp_path / "out") == tables(tmp_path / "whole")


@pytest.fixture
def merged(tmp_path, quick) -> tuple[Path, Path]:
    file, out = written(tmp_path, TEXT % 1), tmp_path / "out"
    for shard in ("1/2", "2/2"):
        run_sweep(file, out, shard=shard)
    return file, out


def test_shards_of_another_division_are_refused(merged):
    file, out = merged
    with pytest.raises(ColonysimError, match="shards of 2 and of 3, expected those of one division"):
        run_sweep(file, out, shard="1/3")
    assert not Shard(1, 3).directory(out).exists()
    shutil.copytree(Shard(1, 2).directory(out), Shard(1, 3).directory(out))
    assert "shards of 2 and of 3" in refused(file, out)


def test_shards_of_another_file_are_refused_until_they_are_run_again(merged):
    file, out = merged
    written(file.parent, (TEXT % 1).replace("[2, 4]", "[2, 8]"))
    assert "shard 1/2 ran another version of the file, of its scenarios or of code; run it again" in refused(file, out)
    written(file.parent, TEXT % 2)
    with pytest.warns(ColonysimWarning, match="shard 2/2 ran another version of the file"):
        run_sweep(file, out, shard="1/2")
    assert "shard 2/2 ran a file of 4 trials, this one has 8; run it again" in refused(file, out)
    run_sweep(file, out, shard="2/2")
    assert len(merge_shards(file, out)[0].trials) == 8


def test_shards_of_another_version_are_refused(merged):
    file, out = merged
    record = Shard(2, 2).directory(out) / "shard.json"
    record.write_text(json.dumps({**json.loads(record.read_text()), "version": "0.0.1"}))
    assert "shard 2/2 was run by colonysim 0.0.1, this is " in refused(file, out)
    record.write_text("[]")
    assert "shard.json: is not as it was written" in refused(file, out)
    record.write_text("{")
    assert "shard.json: cannot be read as JSON" in refused(file, out)


def test_shards_that_contradict_the_sweeps_journal_are_refused(merged):
    file, out = merged
    merge_shards(file, out)
    journal = out / "journal.jsonl"
    line = json.loads(journal.read_text().splitlines()[0])
    journal.write_text(json.dumps({**line, "trace_sha256": "0" * 64}) + "\n")
    told = refused(file, out)
    assert f"{out} and {Shard(1, 2).directory(out)} hold different results of one trial, scenario sanity, " in told


def test_one_shard_runs_once_at_a_time_and_another_meanwhile(tmp_path, quick):
    file, out = written(tmp_path, TEXT % 1), tmp_path / "out"
    with files.alone(Shard(1, 2).directory(out), "is running this sweep"):
        with pytest.raises(ColonysimError, match="another process is running this sweep"):
            run_sweep(file, out, shard="1/2")
        run_sweep(file, out, shard="2/2")


def test_a_file_system_without_locks_is_a_warning(tmp_path, quick, monkeypatch):
    def lock(file: int) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(files, "_lock", lock)
    file, out = written(tmp_path, TEXT % 1), tmp_path / "out"
    with pytest.warns(ColonysimWarning, match="knows no locks: see to it that no other process is running this sweep"):
        run_sweep(file, out, shard="1/1")
    with pytest.warns(ColonysimWarning, match="knows no locks"):
        assert len(merge_shards(file, out)[0].trials) == 4
    with pytest.raises(ColonysimError, match="cannot be locked"), files.alone(out, "is at work there"):
        pass


def test_a_shard_is_every_nth_trial(tmp_path):
    trials = load_sweep(written(tmp_path, TEXT % 2)).trials
    parts = [Shard(number, 3).of(trials) for number in (1, 2, 3)]
    assert parts[1] == trials[1::3] and sorted(map(len, parts)) == [2, 3, 3]
    assert len(Shard(9, 9).of(trials)) == 0


WRONG = ["0/2", "3/2", "2", "a/b", "1/2/3", "-1/2", "", (1, 2, 3), (1,), 5, (1.0, 2), "1/" + "9" * 30]


@pytest.mark.parametrize("wrong", WRONG)
def test_no_such_shard(wrong):
    with pytest.raises(ColonysimError, match="expected the number of a part and how many there are, such as 2/8"):
        as_shard(wrong)


@pytest.mark.parametrize("words", [["--partial"], ["--merge", "--shard", "1/2"], ["--merge", "--workers", "2"]])
def test_options_that_contradict_each_other(tmp_path, words):
    file = written(tmp_path, TEXT % 1)
    answer = CliRunner().invoke(app, ["sweep", str(file), "-o", str(tmp_path / "out"), *words])
    assert answer.exit_code == 2 and "--merge" in answer.stderr and not (tmp_path / "out").exists()


def test_the_batch_job_of_the_documentation(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "sweeps.md").read_text(encoding="utf-8")
    job = re.search(r"```sh\n(#!/bin/bash\n#SBATCH.*?)```", page, re.DOTALL)[1].replace("/16", "/2")
    merge = re.search(r"^colonysim sweep .*--merge$", page, re.MULTILINE)[0]
    (tmp_path / "colonysim").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m colonysim "$@"\n')
    (tmp_path / "colonysim").chmod(0o755)
    (tmp_path / "beta.yaml").write_text(TEXT % 1)
    env = {**os.environ, "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}", "SLURM_CPUS_PER_TASK": "1"}
    for number in ("1", "2"):
        told = {**env, "SLURM_ARRAY_TASK_ID": number}
        subprocess.run(["bash", "-c", job], cwd=tmp_path, env=told, check=True, capture_output=True)
    done = subprocess.run(["bash", "-c", merge], cwd=tmp_path, env=env, check=True, capture_output=True, text=True)
    assert done.stdout == "4 trials succeeded, 0 failed: results/beta\n"
