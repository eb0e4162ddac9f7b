"""`colonysim bench`: figures, files and comparisons; no test looks at how fast anything is."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from colonysim.bench import CASES, Figures, compared, measure, report, save, shares, stored
from colonysim.cli import app
from colonysim.errors import ColonysimError
from colonysim.simulation import simulate


def colonysim(*words: object) -> Result:
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.fixture(scope="module")
def document() -> dict[str, Any]:
    return report([measure("hard", rounds=2)])


def test_every_round_has_a_time_and_a_yardstick(document: dict[str, Any]) -> None:
    (row,) = document["rows"]
    assert row["agents"] == 4 and len(row["seconds"]) == len(row["timeouts"]) == 2
    # 30 episodes of at least 20 steps of somebody, and no more than the scenario allows.
    assert 600 < row["steps"] < 30 * 4 * CASES["hard"].make().max_steps
    assert row["ratio"] == pytest.approx(
        sum(row["steps"] / s / t for s, t in zip(row["seconds"], row["timeouts"], strict=True)) / 2
    )
    assert row["decisions"] >= row["steps"] and row["decision_ratio"] >= row["ratio"] > 0.0
    assert row["peak_mb"] is None or 10 < row["peak_mb"] < 1000


def test_a_kept_report_is_compared_case_by_case(document: dict[str, Any], tmp_path: Path) -> None:
    slower = json.loads(json.dumps(document))
    slower["rows"][0]["ratio"] /= 2
    slower["rows"].append(slower["rows"][0] | {"case": "travel-10"})
    save(slower, tmp_path / "kept" / "before.json")
    assert compared(document, stored(tmp_path / "kept" / "before.json")) == {"hard": pytest.approx(2.0)}


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": 1, "rows": [{"case": "hard"}]}', '{"format": 9}'])
def test_what_is_no_report_is_said_to_be_none(text: str, tmp_path: Path) -> None:
    (tmp_path / "other.json").write_text(text, encoding="utf-8")
    with pytest.raises(ColonysimError, match=r"other\.json"):
        stored(tmp_path / "other.json")
    result = colonysim("bench", "hard", "--compare", tmp_path / "other.json")
    assert result.exit_code == 2 and "other.json" in result.output


def test_cases_are_listed_and_a_wrong_one_is_answered_with_the_nearest() -> None:
    listed = colonysim("bench", "--list").stdout
    assert all(name in listed for name in CASES)
    result = colonysim("bench", "hrad")
    assert result.exit_code == 2 and "hard" in result.output


@pytest.mark.parametrize("name", ["boxes-50", "travel-10"])
def test_cases_are_what_they_say(name: str) -> None:
    scenario = CASES[name].make()
    assert len(scenario.agents) == int(name.rpartition("-")[2])
    share = len(scenario.boxes) / len(scenario.topology)
    assert share == (pytest.approx(0.05) if "boxes" in name else 0.0)


def test_what_a_user_brings_runs_as_the_case_says_and_stands_beside_the_built_in() -> None:
    # Derived and unchanged, or with a field that writes nothing, a colony does what it did before.
    for name in ("subclass", "extra-field", "own-backend", "extra-field-hard"):
        case, beside = CASES[name], CASES[CASES[name].beside]
        ends = []
        for each in (case, beside):
            settings = each.settings | {"episodes": 1}
            events = simulate(each.make(), kinds=["end"], **settings)
            ends.append([(event.time, event.agent, event.node) for event in itertools.islice(events, 2000)])
            events.close()
        assert ends[0] == ends[1], name
    figures = [
        Figures(name, 1000, steps, decisions, 0.1, (1.0,), (1000.0,), None)
        for name, steps, decisions in (("travel-1000", 1000, 1000), ("paper", 200, 500), ("extra-field-hard", 9, 9))
    ]
    assert shares(figures) == {"paper": pytest.approx(0.5)}


def test_where_figures_cannot_be_kept_is_found_before_anything_is_timed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("colonysim.bench.measure", lambda *_: pytest.fail("timed"))
    answer = colonysim("bench", "hard", "--save", tmp_path)
    assert answer.exit_code == 2 and answer.stderr == f"Error: {tmp_path}: is a directory, expected a file\n"
