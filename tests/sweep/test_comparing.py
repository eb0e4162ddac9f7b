"""Differences between policies, versions and settings, paired by seed."""

from __future__ import annotations

import csv
import io
import json

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.errors import ColonysimError
from colonysim.intervals import of_mean
from colonysim.sweep import run_sweep
from colonysim.sweep.comparing import _differences, compare, pooled
from colonysim.sweep.tables import read_table
from colonysim.trace.manifest import read_manifest, write_manifest

FILE = "scenarios: [sanity, {scenario: easy}]\npolicies: [paper, colony]\nseeds: {count: 8, first: 10}\nepisodes: 2\n"


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compared")
    (folder / "both.yaml").write_text(FILE)
    run_sweep(folder / "both.yaml", folder / "both", workers=2)
    return folder / "both"


def by_hand(directory, scenario: str, measure: str, first: int = 1) -> list[float]:
    found: dict[tuple[str, int], list[float]] = {}
    for row in read_table(directory, "episodes").to_pylist():
        if row["scenario"] == scenario and row["episode"] >= first:
            found.setdefault((row["policy"], row["seed"]), []).append(float(row[measure]))
    mean = {key: sum(values) / len(values) for key, values in found.items()}
    return [mean["colony", seed] - mean["paper", seed] for seed in range(10, 18)]


def test_two_policies_of_a_sweep_are_compared_map_by_map_and_seed_by_seed(sweep):
    found = compare([sweep], by="policy")
    assert {(each.where["scenario"], each.measure) for each in found} == {
        (name, measure) for name in ("sanity", "easy") for measure in ("success", "steps", "sim_seconds")
    }
    for each in found:
        values = by_hand(sweep, each.where["scenario"], each.measure)
        assert (each.reference, each.other, each.seeds) == ("paper", "colony", 8)
        assert each.difference == pytest.approx(sum(values) / 8) and each.interval == pytest.approx(of_mean(values))
        assert each.means[1] - each.means[0] == pytest.approx(each.difference)
    second = compare([sweep], by="policy", episodes=(2, 2))
    [late] = [each for each in second if (each.where["scenario"], each.measure) == ("easy", "steps")]
    assert late.difference == pytest.approx(sum(by_hand(sweep, "easy", "steps", 2)) / 8)


def test_pairing_takes_out_what_seeds_have_in_common(sweep, tmp_path):
    # The same trials in another directory differ in nothing, however much seeds do.
    (tmp_path / "again.yaml").write_text(FILE)
    run_sweep(tmp_path / "again.yaml", tmp_path / "again", workers=2)
    for each in compare([sweep, tmp_path / "again"], by="source"):
        assert each.difference == 0.0 and each.interval == (0.0, 0.0) and set(each.where) == {"scenario", "policy"}


def test_only_seeds_that_both_have_are_paired(sweep, tmp_path):
    (tmp_path / "few.yaml").write_text("scenarios: [easy]\npolicies: [oracle]\nseeds: [16, 17, 18]\nepisodes: 2\n")
    run_sweep(tmp_path / "few.yaml", tmp_path / "few", workers=1)
    found = [each for each in compare([sweep, tmp_path / "few"], by="policy") if each.other == "oracle"]
    assert {each.seeds for each in found} == {2} and {each.where["scenario"] for each in found} == {"easy"}


def _other(folder):
    colonysim.run("sanity", policy="paper", seed=3, episodes=2, out=folder / "other", record=("deposits", "frames"))
    return folder / "other"


def test_runs_and_versions(tmp_path):
    for version, seeds in (("1", (3, 4)), ("2", (3, 4))):
        for seed in seeds:
            out = tmp_path / f"{version}-{seed}"
            colonysim.run("sanity", policy="colony", seed=seed, episodes=2, out=out, record=("deposits", "frames"))
            manifest = read_manifest(out)
            write_manifest(out, {**manifest, "versions": {**manifest["versions"], "colonysim": version}})
    found = compare(sorted(path for path in tmp_path.iterdir()))
    assert {(e.by, e.reference, e.other, e.seeds, e.difference) for e in found} == {("version", "1", "2", 2, 0.0)}
    [one, *_] = compare([tmp_path / "1-3", tmp_path / "2-3"])
    assert one.interval is None and one.seeds == 1
    with pytest.raises(ColonysimError, match="there twice"):
        compare([tmp_path / "1-3", tmp_path / "2-3", _other(tmp_path)], by="policy")


def test_what_cannot_be_compared_is_one_message(sweep, tmp_path):
    with pytest.raises(ColonysimError, match="no column 'polcy' to compare by; did you mean 'policy'"):
        compare([sweep], by="polcy")
    with pytest.raises(ColonysimError, match="expected --by, one of scenario, policy"):
        compare([sweep])
    with pytest.raises(ColonysimError, match="backend is 'nodeworld' everywhere"):
        compare([sweep], by="backend")
    with pytest.raises(ColonysimError, match="no run or trial has finished"):
        compare([sweep], by="policy", episodes=(7, 9))
    with pytest.raises(ColonysimError):
        compare([tmp_path])


def test_directories_that_nothing_else_tells_apart_are_what_is_compared(tmp_path):
    text = "scenarios: [sanity]\npolicies: [paper, colony]\nseeds: {count: 2}\nepisodes: 1\n"
    for name, seeds in (("before", text), ("after", text), ("more", text.replace("count: 2", "count: 2, first: 5"))):
        (tmp_path / f"{name}.yaml").write_text(seeds)
        run_sweep(tmp_path / f"{name}.yaml", tmp_path / name, workers=1)
    found = compare([tmp_path / "before", tmp_path / "after"])
    assert {(each.by, each.where["policy"], each.difference) for each in found} == {
        ("source", "paper", 0.0), ("source", "colony", 0.0)
    }  # fmt: skip
    pooled = compare([tmp_path / "before", tmp_path / "more"])
    assert {(each.by, each.reference, each.other, each.seeds) for each in pooled} == {("policy", "paper", "colony", 4)}


def test_two_columns_at_once_are_refused(sweep):
    answer = CliRunner().invoke(app, ["compare", str(sweep), "--by", "policy", "--by", "scenario"])
    assert answer.exit_code == 2 and answer.stderr == (
        "Error: --by: given 2 times (policy, scenario), expected the one that is compared\n"
    )


def test_on_the_command_line(sweep):
    answer = CliRunner().invoke(app, ["compare", str(sweep), "--by", "policy", "--json"])
    told = json.loads(answer.stdout)
    assert len(told["differences"]) == 6 and {row["seeds"] for row in told["differences"]} == {8}
    values = [value for name in ("sanity", "easy") for value in by_hand(sweep, name, "steps")]
    [steps] = [row for row in told["pooled"] if row["measure"] == "steps"]
    assert (steps["pairs"], steps["settings"], steps["reference"], steps["other"]) == (16, 2, "paper", "colony")
    assert steps["difference"] == pytest.approx(sum(values) / 16)
    assert [steps["difference_low"], steps["difference_high"]] == pytest.approx(of_mean(values))
    assert steps["other_mean"] - steps["reference_mean"] == pytest.approx(steps["difference"])
    answer = CliRunner().invoke(app, ["compare", str(sweep), "--by", "policy", "--episodes", "2"])
    assert answer.exit_code == 0 and "colony" in answer.stdout and "sim_seconds" in answer.stdout
    lines = [line for line in answer.stdout.splitlines() if "with policy colony" in line]
    assert [line.split(" is ")[0] for line in lines] == [
        "Success", "The number of steps", "The simulated time in seconds",
    ]  # fmt: skip
    assert answer.stdout.index(lines[-1]) < answer.stdout.index("each setting by itself")
    assert CliRunner().invoke(app, ["compare", str(sweep)]).exit_code == 2


def test_a_difference_of_shares_is_no_larger_than_one(sweep):
    for each in compare([sweep], by="policy", episodes=(1, 1)):
        if each.measure == "success":
            assert each.interval is not None and -1.0 <= each.interval[0] <= each.interval[1] <= 1.0
    found = _differences({}, "policy", "a", "b", _seeds(1.0, 0.0, 0.0), _seeds(0.0, 1.0, 1.0))
    assert {each.measure: each.interval for each in found}["success"] == (-1.0, 1.0)


def _seeds(*success: float) -> dict[int, dict[str, float]]:
    return {seed: {"success": value, "steps": 1.0, "sim_seconds": 1.0} for seed, value in enumerate(success)}


@pytest.mark.parametrize(
    ("one", "two", "said"),
    [
        ((9.0, 8.0, 9.0), (4.0, 3.0, 5.0), "4.7 lower with policy b than with policy a, over 3 pairs of runs: the 95 % "
         "interval of the difference, -6.1 to -3.2, leaves 0 out, so this is more than chance."),
        ((9.0, 1.0, 9.0), (4.0, 3.0, 9.5), "0.8 lower with policy b than with policy a, over 3 pairs of runs, but the "
         "95 % interval of the difference, -10.0 to +8.3, holds 0: this may be chance."),
        ((9.0, 1.0), (9.0, 1.0), "on average the same with policy b as with policy a, over 2 pairs of runs: no pair "
         "differs."),
        ((9.0,), (4.0,), "5.0 lower with policy b than with policy a, over one pair of runs: too few to tell a "
         "difference from chance."),
    ],
)  # fmt: skip
def test_what_a_pooled_effect_means_is_said_in_a_sentence(one, two, said):
    first, second = ({n: {**row, "steps": steps[n]} for n, row in _seeds(*steps).items()} for steps in (one, two))
    [steps] = [each for each in pooled(_differences({}, "policy", "a", "b", first, second)) if each.measure == "steps"]
    assert steps.sentence == f"The number of steps is {said}" and steps.pairs == len(one)


def test_results_as_csv_hold_every_column_and_all_digits(sweep, tmp_path):
    rows = json.loads(CliRunner().invoke(app, ["results", str(sweep), "--json"]).stdout)
    answer = CliRunner().invoke(app, ["results", str(sweep), "--csv"])
    told = list(csv.DictReader(io.StringIO(answer.stdout)))
    assert [[*row] for row in told] == [[*row] for row in rows] and "steps_low" in told[0]
    assert [[float(row[name]) for name in ("success", "steps", "steps_high")] for row in told] == [
        [row[name] for name in ("success", "steps", "steps_high")] for row in rows
    ]
    assert CliRunner().invoke(app, ["results", str(sweep), "--csv", "-o", str(tmp_path / "a.csv")]).exit_code == 0
    assert (tmp_path / "a.csv").read_text() == answer.stdout
    before = (sweep / "trials.parquet").read_bytes()
    for words, said in (
        (["--csv", "-o", str(sweep / "trials.parquet")], "is part of the sweep"), (["--csv", "--json"], "one of them"),
        (["-o", str(tmp_path / "b")], "only with --csv"),
    ):  # fmt: skip
        refused = CliRunner().invoke(app, ["results", str(sweep), *words])
        assert refused.exit_code == 2 and said in refused.stderr
    assert (sweep / "trials.parquet").read_bytes() == before
    query = CliRunner().invoke(app, ["results", str(sweep), "--csv", "--sql", "SELECT 1/3 AS x, NULL AS y"])
    assert query.stdout == f"x,y\n{1 / 3!r},\n"
