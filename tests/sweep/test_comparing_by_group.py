"""Differences by group of agents, paired by seed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from test_results_by_group import MAP
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.errors import ColonysimError
from colonysim.intervals import of_mean
from colonysim.sweep import run_sweep
from colonysim.sweep.comparing import compare, pooled
from colonysim.sweep.tables import read_table

SWEEP = "scenarios: [mixed.yaml, other.yaml]\npolicies: [paper, colony]\nseeds: {count: 4}\nepisodes: 2\n"


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("swept")
    (folder / "mixed.yaml").write_text(MAP)
    other = MAP.replace("mixed", "other").replace("slow", "late").replace("rows: 4", "rows: 5")
    (folder / "other.yaml").write_text(other)
    (folder / "small.yaml").write_text(SWEEP)
    run_sweep(folder / "small.yaml", folder / "out", workers=1)
    return folder


def means(directory: Path, name: str) -> dict[tuple[str, str, str, int], float]:
    """Mean of a measure over the episodes of each trial, by scenario, policy, group and seed."""
    found: dict[tuple[str, str, str, int], list[float]] = {}
    for row in read_table(directory, "groups").to_pylist():
        found.setdefault((row["scenario"], row["policy"], row["group"], row["seed"]), []).append(float(row[name]))
    return {key: sum(values) / len(values) for key, values in found.items()}


def test_each_group_is_compared_for_itself(swept: Path) -> None:
    found = compare([swept / "out"], by="policy", by_group=True)
    groups = {("mixed.yaml", "quick"), ("mixed.yaml", "slow"), ("other.yaml", "quick"), ("other.yaml", "late")}
    assert {(each.where["scenario"], each.where["group"]) for each in found} == groups
    assert {each.measure for each in found} == {"success", "steps"} and len(found) == 8
    for each in found:
        mean, at = means(swept / "out", each.measure), (each.where["scenario"], each.where["group"])
        values = [mean[at[0], "colony", at[1], seed] - mean[at[0], "paper", at[1], seed] for seed in range(4)]
        assert each.difference == pytest.approx(sum(values) / 4) and each.seeds == 4
        within = (-1.0, 1.0) if each.measure == "success" else None
        assert each.interval == pytest.approx(of_mean(values, within=within))


def test_each_group_has_an_effect_of_its_own_over_all_pairs(swept: Path) -> None:
    found = compare([swept / "out"], by="policy", by_group=True)
    effects = {(each.where["group"], each.measure): each for each in pooled(found)}
    assert effects.keys() == {(group, name) for group in ("quick", "slow", "late") for name in ("success", "steps")}
    quick = effects["quick", "steps"]
    values = [each for row in found if (row.where["group"], row.measure) == ("quick", "steps")
              for each in row.by_seed.values()]  # fmt: skip
    assert (quick.pairs, quick.settings, effects["slow", "steps"].pairs) == (8, 2, 4)
    assert quick.difference == pytest.approx(sum(values) / 8) and quick.interval == pytest.approx(of_mean(values))
    assert "steps of group quick is " in quick.sentence


def test_groups_are_compared_with_each_other(swept: Path) -> None:
    found = compare([swept / "out"], by="group", episodes=(2, 2))
    assert {(each.where["scenario"], each.where["policy"], each.reference, each.other) for each in found} == {
        (f"{name}.yaml", policy, "quick", other)
        for name, other in (("mixed", "slow"), ("other", "late"))
        for policy in ("paper", "colony")
    }


def test_runs_are_compared_by_group_and_the_command_says_so(swept: Path, tmp_path: Path) -> None:
    for policy in ("paper", "colony"):
        colonysim.run(swept / "mixed.yaml", seed=3, episodes=2, policy=policy, out=tmp_path / policy)
    paths = [str(tmp_path / "paper"), str(tmp_path / "colony")]
    done = CliRunner().invoke(app, ["compare", *paths, "--by-group", "--json"])
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    rows = told["differences"]
    assert {(row["group"], row["by"], row["reference"], row["measure"]) for row in rows} == {
        (group, "policy", "paper", measure) for group in ("quick", "slow") for measure in ("success", "steps")
    }
    runs = [colonysim.Run.open(path) for path in paths]
    for row in (row for row in rows if row["measure"] == "steps"):
        one, two = (sum(r.steps for r in run.groups if r.group == row["group"]) / 2 for run in runs)
        assert (row["reference_mean"], row["other_mean"]) == (one, two)
    names = ("group", "measure", "difference", "pairs")
    assert [tuple(each[name] for name in names) for each in told["pooled"]] == [
        (row["group"], row["measure"], row["difference"], 1) for row in rows
    ]
    table = CliRunner().invoke(app, ["compare", *paths, "--by-group"])
    assert table.exit_code == 0 and "quick" in table.stdout and "sim_seconds" not in table.stdout


def test_without_groups_it_says_so(tmp_path: Path) -> None:
    for seed in (1, 2):
        colonysim.run("sanity", seed=seed, episodes=1, out=tmp_path / str(seed))
    for asked in ({"by_group": True}, {"by": "group"}):
        with pytest.raises(ColonysimError, match=r"1: its scenario has no groups of agents"):
            compare([tmp_path / "1", tmp_path / "2"], **asked)  # type: ignore[arg-type]


def test_images_by_group_are_of_one_run(swept: Path) -> None:
    done = CliRunner().invoke(app, ["plot", str(swept / "out"), "--by-group"])
    assert done.exit_code == 2 and "--by-group: only of one run" in done.stderr
