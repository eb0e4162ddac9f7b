"""Sweeps survive: kills of the whole group or of single workers, a full disk, trials of every bad kind."""

from __future__ import annotations

import json
import os
import random
import re
import resource
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from typer.testing import CliRunner

from colonysim.cli import app
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.intervals import bootstrap, student
from colonysim.sweep import Store, load_sweep, run_sweep
from colonysim.sweep.tables import read_table, summary

SMALL = "scenarios: [sanity]\ngrid: {policy.beta: [2, 4]}\nseeds: {count: %d}\nepisodes: 2\n"
WITHOUT_CLOCK = ("seconds",)


def written(folder: Path, text: str, name: str = "small.yaml") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def rows(directory: Path, table: str = "trials") -> list[dict[str, object]]:
    return [
        {name: value for name, value in row.items() if name not in WITHOUT_CLOCK}
        for row in read_table(directory, table).to_pylist()
    ]


def journal(directory: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in (directory / "journal.jsonl").read_text().splitlines()]


def started(file: Path, out: Path, *more: str, **kwargs: object) -> subprocess.Popen[str]:
    env = {**os.environ, "PYTHONPATH": f"{Path(__file__).parent}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"}
    command = [sys.executable, "-m", "colonysim", "sweep", str(file), "--out", str(out), "--workers", "2", *more]
    return subprocess.Popen(
        command, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, **kwargs
    )  # type: ignore[call-overload,no-any-return]


def finished(directory: Path) -> int:
    path = directory / "journal.jsonl"
    return path.read_bytes().count(b'"status":"succeeded"') if path.exists() else 0


def begun_trials(directory: Path) -> int:
    path = directory / "journal.jsonl"
    return path.read_bytes().count(b'"status":"running"') if path.exists() else 0


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("uninterrupted")
    file = written(folder, SMALL % 20)
    run_sweep(file, folder / "out", workers=2)
    return file, folder / "out"


def test_a_sweep_that_is_killed_again_and_again_has_the_same_results(uninterrupted, tmp_path):
    file, whole = uninterrupted
    out, rng, kills = tmp_path / "out", random.Random(0), 0
    while finished(out) < 40:
        process = started(file, out)
        wanted = finished(out) + rng.randrange(2, 7)
        while process.poll() is None and finished(out) < wanted:
            time.sleep(0.002)
        time.sleep(rng.random() * 0.02)
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            kills += 1
        process.communicate()
    assert kills >= 3
    run_sweep(file, out, workers=1)
    assert rows(out) == rows(whole) and rows(out, "episodes") == rows(whole, "episodes")
    ends = Counter(str(entry["trial"]) for entry in journal(out) if entry["status"] == "succeeded")
    assert set(ends.values()) == {1} and len(ends) == 40
    begun = sum(entry["status"] == "running" for entry in journal(out))
    assert begun <= 40 + 2 * (kills + 1), "at most the running ones were begun again"


def test_killed_workers_cost_nothing_but_their_trial(uninterrupted, tmp_path):
    file, whole = uninterrupted
    process = started(file, tmp_path / "out")
    killed, rng = 0, random.Random(1)
    while process.poll() is None:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        alive = children.read_text().split() if finished(tmp_path / "out") > 6 * killed else []
        for child in rng.sample(alive, min(1, len(alive))):
            if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes():
                os.kill(int(child), signal.SIGKILL)
                killed += 1
        time.sleep(0.01)
    assert process.communicate()[0].startswith("40 trials succeeded, 0 failed") and killed >= 3
    assert rows(tmp_path / "out") == rows(whole)


def test_more_seeds_run_only_what_is_new_and_nothing_runs_twice(uninterrupted, tmp_path):
    file = written(tmp_path, SMALL % 2)
    begun: list[str] = []

    def watch(outcome, done, total):
        if outcome.status == "running":
            begun.append(outcome.trial.identity)

    run_sweep(file, tmp_path / "out", workers=1, on_outcome=watch)
    assert len(begun) == 4
    written(tmp_path, SMALL.replace("[2, 4]", "[4, 2, 8]") % 3)
    planned, _ = run_sweep(file, tmp_path / "out", workers=1, on_outcome=watch)
    assert len(begun) == len(set(begun)) == 9 == len(planned.trials)
    run_sweep(file, tmp_path / "out", workers=1, on_outcome=watch)
    assert len(begun) == 9
    by_setting = {(row["policy.beta"], row["seed"]): row["trace_sha256"] for row in rows(uninterrupted[1])}
    for row in rows(tmp_path / "out"):
        assert row["policy.beta"] == 8 or row["trace_sha256"] == by_setting[row["policy.beta"], row["seed"]]


def test_trials_that_raise_hang_eat_or_die_are_rows_and_the_others_succeed(tmp_path):
    bad = ["Raises", "Hangs", "Eats", "Dies"]
    names = ", ".join(f"faulty_trials:{name}" for name in bad)
    text = f"scenarios: [sanity]\npolicies: [{names}, stigmergy]\nseeds: {{count: 1}}\nepisodes: 2\n"
    file = written(tmp_path, text + "limits: {seconds: 12, memory_mb: 1500}\n")
    process = started(file, tmp_path / "out")
    out, err = process.communicate(timeout=120)
    assert process.returncode == 1 and out.startswith("1 trials succeeded, 4 failed"), err
    found = {str(row["policy"]).partition(":")[2]: row for row in rows(tmp_path / "out")}
    assert found[""]["status"] == "succeeded"
    assert {found[name]["status"] for name in bad} == {"failed"}
    assert "RuntimeError: out of ideas" in str(found["Raises"]["error"]) and "decide" in str(found["Raises"]["error"])
    assert found["Hangs"]["error"] == "took longer than 12 s"
    assert found["Eats"]["error"] == "took more than 1500 MB"
    assert found["Dies"]["error"] == "its process died 3 times (signal 9)"
    again = started(file, tmp_path / "out")
    assert again.communicate()[0] == out, "what has failed is not tried again"
    assert len(journal(tmp_path / "out")) == 2 * 5 + 2, "the one whose process dies was begun three times"


def test_failed_trials_are_run_again_when_asked(tmp_path):
    file = written(tmp_path, "scenarios: [sanity]\nepisodes: 1\nlimits: {seconds: 0.000001}\n")
    _, store = run_sweep(file, tmp_path / "out", workers=1)
    assert [entry["status"] for entry in store.entries.values()] == ["failed"]
    written(tmp_path, "scenarios: [sanity]\nepisodes: 1\n")
    _, store = run_sweep(file, tmp_path / "out", workers=1)
    assert [entry["status"] for entry in store.entries.values()] == ["failed"]
    _, store = run_sweep(file, tmp_path / "out", workers=1, retry_failed=True)
    assert [entry["status"] for entry in store.entries.values()] == ["succeeded"]


def test_a_full_disk_is_an_error_and_the_sweep_goes_on_later(uninterrupted, tmp_path):
    file, whole = uninterrupted

    def small_disk():
        resource.setrlimit(resource.RLIMIT_FSIZE, (12000, resource.RLIM_INFINITY))

    process = started(file, tmp_path / "out", preexec_fn=small_disk)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 2 and "cannot be written" in err and "Traceback" not in err, err
    assert (tmp_path / "out" / "journal.jsonl").read_bytes().endswith(b"\n")
    kept = finished(tmp_path / "out")
    assert kept > 0
    run_sweep(file, tmp_path / "out", workers=2)
    assert rows(tmp_path / "out") == rows(whole)
    ends = [entry["trial"] for entry in journal(tmp_path / "out") if entry["status"] == "succeeded"]
    assert len(ends) == len(set(ends)) == 40


def test_ctrl_c_leaves_interrupted_trials_and_a_table(tmp_path):
    text = "scenarios: [sanity]\npolicies: [stigmergy, faulty_trials:Hangs]\nseeds: {count: 4}\nepisodes: 2\n"
    process = started(written(tmp_path, text), tmp_path / "out")
    while (begun := begun_trials(tmp_path / "out")) < 6 and process.poll() is None:
        time.sleep(0.01)
    assert begun == 6, "four that end, and one that never does in each of two workers"
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130 and "Run the same command again" in err
    statuses = Counter(row["status"] for row in rows(tmp_path / "out"))
    assert statuses == {"succeeded": 4, "interrupted": 2, "pending": 2}


def test_only_one_process_runs_a_sweep_but_any_may_read_it(uninterrupted):
    _, whole = uninterrupted
    with Store(whole, write=True):
        with pytest.raises(ColonysimError, match="another process"):
            Store(whole, write=True)
        assert len(Store(whole).entries) == 40


def test_a_folder_with_other_things_in_it_is_left_alone(tmp_path):
    file = written(tmp_path, SMALL % 1)
    with pytest.raises(ColonysimError, match="not empty"):
        run_sweep(file, tmp_path)
    with pytest.raises(ColonysimError, match="holds no sweep"):
        Store(tmp_path / "nothing")


def test_trials_are_told_apart_by_what_determines_their_result(tmp_path):
    def identities(text: str) -> list[str]:
        return [trial.identity for trial in load_sweep(written(tmp_path, text)).trials]

    first = identities("scenarios: [easy, hard]\nseeds: [0, 1]\n")
    assert len(set(first)) == 4
    assert identities("seeds: [1]\nscenarios: [hard, hard]\nname: other\n") == [first[3]]
    changes = ("episodes: 3", "modes: [synchronous]", "policies: [paper]", "grid: {max_steps: [9]}", "backends: [mock]")
    for change in changes:
        assert not set(identities(f"scenarios: [easy, hard]\nseeds: [0, 1]\n{change}\n")) & set(first)
    assert len(identities("scenarios: [{scenario: hard, variants: [null, r5-4]}]\n")) == 2
    (tmp_path / "own.yaml").write_text("topology: {kind: line, nodes: 4}\nagents: [0]\ngoal: 3\n")
    own = identities("scenarios: [own.yaml]\n")
    (tmp_path / "own.yaml").write_text("topology: {kind: line, nodes: 5}\nagents: [0]\ngoal: 3\n")
    assert identities("scenarios: [own.yaml]\n") != own


@pytest.mark.parametrize("method", ["uniform", "sobol"])
def test_settings_are_drawn_from_their_ranges(tmp_path, method):
    if method == "sobol":
        pytest.importorskip("scipy")
    ranges = "{policy.beta: [2, 6], max_steps: [9, 9]}"
    text = f"scenarios: [sanity]\nsample: {{count: 16, method: {method}, ranges: {ranges}}}\n"
    with pytest.raises(ScenarioError, match="max_steps"):
        load_sweep(written(tmp_path, text))  # a range gives numbers with a fraction
    text = text.replace(", max_steps: [9, 9]", "").replace("scenarios", "grid: {max_steps: [20, 30]}\nscenarios")
    trials = load_sweep(written(tmp_path, text)).trials
    betas = sorted({trial.parameters["policy.beta"] for trial in trials})
    assert len(trials) == 32 and len(betas) == 16 and betas[0] < 4 < betas[-1] and betas[-1] - betas[0] > 2
    assert trials == load_sweep(written(tmp_path, text)).trials


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("scenarios: [easy]\nsedes: [1]\n", "small.yaml:2:1: sedes: unknown field; did you mean 'seeds'?"),
        ("scenarios: [{scenario: hard, varaints: [r5-4]}]\n", "0.varaints: unknown field; did you mean 'variants'?"),
        ("scenarios: [easy]\nseeds: {cuont: 2}\n", "seeds.cuont: unknown field; did you mean 'count'?"),
        ("scenarios: [easy]\nlimits: {zzz: 2}\n", "limits.zzz: unknown field; there are: seconds, memory_mb"),
        ("scenarios: [easy]\nsample: {count: 2, rangse: {a: [1, 2]}}\n", "unknown field; did you mean 'ranges'?"),
        ("scenarios: [easy]\nsample: {count: 2}\n", "sample.ranges: is missing"),
        ("scenarios: [easy]\nsample: {count: 2, ranges: {policy.beta: [1]}}\n", "expected [lowest, highest]"),
        ("scenarios: [easy]\nseeds: x\n", "seeds: got 'x', expected a list of seeds, or {count: ..., first: ...}"),
        ("scenarios: [5]\n", "scenarios.0: got 5, expected a scenario's name, or {scenario: ..., variants: [...]}"),
        ("scenarios: [easy]\nmodes: [synchronus]\n", "did you mean 'synchronous'?"),
        ("scenarios: [easy]\nepisodes: 1.5\n", "episodes: got 1.5, expected a whole number"),
        ("scenarios: []\n", "small.yaml:1:1: scenarios: "),
        ("scenarios: [esay]\n", "did you mean 'easy'"),
        ("scenarios: [easy]\ngrid: {policy.betta: [1]}\n", "betta"),
        ("scenarios: [{scenario: hard, variants: [r9]}]\n", "r5-4"),
        ("scenarios: [easy]\nseeds: {count: 2000000}\n", "seeds.count"),
        ("scenarios: [easy]\nseeds: {count: 900000}\nepisodes: 2\npolicies: [paper, colony]\n", "at most 1000000"),
        ("scenarios: [easy]\npolicies: [clony]\n", "colony"),
        ("- easy\n", "expected fields"),
        ("scenarios: [easy]\ngrid: {policy.beta: [1]}\nsample: {count: 2, ranges: {policy.beta: [1, 2]}}\n", "both"),
    ],
)
def test_a_wrong_file_is_one_message(tmp_path, text, message):
    with pytest.raises(ColonysimError) as refused:
        load_sweep(written(tmp_path, text))
    assert message in str(refused.value)


def test_means_and_intervals_over_seeds(uninterrupted):
    import pyarrow.compute as pc

    _, whole = uninterrupted
    trials, episodes = read_table(whole, "trials"), read_table(whole, "episodes")
    found = summary(trials, episodes, only=(2, 2))
    assert [line["policy.beta"] for line in found] == [2, 4] and {line["finished"] for line in found} == {20}
    steps = [e["steps"] for e in episodes.to_pylist() if e["policy.beta"] == 2 and e["episode"] == 2]
    assert found[0]["steps"] == pytest.approx(sum(steps) / 20)
    assert (found[0]["steps_low"], found[0]["steps_high"]) == bootstrap(steps)
    assert found[0]["steps_low"] < found[0]["steps"] < found[0]["steps_high"]
    few = {count: trials.filter(pc.less(trials["seed"], count)) for count in (1, 3)}
    [three, _] = summary(few[3], episodes, only=(2, 2))
    assert (three["steps_low"], three["steps_high"]) == pytest.approx(student(steps[:3]))
    [one, _] = summary(few[1], episodes, only=(2, 2))
    assert one["steps"] == steps[0] and one["steps_low"] is one["steps_high"] is None
    [together] = summary(trials, episodes, by=["scenario"])
    assert together["trials"] == 40
    with pytest.raises(ColonysimError, match=r"no column 'beta'; expected one of .*policy\.beta"):
        summary(trials, episodes, by=["beta"])


def test_results_on_the_command_line(uninterrupted, tmp_path):
    _, whole = uninterrupted

    def shown(*words: str) -> str:
        answer = CliRunner().invoke(app, ["results", str(whole), *words])
        assert answer.exit_code == 0, answer.output
        return answer.stdout

    assert "policy.beta" in shown() and "20" in shown("--episodes", "2")
    assert {line["policy.beta"] for line in json.loads(shown("--json"))} == {2, 4}
    pytest.importorskip("duckdb")
    assert json.loads(shown("--json", "--sql", "SELECT count(*) AS n FROM episodes")) == [{"n": 80}]
    odd = (
        "SELECT 1.50::DECIMAL(5,2) AS d, DATE '2026-01-02' AS day, 'nan'::DOUBLE AS n, [1.5::DECIMAL(3,1)] AS l,"
        " 12::DECIMAL AS w"
    )
    answered = [{"d": 1.5, "day": "2026-01-02", "n": None, "l": [1.5], "w": 12}]
    assert json.loads(shown("--json", "--sql", odd)) == answered
    for wrong in (
        ["--sql", "SELEC"], ["--sql", f"SELECT * FROM '{whole}/trials.parquet'"], ["--episodes", "x"],
        ["--episodes", "\u00b2"], ["--episodes", "3-1"], ["--episodes", "9" * 5000], ["--episodes", "-"],
        ["--sql", "SELECT 1 AS a, 2 AS a", "--json"], ["--sql", ""],
    ):  # fmt: skip
        answer = CliRunner().invoke(app, ["results", str(whole), *wrong])
        assert answer.exit_code == 2 and answer.stderr.startswith("Error: ") and answer.stderr.count("\n") == 1, wrong
        assert CliRunner().invoke(app, ["results", str(whole), *wrong]).exit_code == 2
    assert CliRunner().invoke(app, ["results", str(tmp_path)]).exit_code == 2


def test_few_seeds_have_wide_intervals_on_the_command_line_too(tmp_path):
    run_sweep(written(tmp_path, "scenarios: [sanity]\nseeds: {count: 1}\nepisodes: 1\n"), tmp_path / "one", workers=1)
    answer = CliRunner().invoke(app, ["results", str(tmp_path / "one")])
    assert answer.exit_code == 0 and "[" not in answer.stdout
    [row] = json.loads(CliRunner().invoke(app, ["results", str(tmp_path / "one"), "--json"]).stdout)
    assert row["steps"] > 0 and row["steps_low"] is None


def test_tables_that_are_not_what_they_should_be_are_told_by_file_and_column(uninterrupted, tmp_path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    from colonysim.sweep.comparing import compare

    _, whole = uninterrupted
    trials, episodes = (pq.read_table(whole / f"{name}.parquet") for name in ("trials", "episodes"))
    for number, (name, table, said) in enumerate([
        ("trials", trials.drop_columns(["status"]), r"trials\.parquet: column 'status' is missing"),
        ("trials", trials.set_column(0, "trial", pa.array(range(len(trials)))), "column 'trial' holds int64"),
        ("trials", trials.append_column("x", pa.array([{"a": 1}] * len(trials))), "column 'x' holds struct"),
        ("episodes", episodes.drop_columns(["steps"]), r"episodes\.parquet: column 'steps' is missing"),
        ("episodes", episodes.slice(1), r"holds 1 episodes of the trial .*tells of 2"),
        ("episodes", episodes.set_column(episodes.column_names.index("success"), "success",
                                         pa.array([float("nan")] * len(episodes))), "column 'success'.*no finite"),
        ("episodes", episodes.set_column(episodes.column_names.index("steps"), "steps",
                                         pa.array([1e308] * len(episodes))), "column 'steps' holds 1e[+]308, expected"),
        ("episodes", episodes.set_column(episodes.column_names.index("seed"), "seed",
                                         pa.array([2**63] * len(episodes), pa.uint64())), "column .seed. holds uint64"),
    ]):  # fmt: skip
        folder = tmp_path / str(number)
        folder.mkdir()
        for each, kept in (("trials", trials), ("episodes", episodes)):
            pq.write_table(table if each == name else kept, folder / f"{each}.parquet")
        for words in (["results"], ["compare", "--by", "source", str(whole)]):
            answer = CliRunner().invoke(app, [*words, str(folder)])
            assert answer.exit_code == 2 and re.search(said, answer.stderr), (said, answer.output)
        with pytest.raises(ColonysimError, match=said):
            compare([folder])
    os.mkfifo(tmp_path / "trials.parquet")
    answer = CliRunner().invoke(app, ["results", str(tmp_path)])
    assert answer.exit_code == 2 and "trials.parquet: is a pipe" in answer.stderr
