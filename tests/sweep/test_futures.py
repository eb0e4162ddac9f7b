"""The futures of a run: what a change at one moment of it makes, as a sweep."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim import Colony, ColonysimError
from colonysim.cli import app
from colonysim.recording import CHECKPOINT
from colonysim.sweep import fork_run
from colonysim.sweep.comparing import compare
from colonysim.sweep.tables import read_tables
from colonysim.trace.reader import Run


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    return colonysim.run("hard", seed=3, episodes=3, out=tmp_path_factory.mktemp("runs") / "run")


def test_the_futures_are_a_sweep_that_can_be_compared(run: Run, tmp_path: Path) -> None:
    words = ["fork", str(run.path), "--at", "12", "--episode", "2", "--set", "policy.beta=0.2", "--seeds", "0-4"]
    done = CliRunner().invoke(app, [*words, "--out", str(tmp_path / "out"), "--workers", "2"])
    assert done.exit_code == 0 and "10 futures succeeded, 0 failed" in done.output
    assert "--by policy.beta" in done.output
    found = {each.measure: each for each in compare([tmp_path / "out"])}
    assert found["steps"].difference > 10 and found["steps"].seeds == 5 and found["steps"].reference is None
    trials, episodes = read_tables(tmp_path / "out")
    assert {row["fork.at"] for row in trials.to_pylist()} == {12.0} and trials["fork.episode"][0].as_py() == 2
    assert sorted({row["episode"] for row in episodes.to_pylist()}) == [2, 3]
    journal = (tmp_path / "out" / "journal.jsonl").read_text()
    assert CliRunner().invoke(app, [*words, "--out", str(tmp_path / "out")]).exit_code == 0
    assert (tmp_path / "out" / "journal.jsonl").read_text() == journal, "nothing is played twice"


def test_a_future_is_what_a_fork_of_the_colony_does(run: Run, tmp_path: Path) -> None:
    fork_run(run.path, tmp_path / "out", at=12.0, episode=2, overrides=["policy.beta=2.0"], seeds=[7], workers=1)  # type: ignore[arg-type]
    colony = Colony("hard", seed=3, episodes=3)
    colony.run_until(episode=1)
    colony.run_until(time=12.0)
    rows = read_tables(tmp_path / "out")[1].to_pylist()
    for beta, overrides in ((None, {}), (2.0, {"policy.beta": 2.0})):
        ends = [event for event in colony.fork(7, overrides=overrides) if event.kind == "episode"]
        told = [(row["episode"], row["sim_seconds"], row["ended"]) for row in rows if row["policy.beta"] == beta]
        assert told == [(event.episode, event.time, event.status) for event in ends]


def test_from_a_checkpoint_it_is_the_same(run: Run, tmp_path: Path) -> None:
    def stop(event: Any, under_way: Run) -> None:
        time.sleep(2e-4)
        if event.episode == 2 and event.time > 10.0:
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError):
        colonysim.run("hard", seed=3, episodes=3, out=tmp_path / "run", on_event=stop, checkpoint_every=0.01)
    assert (tmp_path / "run" / CHECKPOINT).exists()
    hashes = []
    for number, path in enumerate((run.path, tmp_path / "run")):
        fork_run(path, tmp_path / str(number), at=12.0, episode=2, seeds=[1, 2], workers=1)  # type: ignore[arg-type]
        hashes.append(read_tables(tmp_path / str(number))[0]["trace_sha256"].to_pylist())
    assert hashes[0] == hashes[1] and len(set(hashes[0])) == 2


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"at": 500.0}, "episode 1 ended at .* s, before 500 s"),
        ({"at": -1.0}, "at: -1"),
        ({"at": 5.0, "episode": 4}, "episode: 4"),
        ({"at": 5.0, "seeds": []}, "at least one"),
        ({"at": 5.0, "overrides": {"goal": 3}}, "cannot change under way"),
        ({"at": 5.0, "overrides": {"episodes": 3}}, "give it as episodes="),
        ({"at": 5.0, "episodes": 1, "episode": 2}, "episodes: 1"),
    ],
)
def test_what_cannot_be(asked: dict[str, Any], words: str, run: Run, tmp_path: Path) -> None:
    with pytest.raises(ColonysimError, match=words):
        fork_run(run.path, tmp_path / "out", **asked)  # type: ignore[arg-type]
    assert not (tmp_path / "out").exists()


def test_a_run_that_goes_otherwise_is_told(run: Run, tmp_path: Path) -> None:
    other = colonysim.run("hard", seed=3, episodes=3, out=tmp_path / "run")
    manifest = tmp_path / "run" / "manifest.json"
    manifest.write_text(json.dumps({**other.manifest, "seed": 4}))
    with pytest.raises(ColonysimError, match="gone through again, episode 1 is another than was recorded"):
        fork_run(tmp_path / "run", tmp_path / "out", at=12.0)


def test_groups_are_told_apart(tmp_path: Path) -> None:
    groups = [{"name": "few", "agents": {"count": 1, "seed": 1}}, {"name": "many", "agents": {"count": 3, "seed": 2}}]
    scenario = colonysim.load_scenario("hard", overrides={"agents": None, "groups": groups})
    run = colonysim.run(scenario, seed=3, episodes=1, out=tmp_path / "run")
    fork_run(run.path, tmp_path / "out", at=5.0, overrides=["policy.beta=0.2"], seeds=[0, 1], workers=1)  # type: ignore[arg-type]
    found = compare([tmp_path / "out"], by_group=True)
    assert {each.where["group"] for each in found} == {"few", "many"}


def test_futures_of_another_moment_are_left_alone(run: Run, tmp_path: Path) -> None:
    fork_run(run.path, tmp_path / "out", at=12.0, seeds=[0], workers=1)  # type: ignore[arg-type]
    journal = (tmp_path / "out" / "journal.jsonl").read_bytes()
    with pytest.raises(ColonysimError, match="holds trials of another sweep, or of another moment"):
        fork_run(run.path, tmp_path / "out", at=13.0, seeds=[0], workers=1)  # type: ignore[arg-type]
    assert (tmp_path / "out" / "journal.jsonl").read_bytes() == journal
