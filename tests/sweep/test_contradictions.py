"""Settings that something else takes the place of are refused: results bear no labels that were never in force."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.errors import ColonysimError, ScenarioError
from colonysim.sweep import load_sweep

SAMPLE = "sample: {count: 2, ranges: {policy.beta: [1, 2]}}"


@pytest.mark.parametrize(
    ("text", "messages"),
    [
        ("modes: [asynchronous]\ngrid: {mode: [synchronous, asynchronous]}", (":3:8: grid.mode: ", "`modes:`")),
        ("policies: [colony]\ngrid: {policy.name: [random]}", (":3:8: grid.policy.name: ", "`policies:`")),
        ("policies: [null, paper]\ngrid: {policy: [random]}", (":3:8: grid.policy: ", "`policies:`")),
        ("policies: [paper]\ngrid: {policy.preset: [colony]}", (":3:8: grid.policy.preset: ", "policy 'paper'")),
        ("grid: {policy.name: [paper], policy.preset: [oracle]}", ("grid.policy.preset: ", "policy 'paper'")),
        ("episodes: 3\ngrid: {episodes: [1, 2]}", (":3:8: grid.episodes: ", "`episodes:`")),
        ("episodes: 3\nsample: {count: 2, ranges: {episodes: [1, 2]}}", ("sample.ranges.episodes: ", "`episodes:`")),
        ("grid: {policy.beta: [1, 2], policy: [colony]}", (":2:29: grid.policy: ", "'policy.beta'")),
    ],
)
def test_a_setting_that_would_not_hold(tmp_path, text, messages):
    (tmp_path / "s.yaml").write_text(f"scenarios: [sanity]\n{text}\n")
    with pytest.raises(ScenarioError) as refused:
        load_sweep(tmp_path / "s.yaml")
    assert all(message in str(refused.value) for message in messages), refused.value


@pytest.mark.parametrize(
    "text",
    [
        "modes: [null]\ngrid: {mode: [synchronous, asynchronous]}",
        "grid: {policy: [stigmergy, paper], policy.beta: [2]}",
        "policies: [stigmergy]\ngrid: {policy.preset: [colony, paper]}",
        f"policies: [colony, paper]\n{SAMPLE}",
        "grid: {episodes: [1, 2]}",
    ],
)
def test_a_setting_that_holds(tmp_path, text):
    (tmp_path / "s.yaml").write_text(f"scenarios: [sanity]\n{text}\n")
    assert len(load_sweep(tmp_path / "s.yaml").trials) in (2, 4)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("policies: [colony, 'own_nowhere:P']", ":2:20: policies.1: 'own_nowhere:P' "),
        ("policies: [colony, clony]", ":2:20: policies.1: no policy 'clony'"),
        ("grid: {policy.beta: [2], policy.betta: [2]}", ":2:26: grid.policy.betta: "),
        ("grid: {max_steps: [2, -3]}", ":2:8: grid.max_steps: "),
        ("grid: {policy.name: [clony]}", ":2:8: grid.policy.name: no policy 'clony'"),
        ("sample: {count: 1, ranges: {policy.betta: [1, 2]}}", "sample.ranges.policy.betta: "),
    ],
)
def test_a_fault_is_shown_where_it_stands(tmp_path, text, message):
    (tmp_path / "s.yaml").write_text(f"scenarios: [sanity]\n{text}\n")
    with pytest.raises(ScenarioError) as refused:
        load_sweep(tmp_path / "s.yaml")
    assert message in str(refused.value)


@pytest.mark.parametrize(
    ("option", "value", "setting"),
    [
        ("mode", "asynchronous", "mode=synchronous"),
        ("policy", "paper", "policy.name=colony"),
        ("policy", "paper", "policy=colony"),
        ("policy", "paper", "policy.preset=oracle"),
        ("episodes", 1, "episodes=2"),
    ],
)
def test_options_and_settings_of_a_run(tmp_path, monkeypatch, option, value, setting):
    monkeypatch.chdir(tmp_path)
    answer = CliRunner().invoke(app, ["run", "sanity", f"--{option}", str(value), "--set", setting])
    assert answer.exit_code == 2 and answer.stderr.startswith(f"Error: --set {setting}: contradicts "), answer.output
    assert answer.stderr.count("\n") == 1 and option in answer.stderr
    with pytest.raises(ColonysimError, match=f"{setting}: contradicts .*{option}.*; leave out either"):
        colonysim.run("sanity", overrides=[setting], **{option: value})
    assert not list(tmp_path.iterdir())
