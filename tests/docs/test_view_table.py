"""docs/extending.md names all that a policy can ask its view."""

from __future__ import annotations

import re
from pathlib import Path

from colonysim.policies.view import LocalView

PAGE = Path(__file__).parents[2] / "docs" / "extending.md"


def test_all_that_a_view_answers_is_in_the_table_and_nothing_else():
    section = PAGE.read_text().partition("### What a view answers")[2].partition("\n## ")[0]
    rows = [line.split("|")[1] for line in section.splitlines() if line.startswith("| `")]
    below = section.rpartition("|")[2]
    told = {name for text in (*rows, below) for name in re.findall(r"`([a-z_]+)[`(\[]", text)} - {"check_policy"}
    there = {name for name in dir(LocalView) if not name.startswith("_")}
    assert told == there
