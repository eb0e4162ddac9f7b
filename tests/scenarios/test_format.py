"""What a scenario file can say, and that saying it another way gives the same colony."""

import json
import math
import pickle
import random
import time
from pathlib import Path

import pytest
from hypothesis import given, settings

from colonysim.errors import ScenarioError
from colonysim.scenario.loading import load_scenario, scenario_from_document
from colonysim.scenario.source import read_text
from colonysim.testing.strategies import documents, scenarios
from colonysim.testing.worlds import random_scenario

LINE = {"topology": {"kind": "line", "nodes": 5}, "agents": [0], "goal": 4}


def scenario(**fields):
    return scenario_from_document({**LINE, **fields})


def test_defaults():
    line = scenario()
    assert (line.detection_radius, line.reach, line.max_steps, line.episodes) == (5.0, 0.3, 50, 30)
    assert (line.mode, line.stall_seconds, line.time_limit, line.policy) == ("asynchronous", 600.0, None, "stigmergy")
    assert line.timing.jitter == 0.1
    assert not line.parameters
    assert not line.physics


def test_nodes_edges_holes_and_boxes_in_either_form():
    short = scenario_from_document({
        "nodes": [[7, 0, 0, 1], [3, 1, 0], [5, 2, 0, 1]], "edges": [[7, 3], [3, 5]],
        "holes": [3], "boxes": [[3, 1.0]], "agents": [7], "goal": 5,
    })  # fmt: skip
    long = scenario_from_document({
        "nodes": [{"id": 7, "at": [0, 0], "z": 1}, {"id": 3, "at": [1, 0]}, {"id": 5, "at": [2, 0], "z": 1}],
        "edges": {"radius": 1}, "holes": [{"node": 3}], "boxes": [{"node": 3, "height": 1}], "agents": [7], "goal": 5,
    })  # fmt: skip
    for each in (short, long):
        assert each.topology.ids == (7, 3, 5)
        assert each.topology.z == (1.0, 0.0, 1.0)
        assert each.topology.neighbours == ((1,), (0, 2), (1,))
        assert [(hole.node, hole.floor, hole.rim) for hole in each.holes] == [(1, 0.0, 1.0)]
        assert (each.agents, each.goal, each.boxes[0].node) == ((0,), 2, 1)


def test_a_hole_by_depth_digs_below_the_nodes_z():
    dug = scenario(holes=[{"node": 2, "depth": 0.7}], boxes=[[1, 0.7]])
    assert dug.topology.z[2] == pytest.approx(-0.7)
    assert (dug.holes[0].rim, dug.holes[0].depth) == (0.0, pytest.approx(0.7))


def test_the_rim_is_the_highest_neighbour_that_is_no_hole():
    nodes = [[0, 0, 0, 1], [1, 1, 0, 0], [2, 2, 0, 3], [3, 1, 1, 1.2], [4, 0, 1, 1]]
    edges = [[0, 1], [1, 2], [1, 3], [0, 4], [3, 4]]
    holes = [1, {"node": 2, "depth": 1}]
    made = scenario_from_document({"nodes": nodes, "edges": edges, "holes": holes, "agents": [0], "goal": 4})
    assert made.holes[0].rim == 1.2
    assert made.holes[1].rim == 3


def test_edges_by_radius_include_and_exclude():
    nodes = [[i, i * 0.1, 0] for i in range(6)]  # .1 apart in decimals, not in binary
    document = {"nodes": nodes, "edges": {"radius": 0.1}, "agents": [0], "goal": 5}
    assert scenario_from_document(document).topology.edge_count == 5
    document["edges"] = {"radius": 0.1, "include": [[0, 5]], "exclude": [[2, 3]]}
    topology = scenario_from_document(document).topology
    assert topology.neighbours[0] == (1, 5)
    assert topology.neighbours[2] == (1,)


def test_edges_by_radius_are_those_of_comparing_all_pairs():
    rng = random.Random(3)
    points = [(rng.uniform(-5, 5), rng.uniform(-5, 5)) for _ in range(150)]
    nodes = [[i, x, y] for i, (x, y) in enumerate(points)]
    document = {"nodes": nodes, "edges": {"radius": 1.7, "include": [[0, 1]]}, "agents": [0], "goal": 1}
    topology = scenario_from_document(document).topology
    expected = {(i, j) for i in range(150) for j in range(i) if math.dist(points[i], points[j]) <= 1.7} | {(1, 0)}
    assert {(i, j) for i in range(150) for j in topology.neighbours[i] if j < i} == expected


def test_generated_places():
    grid = scenario(topology={"kind": "grid", "columns": 4, "rows": 3, "spacing": 2}).topology
    assert (len(grid), grid.edge_count, grid.x[5], grid.y[5]) == (12, 17, 2.0, 2.0)
    crossed = scenario(topology={"kind": "grid", "columns": 4, "rows": 3, "diagonals": True}).topology
    assert crossed.edge_count == 17 + 12
    holed = scenario(topology={"kind": "grid", "columns": 3, "rows": 3, "without": [4], "z": 2}, goal=8)
    assert holed.topology.ids == (0, 1, 2, 3, 5, 6, 7, 8)
    assert (holed.topology.edge_count, holed.topology.z[0], holed.goal) == (8, 2.0, 7)
    ring = scenario(topology={"kind": "ring", "nodes": 6}).topology
    assert ring.edge_count == 6
    assert all(length == pytest.approx(1, abs=1e-5) for lengths in ring.lengths for length in lengths)


@pytest.mark.parametrize(("radius", "apart"), [(1.5, 0.0), (0.3, 0.0), (2.0, 0.6)])
def test_random_geometric_graphs_are_connected_and_depend_on_their_seed_only(radius, apart):
    kind = {"kind": "geometric", "nodes": 80, "radius": radius, "seed": 5, "apart": apart}
    first, again = scenario(topology=kind).topology, scenario(topology=kind).topology
    assert (first.x, first.neighbours) == (again.x, again.neighbours)
    assert first.x != scenario(topology={**kind, "seed": 6}).topology.x
    seen, waiting = {0}, [0]
    while waiting:
        new = set(first.neighbours[waiting.pop()]) - seen
        seen |= new
        waiting += new
    assert len(seen) == 80
    assert all(
        math.hypot(first.x[i] - first.x[j], first.y[i] - first.y[j]) >= apart for i in range(80) for j in range(i)
    )


def test_a_geometric_graph_may_stay_in_parts():
    kind = {"kind": "geometric", "nodes": 9, "radius": 0.001, "seed": 5, "connected": False}
    with pytest.raises(ScenarioError, match="has 1 of 9 nodes"):
        scenario(topology=kind)


def test_timing_by_edge():
    timing = scenario(timing={"travels": [[0, 1, 3], [1, 2, 4], [2, 1, 5]], "pushes": [[0, 1, 9]]}).timing
    assert timing.travels == {(0, 1): 3.0, (1, 0): 3.0, (1, 2): 4.0, (2, 1): 5.0}
    assert timing.pushes == {(0, 1): 9.0}


def test_policy_parameters_are_handed_on_unchanged():
    assert scenario(policy="random").policy == "random"
    made = scenario(policy={"name": "mine:Policy", "preset": "paper", "patience": None, "nested": {"a": [1, 2.5]}})
    assert made.policy == "mine:Policy"
    assert made.parameters == {"preset": "paper", "patience": None, "nested": {"a": [1, 2.5]}}


def test_physics_holds_what_was_said_and_nothing_else():
    assert scenario(physics={"xy_scale": 2, "margin": None}).physics == {"xy_scale": 2.0}
    terrain = {"grounds": [{"xmin": 0, "ymin": 0, "xmax": 1, "ymax": 1, "z": 0}]}
    assert scenario(physics={"terrain": terrain}).physics["terrain"]["pits"] == []


def test_variants_merge_mappings_and_replace_lists():
    document = {
        **LINE, "policy": {"name": "a", "beta": 1, "gamma": 2}, "boxes": [[1, 1], [2, 1]],
        "variants": {
            "x": {"policy": {"beta": 5}, "boxes": [[3, 2]]},
            "round": {"topology": {"kind": "ring", "nodes": 5}},
            "random": {"policy": "random"},
            "same": None,
        },
    }  # fmt: skip
    x = scenario_from_document(document, variant="x")
    assert x.parameters == {"beta": 5, "gamma": 2}
    assert [(box.node, box.height) for box in x.boxes] == [(3, 2.0)]
    assert scenario_from_document(document, variant="round").topology.edge_count == 5
    assert scenario_from_document(document, variant="random").parameters == {}
    assert scenario_from_document(document, variant="same").digest == scenario_from_document(document).digest
    assert "variants" not in x.document


def test_overrides_come_last_and_are_read_as_yaml():
    made = load_scenario("hard", "r5-6", ["detection_radius=7", "policy.beta=2", "policy.tags=[a, 1]", "agents.5=27"])
    assert made.detection_radius == 7
    assert made.parameters == {"beta": 2, "tags": ["a", 1]}
    assert made.topology.ids[made.agents[5]] == 27
    same = {"detection_radius": 7, "policy.beta": 2, "policy.tags": ["a", 1], "agents.5": 27}
    assert load_scenario("hard", "r5-6", same).digest == made.digest
    assert load_scenario("hard", overrides=["policy=random", "policy.x=1"]).parameters == {"x": 1}
    assert load_scenario("hard", overrides=["time_limit=null"]).time_limit is None


def test_words_and_numbers_are_those_of_yaml_1_2():
    value, _ = read_text("[no, on, 1e3, 1:30, 0777, +5, -.5, ~, True, '1', 2020-01-01, !!str 1, 1_000]", "x")
    assert value == ["no", "on", 1000.0, "1:30", 777, 5, -0.5, None, True, "1", "2020-01-01", "1", "1_000"]


def test_a_small_alias_is_a_copy():
    value, positions = read_text("a: &p {x: [1]}\nb: *p\n", "x")
    assert value["a"] == value["b"]
    assert value["a"]["x"] is not value["b"]["x"]
    assert positions["a.x.0"] == (1, 12)
    assert positions["b"] == (2, 1)


def test_positions_are_those_of_the_file():
    hard = load_scenario("hard")
    lines = Path(hard.source).read_text(encoding="utf-8").splitlines()
    texts = {"goal": "goal: 6", "slopes.0": "[30, 17]", "no_push.3": "[16, 18]", "physics.z_scale": "z_scale"}
    for path, text in texts.items():
        line, column = hard.positions[path]
        assert lines[line - 1][column - 1 :].startswith(text)


def test_a_document_rebuilds_its_scenario():
    made = load_scenario("hard", "r5-6", ["policy.beta=2"])
    again = scenario_from_document(json.loads(json.dumps(made.document)))
    assert again.digest == made.digest
    assert again.document == made.document
    assert (again.topology, again.agents) == (again.topology, made.agents)
    assert again.topology.neighbours == made.topology.neighbours
    assert pickle.loads(pickle.dumps(made)).digest == made.digest  # worker processes get scenarios so


def test_the_callers_document_is_left_alone():
    document = {**LINE, "policy": "random", "variants": {"a": {"goal": 3}}}
    before = json.dumps(document)
    made = scenario_from_document(document, variant="a", overrides={"policy.x": 1})
    assert json.dumps(document) == before
    assert made.goal == 3


def test_digests_depend_on_content_not_on_order():
    backwards = dict(reversed(LINE.items()))
    assert scenario_from_document(backwards).digest == scenario_from_document(LINE).digest
    assert scenario(goal=3).digest != scenario().digest


def test_the_goal_check_knows_stacks_stairs_and_slopes():
    deep = {"holes": [{"node": 2, "depth": 2}]}
    scenario(**deep, boxes=[[1, 1], [3, 1]])
    with pytest.raises(ScenarioError, match="no filling"):
        scenario(**deep, boxes=[[1, 1]])
    nodes = [[0, 0, 0, 0], [1, 1, 0, 0], [2, 2, 0, 0.4]]
    stairs = {"nodes": nodes, "edges": {"radius": 1}, "agents": [0], "goal": 2}
    with pytest.raises(ScenarioError, match=r"smallest step in its way is 0\.4 up from 1 to 2"):
        scenario_from_document(stairs)
    scenario_from_document({**stairs, "boxes": [[1, 0.2]]})  # a low box is a step
    scenario_from_document({**stairs, "slopes": [[1, 2]]})
    scenario_from_document({**stairs, "reach": 0.5})


def test_a_large_generated_place_loads_at_once():
    started = time.process_time()
    made = scenario(topology={"kind": "grid", "columns": 100, "rows": 100}, goal=9999)
    assert len(made.topology) == 10_000
    assert time.process_time() - started < 3  # about .2 s on an idle machine


def test_a_large_listed_place_loads(tmp_path):
    path = tmp_path / "large.yaml"
    rows = "".join(f"  - [{i}, {i % 100}, {i // 100}, 1.0]\n" for i in range(10_000))
    path.write_text(f"nodes:\n{rows}edges: {{radius: 1}}\nagents: [0]\ngoal: 9999\n")
    started = time.process_time()
    assert load_scenario(path).topology.edge_count == 19_800
    assert time.process_time() - started < 8  # about 1 s on an idle machine


@settings(max_examples=60, deadline=None)
@given(scenarios())
def test_random_scenarios_are_valid_and_rebuild(made):
    assert 4 <= len(made.topology) <= 12
    assert all(hole.depth > 0 for hole in made.holes)
    assert scenario_from_document(json.loads(json.dumps(made.document))).digest == made.digest


@settings(max_examples=40, deadline=None)
@given(documents())
def test_a_document_without_a_required_field_is_refused(document):
    for name in ("nodes", "edges", "agents", "goal"):
        with pytest.raises(ScenarioError, match=rf"^<document>: {name}: "):
            scenario_from_document({key: value for key, value in document.items() if key != name})


def test_random_scenarios_repeat_and_vary():
    assert random_scenario(11).digest == random_scenario(11).digest
    made = [random_scenario(seed) for seed in range(150)]
    assert len({one.digest for one in made}) == 150
    assert any(one.topology.rises for one in made)
    assert {len(one.holes) for one in made} == {0, 1, 2, 3}
    assert {len(one.agents) for one in made} == {1, 2, 3, 4}


def test_a_diagonal_that_may_not_cut_corners_keeps_to_both_nodes_beside_it():
    def pairs(**fields):
        kind = {"kind": "grid", "columns": 3, "rows": 3, "without": [4, 8], "diagonals": True, **fields}
        place = scenario(topology=kind, goal=1).topology
        return {(place.ids[i], place.ids[j]) for i in range(len(place)) for j in place.neighbours[i] if i < j}

    straight = {(0, 1), (1, 2), (0, 3), (2, 5), (3, 6), (6, 7)}
    assert pairs() == straight | {(1, 3), (1, 5), (3, 7), (5, 7)}
    assert pairs(cut_corners=False) == straight
    assert pairs(cut_corners=False, without=[8]) == straight | {
        (1, 4), (3, 4), (4, 5), (4, 7), (0, 4), (1, 3), (1, 5), (2, 4), (3, 7), (4, 6),
    }  # fmt: skip
    with pytest.raises(ScenarioError, match=r"topology\.cut_corners: false beside no diagonals"):
        pairs(cut_corners=False, diagonals=False)
