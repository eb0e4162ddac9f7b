"""`colonysim validate`: what it warns of, and that it imports nobody's code."""

# ruff: noqa: E501 - tables

import sys

import pytest
from typer.testing import CliRunner

from colonysim.cli import app
from colonysim.errors import ScenarioError
from colonysim.geometry.layout import lay_out
from colonysim.scenario.loading import scenario_from_document

LINE = {"topology": {"kind": "line", "nodes": 4}, "agents": [0], "goal": 3}
PLANTED = "raise SystemExit('imported')"


def validated(*arguments):
    result = CliRunner().invoke(app, ["validate", *arguments])
    return result.exit_code, result.stdout, result.stderr


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--set", "policy=planted:Policy"], "policy planted:Policy, whose parameters are not checked here"),
        (["--set", 'policy.extra_fields=["planted:Field"]'], "field planted:Field"),
        (["--backend", "planted:Backend"], "backend planted:Backend"),
        (["--set", "physics.robot=planted:ROBOT"],
         "robot planted:ROBOT, whose numbers, and the room for it, are not checked here"),
        (["--set", "physics.robot=planted:ROBOT", "--backend", "physics"],
         "robot planted:ROBOT, whose numbers, and the room for it, are not checked here"),
    ],
)  # fmt: skip
def test_it_names_the_code_of_others_and_imports_none(tmp_path, monkeypatch, arguments, told):
    (tmp_path / "planted.py").write_text(PLANTED)
    monkeypatch.syspath_prepend(tmp_path)
    assert validated("easy", *arguments)[:2] == (
        0, f"easy: valid: 31 nodes, 52 edges, 2 holes, 2 boxes, 4 agents\neasy: a run imports {told}\n"
    )  # fmt: skip
    assert "planted" not in sys.modules


def test_a_function_that_is_named_as_policy_is_not_called(capfd):
    assert validated("easy", "--set", "policy=os:system")[0] == 0
    assert "sh:" not in capfd.readouterr().err


def test_parameters_of_our_own_policies_are_checked():
    assert validated("easy", "--set", "policy.beta=1.0e+300")[0] == 2
    assert validated("easy", "--set", "policy=colny")[2] == "Error: no policy 'colny'; did you mean 'colony'?\n"


def test_the_time_to_drive_is_that_of_the_robot():
    half = validated("easy", "--set", "stall_seconds=0.5", "--set", "physics={robot: half}")[2]
    assert "takes 3.93825 s to drive on a physics backend (2.22781 m)" in half


def test_numbers_of_a_robot_are_checked_for_every_backend():
    assert "physics.robot.length: got 3" in validated("easy", "--set", "physics.robot={length: 3}")[2]


def test_edges_longer_than_the_stall_are_warned_of():
    code, out, err = validated("easy", "--set", "stall_seconds=0.5")
    assert (code, out.count("valid")) == (0, 1)
    assert "Warning: easy: edge" in err
    assert "to travel, longer than stall_seconds (0.5)" in err
    assert "to drive on a physics backend" in err
    assert "to push a box over" in err
    assert validated("easy", "--set", "timing.travels=[[0, 1, 700]]")[2].count("takes 700 s to travel") == 1
    assert validated("easy")[2] == ""


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"topology": {"kind": "line", "nodes": 4, "spacing": 200}}, "physics: edge 0-1 is 320 m long, expected at most"),
        ({"topology": {"kind": "line", "nodes": 1000}}, "physics: node 626 lies 1001.6 m off"),
        ({"topology": {"kind": "line", "nodes": 4, "z": 1}, "physics": {"z_scale": 1e4}}, "m off, expected at most 1000 m; see z_scale"),
        ({"topology": {"kind": "grid", "columns": 150, "rows": 150}}, "physics: 22500 nodes, expected at most 20000"),
        ({"topology": {"kind": "grid", "columns": 130, "rows": 130}, "agents": {"count": 501, "seed": 1}},
         "physics: 501 robots and boxes, expected at most 500"),
        ({"boxes": [[1, 1.0]], "physics": {"z_scale": 100}}, "boxes.0: the box is 100 m high, expected 0.01 to 10 m"),
    ],
)  # fmt: skip
def test_what_no_engine_can_move_is_refused(changes, message):
    with pytest.raises(ScenarioError, match=message.replace("(", "\\(")):
        lay_out(scenario_from_document({**LINE, **changes}))


@pytest.mark.parametrize("backend", ["physics", "bullet", "mujoco"])
def test_the_backend_is_checked_for_when_asked(tmp_path, backend):
    path = tmp_path / "far.yaml"
    path.write_text("nodes: [[0, 0, 0], [1, 1, 0], [2, 1.0e+9, 0]]\nedges: [[0, 1], [1, 2]]\nagents: [0]\ngoal: 1\n")
    assert validated(str(path))[0] == 0
    code, _, err = validated(str(path), "--backend", backend)
    assert code == 2
    assert "edge 1-2 is 1.6e+09 m long" in err
