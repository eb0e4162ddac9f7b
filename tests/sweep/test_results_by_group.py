"""Groups of agents in the results of a sweep."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.sweep import run_sweep
from colonysim.sweep.tables import read_table

MAP = """
name: mixed
topology: {kind: grid, columns: 6, rows: 4}
groups:
  - {name: quick, agents: [0, 1], speed: 2}
  - {name: slow, agents: [6, 12], speed: 0.5}
goal: 23
"""
SWEEP = "scenarios: [mixed.yaml]\ngrid: {max_steps: [4, 30]}\nseeds: {count: 3}\nepisodes: 2\n"


def asked(*arguments: str) -> object:
    told = CliRunner().invoke(app, ["results", *arguments, "--json"])
    assert told.exit_code == 0, told.output
    return json.loads(told.stdout)


@pytest.fixture
def swept(tmp_path: Path) -> Path:
    (tmp_path / "mixed.yaml").write_text(MAP)
    (tmp_path / "small.yaml").write_text(SWEEP)
    run_sweep(tmp_path / "small.yaml", tmp_path / "out", workers=1)
    return tmp_path


def test_results_can_be_told_apart_by_group(swept: Path) -> None:
    out = str(swept / "out")
    found = asked(out, "--by", "max_steps", "--by", "group")
    assert isinstance(found, list)
    means = {(row["max_steps"], row["group"]): row for row in found}
    assert set(means) == {(4, "quick"), (4, "slow"), (30, "quick"), (30, "slow")}
    assert all(row["trials"] == row["finished"] == 3 for row in found)
    runs = [
        colonysim.run(swept / "mixed.yaml", seed=seed, episodes=2, overrides={"max_steps": 30}, trace=False)
        for seed in {row["seed"] for row in read_table(out, "trials").to_pylist()}
    ]
    for group in ("quick", "slow"):
        steps = [result.steps for run in runs for result in run.groups if result.group == group]
        assert means[30, group]["steps"] == pytest.approx(sum(steps) / len(steps))
        assert means[30, group]["success"] == 1.0 and means[4, group]["success"] < 1.0
    sql = 'SELECT "group", count(*) AS rows FROM groups GROUP BY "group" ORDER BY 1'
    assert asked(out, "--sql", sql) == [{"group": "quick", "rows": 12}, {"group": "slow", "rows": 12}]


def test_a_sweep_without_groups_says_so(tmp_path: Path) -> None:
    (tmp_path / "small.yaml").write_text("scenarios: [sanity]\nseeds: {count: 1}\nepisodes: 1\n")
    run_sweep(tmp_path / "small.yaml", tmp_path / "out", workers=1)
    told = CliRunner().invoke(app, ["results", str(tmp_path / "out"), "--by", "group"])
    assert told.exit_code == 2 and "no scenario of this sweep has groups of agents" in told.output


def test_a_damaged_line_about_groups_is_left_out(swept: Path) -> None:
    journal = swept / "out" / "journal.jsonl"
    lines = journal.read_text().splitlines()
    at = next(n for n, line in enumerate(lines) if '"groups"' in line)
    lines[at] = lines[at].replace('"quick"', "7")
    journal.write_text("\n".join(lines) + "\n")
    with pytest.warns(UserWarning, match="its groups of agents are not as they were written"):
        run_sweep(swept / "small.yaml", swept / "out", workers=1)
    assert len(read_table(swept / "out", "groups")) == 24
