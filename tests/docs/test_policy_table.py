"""docs/policies.md is what `colonysim policies --markdown` prints, and cites the paper as the other pages do."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

from typer.testing import CliRunner

from colonysim.cli import app
from colonysim.policies.described import list_policies
from colonysim.policies.settings import StigmergySettings

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_the_page_is_current():
    printed = CliRunner().invoke(app, ["policies", "--markdown"]).stdout
    page = (DOCS / "policies.md").read_text(encoding="utf-8")
    assert page == printed, "run: colonysim policies --markdown > docs/policies.md"
    for field in dataclasses.fields(StigmergySettings):
        assert f"\n| `{field.name}` | " in page


def test_every_parameter_has_a_meaning_and_the_algorithms_are_those_of_the_equations():
    rows = (DOCS / "equations.md").read_text(encoding="utf-8").splitlines()
    known = {row.split("|")[1].strip() for row in rows if row.startswith("|")}
    ours = [each for policy in list_policies() for each in policy.parameters or ()]
    assert all(each.meaning for each in ours)
    papers = {each.paper for each in ours} - {""}
    assert papers <= known and {f"Alg. {number}" for number in (2, 3, 4, 5, 6, 7, 8, 9)} <= papers


def test_an_algorithm_that_the_readings_name_for_an_option_is_one_of_the_paper_s():
    """A row of docs/readings.md that begins with an algorithm belongs to the parameters in its column "Option"."""
    papers = {each.name: each.paper for policy in list_policies() for each in policy.parameters or ()}
    found = 0
    for row in (DOCS / "readings.md").read_text(encoding="utf-8").splitlines():
        cells = row.split("|")
        number = re.search(r"\((Alg\. \d)\)", cells[1]) if len(cells) == 8 else None
        for name in re.findall(r"`(\w+)`", cells[5]) if number else ():
            if name in papers:
                assert papers[name] == number[1], name
                found += 1
    assert found >= 5
