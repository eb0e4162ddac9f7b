"""What a row of a trace costs: `write` alone, with the hash, and with Parquet on disk (microseconds of CPU time).

Run with: python benchmarks/trace_overhead.py [rows]
"""

from __future__ import annotations

import gc
import sys
import tempfile
import time
from pathlib import Path

import colonysim.trace.writer
from colonysim.trace.schema import Decision, Deposit, Event, Table
from colonysim.trace.writer import TraceWriter


def rows(count: int) -> list[tuple[Table, tuple[object, ...]]]:
    """One event and one decision to five deposits, about as a colony writes them."""
    made: list[tuple[Table, tuple[object, ...]]] = []
    for i in range(count // 7):
        t = i / 7
        made.append(("events", Event(1, t, "end", i % 4, "travel", i % 30, 3, status="arrived", step=i % 50)))
        made.append(("decisions", Decision(1, t, i % 4, i % 30, False, 1, (1, 2, 3), (-1,) * 3, (0.2, 0.3, 0.5))))
        made += [("deposits", Deposit(1, t, field, i % 4, i % 30, -1, t * t)) for field in "DEHHB"]
    return made


def measure(directory: Path | None, made: list[tuple[Table, tuple[object, ...]]]) -> float:
    writer = TraceWriter(directory, {"rows": {}})
    begin = time.process_time()
    for table, row in made:
        writer.write(table, row)
    writer.finish("finished")
    return (time.process_time() - begin) / len(made) * 1e6


def main() -> None:
    import pyarrow.parquet  # noqa: F401  (its import is no cost of a row)

    made = rows(int(sys.argv[1]) if len(sys.argv) > 1 else 350_000)
    colonysim.trace.writer.BLOCK = 10**9
    gc.freeze()  # the collector must not search through rows that only a benchmark holds
    writer = TraceWriter(None, {}, rows_per_part=10**9, flush_seconds=1e9)
    begin = time.process_time()
    for table, row in made:
        writer.write(table, row)
    print(f"rows                 {len(made)}")
    print(f"write() alone        {(time.process_time() - begin) / len(made) * 1e6:.2f} us a row")
    colonysim.trace.writer.BLOCK = 2048
    del writer
    print(f"with hash            {measure(None, made):.2f} us a row")
    with tempfile.TemporaryDirectory() as name:
        print(f"with hash and files  {measure(Path(name), made):.2f} us a row")


if __name__ == "__main__":
    main()
