from __future__ import annotations

import json
from pathlib import Path

import pytest
from recorded_runs import record, rows

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
