"""Damaged journals: each line is named with its number, the rest is kept, and the sweep goes on to the same tables."""

from __future__ import annotations

import json
import random
import re
import warnings
from pathlib import Path

import pytest

from colonysim.errors import ColonysimError, ColonysimWarning
from colonysim.jsonlines import append_line, read_lines
from colonysim.processes import attempt
from colonysim.sweep import Store, run_sweep, running
from colonysim.sweep.tables import read_table
from colonysim.sweep.trial import run_trial
from colonysim.sweep.workers import Outcome

FILE = "scenarios: [sanity]\ngrid: {policy.beta: [2, 4]}\nseeds: {count: 2}\nepisodes: 1\n"
WRONG = (None, 7, "x", [], {}, [[1]], True, -1.5)


def here(trials, limits, workers):
    """The trials in this process, which takes no time to start."""
    for trial in trials:
        yield Outcome(trial, "running")
        word, value = attempt(run_trial, trial, None)
        assert word == "succeeded", value
        yield Outcome(trial, "succeeded", value)


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("journals")
    (folder / "small.yaml").write_text(FILE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(running, "run_locally", here)
        run_sweep(folder / "small.yaml", folder / "out")
    return folder


def rows(directory: Path) -> list[object]:
    tables = [read_table(directory, name).to_pylist() for name in ("trials", "episodes")]
    return [{name: value for name, value in row.items() if name != "seconds"} for table in tables for row in table]


def damaged(lines: list[bytes], rng: random.Random) -> tuple[bytes, set[int]]:
    """A journal after some accidents, and the numbers of its lines that are none."""
    marked: list[tuple[bytes, bool | None]] = [(line, False) for line in lines]  # None: to be left as it is
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(marked))
        line, bad = marked[at]
        if bad is not False:
            continue
        kind = rng.randrange(9)
        if kind == 0:
            marked.insert(at, (rng.choice((b"", b"   ", b"\t")), True))
        elif kind == 1:
            garbage = bytes(rng.randrange(256) for _ in range(rng.randint(1, 300)))
            marked.insert(at, (re.sub(rb"[\n\r]", b"?", garbage) + b"\xff", True))
        elif kind == 2:
            marked[at] = b"\0" * len(line), True
        elif kind == 3:
            cut = rng.randrange(1, len(line))
            marked[at] = line[:cut], True
        elif kind == 4:
            row = json.loads(line)
            names = [name for name in row if name not in ("at", "made_by")]
            name = rng.choice(names)
            value = rng.choice([w for w in WRONG if not (name == "seconds" and isinstance(w, (int, float)))])
            if (name in ("trial", "asked", "trace_sha256") and value == "x") or (name == "episodes" and value == []):
                value = None
            marked[at] = json.dumps({**row, name: value}).encode(), True
        elif kind == 5 and b"succeeded" in line:
            marked[at : at + 1] = [(line, None), (line, True)]
        elif kind == 6:
            cut = rng.randrange(len(line))
            marked[at] = line[:cut] + rng.choice((b"\xff", b"\xc3\x28", b"\x80")) + line[cut:], True
        elif kind == 7:
            marked[at] = rng.choice((b"[" * 100_000, b"5", b"null", b"[]", b'"text"', b"{}", b"9" * 5000)), True
        elif kind == 8 and at + 1 < len(marked) and marked[at + 1][1] is False:
            marked[at : at + 2] = [(line + marked[at + 1][0], True)]
    return b"".join(line + b"\n" for line, _ in marked), {n for n, (_, bad) in enumerate(marked, 1) if bad}


@pytest.mark.parametrize("count", [12, pytest.param(500, marks=pytest.mark.slow)])
def test_damaged_lines_are_named_the_rest_is_kept_and_the_sweep_goes_on(whole, tmp_path, monkeypatch, count):
    monkeypatch.setattr(running, "run_locally", here)
    lines = (whole / "out" / "journal.jsonl").read_bytes().splitlines()
    expected, rng = rows(whole / "out"), random.Random(0)
    for number in range(count):
        out = tmp_path / str(number)
        out.mkdir()
        content, bad = damaged(lines, rng)
        if rng.random() < 0.2:  # as after a loss of power
            content += b"\0" * rng.randint(1, 5000)
            bad.add(content.count(b"\n") + 1)
        (out / "journal.jsonl").write_bytes(content)
        kept = {}
        for n, line in enumerate(content.split(b"\n"), 1):
            if n not in bad and line:
                row = json.loads(line)
                kept[row["trial"]] = row["status"]
        begun: list[str] = []
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            run_sweep(
                whole / "small.yaml", out,
                on_outcome=lambda outcome, *_, begun=begun: begun.append(outcome.trial.identity),
            )  # fmt: skip
        told = [str(each.message) for each in caught if each.category is ColonysimWarning]
        named = {int(text) for text in re.findall(r"line (\d+): ", " ".join(told))}
        assert named == bad, (number, told)
        assert len(told) == (1 if bad else 0), told
        done = {trial for trial, status in kept.items() if status == "succeeded"}
        assert not done & set(begun), "what its line still tells is not run again"
        assert rows(out) == expected
        left = (out / "journal.jsonl").read_bytes()
        assert left.startswith(content), "nothing that stood there is thrown away"


def test_two_results_of_one_trial_are_run_again(whole, tmp_path, monkeypatch):
    monkeypatch.setattr(running, "run_locally", here)
    lines = (whole / "out" / "journal.jsonl").read_bytes().splitlines()
    (tmp_path / "out").mkdir()
    other = re.sub(rb'"episodes":\[\[1,\d+', b'"episodes":[[1,77', lines[1])
    assert other != lines[1]
    (tmp_path / "out" / "journal.jsonl").write_bytes(b"\n".join([*lines, other]) + b"\n")
    with pytest.warns(ColonysimWarning, match=r"line 9: line 2 told already what came of this trial"):
        run_sweep(whole / "small.yaml", tmp_path / "out")
    assert rows(tmp_path / "out") == rows(whole / "out")
    with pytest.warns(ColonysimWarning, match="line 9"):
        assert {entry["status"] for entry in Store(tmp_path / "out").entries.values()} == {"succeeded"}


def test_a_reader_says_nothing_of_a_line_that_is_being_written(whole, tmp_path):
    content = (whole / "out" / "journal.jsonl").read_bytes()
    (tmp_path / "journal.jsonl").write_bytes(content[:-20])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert [entry["status"] for entry in Store(tmp_path).entries.values()][-1] == "running"
    with pytest.warns(ColonysimWarning, match="line 8: it is no JSON, or cut off"):
        Store(tmp_path, write=True).__exit__(None, None, None)
    (tmp_path / "journal.jsonl").write_bytes(content[:-1])  # whole, but for its end
    with warnings.catch_warnings(), Store(tmp_path, write=True) as store:
        warnings.simplefilter("error")
        assert [entry["status"] for entry in store.entries.values()] == ["succeeded"] * 4
    assert (tmp_path / "journal.jsonl").read_bytes() == content


def test_a_journal_that_is_no_file_is_one_message(tmp_path):
    (tmp_path / "journal.jsonl").mkdir()
    for write in (False, True):
        with pytest.raises(ColonysimError):
            Store(tmp_path, write=write)


def test_other_files_of_lines(tmp_path):
    path = tmp_path / "new" / "rows.jsonl"
    for number in range(3):
        append_line(path, {"n": number})
    path.write_bytes(path.read_bytes() + b'{"n": 3')  # stopped in the middle of a line
    append_line(path, {"n": 4})
    found, faults = read_lines(path, lambda row: "odd" if row["n"] % 2 else None)
    assert [row["n"] for row in found] == [0, 2, 4] and faults == {2: "odd", 4: "it is no JSON, or cut off"}
    with pytest.raises(ColonysimError, match="no such file"):
        read_lines(tmp_path / "none.jsonl", lambda _: None)


@pytest.mark.parametrize(
    "row", [[1, 2**63, 1.0, "goal", 4.5, 0], [1, 9, 10**400, "goal", 4.5, 0], [1, 9, 1.0, "goal", 1e308, 0]]
)
def test_numbers_that_no_table_takes_are_told_by_line_and_their_trials_run_again(whole, tmp_path, monkeypatch, row):
    monkeypatch.setattr(running, "run_locally", here)
    lines = (whole / "out" / "journal.jsonl").read_bytes().splitlines()
    entry = json.loads(lines[1])
    lines[1] = json.dumps(entry | {"episodes": [row]}).encode()
    lines[3] = json.dumps(json.loads(lines[3]) | {"seconds": 10**400}).encode()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "journal.jsonl").write_bytes(b"\n".join(lines) + b"\n")
    with pytest.warns(ColonysimWarning, match="line 2: its episodes are not as .*line 4: its seconds are no number"):
        run_sweep(whole / "small.yaml", tmp_path / "out")
    assert rows(tmp_path / "out") == rows(whole / "out")
