"""Scenarios from standard input and pipes, which can be read once only."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from typer.testing import CliRunner

from colonysim.cli import app
from colonysim.errors import ScenarioError
from colonysim.scenario.loading import load_scenario
from colonysim.sweep.plan import load_sweep


def test_a_scenario_may_come_from_standard_input_or_a_pipe(tmp_path):
    """Also one with variants: it is read once, as it can be read only once."""
    text = (Path(__file__).parents[2] / "scenarios" / "hard.yaml").read_text(encoding="utf-8")
    for word in ("-", "/dev/stdin"):
        command = [sys.executable, "-m", "colonysim", "validate", word]
        checked = subprocess.run(command, input=text, capture_output=True, text=True, check=False)
        assert checked.returncode == 0 and checked.stdout.count("valid: ") == 4, checked.stderr
    pipe = tmp_path / "pipe.yaml"
    os.mkfifo(pipe)
    for _ in range(2):
        writer = threading.Thread(target=pipe.write_text, args=(text,))
        writer.start()
        assert load_scenario(pipe, "r5-6").variant == "r5-6"
        writer.join()


@pytest.mark.parametrize(("text", "message"), [
    ("", "<stdin>: is empty, expected a scenario"),
    ("agens: [0]", "<stdin>:1:1: agens: unknown field; did you mean 'agents'?"),
    ("# " + " " * 16_000_000, "<stdin>: the file holds 16.0 MB, expected at most 16 MB"),
])  # fmt: skip
def test_faults_of_standard_input(text, message):
    checked = CliRunner().invoke(app, ["validate", "-"], input=text)
    assert checked.exit_code == 2 and message in checked.stderr


def test_standard_input_without_a_name_is_called_scenario():
    text = "topology: {kind: line, nodes: 4}\nagents: [0]\ngoal: 3\n"
    ran = CliRunner().invoke(app, ["run", "-", "-n", "1", "--json", "--no-trace", "-q"], input=text)
    assert ran.exit_code == 0 and json.loads(ran.stdout)["scenario"] == "scenario"


def test_a_sweep_needs_scenarios_that_can_be_read_again(tmp_path):
    os.mkfifo(tmp_path / "pipe.yaml")
    for name in ("-", "pipe.yaml"):
        (tmp_path / "sweep.yaml").write_text(f"scenarios: ['{name}']")
        with pytest.raises(ScenarioError, match=f"scenarios.0: {name}: can be read once"):
            load_sweep(tmp_path / "sweep.yaml")
    with pytest.raises(ScenarioError, match="is no file"):
        load_sweep(tmp_path / "pipe.yaml")
