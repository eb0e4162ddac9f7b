"""Rows and run directories that no simulation had to make."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from colonysim.trace.schema import Decision, Deposit, EpisodeResult, Event, Frame, Table
from colonysim.trace.writer import TraceWriter

Row = tuple[Table, tuple[object, ...]]


def manifest(**changes: Any) -> dict[str, Any]:
    return {
        "format": "colonysim run", "schema": 1, "status": "running", "name": "tiny", "variant": None, "backend": "mock",
        "policy": "random", "mode": "asynchronous", "episodes": 3, "seed": 0, "options": {}, "rows": {},
        "trace_sha256": None, "versions": {}, "scenario": None,
    } | changes  # fmt: skip


def rows(episodes: int = 3, each: int = 40) -> list[Row]:
    made: list[Row] = []
    for episode in range(1, episodes + 1):
        for i in range(each):
            time = 0.1 * i
            event = Event(episode, time, "end", i % 4, "travel", i % 7, (i + 1) % 7, status="arrived", step=i)
            made.append(("events", event))
            chances = tuple(1 / (i % 3 + 1) for _ in range(i % 3 + 1))
            targets = tuple(range(i % 3 + 1))
            decision = Decision(episode, time, i % 4, i % 7, i % 2 == 0, 0, targets, targets, chances)
            made.append(("decisions", decision))
            made.append(("deposits", Deposit(episode, time, "DHE"[i % 3], i % 4, i % 7, -1, time / 3)))
        for node in range(7):
            made.append(("frames", Frame(episode, "D", node, -1, node / episode)))
            made.append(("frames", Frame(episode, "H", node, 3, node * 0.5)))
        made.append(("episodes", EpisodeResult(episode, each, 1.0, "goal", 4.0, 0, 0.25)))
    return made


def record(directory: Path | None, made: list[Row], **options: Any) -> TraceWriter:
    if directory is not None:
        directory.mkdir(parents=True)
    writer = TraceWriter(directory, manifest(), **options)
    for table, row in made:
        writer.write(table, row)
    return writer
