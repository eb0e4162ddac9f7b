"""Which robot a scenario asks for, what is said of one that does not fit, and that opening a run imports nothing."""

# ruff: noqa: E501 - tables

import json
import subprocess
import sys
from importlib.metadata import EntryPoint

import pytest

import colonysim
from colonysim import plugins
from colonysim.errors import PluginError, ScenarioError
from colonysim.geometry.drawing import draw
from colonysim.geometry.layout import lay_out
from colonysim.geometry.robot_choice import robot_of, robots_of, with_robot
from colonysim.physics import HALF, STANDARD
from colonysim.scenario.loading import load_scenario, scenario_from_document

LANE = {
    "topology": {"kind": "line", "nodes": 6, "spacing": 1.0}, "agents": [0], "goal": 5,
    "holes": [{"node": 3, "depth": 1.0}], "boxes": [[1, 1.0]],
}  # fmt: skip
PLANTED = """
from dataclasses import replace
import colonysim.physics as physics
SMALL = replace(physics.STANDARD.scaled(0.7), wheel_speed=7.0)
HUGE = physics.STANDARD.scaled(9.0)
NONE = 3
"""


def lane(robot=None, **changes):
    physics = {**changes.pop("physics", {}), **({} if robot is None else {"robot": robot})}
    return scenario_from_document({**LANE, **changes, "physics": physics})


@pytest.fixture
def planted(tmp_path, monkeypatch):
    (tmp_path / "planted_robots.py").write_text(PLANTED)
    monkeypatch.syspath_prepend(tmp_path)
    yield "planted_robots"
    sys.modules.pop("planted_robots", None)


def test_the_standard_robot_unless_another_is_asked_for():
    assert robot_of(lane()) == STANDARD
    assert robot_of(lane("half")) == HALF
    assert robot_of(lane({"preset": "half"})) == HALF
    assert robot_of(lane({"scale": 0.5})) == HALF
    slow = robot_of(lane({"preset": "half", "wheel_speed": 7.0}))
    assert (slow.wheel_speed, slow.length) == (7.0, HALF.length)


def test_what_is_left_open_has_the_size_of_the_robot():
    layout, drawing = lay_out(lane("half")), draw(lane("half"))
    standard = lay_out(lane())
    assert layout.terrain == standard.terrain and layout.places == standard.places and layout.boxes == standard.boxes
    assert drawing.places == tuple((x / 2, y / 2) for x, y in standard.places)
    assert (drawing.pits[0].side, drawing.pits[0].depth, drawing.boxes[0].length) == (0.6, 0.125, 0.5)
    given = lay_out(lane("half", physics={"xy_scale": 1.6, "box_mass": 1.5}))
    assert given.places[1][0] == 3.2 and given.boxes[0].mass == pytest.approx(12.0)
    assert draw(load_scenario("hard")).slabs == tuple(lay_out(load_scenario("hard")).terrain.slabs())


@pytest.mark.parametrize(
    ("robot", "message"),
    [
        ("halv", "physics.robot: no robot 'halv'; did you mean 'half'?"),
        ({"preset": "halv"}, "physics.robot.preset: no robot 'halv'; did you mean 'half'?"),
        ({"wheel_sped": 6.0}, "physics.robot.wheel_sped: unknown field; did you mean 'wheel_speed'?"),
        ({"wheel_speed": 1.0}, "physics.robot.wheel_speed: got 1, expected"),
        ({"wheel_speed": 20.0}, "physics.robot.wheel_speed: got 20, expected 3 to 8, with which the controls work; they ask for no more, so"),
        ({"wheel_speed": 17.0, "wheel_radius": 0.08}, "physics.robot.wheel_speed: got 17, expected 3 to 12, with"),
        ({"wheel_radius": 0.06}, "physics.robot.wheel_radius: got 0.06, expected 0.08 to 0.15, with"),
        ({"preset": "half", "wheel_speed": 12.0}, "physics.robot.wheel_speed: got 12, expected 4.243 to 11.31 at scale 0.5, with"),
        ({"scale": 0.5, "chassis_mass": 100.0}, "physics.robot.chassis_mass: got 100, expected"),
        ({"scale": 20.0}, "physics.robot.scale: got 20, expected 0.2 to 4"),
        ({"track": "wide"}, "physics.robot.track: got 'wide', expected a number"),
        (3, "physics.robot: "),
        ([1], "physics.robot: got a list of 1, expected a robot's name, or {preset: ..., numbers}"),
        ("planted_robots:SMALL", "physics.robot: 'planted_robots:SMALL' is a robot of other code"),
    ],
)
def test_a_robot_that_is_none_is_told_by_its_field(robot, message):
    with pytest.raises(ScenarioError) as error:
        lay_out(lane(robot))
    assert message in str(error.value)


@pytest.mark.parametrize(("robot", "field"), [({"length": 3.0}, "robot.length: got 3"), ("haf", "robot: no robot 'haf'")])
def test_a_robot_that_is_none_is_refused_on_the_node_world_too(robot, field):
    with pytest.raises(ScenarioError, match=f"physics.{field}"):
        list(colonysim.simulate(lane(robot), episodes=1))


def test_the_line_of_the_field_is_told(tmp_path):
    path = tmp_path / "slow.yaml"
    path.write_text(json.dumps(LANE)[:-1] + ', "physics": {\n "robot": {\n  "wheel_speed": 1.0}}}')
    with pytest.raises(ScenarioError, match=r"slow.yaml:3:3: physics.robot.wheel_speed: got 1, expected"):
        lay_out(load_scenario(path))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"physics": {"pit_side": 1.02}}, "physics.pit_side: the pit at hole 3 is 1.02 m wide, expected at least 1.03"),
        ({"physics": {"box_length": 0.3}}, "physics.box_length: the box at node 1 is 0.3 m wide, expected"),
        ({"physics": {"box_mass": 80.0}}, "physics.box_mass: the box at node 1 takes 314 N to push, expected"),
        ({"robot": {"chassis_mass": 8.0, "grip": 0.4}}, "the box at node 1 takes 47.1 N to push"),
        ({"physics": {"xy_scale": 1.2, "pit_side": 1.8}},
         "topology: node 2 lies 0.30 m from the pit of hole 3, too close for a robot, expected at least 0.40 m;"
         " physics.xy_scale: 1.4 would do (it is 1.2)"),
        ({"physics": {"xy_scale": 0.7}, "agents": [0, 1], "boxes": [[2, 1.0]]},
         "topology: nodes 0 and 1 are 0.70 m apart, too close for two of the robots, expected at least 0.75 m;"
         " physics.xy_scale: 1.05 would do (it is 0.7)"),
        ({"physics": {"xy_scale": 0.9}},
         "topology: node 0 lies 0.40 m from the box at node 1, too close for a robot that gets there or takes hold of it,"
         " expected at least 0.51 m; physics.xy_scale: 1.1 would do (it is 0.9)"),
        ({"physics": {"xy_scale": 1.05}, "boxes": [[0, 1.0]], "agents": [1]},
         "topology: the nodes beside hole 3 lie at most 0.45 m from its pit, too close for a box that is pushed there first,"
         " expected at least 0.50 m; physics.xy_scale: 1.1 would do (it is 1.05)"),
        ({"robot": "half", "physics": {"box_length": 1.0}}, "the box at node 1 is 1 m wide, expected 0."),
        ({"robot": "half", "physics": {"xy_scale": 0.6, "pit_side": 0.9}},
         "node 2 lies 0.15 m from the pit of hole 3, too close for a robot, expected at least 0.20 m;"
         " physics.xy_scale: 0.7 would do (it is 0.6)"),
    ],
)  # fmt: skip
def test_a_place_that_is_too_narrow_names_its_nodes(changes, message):
    with pytest.raises(ScenarioError) as error:
        lay_out(lane(**changes))
    assert message in str(error.value)


def test_a_robot_of_others_becomes_numbers(planted, monkeypatch):
    scenario = with_robot(lane(f"{planted}:SMALL"))
    assert robot_of(scenario).wheel_speed == 7.0
    assert scenario.document["physics"]["robot"]["scale"] == 0.7
    assert scenario_from_document(scenario.document).digest == scenario.digest
    assert robot_of(with_robot(lane({"preset": f"{planted}:SMALL", "grip": 0.9}))).grip == 0.9
    points = [EntryPoint("small", f"{planted}:SMALL", "colonysim.robots")]
    monkeypatch.setattr(plugins, "entry_points", lambda group: points if group == "colonysim.robots" else [])
    assert with_robot(lane("small")).digest == scenario.digest
    with pytest.raises(ScenarioError, match=r"physics.robot.scale: got 9, expected"):
        with_robot(lane(f"{planted}:HUGE"))
    with pytest.raises(ScenarioError, match="planted_robots:NONE is int, expected a colonysim Robot"):
        with_robot(lane(f"{planted}:NONE"))
    with pytest.raises(PluginError, match="cannot be loaded"):
        with_robot(lane("no_such_module:IT"))


def grouped(*robots, physics=None):
    """A lane with a group for each of these robots; None for one that has none of its own."""
    groups = [
        {"name": f"g{n}", "agents": [n], **({} if robot is None else {"robot": robot})}
        for n, robot in enumerate(robots)
    ]
    made = {**LANE, "groups": groups, "boxes": [[2, 1.0]], **({} if physics is None else {"physics": physics})}
    del made["agents"]
    return scenario_from_document(made)


def test_groups_have_robots_of_their_own(planted):
    slow = grouped(None, {"wheel_speed": 5.0}, physics={"robot": {"grip": 0.9}})
    assert [(r.wheel_speed, r.grip) for r in robots_of(slow)] == [(8.0, 0.9), (5.0, 0.9)], "the rest is as that of all"
    assert lay_out(slow).models == draw(slow).models == robots_of(slow)
    named = robots_of(grouped(None, "standard", physics={"robot": {"grip": 0.9}}))
    assert [robot.grip for robot in named] == [0.9, 0.8]
    halves = robots_of(grouped("half", {"wheel_speed": 9.0}, physics={"robot": "half"}))
    assert halves[0] == HALF and (halves[1].wheel_speed, halves[1].length) == (9.0, HALF.length)
    other = with_robot(grouped(None, {"preset": f"{planted}:SMALL"}, physics={"robot": {"scale": 0.7}}))
    assert robots_of(other)[1].wheel_speed == 7.0 and other.document["groups"][1]["robot"]["scale"] == 0.7
    assert scenario_from_document(other.document).digest == other.digest
    both = with_robot(grouped(None, {"grip": 0.9}, physics={"robot": f"{planted}:SMALL"}))
    assert [(robot.wheel_speed, robot.grip) for robot in robots_of(both)] == [(7.0, 0.8), (7.0, 0.9)]


@pytest.mark.parametrize(
    ("robot", "message"),
    [
        ("half", "groups.1.robot: a robot of scale 0.5 among robots of scale 1 (physics.robot), expected the same scale"),
        ({"scale": 2}, "groups.1.robot.scale: a robot of scale 2 among robots of scale 1"),
        ("halv", "groups.1.robot: no robot 'halv'; did you mean 'half'?"),
        ({"wheel_speed": 1.0}, "groups.1.robot.wheel_speed: got 1, expected 3 to 8"),
        ({"wheel_sped": 1.0}, "groups.1.robot.wheel_sped: unknown field; did you mean 'wheel_speed'?"),
        (7, "groups.1.robot: got 7, expected a robot's name, or {preset: ..., numbers}"),
        ({"chassis_mass": 8.0, "grip": 0.4}, "the box at node 2 takes 47.1 N to push"),
    ],
)
def test_a_robot_of_a_group_that_does_not_fit_is_told_by_its_field(robot, message):
    with pytest.raises(ScenarioError) as error:
        lay_out(grouped(None, robot))
    assert message in str(error.value)


def test_who_does_not_push_need_not_be_able_to():
    weak = grouped(None, {"chassis_mass": 8.0, "grip": 0.4}).document
    groups = [weak["groups"][0], {**weak["groups"][1], "pushes": False}]
    assert lay_out(scenario_from_document({**weak, "groups": groups})).models[1].grip == 0.4


def test_a_robot_of_a_group_is_refused_on_the_node_world_too():
    with pytest.raises(ScenarioError, match=r"groups\.1\.robot: a robot of scale 0\.5"):
        list(colonysim.simulate(grouped(None, "half"), episodes=1))


def test_whoever_opens_a_run_imports_nothing(planted, tmp_path):
    pytest.importorskip("pybullet")
    run = colonysim.run(lane(f"{planted}:SMALL"), backend="bullet", episodes=1, out=tmp_path / "run")
    (tmp_path / "planted_robots.py").write_text("raise SystemExit('imported')")
    program = (
        "import sys, colonysim\n"
        "from colonysim.geometry.drawing import draw\n"
        "scenario = colonysim.Run.open(sys.argv[1]).scenario\n"
        "print(draw(scenario).robot.wheel_speed, 'planted_robots' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", program, run.path], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["7.0", "False"]


STEEP = {
    "topology": None, "nodes": [[0, 0, 0], [1, 1, 0], [2, 2, 0, 3.0], [3, 3, 0, 3.0]], "edges": [[0, 1], [1, 2], [2, 3]],
    "slopes": [[1, 2]], "holes": [], "boxes": [[1, 1.0]], "goal": 3,
}  # fmt: skip
FLOOR = {"grounds": [{"xmin": -2.0, "ymin": -2.0, "xmax": 3.0, "ymax": 2.0, "z": 0.0}]}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({**STEEP, "physics": {"xy_scale": 0.8}},
         "slopes.0: slope 1-2 rises 0.38 m over 0.80 m (physics.z_scale is 0.125 by default, which makes the lowest box 0.125 m high), expected at least 1.25 m; physics.xy_scale: 1.25 would do (it is 0.8)"),
        ({"physics": {"pit_side": 0.5}}, "physics.pit_side: a pit of 0.5 m takes no box of 0.5 m, expected at least 0.5154 m"),
        ({"physics": {"box_height": 8.0}}, "boxes.0: the box is 8 m high, expected 0.005 to 5 m"),
        ({"physics": {"margin": 0.1}}, "physics.margin: 0.1 m of ground beyond the outermost nodes, expected at least 0.225 m"),
        ({"physics": {"z_scale": 60.0, "box_height": 0.2}}, "physics: hole 3 is 60 m deep, expected at most 25 m"),
        ({"physics": {"xy_scale": 101.0}}, "physics: edge 0-1 is 101 m long, expected at most 100 m"),
        ({"physics": {"terrain": FLOOR}}, "physics.terrain: no ground under node 4 (3.20, 0.00 m)"),
        ({"physics": {"terrain": {**FLOOR, "pits": [{"x": 2.3, "y": 0.0, "side": 0.6, "rim": 0.1, "depth": 0.1}]}}},
         "physics.terrain: no ground at the rim's height, 0.10 m, round the pit at 2.30, 0.00 m"),
    ],
)  # fmt: skip
def test_lengths_are_told_in_the_metres_of_the_file(changes, message):
    with pytest.raises(ScenarioError) as error:
        lay_out(lane("half", **changes))
    assert f"<document>: {message}" in str(error.value)
    assert "times" not in str(error.value)


def test_the_scale_that_is_proposed_for_another_robot_does():
    for robot, small in (("half", 0.3), ({"scale": 0.7}, 0.45), ({"scale": 2.0}, 1.3)):
        with pytest.raises(ScenarioError, match="would do") as error:
            lay_out(lane(robot, physics={"xy_scale": small}))
        scale = float(str(error.value).partition("xy_scale: ")[2].split()[0])
        lay_out(lane(robot, physics={"xy_scale": scale}))


def test_nodes_that_are_too_close_are_told_by_their_line(tmp_path):
    path = tmp_path / "narrow.yaml"
    path.write_text(
        "nodes:\n  - [0, 0, 0]\n  - [1, 0.4, 0]\n  - [2, 2, 0]\nedges:\n  - [0, 1]\n  - [1, 2]\nagents: [0, 1]\ngoal: 2\n"
    )
    with pytest.raises(
        ScenarioError, match=r"narrow.yaml:6:5: edges.0: nodes 0 and 1 are 0.64 m .*xy_scale: 1.9 would"
    ):
        lay_out(load_scenario(path))


def test_a_slope_made_steep_by_a_low_box_says_so():
    with pytest.raises(ScenarioError, match=r"z_scale is 5 by default, which makes the lowest box 0\.25 m") as error:
        lay_out(lane(**{**STEEP, "boxes": [[1, 0.05]], "reach": 0.01}))
    assert "rises 15.00 m" in str(error.value)
    with pytest.raises(ScenarioError, match=r"z_scale is 2\.5 by default, which makes the lowest box 0\.125 m"):
        lay_out(lane("half", **{**STEEP, "boxes": [[1, 0.05]], "reach": 0.01}))
