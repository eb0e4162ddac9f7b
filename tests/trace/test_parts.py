"""Part files: in place when they are closed and not before, few however long a run is, and readable after any end."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest
from full_disk import small_disk
from recorded_runs import manifest, record, rows

from colonysim.errors import TraceError
from colonysim.trace import writer as module
from colonysim.trace.packing import TableDigest
from colonysim.trace.parts import PartFile
from colonysim.trace.reader import Run
from colonysim.trace.schema import Deposit, EpisodeResult, Event
from colonysim.trace.writer import TraceWriter


def still_open(folder: Path) -> list[str]:
    """Files below a folder that this process has open."""
    found = []
    for handle in Path("/proc/self/fd").iterdir():
        try:
            found.append(str(handle.readlink()))
        except OSError:
            continue
    return [name for name in found if name.startswith(str(folder))]


def files(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.rglob("*") if path.is_file() and path.name != "manifest.json")


def deposits(count: int) -> tuple[dict[str, Any], dict[str, Any]]:
    digest = TableDigest("deposits")
    return digest.add([Deposit(1, float(i), "D", 0, i, -1, 0.5) for i in range(count)]), digest.codes


def test_a_part_is_in_place_when_it_is_closed_and_only_then(tmp_path: Path) -> None:
    columns, codes = deposits(100)
    part = PartFile(tmp_path / "part-00000.parquet", columns)
    part.add(columns, codes)
    part.add(columns, codes)
    assert len(files(tmp_path)) == 1 and files(tmp_path)[0].endswith(".tmp")
    part.close()
    assert files(tmp_path) == ["part-00000.parquet"] and not still_open(tmp_path)
    assert pq.read_table(tmp_path / "part-00000.parquet")["node"].to_pylist() == [*range(100)] * 2 and part.rows == 200


@pytest.mark.parametrize("end", ["abandon", "forget"])
def test_a_part_that_is_given_up_leaves_nothing(end: str, tmp_path: Path) -> None:
    columns, codes = deposits(100)
    part = PartFile(tmp_path / "part-00000.parquet", columns)
    part.add(columns, codes)
    if end == "abandon":
        part.abandon()
    del part
    assert files(tmp_path) == [] and not still_open(tmp_path)


@pytest.mark.parametrize("end", ["flush", "finish"])
def test_all_parts_are_closed_by_a_flush_and_by_the_end(end: str, tmp_path: Path) -> None:
    made = rows(3, 400)
    writer = record(tmp_path / "run", made, rows_per_part=10_000, flush_seconds=1e9)
    if end == "flush":
        writer.flush()
    else:
        writer.finish("finished")
    assert all(name.startswith("part-") and name.endswith(".parquet") for name in files(tmp_path))
    assert not still_open(tmp_path)
    run = Run.open(tmp_path / "run")
    assert list(run.events()) == [row for table, row in made if table == "events"] and len(run.episodes) == 3


def test_rows_go_to_disk_long_before_their_part_is_closed(tmp_path: Path) -> None:
    writer = TraceWriter(tmp_path, manifest(), flush_seconds=1e9)
    for i in range(5 * module.GROUP):
        writer.write("deposits", Deposit(1, float(i), "D", 0, i % 7, -1, 0.5))
    (name,) = files(tmp_path)
    assert name.endswith(".tmp") and (tmp_path / "deposits" / name).stat().st_size > 4 * 4 * module.GROUP
    # Whoever reads now, or after a kill, sees a run without these rows and not half a file.
    assert Run.open(tmp_path).table("deposits").num_rows == 0
    writer.flush()
    assert Run.open(tmp_path).table("deposits").num_rows == 5 * module.GROUP


def test_a_day_long_run_has_some_hundred_parts_at_most(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [0.0]
    monkeypatch.setattr(module.time, "monotonic", lambda: clock[0])
    writer = TraceWriter(tmp_path, manifest(episodes=10**6))
    lost = 0.0
    while clock[0] < 86_400:
        clock[0] += 0.5 + clock[0] / 1000
        parts = len(list((tmp_path / "events").glob("part-*"))) if (tmp_path / "events").exists() else 0
        writer.write("events", Event(1, clock[0], "start"))
        if len(list((tmp_path / "events").glob("part-*"))) > parts:
            lost = clock[0]
        assert clock[0] - lost <= max(2.0, 0.1 * clock[0]) + 0.5 + clock[0] / 1000, "what a kill would take"
    writer.finish("finished")
    assert 20 < len(files(tmp_path)) < 120


def test_parts_grow_once_a_table_has_many(tmp_path: Path) -> None:
    writer = TraceWriter(tmp_path, manifest(), rows_per_part=2, flush_seconds=1e9)
    for i in range(4000):
        writer.write("deposits", Deposit(1, float(i), "D", 0, i % 7, -1, 0.5))
    writer.finish("finished")
    assert len(files(tmp_path)) < 1000 < 2000 and Run.open(tmp_path).verify()
    assert Run.open(tmp_path).table("deposits")["time"].to_pylist() == [float(i) for i in range(4000)]


def test_after_a_write_that_failed_nothing_more_is_written_and_what_was_there_is_read(tmp_path: Path) -> None:
    with small_disk(tmp_path / "disk", 256) as disk:
        path = disk / "run"
        path.mkdir()
        writer = TraceWriter(path, manifest(episodes=100), flush_seconds=1e9)
        with pytest.raises(TraceError, match=r"part-.*cannot be written: .*No space left"):
            for number in range(1, 101):
                for i in range(2000):
                    writer.write("deposits", Deposit(number, float(i), "D", i % 3, i % 7, -1, i / 7))
                    writer.write("events", Event(number, float(i), "start", node=i % 7))
                writer.write("episodes", EpisodeResult(number, 1, 1.0, "goal", 1.0, 0, 0.0))
                writer.flush()
        with pytest.raises(TraceError, match="No space left"):
            writer.finish("failed")
        assert all(name.startswith("part-") for name in files(path)) and not still_open(path)
        run = Run.open(path)
        assert run.status == "running" and len(run.episodes) >= 1
        assert len(list(run.events(run.episodes[-1].episode))) == 2000
