from __future__ import annotations

import io
import json
import os
import shutil
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from recorded_runs import manifest, record, rows

import colonysim
from colonysim.errors import TraceError
from colonysim.trace.manifest import prepare_directory
from colonysim.trace.reader import Run


@pytest.fixture
def path(tmp_path: Path) -> Path:
    record(tmp_path / "run", rows(), rows_per_part=25).finish("finished")
    return tmp_path / "run"


def test_rows_come_back_as_they_were(path: Path) -> None:
    run = Run.open(path)
    made = rows()
    assert list(run.events()) == [row for table, row in made if table == "events"]
    assert list(run.events(episode=2)) == [r for t, r in made if t == "events" and r[0] == 2]
    assert run.episodes == [row for table, row in made if table == "episodes"]
    decisions = [tuple(row.values()) for row in run.table("decisions").to_pylist()]
    wanted = [tuple(list(v) if isinstance(v, tuple) else v for v in r) for t, r in made if t == "decisions"]
    assert decisions == wanted


def test_fields_are_looked_up_by_episode(path: Path) -> None:
    run = Run.open(path)
    assert run.field("D", episode=2) == {node: node / 2 for node in range(7)}
    assert run.field("D") == run.field("D", episode=3)
    assert run.field("H")[6, 3] == 3.0
    with pytest.raises(TraceError, match="fields: D, H"):
        run.field("X")
    with pytest.raises(TraceError, match="it has 1 to 3"):
        run.field("D", episode=9)


def test_what_is_no_run_is_said_so(tmp_path: Path, path: Path) -> None:
    (tmp_path / "foreign").mkdir()
    (tmp_path / "file").write_text("")
    with pytest.raises(TraceError, match="no such run directory"):
        Run.open(tmp_path / "nowhere")
    with pytest.raises(TraceError, match="is a file"):
        Run.open(tmp_path / "file")
    with pytest.raises(TraceError, match="not a run directory"):
        Run.open(tmp_path / "foreign")
    (tmp_path / "foreign" / "manifest.json").write_text('{"name": "something else"}')
    with pytest.raises(TraceError, match="not a run directory"):
        Run.open(tmp_path / "foreign")
    (path / "manifest.json").write_text("{")
    with pytest.raises(TraceError, match="cannot be read"):
        Run.open(path)


def test_a_newer_schema_is_refused(path: Path) -> None:
    stored = json.loads((path / "manifest.json").read_text())
    (path / "manifest.json").write_text(json.dumps(stored | {"schema": 99}))
    with pytest.raises(TraceError, match="newer colonysim"):
        Run.open(path)


def test_a_damaged_part_is_named_and_a_temporary_file_passed_over(path: Path) -> None:
    (path / "events" / ".part-00009.parquet.tmp").write_bytes(b"half")
    assert len(list(Run.open(path).events())) == 120
    part = path / "events" / "part-00001.parquet"
    whole = part.read_bytes()
    part.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(TraceError, match=r"part-00001\.parquet: damaged"):
        list(Run.open(path).events())
    part.unlink()
    with pytest.raises(TraceError, match=r"part-00001\.parquet is missing"):
        list(Run.open(path).events())


def test_a_changed_trace_is_found_out(path: Path) -> None:
    run = Run.open(path)
    assert run.verify()
    parts = sorted((path / "events").iterdir())
    parts[1].write_bytes(parts[0].read_bytes())
    assert not run.verify()


def test_a_run_does_not_move_with_the_working_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
    monkeypatch.chdir(tmp_path / "one")
    made = colonysim.run("sanity", seed=1, episodes=2)
    opened = Run.open("runs/sanity-nodeworld-s1-1")
    monkeypatch.chdir(tmp_path / "two")
    assert made.path == opened.path == tmp_path / "one/runs/sanity-nodeworld-s1-1"
    assert len(opened.episodes) == 2 and list(opened.events()) == list(made.events()) != []
    opened.path.rename(tmp_path / "two/elsewhere")
    with pytest.raises(TraceError, match="no such run directory; it was there"):
        opened.table("deposits")
    assert Run.open("elsewhere").table("deposits").num_rows > 0


def test_a_missing_table_or_part_is_named_with_what_the_manifest_counts(path: Path) -> None:
    shutil.rmtree(path / "deposits")
    last = sorted((path / "events").iterdir())[-1]
    last.unlink()
    run = Run.open(path)
    with pytest.raises(TraceError, match="deposits: is missing, the manifest counts 120"):
        run.table("deposits")
    with pytest.raises(TraceError, match=r"events: holds \d+ rows, the manifest counts 120"):
        run.table("events")
    assert len(run.episodes) == 3
    shutil.copytree(path / "frames", path / "poses")
    with pytest.raises(TraceError, match="poses"):  # there never was any
        run.table("poses")
    with pytest.raises(TraceError, match="part of the run is not there"):
        run.verify()


def test_a_dropped_table_is_none_and_a_run_under_way_is_read_as_far_as_it_came(tmp_path: Path) -> None:
    with pytest.warns(DeprecationWarning, match="record="):
        run = colonysim.run("sanity", episodes=1, decisions=False, out=tmp_path / "dropped")
    assert run.path is not None and Run.open(run.path).missing("decisions") and run.verify()
    writer = record(tmp_path / "killed", rows(2), rows_per_part=25)
    writer.flush()
    killed = Run.open(tmp_path / "killed")
    assert killed.shortfall == "running or killed after 2 of 3 episodes" and len(list(killed.events())) == 80
    for episode in rows(3)[len(rows(2)) :]:
        writer.write(*episode)
    writer.flush()
    assert len(list(killed.events())) == 120, "what has come since is read too"
    for part in sorted((tmp_path / "killed/events").iterdir())[1:]:
        part.unlink()
    with pytest.raises(TraceError, match="events: ends with episode 1, but 3 are complete"):
        list(killed.events())


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"seed": None}, "seed: is None, expected a whole number"),
        ({"seed": 10**50}, "fewer than 40 digits"),
        ({"name": 3}, "name: is 3, expected a text"),
        ({"episodes": -1}, "episodes: is -1"),
        ({"status": "done"}, "status: is 'done', expected one of running, finished"),
        ({"rows": {"events": 1.5}}, r"rows\.events: is 1.5|rows: a run that is finished"),
        ({"rows": {"evnts": 1, "episodes": 3}}, r"rows\.evnts: no such table"),
        ({"rows": {}}, "rows: a run that is finished has its rows counted"),
        ({"trace_sha256": "x"}, "trace_sha256: is 'x', expected 64"),
        ({"options": []}, "options: is list, expected a mapping"),
        ({"versions": {"a": 1}}, r"versions\.a: is 1, expected a text"),
        ({"fields": {"D": {}}}, r"fields\.D\.by_box: is None, expected true or false"),
        ({"scenario": "hard"}, "scenario: is 'hard', expected a mapping"),
        ({"evaluation": {"executor": "rl", "robot_size": [1]}}, r"evaluation\.robot_size: is list, expected 2 numbers"),
        ({"name": "\ud800"}, "name: holds half of a surrogate pair"),
        ({"deep": json.loads("[" * 80 + "]" * 80)}, "nested deeper than 64"),
        ({"name": "a" * 2000}, "at most 1000 characters"),
        ({"x": float("nan")}, "NaN is no finite number"),
    ],
)
def test_a_field_of_the_manifest_that_is_wrong_is_named(path: Path, change: dict[str, Any], said: str) -> None:
    file = path / "manifest.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    with pytest.raises(TraceError, match=rf"manifest\.json: .*({said})"):
        Run.open(path)


@pytest.mark.parametrize("kind", ["pipe", "folder", "loop", "device", "bytes", "huge", "deep"])
def test_what_is_no_file_is_not_waited_for(path: Path, kind: str) -> None:
    for file in (path / "manifest.json", path / "events/part-00001.parquet"):
        file.unlink()
        if kind == "pipe":
            os.mkfifo(file)
        elif kind == "folder":
            file.mkdir()
        elif kind == "loop":
            file.symlink_to(file.name)
        elif kind == "device":
            file.symlink_to("/dev/zero")
        elif kind == "huge":
            with file.open("wb") as sparse:
                sparse.truncate(2**40)
        else:
            file.write_bytes(b"\xff\xfe" if kind == "bytes" else b"[" * 10**6)
    with pytest.raises(TraceError, match=r"manifest\.json: (is a|cannot be read|holds)"):
        Run.open(path)
    with pytest.raises(TraceError, match=r"part-00001\.parquet: (is a|cannot be read|holds|damaged)"):
        Run(path, manifest()).table("events")


@pytest.mark.parametrize(
    ("table", "column", "value", "said"),
    [
        ("events", "episode", 9, "is 9, expected 1 to 3"),
        ("events", "episode", 1, "no number smaller"),
        ("events", "time", float("nan"), "is nan, expected 0 to"),
        ("events", "time", -1.0, "is -1.0"),
        ("events", "time", 0.0, "no moment before|is"),
        ("events", "node", 2**60, "expected -1 to"),
        ("events", "agent", None, "holds nulls"),
        ("decisions", "targets", [1, 2, 3, 4, 5], "as many values as targets"),
        ("decisions", "probabilities", [float("inf")], "is|as many"),
        ("episodes", "success", 1.5, "expected 0 to 1"),
        ("frames", "field", "a" * 5000, "a text of 5000 characters"),
    ],
)
def test_a_value_that_cannot_be_is_named_by_file_and_column(
    tmp_path: Path, table: str, column: str, value: Any, said: str
) -> None:
    record(tmp_path / "run", rows()).finish("finished")
    part = tmp_path / "run" / table / "part-00000.parquet"
    found = pq.read_table(part)
    values = found[column].to_pylist()
    values[-1] = value
    at = found.column_names.index(column)
    pq.write_table(found.set_column(at, column, pa.array(values, type=found[column].type)), part, store_schema=False)
    with pytest.raises(TraceError, match=rf"{table}/part-00000\.parquet: column .*({said})"):
        Run.open(tmp_path / "run").table(table)  # type: ignore[arg-type]


def test_a_column_of_another_type_or_none_is_named(path: Path) -> None:
    part = path / "frames/part-00000.parquet"
    found = pq.read_table(part)
    for other, said in (
        (found.drop_columns(["value"]), "has no column 'value'"),
        (found.set_column(2, "node", pa.array(["1"] * len(found))), "column 'node' holds string, expected int64"),
        (found.set_column(2, "node", pa.array([1.0] * len(found))), "column 'node' holds double"),
    ):
        pq.write_table(other, part, store_schema=False)
        with pytest.raises(TraceError, match=rf"part-00000\.parquet: .*{said}"):
            Run.open(path).table("frames")


@pytest.mark.parametrize(
    ("column", "value", "said"),
    [("node", 77, "a node of the scenario"), ("agent", 50, "-1 to"), ("box", 50, "-1 to"), ("hole", 0, "of a hole"),
     ("now_at", -1, "expected a node")],
)  # fmt: skip
def test_a_place_that_the_scenario_does_not_have_is_named(tmp_path: Path, column: str, value: int, said: str) -> None:
    colonysim.run("sanity", episodes=1, out=tmp_path / "run").check_places()
    part = tmp_path / "run/events/part-00000.parquet"
    found = pq.read_table(part)
    values = found[column].to_pylist()
    values[found["kind"].to_pylist().index("end")] = value
    at = found.column_names.index(column)
    pq.write_table(found.set_column(at, column, pa.array(values)), part, store_schema=False)
    run = Run.open(tmp_path / "run")
    assert list(run.events()), "it can be read"
    with pytest.raises(TraceError, match=rf"part-00000\.parquet: column '{column}', row \d+: .*{said}"):
        run.check_places()


def test_a_part_that_claims_more_than_it_can_hold_takes_no_memory(path: Path) -> None:
    part = path / "frames/part-00000.parquet"
    columns = {"episode": 1, "field": "D", "node": 1, "key": -1, "value": 0.5}
    many = pa.table({name: pa.array([value]).take(pa.array([0] * 5_000_000)) for name, value in columns.items()})
    pq.write_table(many, part)
    assert part.stat().st_size < 100_000
    with pytest.raises(TraceError, match=r"part-00000\.parquet: (holds 5000000 rows|damaged part, it claims)"):
        Run.open(path).table("frames")
    with pytest.raises(TraceError, match=r"part-00000\.parquet: damaged part, it claims"):
        Run(path, manifest()).table("frames")


def test_a_byte_that_changed_in_a_part_is_found_out(path: Path) -> None:
    part = path / "frames/part-00000.parquet"
    content = bytearray(part.read_bytes())
    for at in range(40, len(content) // 2, 97):
        content[at] ^= 1
        part.write_bytes(content)
        with pytest.raises(TraceError):
            Run.open(path).table("frames")
        content[at] ^= 1


def test_unknown_tables_are_answered_with_the_known_ones(path: Path) -> None:
    with pytest.raises(TraceError, match="events, decisions"):
        Run.open(path).table("event")  # type: ignore[arg-type]
    with pytest.raises(TraceError, match="kept no trace"):
        Run(None, {"status": "finished"}).table("events")


def test_a_run_never_overwrites(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)

    def about(backend: str, seed: int, variant: str | None = None) -> dict[str, object]:
        return {"name": "hard", "variant": variant, "backend": backend, "seed": seed}

    names = [prepare_directory(None, about("nodeworld", 0, "R 5")).name for _ in range(2)]
    assert names == ["hard-R_5-nodeworld-s0-1", "hard-R_5-nodeworld-s0-2"]
    assert prepare_directory(None, about("bullet", 3)).name == "hard-bullet-s3-1"
    (tmp_path / "full").mkdir()
    assert prepare_directory(tmp_path / "full", about("bullet", 0)) == tmp_path / "full"
    (tmp_path / "full" / "notes").write_text("")
    with pytest.raises(TraceError, match="not empty"):
        prepare_directory(tmp_path / "full", about("bullet", 0))


@pytest.mark.parametrize("letter", ["x", "\u00e9", "\u6771", "\U0001d538"])
def test_a_long_name_is_cut_to_what_file_systems_take(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, letter: str
) -> None:
    monkeypatch.chdir(tmp_path)
    told = manifest(name=letter * 200, variant=letter * 200, backend="y" * 300, seed=10**17)
    paths = [prepare_directory(None, told) for _ in range(2)]
    assert [path.name.rpartition("-s")[2] for path in paths] == [f"{10**17}-1", f"{10**17}-2"]
    assert all(path.name.startswith(letter * 50) and 250 < len(os.fsencode(path.name)) <= 255 for path in paths)


def test_tables_are_read_by_the_thread_that_asks(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # A thread of Arrow's that still holds the file when Python shuts down aborts the process.
    readers: set[int] = set()

    class Watched(io.FileIO):
        def readinto(self, buffer: Any) -> int | None:
            readers.add(threading.get_ident())
            return super().readinto(buffer)

        def read(self, size: int | None = -1) -> bytes:
            readers.add(threading.get_ident())
            return super().read(-1 if size is None else size) or b""

    @contextmanager
    def watched(file: Path, *_: Any) -> Iterator[io.FileIO]:
        with Watched(file) as opened:
            yield opened

    monkeypatch.setattr("colonysim.trace.stored.opened_file", watched)
    assert len(list(Run.open(path).events())) > 25
    assert readers == {threading.get_ident()}
