from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from recorded_runs import manifest, record, rows

from colonysim.errors import TraceError
from colonysim.trace.packing import TableDigest, trace_sha256
from colonysim.trace.reader import Run
from colonysim.trace.schema import TABLES, EpisodeResult, Event, Frame
from colonysim.trace.writer import TraceWriter


def test_the_hash_knows_nothing_of_parts_or_disk(tmp_path: Path) -> None:
    made = rows()
    expected = record(None, made).finish("finished")
    for i, size in enumerate((1, 7, 40, 100_000)):
        path = tmp_path / str(i)
        assert record(path, made, rows_per_part=size, flush_seconds=0.0).finish("finished") == expected
        assert Run.open(path).trace_sha256 == expected


@given(st.lists(st.integers(1, 50), max_size=8))
def test_the_hash_is_the_same_for_every_way_to_cut_the_rows(cuts: list[int]) -> None:
    events = [row for table, row in rows() if table == "events"]
    whole, parts = TableDigest("events"), TableDigest("events")
    whole.add(events)
    begin = 0
    for cut in [*cuts, len(events)]:
        parts.add(events[begin : begin + cut])
        begin += cut
    assert trace_sha256([whole]) == trace_sha256([parts])


def test_every_value_counts_but_the_wall_clock() -> None:
    made = rows(2, 10)
    before = record(None, made).finish("finished")
    seen = {before}
    for table in ("events", "decisions", "deposits", "frames", "episodes"):
        at = next(i for i, (name, _) in enumerate(made) if name == table)
        for column, (name, kind) in enumerate(TABLES[table].items()):
            row = list(made[at][1])
            row[column] = {
                "int": 77, "float": 0.123, "text": "other", "bool": not row[column],
                "ints": (7, 7, 7), "floats": (0.5, 0.5),
            }[kind]  # fmt: skip
            changed = [*made[:at], (table, tuple(row)), *made[at + 1 :]]
            after = record(None, changed).finish("finished")
            if name == "wall_seconds":
                assert after == before
            else:
                assert after not in seen, (table, name)
                seen.add(after)


def test_order_and_list_boundaries_count() -> None:
    def digest(*boxes: tuple[int, ...]) -> str:
        writer = TraceWriter(None, manifest())
        for box in boxes:
            writer.write("decisions", (1, 0.0, 0, 0, False, 0, box, (), ()))
        return writer.finish("finished")

    assert len({digest((1, 2), (3,)), digest((1,), (2, 3)), digest((3,), (1, 2))}) == 3


def test_a_known_trace_keeps_its_hash() -> None:
    # A change here makes every stored hash worthless: raise schema.VERSION with it.
    digest = TableDigest("frames")
    digest.add([(1, "D", 3, -1, 0.5), (1, "ü", 4, 7, -0.0)])
    assert trace_sha256([digest])[:8] == "eb75f090"


def test_text_may_be_anything_and_comes_back(tmp_path: Path) -> None:
    made = [("events", Event(1, 0.0, text, reason=text)) for text in ("", "ü\n", "a,b", "\0", "🐜")]
    record(tmp_path / "run", made, rows_per_part=2).finish("finished")
    assert [event.kind for event in Run.open(tmp_path / "run").events()] == [row[1][2] for row in made]


def test_a_row_that_does_not_fit_is_refused() -> None:
    for row, error in [((1, 0.5), ValueError), ((1, "late", 0, "script", "travel", 50), TypeError),
                       ((1.5, 0.5, 0, "script", "travel", 50), TypeError)]:  # fmt: skip
        writer = TraceWriter(None, manifest())
        with pytest.raises(error, match="controls"):  # at once, or when rows become columns
            writer.write("controls", row)
            writer.flush()


def test_dropped_tables_leave_nothing(tmp_path: Path) -> None:
    made = rows()
    record(tmp_path / "run", made, drop=("decisions",)).finish("finished")
    run = Run.open(tmp_path / "run")
    assert not (tmp_path / "run" / "decisions").exists()
    assert run.table("decisions").num_rows == 0
    assert "decisions" not in run.manifest["rows"]
    assert run.verify()


def test_the_end_is_written_down(tmp_path: Path) -> None:
    for error, status in ((None, "finished"), (KeyboardInterrupt, "interrupted"), (ValueError, "failed")):
        path = tmp_path / status
        path.mkdir()
        try:
            with TraceWriter(path, manifest()) as writer:
                writer.write("episodes", EpisodeResult(1, 2, 1.0, "goal", 3.0, 0, 0.1))
                if error:
                    raise error
        except (KeyboardInterrupt, ValueError):
            pass
        run = Run.open(path)
        assert run.status == status and len(run.episodes) == 1 and run.verify()
        with pytest.raises(TraceError, match="finished already"):
            writer.finish("finished")


def test_no_place_to_write_is_a_message(tmp_path: Path) -> None:
    path = tmp_path / "run"
    path.mkdir()
    writer = TraceWriter(path, manifest())
    (path / "events").write_text("in the way")
    writer.write("events", Event(1, 0.0, "start"))
    with pytest.raises(TraceError, match="events"):
        writer.finish("finished")


def test_a_killed_run_is_readable(tmp_path: Path) -> None:
    path = tmp_path / "run"
    path.mkdir()
    program = (
        "import sys, time; from pathlib import Path; from recorded_runs import manifest, rows;"
        "from colonysim.trace.writer import TraceWriter;"
        "w = TraceWriter(Path(sys.argv[1]), manifest(episodes=200), rows_per_part=50, flush_seconds=0.0);"
        "made = rows(200);"
        "say = lambda t: t == 'episodes' and (print('.', flush=True), time.sleep(0.05));"
        "[w.write(t, r) or say(t) for t, r in made]"
    )
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])}
    process = subprocess.Popen(
        [sys.executable, "-c", program, str(path)], stdout=subprocess.PIPE, env=environment
    )
    assert process.stdout is not None
    for _ in range(12):
        process.stdout.readline()
    process.send_signal(signal.SIGKILL)
    process.wait()
    run = Run.open(path)
    assert run.status == "running" and run.trace_sha256 is None
    assert len(run.episodes) >= 6
    assert sum(1 for _ in run.events()) >= 6 * 40
    assert run.field("D", episode=2)[4] == 2.0


def test_an_episode_that_is_listed_is_there_as_a_whole_however_fast_they_come(tmp_path: Path) -> None:
    writer = TraceWriter(tmp_path, manifest(episodes=16), rows_per_part=8, flush_seconds=1e9)
    writer.write("events", Event(1, 0.0, "start", 1))  # or every part would end with an episode
    for number in range(1, 17):
        writer.write("events", Event(number, 0.0, "start"))
        writer.write("events", Event(number, 1.0, "goal"))
        writer.write("frames", Frame(number, "D", 0, -1, 2.0))
        writer.write("episodes", EpisodeResult(number, 1, 1.0, "goal", 1.0, 0, 0.0))
    killed = Run.open(tmp_path)
    last = killed.episodes[-1].episode
    assert last == 16
    assert [event.kind for event in killed.events(last)] == ["start", "goal"]
    assert killed.field("D", episode=last)


def test_the_hash_is_the_same_for_every_hash_seed(tmp_path: Path) -> None:
    program = "from recorded_runs import *; print(record(None, rows(2, 5)).finish('finished'))"
    found = set()
    for seed in ("0", "1"):
        environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[1]), "PYTHONHASHSEED": seed}
        found.add(subprocess.check_output([sys.executable, "-c", program], env=environment))
    assert len(found) == 1


def test_the_manifest_is_plain_json(tmp_path: Path) -> None:
    record(tmp_path / "run", rows()).finish("finished")
    stored = json.loads((tmp_path / "run" / "manifest.json").read_text())
    assert stored["rows"]["events"] == 120
    assert random.Random(stored["trace_sha256"])  # a plain string
    assert not list((tmp_path / "run").rglob("*.tmp"))


@pytest.mark.parametrize("at", ["hash", "add", "close"])
def test_ctrl_c_waits_until_rows_are_hashed_and_written(
    at: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import colonysim.trace.writer as module

    owner, name = (module.TableDigest, "add") if at == "hash" else (module.PartFile, at)
    original = getattr(owner, name)

    def interrupted(*args: object) -> object:
        os.kill(os.getpid(), signal.SIGINT)
        monkeypatch.setattr(owner, name, original)
        return original(*args)

    path = tmp_path / "run"
    path.mkdir()
    made = rows()
    with pytest.raises(KeyboardInterrupt), TraceWriter(path, manifest(), rows_per_part=30) as writer:
        monkeypatch.setattr(owner, name, interrupted)
        for table, row in made:
            writer.write(table, row)
    run = Run.open(path)
    assert run.status == "interrupted" and run.verify()
    assert 30 <= run.table("events").num_rows <= 120
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_what_a_signal_does_is_done_after_the_last_write_and_an_ignored_one_does_nothing(
    number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import colonysim.trace.writer as module

    original = module.finish_manifest

    def impatient(*args: object) -> None:
        for _ in range(3):
            os.kill(os.getpid(), number)
        original(*args)

    def stop(number: int, frame: object) -> None:
        raise KeyboardInterrupt(number)

    monkeypatch.setattr(module, "finish_manifest", impatient)
    before = signal.getsignal(number)
    try:
        for handler in (stop, signal.SIG_IGN):
            signal.signal(number, handler)
            path = tmp_path / str(handler == stop)
            path.mkdir()
            writer = TraceWriter(path, manifest())
            if handler is stop:
                with pytest.raises(KeyboardInterrupt, match=str(int(number))):
                    writer.finish("finished")
            else:
                writer.finish("finished")
            assert Run.open(path).status == "finished" and signal.getsignal(number) is handler
    finally:
        signal.signal(number, before)
