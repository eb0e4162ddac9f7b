"""The sections `groups` and `faults`: what is refused, and where the message points."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.scenario.faults import Faults
from colonysim.scenario.groups import Group

MAP = """topology: {kind: grid, columns: 6, rows: 6}
groups:
  - name: scouts
    agents: {count: 2, seed: 1}
    speed: 1.5
    detection_radius: 3
    pushes: false
    ignores: [D]
    policy: {beta: 0.5}
  - name: workers
    agents: [1, 2, 3]
goal: 35
faults:
  seed: 2
  move_fails: 0.05
  stops: {every: 30, seconds: 10}
"""
REFUSED = [
    ("scouts", "workers", r"10:5: groups\.1\.name: groups\.0 is called 'workers' too"),
    ("speed: 1.5", "sped: 1.5", r"5:5: groups\.0\.sped: unknown field; did you mean 'speed'\?"),
    ("speed: 1.5", "robot: half", r"5:5: groups\.0\.robot: a robot of scale 0\.5 among robots of scale 1"),
    ("speed: 1.5", "robot: {wheel_speed: 9}", r"5:13: groups\.0\.robot\.wheel_speed: got 9, expected 3 to 8"),
    ("speed: 1.5", "seed: 3", r"5:5: groups\.0\.seed: unknown field; the seed belongs to the run"),
    ("speed: 1.5", "speed: 0", r"5:5: groups\.0\.speed: got 0, expected at least 0\.001"),
    ("ignores: [D]", "ignores: D", r"8:5: groups\.0\.ignores: got 'D', expected a list of fields' names"),
    ("ignores: [D]", "ignores: [d]", r"8:15: groups\.0\.ignores\.0: no field 'd'; did you mean 'D'\?"),
    ("beta: 0.5", "d_max: 2", r"9:14: groups\.0\.policy\.d_max: d_max is 2\.0 here and 1\.5 in the policy of all"),
    ("{beta: 0.5}", "paper", r"9:5: groups\.0\.policy: distance_rule is 'literal' here"),
    ("beta: 0.5", "bta: 2", r"9:14: groups\.0\.policy\.bta: no such parameter; did you mean 'beta'\?"),
    ("{beta: 0.5}", "{weights: {D: 0}}", r"9:24: groups\.0\.policy\.weights\.D: no extra field 'D'"),
    ("{beta: 0.5}", "stigmrgy", r"9:5: groups\.0\.policy\.name: no policy 'stigmrgy'; did you mean 'stigmergy'\?"),
    ("{beta: 0.5}", "{name: random, beta: 1}", r"9:28: groups\.0\.policy\.beta: no such parameter"),
    ("{beta: 0.5}", "7", r"9:5: groups\.0\.policy: got 7, expected a policy's name, or \{name: \.\.\., parameters\}"),
    ("[1, 2, 3]", "[1, 2, 1]", r"11:20: groups\.1\.agents\.2: two agents stand on node 1, .* groups\.1\.agents\.0"),
    ("[1, 2, 3]", "{count: 40, seed: 1}", r"11:14: groups\.1\.agents\.count: 40 agents, but only"),
    ("[1, 2, 3]", "[]", r"11:5: groups\.1\.agents: got an empty list, expected at least 1"),
    ("[1, 2, 3]", "[1, 2, 99]", r"11:20: groups\.1\.agents\.2: there is no node 99"),
    ("goal: 35", "goal: 35\nagents: [4]", r"2:1: groups: stands beside `agents`, expected either"),
    ("groups:", "gruops:", r"2:1: gruops: unknown field; did you mean 'groups'\?"),
    ("name: workers", "pushes: true", r"10:5: groups\.1\.name: is missing, expected short name"),
    ("0.05", "1.5", r"15:3: faults\.move_fails: got 1\.5, expected at most 1"),
    ("move_fails", "move_fail", r"15:3: faults\.move_fail: unknown field; did you mean 'move_fails'\?"),
    ("every: 30, ", "", r"16:3: faults\.stops\.every: is missing, expected mean simulated seconds"),
    ("every: 30", "every: 0", r"16:11: faults\.stops\.every: got 0, expected at least 1e-06"),
    ("seed: 2", "seed: -2", r"14:3: faults\.seed: got -2, expected at least 0"),
]


def validated(folder: Path, text: str, *more: str):
    path = folder / "map.yaml"
    path.write_text(text)
    return CliRunner().invoke(app, ["validate", str(path), *more])


def test_what_it_becomes(tmp_path: Path) -> None:
    assert validated(tmp_path, MAP).exit_code == 0
    scenario = colonysim.load_scenario(tmp_path / "map.yaml")
    assert scenario.groups == (
        Group("scouts", range(2), 3.0, 1.5, False, ("D",), None, {"beta": 0.5}),
        Group("workers", range(2, 5), 5.0),
    )
    assert scenario.faults == Faults(2, 0.05, stop_every=30.0, stop_seconds=10.0)
    set_so = colonysim.load_scenario(
        tmp_path / "map.yaml", overrides=["groups.0.policy.beta=1", "groups.1.detection_radius=7", "faults=null"]
    )
    assert set_so.groups[0].parameters == {"beta": 1} and set_so.groups[1].detection_radius == 7.0
    assert set_so.faults is None


@pytest.mark.parametrize(("old", "new", "words"), REFUSED, ids=lambda text: text if len(text) < 30 else "-")
def test_what_is_refused_and_where(old: str, new: str, words: str, tmp_path: Path) -> None:
    told = validated(tmp_path, MAP.replace(old, new, 1))
    assert told.exit_code == 2
    assert re.search(rf"map\.yaml:{words}", told.output), told.output


@pytest.mark.parametrize("backend", ["physics", "bullet", "mujoco"])
def test_speeds_are_refused_for_rigid_bodies(backend: str, tmp_path: Path) -> None:
    told = validated(tmp_path, MAP, "--backend", backend)
    assert told.exit_code == 2 and "map.yaml:5:5: groups.0.speed: 1.5 is for backends without a clock" in told.output
    assert "a group's `robot`, as {wheel_speed: 5}, does" in told.output
    assert validated(tmp_path, MAP.replace("1.5", "1"), "--backend", backend).exit_code == 0


def test_code_of_others_is_named_and_not_imported(tmp_path: Path) -> None:
    told = validated(tmp_path, MAP.replace("{beta: 0.5}", "nobody.knows:Policy"))
    assert told.exit_code == 0 and "a run imports policy nobody.knows:Policy, whose parameters are not" in told.output
    told = validated(tmp_path, MAP.replace("{beta: 0.5}", "{extra_fields: ['nobody.knows:Field']}"))
    assert told.exit_code == 0 and "a run imports field nobody.knows:Field" in told.output


def test_neither_agents_nor_groups(tmp_path: Path) -> None:
    told = validated(tmp_path, "topology: {kind: line, nodes: 3}\ngoal: 2\n")
    assert told.exit_code == 2 and "agents: is missing" in told.output and "or `groups`" in told.output


def test_wiped_marks_are_looked_at_without_groups_too(tmp_path: Path) -> None:
    told = validated(
        tmp_path, "topology: {kind: line, nodes: 3}\nagents: [0]\ngoal: 2\nchanges:\n  - wipe: {fields: [Q]}\n"
    )
    assert told.exit_code == 2
    assert "changes.0.wipe.fields.0: the policy has no field 'Q'" in told.output
