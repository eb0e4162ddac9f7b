"""What of a run is kept: by name, or by the size of its world; and that whoever needs more is told so by name."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.errors import ColonysimError, TraceError
from colonysim.scenario.invent import invent
from colonysim.scenario.loading import load_scenario, scenario_from_document
from colonysim.trace import kept
from colonysim.trace.kept import asked_for, by_size
from colonysim.trace.reader import Run
from colonysim.trace.schema import TABLES


def cli(*words: object) -> Any:
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.mark.parametrize(
    ("asked", "tables", "last"),
    [
        ("events", "events episodes", False),
        ("", "events episodes", False),
        ("frames, deposits", "events deposits frames episodes", False),
        (["last-frames", "poses"], "events poses frames episodes", True),
        (("events", "decisions", "deposits", "poses", "controls", "frames", "episodes"), " ".join(TABLES), False),
    ],
)
def test_what_is_asked_for_is_kept_and_what_always_is(asked: Any, tables: str, last: bool) -> None:
    if asked == "":
        with pytest.raises(ColonysimError, match="record: '' is nothing"):
            asked_for(asked)
        return
    found = asked_for(asked)
    assert {*found.tables} == {*tables.split(), "measurements"} and found.last_frames == last and not found.thinned
    assert {*found.dropped} == {*TABLES} - {*found.tables}


@pytest.mark.parametrize(
    ("asked", "said"),
    [("event", "did you mean 'events'"), ("frames,last-frames", "leave out one of them"), (3, "expected names"),
     ([3], "3 is nothing that a run keeps"), ("deposits,,frames", "'' is nothing")],
)  # fmt: skip
def test_what_cannot_be_asked_for_is_answered_before_anything_is_made(asked: Any, said: str, tmp_path: Path) -> None:
    with pytest.raises(ColonysimError, match=said):
        colonysim.run("sanity", episodes=1, out=tmp_path / "run", record=asked)
    assert not (tmp_path / "run").exists()


def test_all_maps_that_are_shipped_and_those_of_the_bench_record_everything() -> None:
    from colonysim.bench import CASES

    for name in ("sanity", "easy", "medium", "hard", "junction", "deadlock"):
        assert not by_size(load_scenario(name), 1000).thinned
    for name in ("traced", "steps-1000", "steps-100000"):
        assert not by_size(CASES[name].make(), CASES[name].episodes).thinned
    # A bound on steps that nobody comes near does not count.
    assert not by_size(load_scenario("hard", overrides=["max_steps=1000000"]), 30).thinned


def test_of_a_large_world_deposits_are_left_out_and_frames_thinned() -> None:
    document = invent("grid", columns=130, rows=130, agents=200, holes=500, spare=500, seed=1)
    found = by_size(scenario_from_document(document), 2)
    assert found.dropped == ("deposits",) and found.last_frames and found.thinned
    assert "deposits (82 million rows expected) are left out" in found.why and "last episode only" in found.why
    assert found.document()["frames"] == "last"
    huge = invent("grid", columns=300, rows=300, agents=2000, holes=1000, seed=1)
    assert {*by_size(scenario_from_document(huge), 6).dropped} == {"decisions", "deposits", "frames"}


def test_the_hash_is_over_what_is_recorded(tmp_path: Path) -> None:
    everything = colonysim.run("hard", seed=10, episodes=2, trace=False)
    named = colonysim.run("hard", seed=10, episodes=2, trace=False, record=[*TABLES])
    assert everything.trace_sha256 == named.trace_sha256
    hashes = {everything.trace_sha256}
    for i, record in enumerate(("events", "events,deposits", "deposits,frames", "deposits,last-frames")):
        run = colonysim.run("hard", seed=10, episodes=2, out=tmp_path / str(i), record=record)
        assert run.trace_sha256 == colonysim.run("hard", seed=10, episodes=2, trace=False, record=record).trace_sha256
        assert run.trace_sha256 not in hashes and Run.open(tmp_path / str(i)).verify()
        hashes.add(run.trace_sha256)
        assert {path.name for path in (tmp_path / str(i)).iterdir()} == {
            "manifest.json", *(table for table in asked_for(record).tables if table != "measurements")
        }  # fmt: skip
        assert run.episodes[0][:6] == everything.episodes[0][:6], "what is recorded changes nothing"


def test_readers_say_by_name_what_was_not_recorded(tmp_path: Path) -> None:
    run = colonysim.run("hard", seed=10, episodes=3, out=tmp_path / "run", record="last-frames")
    opened = Run.open(tmp_path / "run")
    assert opened.frames() == opened.frames(3) != [] and opened.field("D", 3)
    with pytest.raises(TraceError, match=r"no frames of episode 1: it was recorded with --record events,last-frames$"):
        opened.field("D", 1)
    with pytest.raises(TraceError, match=r"no deposits: it was recorded with --record events,last-frames$"):
        opened.table("deposits")
    with pytest.raises(TraceError, match="no deposits"):
        list(opened.batches("deposits"))
    opened.check_places()
    for words, said in (
        (("export", run.path, "deposits"), "no deposits"),
        (("export", run.path, "frames", "--episodes", "1"), "no frames of episode 1"),
        (("plot", run.path, "--what", "D", "--episodes", "1", "-o", tmp_path / "plots"), "no frames of episode 1"),
        (("run", "hard", "--from", tmp_path / "bare", "--no-trace"), "no frames"),
    ):
        if "--from" in words:
            colonysim.run("hard", seed=10, episodes=1, out=tmp_path / "bare", record="events")
        done = cli(*words)
        assert done.exit_code == 2 and f"{said}: it was recorded with --record events" in done.output, done.output
    # The last one's are there to go on with, and to be drawn.
    colonysim.run("hard", seed=1, episodes=1, initial=opened, trace=False)
    done = cli("plot", run.path, "--what", "D", "-o", tmp_path / "plots")
    assert done.exit_code == 0 and (tmp_path / "plots/D.png").exists()


def test_what_was_not_recorded_is_left_out_of_the_plots_and_named(tmp_path: Path) -> None:
    colonysim.run("sanity", episodes=1, out=tmp_path / "run", record="events")
    done = cli("plot", tmp_path / "run", "-o", tmp_path / "plots")
    assert done.exit_code == 0, done.output
    assert "this run has no frames: it was recorded with --record events" in done.output
    assert {path.stem for path in (tmp_path / "plots").iterdir()} == {
        "map", "trajectories", "episodes", "waiting", "workload", "fates"
    }  # fmt: skip


def test_a_film_without_poses_says_that_there_are_none(tmp_path: Path) -> None:
    pytest.importorskip("av", reason="PyAV is not installed")
    colonysim.run("sanity", episodes=1, out=tmp_path / "run", record="events")
    done = cli("video", tmp_path / "run", tmp_path / "film.gif", "--seconds", "1")
    assert done.exit_code == 0 and (tmp_path / "film.gif").exists(), done.output
    assert "this run has no poses: it was recorded with --record events" in done.output


def test_an_interrupted_run_with_the_last_frames_only_says_that_it_has_none(tmp_path: Path) -> None:
    def stop(event: Any, run: Any) -> None:
        if event.episode == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        colonysim.run("sanity", episodes=5, out=tmp_path / "run", record="last-frames", on_event=stop)
    run = Run.open(tmp_path / "run")
    assert run.verify()
    with pytest.raises(TraceError, match="no frames of episode 2: it was recorded with --record events,last-frames"):
        run.frames()


def test_a_large_run_says_in_one_line_what_it_leaves_out_and_keeps_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kept, "MOST_ROWS", {"decisions": 1e9, "deposits": 50, "frames": 50})
    done = cli("run", "sanity", "-n", 2, "-o", tmp_path / "run")
    told = [line for line in done.output.splitlines() if "--record" in line]
    assert done.exit_code == 0 and len(told) == 1 and "deposits" in told[0] and "last episode only" in told[0]
    manifest = json.loads((tmp_path / "run/manifest.json").read_text())
    assert manifest["recorded"]["frames"] == "last" and "deposits" not in manifest["recorded"]["tables"]
    assert manifest["recorded"]["why"].startswith("by default, for its size: deposits")
    run = Run.open(tmp_path / "run")
    with pytest.raises(TraceError, match=r"no deposits: .*\(by default, for its size: deposits"):
        run.table("deposits")
    assert {*run.table("frames")["episode"].to_pylist()} == {2} and run.verify()
    everything = ("run", "sanity", "-n", 2, "--record", "decisions,deposits,frames", "-o", tmp_path / "all")
    assert "for its size" not in cli(*everything).output and Run.open(tmp_path / "all").field("D", 1)
    assert "--record" not in cli("run", "sanity", "-n", 2, "-q", "-o", tmp_path / "quiet").output
    assert "--record" not in cli("run", "sanity", "-n", 2, "--no-trace").output


def test_the_old_ways_to_leave_out_decisions_still_do_and_say_what_replaces_them(tmp_path: Path) -> None:
    done = cli("run", "sanity", "-n", 1, "--no-decisions", "-o", tmp_path / "old")
    assert done.exit_code == 0 and "--record" in done.output
    with pytest.warns(DeprecationWarning, match="record="):
        run = colonysim.run("sanity", episodes=1, decisions=False, trace=False)
    assert Run.open(tmp_path / "old").trace_sha256 == run.trace_sha256
    assert "decisions" not in run.manifest["recorded"]["tables"]
    with pytest.raises(ColonysimError, match="leave out decisions"):
        colonysim.run("sanity", episodes=1, decisions=False, record="events", trace=False)
    done = cli("run", "sanity", "--no-decisions", "--record", "events", "--no-trace")
    assert done.exit_code == 2 and "leave out --no-decisions" in done.output
    # A run of a version that knew of nothing else.
    file = tmp_path / "old/manifest.json"
    stored = json.loads(file.read_text())
    del stored["recorded"]
    file.write_text(json.dumps(stored))
    with pytest.raises(TraceError, match="no decisions: it was recorded with --no-decisions"):
        Run.open(tmp_path / "old").table("decisions")


@pytest.mark.parametrize(
    ("change", "said"),
    [({"tables": ["events", "evnts"]}, r"recorded\.tables\.1: is 'evnts'"), ({"tables": ["frames"]}, "among them"),
     ({"frames": "some"}, r"recorded\.frames: is 'some'"), ({"why": 3}, r"recorded\.why: is 3")],
)  # fmt: skip
def test_a_manifest_that_says_of_it_what_cannot_be_is_refused(
    change: dict[str, Any], said: str, tmp_path: Path
) -> None:
    colonysim.run("sanity", episodes=1, out=tmp_path / "run")
    file = tmp_path / "run/manifest.json"
    stored = json.loads(file.read_text())
    stored["recorded"] |= change
    file.write_text(json.dumps(stored))
    with pytest.raises(TraceError, match=rf"manifest\.json: {said}|{said}"):
        Run.open(tmp_path / "run")
