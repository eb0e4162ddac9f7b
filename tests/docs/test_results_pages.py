"""The tables of docs/results are those of the runs stored beside them."""

from __future__ import annotations

import json
import re
from pathlib import Path
from statistics import fmean

import pytest

RESULTS = Path(__file__).parents[2] / "docs" / "results"
MAPS = {
    "easy": "easy", "medium": "medium", "hard, R = 20, 4 robots": "hard", "hard, R = 5, 4 robots": "hard:r5-4",
    "hard, R = 5, 6 robots": "hard:r5-6",
}  # fmt: skip


def episodes_of(engine: str, **settings: object) -> list[list[dict[str, float]]]:
    rows = map(json.loads, (RESULTS / f"{engine}.jsonl").read_text(encoding="utf-8").splitlines())
    return [
        row["episodes"]
        for row in rows
        if "parameters" not in row and all(row[name] == value for name, value in settings.items())
    ]


def told(runs: list[list[dict[str, float]]], first: int, last: int) -> str:
    """Steps and success of some episodes as the pages print them."""
    chosen = [episode for run in runs for episode in run[first:last]]
    steps, success = (fmean(episode[name] for episode in chosen) for name in ("steps", "success"))
    return f"{steps:.1f} / {success:.3f}".replace(" 0.", " .")


def rows_of(page: str, columns: int) -> list[list[str]]:
    lines = (RESULTS / page).read_text(encoding="utf-8").splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")]
    return [row for row in cells if len(row) == columns and row[0] in MAPS]


@pytest.mark.parametrize("row", rows_of("bullet.md", 9), ids=lambda row: f"{row[0]} {row[1]}")
def test_the_table_of_bullet_is_of_the_stored_runs(row):
    name, executor, seeds, early, late, there = row[:6]
    push = re.search(r"`(\w+)`", executor)[1]
    policy = "paper" if "rules `paper`" in executor else "colony"
    runs = episodes_of("bullet", map=MAPS[name], policy=policy, push=push)
    first, last = map(int, seeds.split("-"))
    assert len(runs) == last - first + 1
    assert (told(runs, 0, 10), told(runs, 10, 20)) == (early, late)
    ended = [episode["success"] == 1.0 for run in runs for episode in run[10:]]
    assert there.startswith(f"{sum(ended)} of {len(ended)} [")


def test_the_table_of_both_engines_is_of_the_stored_runs():
    lines = (RESULTS / "engines.md").read_text(encoding="utf-8").partition("## Colonies")[2].partition("\n## ")[0]
    name, seen = "", 0
    for line in lines.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) != 5 or cells[1] not in ("Bullet", "MuJoCo"):
            continue
        name, seen = cells[0] or name, seen + 1
        runs = episodes_of(cells[1].lower(), map=MAPS[name], policy="colony", push="staged")
        assert [told(runs, 0, 10), told(runs, 10, 20)] == cells[2:4], (name, cells[1])
    assert seen == 2 * len(MAPS)
