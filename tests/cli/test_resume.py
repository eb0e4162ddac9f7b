"""A run that was killed goes on: the same hash, every row once."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim import ColonysimError
from colonysim.cli import app
from colonysim.engines import PACKAGES
from colonysim.physics import engine_trouble
from colonysim.recording import CHECKPOINT
from colonysim.trace.reader import Run
from colonysim.trace.schema import TABLES

LONG = ["hard", "--episodes", "80", "--seed", "3", "--quiet"]


def command(*words: object) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "colonysim", *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip


def killed(seconds: float, path: Path, *words: object) -> bool:
    """Starts a command, kills it that long after there is a manifest; whether it was still under way."""
    process = command(*words)
    while not (path / "manifest.json").exists() and process.poll() is None:
        time.sleep(0.005)
    time.sleep(seconds)
    under_way = process.poll() is None
    process.send_signal(signal.SIGKILL)
    process.communicate()
    return under_way


def rows(run: Run) -> dict[str, Any]:
    """All rows, without wall clock."""
    found = {}
    for table in TABLES:
        columns = run.table(table).to_pydict()
        columns.pop("wall_seconds", None)
        found[table] = columns
    return found


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Run:
    path = tmp_path_factory.mktemp("whole") / "run"
    assert CliRunner().invoke(app, ["run", *LONG, "--out", str(path)]).exit_code == 0
    return Run.open(path)


def check_kills(folder: Path, whole: Run, count: int, seed: int, words: list[str]) -> None:
    """So many kills at random moments, of runs and of resumed runs; each run comes to the same in the end."""
    rng, kills, path, resumed = random.Random(seed), 0, folder / "run", 0
    # To begin takes a process longer than to run, and checkpoints take time: some kills come too early or too late.
    span = 1.0 + 3.0 * sum(episode.wall_seconds for episode in whole.episodes)
    while kills < count or not resumed:
        every = rng.choice(("0.02s", "0.05s", "0.1s"))
        kills += killed(rng.uniform(0.0, span), path, "run", *words, "--checkpoint-every", every, "--out", path)
        while rng.random() < 0.5 and kills < count:
            kills += killed(rng.uniform(0.0, span), path, "resume", path, "--quiet")
        resumed += (path / CHECKPOINT).exists()
        done = command("resume", path, "--json", "--quiet")
        out, error = done.communicate()
        assert done.returncode == 0, error
        assert json.loads(out)["trace_sha256"] == whole.trace_sha256, kills
        run = Run.open(path)
        assert run.status == "finished" and run.verify() and run.manifest["rows"] == whole.manifest["rows"]
        assert rows(run) == rows(whole)
        assert not (path / CHECKPOINT).exists() and not [*path.rglob("*.tmp")] and not (path / ".lock").exists()
        shutil.rmtree(path)


def test_killed_and_resumed_it_comes_to_the_same(tmp_path: Path, whole: Run) -> None:
    check_kills(tmp_path, whole, 3, 1, LONG)


@pytest.mark.slow
def test_killed_and_resumed_it_comes_to_the_same_30_times(tmp_path: Path, whole: Run) -> None:
    check_kills(tmp_path, whole, 30, 2, LONG)


@pytest.mark.slow
@pytest.mark.parametrize("engine", PACKAGES)
def test_bodies_are_killed_and_resumed(engine: str, tmp_path: Path) -> None:
    if trouble := engine_trouble(engine):
        pytest.skip(trouble)
    words = ["sanity", "--episodes", "4", "--seed", "1", "--quiet", "--backend", engine, "--push", "scripted"]
    assert CliRunner().invoke(app, ["run", *words, "--out", str(tmp_path / "whole")]).exit_code == 0
    check_kills(tmp_path, Run.open(tmp_path / "whole"), 6, 3, words)


def stopped_at(path: Path, number: int, **more: Any) -> None:
    """A run that is stopped by an error at an event; if it makes checkpoints every .01 s, there is one halfway."""
    count = 0

    def stop(event: Any, run: Run) -> None:
        nonlocal count
        count += 1
        if count == number // 2:
            time.sleep(0.02)  # so that a checkpoint is due
        if count == number:
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        colonysim.run("hard", out=path, seed=2, episodes=3, on_event=stop, **more)


def test_one_that_failed_goes_on_from_python(tmp_path: Path) -> None:
    whole = colonysim.run("hard", out=tmp_path / "whole", seed=2, episodes=3)
    stopped_at(tmp_path / "run", 200, checkpoint_every=0.01)
    assert Run.open(tmp_path / "run").status == "failed" and (tmp_path / "run" / CHECKPOINT).exists()
    events: list[Any] = []
    run = colonysim.resume(tmp_path / "run", on_event=lambda event, run: events.append(event))
    assert run.trace_sha256 == whole.trace_sha256 and run.verify()
    assert 0 < len(events) < whole.manifest["rows"]["events"]
    assert run.manifest["resumed"][0]["from"] == CHECKPOINT and "resumed" not in whole.manifest
    assert colonysim.resume(tmp_path / "run").manifest == Run.open(tmp_path / "run").manifest, "it is left as it is"


def test_one_without_checkpoints_begins_anew(tmp_path: Path) -> None:
    asked = {"policy": "paper", "record": "events,last-frames"}
    whole = colonysim.run("hard", out=tmp_path / "whole", seed=2, episodes=3, **asked)  # type: ignore[arg-type]
    stopped_at(tmp_path / "run", 200, **asked)
    run = colonysim.resume(tmp_path / "run")
    assert run.trace_sha256 == whole.trace_sha256 and run.verify()


def test_what_was_measured_is_measured_again(tmp_path: Path) -> None:
    def measured(colony: Any) -> None:
        colony.measure("there", lambda held: float((held.agents.status == "goal").sum()), every=2.0)

    whole = colonysim.run("hard", out=tmp_path / "whole", seed=2, episodes=3, on_begin=measured)
    stopped_at(tmp_path / "run", 200, checkpoint_every=0.01, on_begin=measured)
    before = (tmp_path / "run" / "manifest.json").read_text()
    with pytest.raises(ColonysimError, match=r"this run measured there, and is now to measure nothing.*on_begin="):
        colonysim.resume(tmp_path / "run")
    assert json.loads(before)["measured"] == ["there"]
    assert colonysim.resume(tmp_path / "run", on_begin=measured).trace_sha256 == whole.trace_sha256


def test_one_under_way_is_left_alone(tmp_path: Path) -> None:
    def resume(event: Any, run: Run) -> None:
        code = f"import colonysim; colonysim.resume({str(tmp_path / 'run')!r})"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
        assert done.returncode and "another process is recording this run" in done.stderr
        raise RuntimeError("seen")

    with pytest.raises(RuntimeError, match="seen"):
        colonysim.run("hard", out=tmp_path / "run", on_event=resume)


def test_what_cannot_be_gone_on_with(tmp_path: Path) -> None:
    with pytest.raises(ColonysimError, match="no such run directory"):
        colonysim.resume(tmp_path / "absent")
    assert not (tmp_path / "absent").exists()
    stopped_at(tmp_path / "run", 200, checkpoint_every=0.01)
    manifest = tmp_path / "run" / "manifest.json"
    about = json.loads(manifest.read_text())
    older = {**about, "versions": {**about["versions"], "colonysim": "0.0.9"}}
    manifest.write_text(json.dumps(older))
    with pytest.raises(ColonysimError, match=r"recorded with colonysim 0\.0\.9"):
        colonysim.resume(tmp_path / "run")
    for change in ({"started": "2001-01-01T00:00:00+00:00"}, {"scenario_sha256": "0" * 64}):
        manifest.write_text(json.dumps({**about, **change}))
        with pytest.raises(ColonysimError, match="is no checkpoint of this run"):
            colonysim.resume(tmp_path / "run")
    manifest.write_text(json.dumps(about))
    (tmp_path / "run" / CHECKPOINT).write_bytes(b"PK")
    with pytest.raises(ColonysimError, match=r"checkpoint\.npz: damaged"):
        colonysim.resume(tmp_path / "run")


def test_rows_that_the_checkpoint_counts_must_be_there(tmp_path: Path) -> None:
    stopped_at(tmp_path / "run", 200, checkpoint_every=0.01)
    parts = sorted((tmp_path / "run" / "events").glob("part-*"))
    parts[0].unlink()
    kept = [*(tmp_path / "run" / "events").iterdir()]
    with pytest.raises(ColonysimError, match="is missing"):
        colonysim.resume(tmp_path / "run")
    assert [*(tmp_path / "run" / "events").iterdir()] == kept


def test_code_of_others_is_given_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "others.py").write_text(
        "from colonysim.policies.uniform import Uniform\n\n\nclass Others(Uniform):\n    name = 'others'\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    for asked in ({"checkpoint_every": 0.01}, {}):
        path = tmp_path / f"run{len(asked)}"
        name = "others:Others"
        whole = colonysim.run("hard", seed=2, episodes=3, policy=name, trace=False)

        def stop(event: Any, run: Run) -> None:
            time.sleep(2e-4)
            if event.episode == 2:
                raise RuntimeError("stop")

        with pytest.raises(RuntimeError):
            colonysim.run("hard", out=path, seed=2, episodes=3, policy=name, on_event=stop, **asked)  # type: ignore[arg-type]
        about = json.loads((path / "manifest.json").read_text())
        assert about["policy"] == "others"
        with pytest.raises(ColonysimError, match="is code of others"):
            colonysim.resume(path)
        assert json.loads((path / "manifest.json").read_text()) == about
        assert colonysim.resume(path, policy=name).trace_sha256 == whole.trace_sha256
    monkeypatch.undo()


@pytest.mark.parametrize("text", ["0s", "often", "-1", "1d", "s"])
def test_what_is_no_time(text: str, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["run", "hard", "--checkpoint-every", text, "--out", str(tmp_path / "run")])
    assert done.exit_code == 2 and "expected a time such as 60s" in done.output and not (tmp_path / "run").exists()


def test_the_command_line_says_when_there_is_nothing_to_do(tmp_path: Path) -> None:
    path = str(tmp_path / "run")
    assert CliRunner().invoke(app, ["run", "sanity", "-n", "1", "--out", path, "--quiet"]).exit_code == 0
    done = CliRunner().invoke(app, ["resume", path])
    assert done.exit_code == 0 and "finished already" in done.output


@pytest.mark.parametrize("checkpoint", [None, 0.01])
def test_it_goes_on_with_its_own_policy_and_backend_only(tmp_path: Path, checkpoint: float | None) -> None:
    stopped_at(tmp_path / "run", 200, checkpoint_every=checkpoint)
    before = (tmp_path / "run" / "manifest.json").read_bytes()
    for other in ({"policy": "paper"}, {"policy": "random"}, {"backend": "mock"}):
        with pytest.raises(ColonysimError, match="and cannot go on with"):
            colonysim.resume(tmp_path / "run", **other)  # type: ignore[arg-type]
    assert (tmp_path / "run" / "manifest.json").read_bytes() == before
    whole = colonysim.run("hard", out=tmp_path / "whole", seed=2, episodes=3)
    again = colonysim.resume(tmp_path / "run", policy="colony", backend="nodeworld")
    assert again.trace_sha256 == whole.trace_sha256


def test_the_run_that_it_started_from_must_still_be_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = colonysim.run("hard", out=tmp_path / "first", seed=1, episodes=1)
    monkeypatch.chdir(tmp_path)
    whole = colonysim.run("hard", out="whole", seed=2, episodes=3, initial="first")
    stopped_at(tmp_path / "run", 200, initial="first")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    shutil.move(tmp_path / "first", tmp_path / "kept")
    colonysim.run("hard", out=tmp_path / "first", seed=7, episodes=1)
    with pytest.raises(ColonysimError, match="is not the run any more whose pheromones"):
        colonysim.resume(tmp_path / "run")
    shutil.rmtree(tmp_path / "first")
    shutil.move(tmp_path / "kept", tmp_path / "first")
    assert first.trace_sha256 != whole.trace_sha256
    assert colonysim.resume(tmp_path / "run").trace_sha256 == whole.trace_sha256
