"""Whoever listens to a run hears every row, and the run does not notice."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

import colonysim
from colonysim.trace import writer
from colonysim.trace.packing import Codes, Packed
from colonysim.trace.schema import Table


class Listener:
    """Keeps what it is told, and how much of it there was at each cut."""

    def __init__(self) -> None:
        self.times: dict[Table, list[float]] = {}
        self.kinds: list[str] = []
        self.cuts: list[dict[Table, int]] = []

    def take(self, table: Table, columns: Mapping[str, Packed], codes: Mapping[str, Codes]) -> None:
        if "time" in columns:
            self.times.setdefault(table, []).extend(columns["time"].values)
        if table == "events":
            words = list(codes["kind"])
            self.kinds += [words[code] for code in columns["kind"].values]

    def cut(self) -> None:
        self.cuts.append({table: len(times) for table, times in self.times.items()})


@pytest.mark.parametrize("seconds", [0.0, 1e9], ids=["at every event", "at the end"])
def test_a_tap_hears_every_row_and_changes_nothing(
    seconds: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writer, "SHARE_SECONDS", seconds)
    plain = colonysim.run("hard", seed=10, episodes=3, trace=False)
    heard = Listener()
    run = colonysim.run("hard", seed=10, episodes=3, out=tmp_path / "run", tap=heard)
    assert run.trace_sha256 == plain.trace_sha256 and run.verify()
    for table in ("events", "decisions", "deposits"):
        assert heard.times[table] == run.table(table)["time"].to_pylist()
    assert heard.kinds == run.table("events")["kind"].to_pylist()
    assert heard.cuts[-1]["events"] == len(heard.kinds)
    if not seconds:
        assert len(heard.cuts) > 100
        # A cut is one moment: no table is ahead of the events by then, nor are rows of an older moment to come.
        events = heard.times["events"]
        ends = [i for i, kind in enumerate(heard.kinds) if kind == "episode"]
        for cut in heard.cuts[:-1]:
            told = cut["events"]
            episode = next(i for i in ends if i >= told - 1)
            if episode > told - 1 and heard.kinds[told - 1] != "start":  # nobody has decided yet
                assert heard.times["decisions"][cut["decisions"] - 1] <= events[told - 1]


def test_a_run_without_a_trace_can_be_followed_too() -> None:
    heard = Listener()
    run = colonysim.run("sanity", seed=10, episodes=1, trace=False, tap=heard)
    assert heard.kinds.count("episode") == 1 and run.path is None
