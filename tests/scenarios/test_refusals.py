"""Everything that can be wrong with a scenario gets one message: where, what, and the nearest right word."""

# ruff: noqa: E501 - a message is easier to read on one line

import re
from typing import Any

import pytest

from colonysim.errors import ScenarioError
from colonysim.scenario import generate, source
from colonysim.scenario.loading import load_scenario, scenario_from_document

GOOD = """\
name: good
nodes:
  - [0, 0, 0, 1]
  - [1, 1, 0, 1]
  - [2, 2, 0, 0]
  - [3, 3, 0, 1]
edges:
  radius: 1.1
  exclude: []
holes: [2]
boxes:
  - [1, 1.0]
agents: [0]
goal: 3
timing:
  travel: 2
policy: {name: stigmergy, beta: 4}
variants:
  far:
    detection_radius: 9
"""


def refused(tmp_path, text, **options):
    """The message for a file with this text, without the folder."""
    path = tmp_path / "x.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path, **options)
    assert caught.value.exit_code == 2
    assert "\n" not in str(caught.value)
    return str(caught.value).replace(f"{tmp_path}/", "")


def test_the_base_of_these_tests_is_good(tmp_path):
    path = tmp_path / "x.yaml"
    path.write_text(GOOD)
    scenario = load_scenario(path)
    assert scenario.goal == 3
    assert scenario.topology.edge_count == 3


CHANGED = [
    # what is written instead of what, and the message
    ("agents: [0]", "agens: [0]", "x.yaml:13:1: agens: unknown field; did you mean 'agents'?"),
    ("goal: 3", "goal: 3\nseed: 1", "x.yaml:15:1: seed: unknown field; the seed belongs to the run"),
    ("goal: 3", "goal: 3\nxy_scale: 1", "x.yaml:15:1: xy_scale: unknown field; did you mean 'physics.xy_scale'?"),
    ("goal: 3", "goal: 3\nphysics: {xyscale: 1}", "x.yaml:15:11: physics.xyscale: unknown field; did you mean 'xy_scale'?"),
    ("goal: 3", "goal: 3\n<<: {a: 1}", "x.yaml:15:1: <<: unknown field; merge keys"),
    ("travel: 2", "travle: 2", "x.yaml:16:3: timing.travle: unknown field; did you mean 'travel'?"),
    ("goal: 3", "", "goal: is missing, expected the node that all agents must reach"),
    ("goal: 3", "goal:", "x.yaml:14:1: goal: is missing"),
    ("goal: 3", "goal: three", "x.yaml:14:1: goal: got 'three', expected a whole number"),
    ("goal: 3", "goal: 3.5", "x.yaml:14:1: goal: got 3.5, expected a whole number"),
    ("goal: 3", "goal: true", "x.yaml:14:1: goal: got true, expected a whole number"),
    ("goal: 3", "goal: 7", "x.yaml:14:1: goal: there is no node 7, expected one of the 4 nodes 0 to 3; did you mean 3?"),
    ("goal: 3", "goal: 3\ngoal: 2", "x.yaml:15:1: goal: the key 'goal' stands twice, first on line 14"),
    ("goal: 3", "goal: 3\nmode: syncronous", "x.yaml:15:1: mode: got 'syncronous', expected asynchronous or synchronous; did you mean 'synchronous'?"),
    ("goal: 3", "goal: 3\nmax_steps: 0", "x.yaml:15:1: max_steps: got 0, expected at least 1"),
    ("goal: 3", "goal: 3\nreach: -1", "x.yaml:15:1: reach: got -1, expected at least 1e-06"),
    ("[3, 3, 0, 1]", "[3, 3]", "x.yaml:6:5: nodes.3: a value is missing, expected [id, x, y]"),
    ("[3, 3, 0, 1]", "[3, 3, 0, 1, 1]", "x.yaml:6:5: nodes.3: got a list of 5, expected [id, x, y]"),
    ("[3, 3, 0, 1]", "3", "x.yaml:6:5: nodes.3: got 3, expected [id, x, y]"),
    ("[3, 3, 0, 1]", "[3, 3, zero, 1]", "x.yaml:6:12: nodes.3.2: got 'zero', expected a number"),
    ("[3, 3, 0, 1]", "[-3, 3, 0, 1]", "x.yaml:6:6: nodes.3.0: got -3, expected at least 0"),
    ("[3, 3, 0, 1]", "[1, 3, 0, 1]", "x.yaml:6:5: nodes.3: node 1 is listed twice, first on line 4"),
    ("[3, 3, 0, 1]", "{id: 3, att: [3, 0]}", "x.yaml:6:13: nodes.3.att: unknown field, expected id, at or z; did you mean 'at'?"),
    ("[3, 3, 0, 1]", "{id: 3, at: [3]}", "x.yaml:6:13: nodes.3.at: a value is missing, expected [x, y]"),
    ("[3, 3, 0, 1]", "[3, .nan, 0, 1]", "x.yaml:6:9: nodes.3.1: .nan is not allowed, expected a finite number"),
    ("[3, 3, 0, 1]", "[3, 3, -.inf, 1]", "x.yaml:6:12: nodes.3.2: -.inf is not allowed"),
    ("[3, 3, 0, 1]", "[3, 3, 1e999, 1]", "x.yaml:6:12: nodes.3.2: 1e999 is out of range"),
    ("[3, 3, 0, 1]", "[3, 2, 0, 1]", "x.yaml:6:5: nodes.3: node 3 stands where node 2 stands"),
    ("exclude: []", "exclude: [[1, 9]]", "x.yaml:9:17: edges.exclude.0.1: there is no node 9"),
    ("exclude: []", "exclude: [[1, 1]]", "x.yaml:9:13: edges.exclude.0: joins node 1 with itself"),
    ("exclude: []", "exclude: [[1, 2, 3]]", "x.yaml:9:13: edges.exclude.0: got a list of 3, expected [from, to]"),
    ("exclude: []", "include: [[0, 1], [1, 0]]", "x.yaml:9:21: edges.include.1: edge 1-0 is listed twice"),
    ("radius: 1.1", "raduis: 1.1", "x.yaml:8:3: edges.raduis: unknown field, expected radius, include or exclude; did you mean 'radius'?"),
    ("radius: 1.1", "radius: 0", "x.yaml:8:3: edges.radius: got 0, expected at least 1e-06"),
    ("holes: [2]", "holes: [{node: 2, depth: -1}]", "x.yaml:10:19: holes.0.depth: got -1, expected at least 1e-06"),
    ("holes: [2]", "holes: [{node: 2, dept: 1}]", "x.yaml:10:19: holes.0.dept: unknown field, expected node or depth; did you mean 'depth'?"),
    ("holes: [2]", "holes: [2, two]", "x.yaml:10:12: holes.1: got 'two', expected a whole number"),
    ("holes: [2]", "holes: [2, [2]]", "x.yaml:10:12: holes.1: got a list of 1, expected a node's number, or {node"),
    ("holes: [2]", "holes: [2, 2]", "x.yaml:10:12: holes.1: node 2 is listed twice as a hole"),
    ("holes: [2]", "holes: 2", "x.yaml:10:1: holes: got 2, expected a list"),
    ("holes: [2]", "holes: [3]", "x.yaml:10:9: holes.0: the floor of hole 3 is 1, not below its rim 0"),
    ("holes: [2]", "holes: [0, 1, 2, 3]", "x.yaml:10:9: holes.0: hole 0 has no neighbour that could be its rim"),
    ("[1, 1.0]", "[1, 0]", "x.yaml:12:9: boxes.0.1: got 0, expected at least 1e-06"),
    ("[1, 1.0]", "[8, 1]", "x.yaml:12:6: boxes.0.0: there is no node 8"),
    ("[1, 1.0]", "{node: 1, heigth: 1}", "x.yaml:12:15: boxes.0.heigth: unknown field, expected node or height; did you mean 'height'?"),
    ("[1, 1.0]", "[1, 1.0]\n  - [1, 1.0]", "x.yaml:13:5: boxes.1: a second box stands on node 1, which is no hole"),
    ("agents: [0]", "agents: []", "x.yaml:13:1: agents: got an empty list, expected at least 1"),
    ("agents: [0]", "agents: 4", "x.yaml:13:1: agents: got 4, expected a list of nodes, or {count: ..., seed: ..., within: "),
    ("agents: [0]", "agents: {count: 2}", "x.yaml:13:1: agents.seed: is missing"),
    ("agents: [0]", "agents: {count: 2, sede: 1}", "x.yaml:13:20: agents.sede: unknown field, expected count, seed or within"),
    ("agents: [0]", "agents: {count: 20, seed: 1}", "x.yaml:13:10: agents.count: 20 agents, but only"),
    ("agents: [0]", "agents: [0, 12]", "x.yaml:13:13: agents.1: there is no node 12"),
    ("agents: [0]", "agents: [0, 3, 0]", "x.yaml:13:13: agents.1: an agent stands on the goal 3"),
    ("agents: [0]", "agents: [0, 0]", "x.yaml:13:13: agents.1: two agents stand on node 0, the other is agents.0"),
    ("agents: [0]", "agents: [2]", "x.yaml:13:10: agents.0: an agent stands in the hole 2"),
    ("agents: [0]", "agents: [1]", "x.yaml:13:10: agents.0: an agent and a box stand on node 1"),
    ("goal: 3", "goal: 2", "x.yaml:14:1: goal: node 2 is a hole, and no box is ever pushed to the goal"),
    ("[1, 1.0]", "[3, 1.0]", "x.yaml:12:5: boxes.0: a box stands on the goal 3, where agents arrive"),
    ("[1, 1.0]", "[1, 1.0e-9]", "x.yaml:12:9: boxes.0.1: got 1e-09, expected at least 1e-06"),
    ("[3, 3, 0, 1]", "[3, 2.0000001, 0, 1]", "x.yaml:6:5: nodes.3: node 3 stands where node 2 stands"),
    ("goal: 3", "goal: 3\n'<list>': 1", "x.yaml:15:1: <list>: unknown field"),
    ("goal: 3", 'goal: 3\nname: "a\\nb"', "x.yaml:15:1: name: the key 'name' stands twice"),
    ("name: good", 'name: "a\\nb"', "x.yaml:1:1: name: got 'a\\nb', expected one line of text"),
    ("name: good", f"name: {'é' * 101}", "x.yaml:1:1: name: got"),
    ("goal: 3", "goal: 3\nphysics: {xy_scale: 1.0e-5}", "x.yaml:15:11: physics.xy_scale: got 1e-05, expected at least 0.0001"),
    ("travel: 2", "travel: 1.0e-9", "x.yaml:16:3: timing.travel: an edge of length 1 takes 1e-09 s, expected 1e-06 to 1e+09 s"),
    ("radius: 1.1", "radius: 1.0e-300", "x.yaml:8:3: edges.radius: got 1e-300, expected at least 1e-06"),
    ("goal: 3", "goal: 3\nno_push: [[0, 3]]", "x.yaml:15:11: no_push.0: 0-3 is no edge, expected one; node 0 is joined with 1"),
    ("goal: 3", "goal: 3\nslopes: [[3, 2]]", "x.yaml:15:10: slopes.0: node 2 is a hole"),
    ("goal: 3", "goal: 3\ntopology: {kind: line, nodes: 4}", "x.yaml:2:1: nodes: stands beside `topology`"),
    ("travel: 2", "jitter: 1", "x.yaml:16:3: timing.jitter: got 1, expected less than 1"),
    ("travel: 2", "travel: 0", "x.yaml:16:3: timing.travel: 0 beside a travel_fixed of 0, expected some time"),
    ("travel: 2", "travels: [[0, 1, 2], [0, 1, 3]]", "x.yaml:16:24: timing.travels.1: edge 0-1 is listed twice"),
    ("travel: 2", "pushes: [[0, 3, 2]]", "x.yaml:16:12: timing.pushes.0: 0-3 is no edge"),
    ("beta: 4", "beta: .inf", "x.yaml:17:33: policy.beta: .inf is not allowed"),
    ("policy: {name: stigmergy, beta: 4}", "policy: [a]", "x.yaml:17:1: policy: got a list of 1, expected a policy's name, or {name"),
    ("    detection_radius: 9", "    detection_radus: 9", "x.yaml:20:5: variants.far.detection_radus: unknown field; did you mean 'detection_radius'?"),
    ("    detection_radius: 9", "    variants: {}", "x.yaml:20:5: variants.far.variants: cannot stand in a variant"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), CHANGED, ids=[row[1][:40] for row in CHANGED])
def test_a_wrong_field_is_named_with_its_place(tmp_path, old, new, message):
    assert old in GOOD
    assert message in refused(tmp_path, GOOD.replace(old, new))


GENERATED = [
    ("{kind: gird, rows: 3}", "topology.kind: unknown kind 'gird', expected grid, line, ring, geometric or rooms; did you mean 'grid'?"),
    ("{rows: 3}", "topology: the `kind` is missing"),
    ("grid", "topology: got 'grid', expected a mapping with a `kind`"),
    ("{kind: grid, rows: 3, colums: 3}", "x.yaml:1:33: topology.colums: unknown field; did you mean 'columns'?"),
    ("{kind: grid, rows: 3, columns: 3, diagonals: yes}", "x.yaml:1:45: topology.diagonals: got 'yes', expected true or false"),
    ("{kind: grid, rows: 3000, columns: 3000}", "topology: makes 9000000 nodes, expected at most 2000000"),
    ("{kind: rooms, rows: 300, columns: 300, size: 9, seed: 1}", "topology: makes 8994001 nodes"),
    ("{kind: rooms, rows: 3, columns: 3, size: 1, seed: 1}", "topology.size: got 1, expected at least 2"),
    ("{kind: ring, nodes: 2}", "topology.nodes: got 2, expected at least 3"),
    ("{kind: geometric, nodes: 9, radius: 1}", "topology.seed: is missing"),
    ("{kind: geometric, nodes: 99, radius: 1, seed: 1, apart: 5}", "topology: 99 nodes 5 apart do not fit into 10 x 10"),
    ("{kind: grid, rows: 1400, columns: 1400, diagonals: true}", "topology: makes 7831602 edges, expected at most 4000000"),
    ("{kind: line, nodes: 4, spacing: 1.0e+9}", "topology: has nodes at 3e+09, expected none beyond 1e+09"),
    ("{kind: geometric, nodes: 1000000, radius: 1, seed: 1}", "topology: about 4.5e+10 pairs of nodes would have to be compared"),
    ("{kind: geometric, nodes: 1000000, radius: 0.01, seed: 1, apart: 0.02}", "topology: 1000000 nodes 0.02 apart do not fit"),
    ("{kind: geometric, nodes: 5, radius: 1, seed: 1, width: 1.0e-6, height: 1.0e-6}", "topology: node"),
    ("{kind: line, nodes: 4, without: [4]}", "topology.without.0: there is no node 4"),
    ("{kind: line, nodes: 4, without: [2]}", "goal: no filling of holes lets the agent on node 0 reach the goal 3: no edge leads out"),
]  # fmt: skip


@pytest.mark.parametrize(("topology", "message"), GENERATED, ids=[row[0][:40] for row in GENERATED])
def test_a_wrong_generated_place(tmp_path, topology, message):
    assert message in refused(tmp_path, f"topology: {topology}\nagents: [0]\ngoal: 3\n")


TEXTS = [
    ("", "x.yaml: is empty, expected a scenario"),
    ("# nothing\n", "x.yaml: is empty, expected a scenario"),
    ("- 1\n", "x.yaml:1:1: a list stands at the top, expected fields such as `nodes:`"),
    ("word\n", "x.yaml:1:1: a single value stands at the top"),
    ("a: [1, 2\nb: 3\n", "x.yaml:2:2: did not find expected ',' or ']'"),
    ("a:\n\tb: 1\n", "x.yaml:2:1: found character that cannot start any token (YAML is indented with spaces, not tabs)"),
    ("a: 1\n---\nb: 1\n", "x.yaml:2:1: a second document starts here, expected one scenario per file"),
    ("name: caf\xe9\n".encode("latin-1"), "x.yaml:1:10: byte 0xe9 is not UTF-8"),
    ("name: x\n".encode("utf-16"), "x.yaml:1:1: byte 0xff is not UTF-8"),
    (b"a: 1\nname: x\x07\n", "x.yaml:2:8: the control character 0x07 is not allowed"),
    ("a: !!python/object:os.system [1]\n", "x.yaml:1:4: a: the tag !!python/object:os.system is not allowed"),
    ("a: !!python/name:os.system\n", "x.yaml:1:4: a: the tag !!python/name:os.system is not allowed"),
    ("a: !include other.yaml\n", "x.yaml:1:4: a: the tag !include is not allowed"),
    ("a: !!int word\n", "x.yaml:1:4: a: 'word' is no !!int"),
    ("? [a, b]\n: 1\n", "x.yaml:1:3: a list or mapping stands where a key was expected"),
    ("? *a\n: 1\n", "x.yaml:1:3: "),
    ("a: &a [*a]\n", "x.yaml:1:8: a.0: the alias *a stands inside or before its own anchor"),
    ("goal: " + "9" * 5000, "x.yaml:1:7: goal: 99999999999999999999... is out of range"),
    ("a: " + "[" * 50_000, ": nested deeper than 32 levels"),
    ("a: " + "[" * 40, ": nested deeper than 32 levels"),
    ("- " * 3000, ": nested deeper than 32 levels"),
    ('a: "\\x1b[31m"\n', "x.yaml:1:4: a: the character U+001B is not allowed"),
    ('"\\x1b": 1\n', "x.yaml:1:1: \\x1b: the character U+001B is not allowed in a name"),
    ("a: !%1b 1\n", "the tag !\\x1b"),
    ("a: 0." + "1" * 5000, "x.yaml:1:4: a: 0.111111111111111111... has more than 400 characters"),
    ("x" * 200 + ":\n  " + "y" * 200 + ": 1\n", "a field's name and those it stands under are 401 characters long"),
    ("a0: &a0 [" + "[" * 25 + "1" + "]" * 26 + "\na1: [" + "[" * 10 + "*a0" + "]" * 11, "nested deeper than 32 levels"),
    ("a: &a " + "x" * 100_000 + "\nb: [" + "*a, " * 10 + "]", "aliases stand for more than 10000 values"),
    ("a: 1\na: 2\n", "x.yaml:2:1: a: the key 'a' stands twice, first on line 1"),
    ("a: {b: 1, b: 2}\n", "x.yaml:1:11: a.b: the key 'b' stands twice, first on line 1"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "message"), TEXTS, ids=[repr(row[0][:20]) for row in TEXTS])
def test_a_text_that_is_no_scenario(tmp_path, text, message):
    assert message in refused(tmp_path, text)


def test_an_alias_bomb_is_refused_before_it_expands(tmp_path):
    lines = ["a: &a [" + ", ".join("1" * 10) + "]"]
    for before, name in zip("abcdefgh", "bcdefghi", strict=True):
        lines.append(f"{name}: &{name} [" + ", ".join([f"*{before}"] * 10) + "]")
    assert "d.7: aliases stand for more than 10000 values" in refused(tmp_path, "\n".join(lines))


def test_a_file_of_50_mb_is_refused_unread(tmp_path):
    path = tmp_path / "x.yaml"
    with path.open("wb") as stream:
        stream.truncate(50_000_000)
    with pytest.raises(ScenarioError, match=r"x\.yaml: the file holds 50\.0 MB, expected at most 16 MB"):
        load_scenario(path)


def test_more_values_than_any_scenario_needs(tmp_path, monkeypatch):
    monkeypatch.setattr(source, "MAX_VALUES", 100)
    assert "holds more than 100 values" in refused(tmp_path, f"a: {list(range(200))}")


def test_a_radius_that_joins_everything_with_everything(tmp_path, monkeypatch):
    monkeypatch.setattr(generate, "MAX_EDGES", 1000)
    nodes = ", ".join(f"[{i}, {i}e-3, 0]" for i in range(50))
    text = f"nodes: [{nodes}]\nedges: {{radius: 100}}\nagents: [0]\ngoal: 1\n"
    assert "x.yaml:2:9: edges.radius: radius 100 joins more than 1000 pairs" in refused(tmp_path, text)


def test_several_mistakes_are_counted(tmp_path):
    text = GOOD.replace("goal: 3", "goal: x").replace("holes: [2]", "holes: [y]")
    assert refused(tmp_path, text).endswith("(and 1 more)")


UNREACHABLE = [
    ("[1, 1.0]", "[1, 0.5]", "the smallest step in its way is 1 down from 1 to 2, level is less than 0.3, and the boxes' heights add up to 0.5"),
    ("radius: 1.1", "radius: 1.1\n  exclude: [[2, 3]]", "no edge leads out of its part of the place, which has 3 of 4 nodes"),
    ("[3, 3, 0, 1]", "[3, 3, 0, 2.5]", "the smallest step in its way is 2.5 up from 2 to 3"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "why"), UNREACHABLE)
def test_a_goal_that_no_filling_of_holes_could_reach(tmp_path, old, new, why):
    text = GOOD.replace("  exclude: []\n", "").replace(old, new)
    message = refused(tmp_path, text)
    assert re.match(r"x\.yaml:\d+:1: goal: no filling of holes lets the agent on node 0 reach the goal 3: ", message)
    assert why in message


def test_a_missing_file_and_near_names(tmp_path):
    (tmp_path / "mine.yaml").write_text(GOOD)
    with pytest.raises(ScenarioError, match=r"min\.yaml: no such file; did you mean 'mine\.yaml'\?"):
        load_scenario(tmp_path / "min.yaml")
    with pytest.raises(ScenarioError, match="is a directory, expected a YAML file"):
        load_scenario(tmp_path)
    with pytest.raises(ScenarioError, match=r"hrad: no such scenario, .* did you mean 'hard'\?"):
        load_scenario("hrad")
    with pytest.raises(ScenarioError, match=r"holds 16\.0 MB, expected at most"):
        load_scenario("/dev/zero")


def test_an_unknown_variant():
    with pytest.raises(
        ScenarioError, match=r"no variant 'r5_6', expected one of r20-4, r5-4, r5-6; did you mean 'r5-6'\?"
    ):
        load_scenario("hard", "r5_6")
    with pytest.raises(ScenarioError, match="no variant 'x', the scenario has none"):
        load_scenario("easy", "x")


def test_a_wrong_value_in_the_chosen_variant_points_into_it(tmp_path):
    text = GOOD.replace("detection_radius: 9", "agents: [0, 99]")
    assert "x.yaml:20:17: agents.1: there is no node 99" in refused(tmp_path, text, variant="far")


OVERRIDES = [
    ("detection_radus=3", "--set detection_radus=3: unknown field; did you mean 'detection_radius'?"),
    ("detection_radius=x", "--set detection_radius=x: got 'x', expected a number"),
    ("agents=[0, 99]", "--set agents=[0, 99]: agents.1: there is no node 99"),
    ("agents.0=99", "--set agents.0=99: there is no node 99"),
    ("agents.5=1", "--set agents.5=1: agents is a list of 1, expected a place from 0 to 0"),
    ("agents.²=1", "--set agents.²=1: agents is a list of 1, expected a place from 0 to 0"),
    ("agents." + "9" * 5000 + "=1", "9...: is no field, expected a path such as policy.beta"),
    ("a." * 100 + "b=1", "is no field, expected a path"),
    ("name=\udcff", "--set name=\\udcff: the control character 0xdcff is not allowed"),
    ("\udcff=1", "--set \\udcff=1: is no field"),
    ("goal.x=1", "--set goal.x=1: goal is no mapping or list, so it has no 'x'"),
    ("policy.beta=.nan", "--set policy.beta=.nan: .nan is not allowed"),
    ("policy.beta=[1", "--set policy.beta=[1: did not find expected ',' or ']'"),
    ("policy.beta=!!python/name:os.system", "the tag !!python/name:os.system is not allowed"),
    ("policy.beta", "--set policy.beta: expected FIELD=VALUE, for example policy.beta=2"),
    ("=1", "--set =1: expected FIELD=VALUE"),
    ("variants.far=1", "--set variants.far=1: variants cannot be set"),
    ("timing.travel=0", "--set timing.travel=0: 0 beside a travel_fixed of 0"),
]


@pytest.mark.parametrize(("override", "message"), OVERRIDES, ids=[row[0] for row in OVERRIDES])
def test_a_wrong_override_is_named_instead_of_the_file(tmp_path, override, message):
    assert message in refused(tmp_path, GOOD, overrides=[override])


@pytest.mark.parametrize("value", [float("nan"), float("inf"), object(), {1: 2}, b"x", {1, 2}, pytest.param(10**5000, id="huge"), "\ud800", "\x1b"])
def test_documents_from_python_are_plain_and_finite(value):
    document = {"topology": {"kind": "line", "nodes": 3}, "agents": [0], "goal": 2, "policy": {"beta": value}}
    with pytest.raises(ScenarioError, match=r"^<document>: policy\.beta: "):
        scenario_from_document(document)
    document["policy"] = {}
    with pytest.raises(ScenarioError, match=r"--set policy\.beta="):
        scenario_from_document(document, overrides={"policy.beta": value})


def test_a_policy_can_point_at_its_parameters(tmp_path):
    path = tmp_path / "x.yaml"
    path.write_text(GOOD)
    scenario = load_scenario(path, overrides=["policy.betta=2"])
    assert str(scenario.fault("policy.beta", "too hot")) == f"{path}:17:27: policy.beta: too hot"
    assert str(scenario.fault("policy.betta", "no")) == "--set policy.betta=2: no"
    assert str(scenario.fault("policy.gamma", "no")) == f"{path}:17:1: policy.gamma: no"
    assert str(scenario.fault("physics.margin", "no")) == f"{path}:1:1: physics.margin: no"


def test_a_name_too_long_for_a_file_and_no_text_at_all():
    with pytest.raises(ScenarioError, match=r"cannot be read: File name too long"):
        load_scenario("a" * 300)
    with pytest.raises(ScenarioError, match=r"\\udcff\.yaml: no such file"):
        load_scenario("\udcff.yaml")


def test_a_file_with_a_long_name_gives_a_name(tmp_path):
    path = tmp_path / f"{'x' * 200}.yaml"
    path.write_text(GOOD.replace("name: good\n", ""))
    assert len(load_scenario(path).name) == 100


def test_more_variants_than_anybody_checks(tmp_path):
    text = GOOD + "".join(f"  v{n}: {{}}\n" for n in range(1000))
    assert "variants: 1001 variants, expected at most 1000" in refused(tmp_path, text)


def test_a_scenario_is_shown_in_a_line(tmp_path):
    path = tmp_path / "x.yaml"
    path.write_text(GOOD)
    scenario = load_scenario(path)
    assert repr(scenario).startswith("<Scenario 'good': 4 nodes, 1 holes, 1 boxes, 1 agents")
    assert len(repr(scenario)) < 120
    assert repr(scenario.topology) == "<Topology: 4 nodes, 3 edges>"


def test_tiny_distances_that_nodes_keep_are_no_matter():
    topology = {"kind": "geometric", "nodes": 20, "radius": 3, "seed": 4, "apart": 5e-324}
    scenario = scenario_from_document({"topology": topology, "agents": [0], "goal": 7})
    topology = {**topology, "apart": 0}
    assert scenario.topology.x == scenario_from_document({"topology": topology, "agents": [0], "goal": 7}).topology.x


def test_a_radius_with_far_more_pairs_is_refused_before_they_are_looked_at(tmp_path, monkeypatch):
    monkeypatch.setattr(generate, "MAX_EDGES", 500)
    nodes = ", ".join(f"[{i}, {i}e-3, 0]" for i in range(100))
    text = f"nodes: [{nodes}]\nedges: {{radius: 100}}\nagents: [0]\ngoal: 1\n"
    assert "edges.radius: about 1e+04 pairs of nodes would have to be compared" in refused(tmp_path, text)


@pytest.mark.parametrize("document", [[], (), None, "nodes", 3])
def test_a_document_that_is_no_mapping(document: Any) -> None:
    with pytest.raises(ScenarioError, match=f"of type {type(document).__name__}, expected a mapping of fields"):
        scenario_from_document(document)
