"""Tuning: a search that goes on where it was, finds what its file asks for, and says what is wrong with the file."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from colonysim.cli import app
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.sweep import Store
from colonysim.sweep.tuning import Candidate, Measure, tune

pytest.importorskip("optuna")
FILE = (
    "scenarios: [sanity]\nsample: {count: %d, ranges: {policy.epsilon: [0.01, 0.99]}}\nseeds: {count: 2}\nepisodes: 3\n"
)


def searched(
    folder: Path, count: int = 6, text: str = FILE, measure: Measure = "steps"
) -> tuple[list[Candidate], list[str]]:
    """What a search finds, best first, and the trials that it begins."""
    file = folder / "search.yaml"
    file.write_text(text % count if "%d" in text else text)
    begun: list[str] = []
    found = tune(
        file, folder / "out", measure=measure, workers=2,
        on_outcome=lambda outcome, *_: begun.append(outcome.trial.identity) if outcome.status == "running" else None,
    )  # fmt: skip
    return found, begun


def test_a_search_goes_on_where_it_was_and_grows(tmp_path: Path) -> None:
    first, begun = searched(tmp_path)
    assert len(first) == 6 and len(begun) == 12 == len(set(begun))
    values = [each.value for each in first]
    assert None not in values and values == sorted(values)  # type: ignore[type-var]
    again, repeated = searched(tmp_path)
    assert again == first and not repeated
    grown, new = searched(tmp_path, 8)
    assert len(new) == 4 and not set(new) & set(begun)
    assert [each for each in grown if each in first] == first
    assert set(Store(tmp_path / "out").entries) == {*begun, *new}, "all of it is one sweep"


def test_a_value_is_the_mean_over_the_episodes_that_count(tmp_path: Path) -> None:
    found, _ = searched(tmp_path, 3)
    file, entries = tmp_path / "search.yaml", Store(tmp_path / "out").entries
    last = tune(file, tmp_path / "out", episodes=(3, 3))
    steps = sorted(sum(row[1] for row in entry["episodes"] if row[0] == 3) for entry in entries.values())
    assert sum(each.value * 2 for each in last if each.value is not None) == pytest.approx(sum(steps))
    assert [each.value for each in last] != [each.value for each in found]
    with pytest.raises(ColonysimError, match="no episode 7-9"):
        tune(file, tmp_path / "out", episodes=(7, 9))


def test_success_is_made_large(tmp_path: Path) -> None:
    short = "scenarios: [sanity]\nsample: {count: 5, ranges: {max_steps: [4, 30]}}\nseeds: [0]\nepisodes: 2\n"
    with pytest.raises(ScenarioError, match="max_steps"):
        searched(tmp_path, text=short)  # settings between whole numbers do not fit this field
    found, _ = searched(tmp_path, 4, measure="success")
    values = [each.value for each in found]
    assert None not in values and values == sorted(values, reverse=True)  # type: ignore[type-var]


def test_intervals_of_success_lie_within_what_a_share_can_be(tmp_path: Path) -> None:
    text = FILE.replace("[sanity]", "[hard]").replace("{count: 2}", "{count: 3}").replace("episodes: 3", "episodes: 1")
    found, _ = searched(tmp_path, 2, text, "success")
    for each in found:
        assert each.interval is not None and 0.0 <= each.interval[0] <= each.interval[1] <= 1.0


def test_a_choice_with_a_failed_trial_comes_last(tmp_path: Path) -> None:
    text = FILE.replace("episodes: 3", "episodes: 3\nlimits: {seconds: 0.001}")
    found, _ = searched(tmp_path, 2, text)
    assert [each.value for each in found] == [None, None]
    told = CliRunner().invoke(app, ["tune", str(tmp_path / "search.yaml"), "-o", str(tmp_path / "out"), "-q"])
    assert told.exit_code == 2 and "every choice had a trial that failed" in told.stderr


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("scenarios: [sanity]\n", "has no `sample`"),
        (FILE.replace("%d", "2") + "grid: {policy.beta: [1]}\n", "expected no grid"),
        (FILE.replace("%d", "2").replace("epsilon", "epsilom"), "epsilom"),
        (FILE.replace("%d", "2").replace("0.01, 0.99", "0.99, 0.01"), r"lowest value first, found \[0.99, 0.01\]"),
        (FILE.replace("%d", "2").replace("0.01, 0.99", "-1.0e+308, 1.0e+308"), "not as wide"),
    ],
)
def test_a_file_that_cannot_be_searched_is_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        searched(tmp_path, text=text)
    assert not (tmp_path / "out").exists()
