"""From graphs to ground, pits, ramps, boxes and robots."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest
from backends.places import LANE, place, two_levels

from colonysim.errors import ScenarioError
from colonysim.geometry.layout import Layout, lay_out
from colonysim.physics import Scene
from colonysim.push.paths import FreeSpace, Surroundings
from colonysim.push.staging import MAX_MISMATCH, plan_push, quarter
from colonysim.push.task import PushTask
from colonysim.scenario.loading import load_scenario
from colonysim.scenario.scenario import Scenario

pytestmark = pytest.mark.usefixtures("engine")

SHIPPED = ("easy", "medium", "hard", "sanity", "junction", "deadlock")

NEEDED = {
    "easy": (("3", "4"), ("13", "30")),
    "medium": (("3", "4"), ("18", "13", "29"), ("25", "12", "20")),
    "hard": (("3", "4"), ("12", "20"), ("18", "13", "29"), ("30", "17", "26", "18", "13", "29")),
    "sanity": (("1", "3"), ("2", "3", "4", "7")),
    "junction": (("1", "2", "5"), ("3", "2", "5")),
    "deadlock": (("1", "2"), ("3", "2")),
}
"""The way of each box that a map's solution needs."""


def stands_on_ground(scenario: Scenario, layout: Layout) -> None:
    for node, (at, height) in enumerate(zip(layout.places, layout.heights, strict=True)):
        name = scenario.topology.ids[node]
        if node in layout.pit_at:
            pit = layout.terrain.pits[layout.pit_at[node]]
            assert (pit.x, pit.y, pit.rim) == (*at, height), name
            assert layout.terrain.height(*at) == pytest.approx(height - pit.depth), name
        else:
            assert layout.terrain.height(*at) == pytest.approx(height), name


@pytest.mark.parametrize("name", SHIPPED)
def test_every_node_of_the_shipped_maps_lies_on_the_ground(name: str) -> None:
    scenario = load_scenario(name)
    stands_on_ground(scenario, lay_out(scenario))


@pytest.mark.parametrize("name", SHIPPED)
def test_pits_are_whole_boxes_deep_and_wider_than_boxes(name: str) -> None:
    layout = lay_out(load_scenario(name))
    low = min(box.height for box in layout.boxes)
    for pit in layout.terrain.pits:
        assert pit.depth / low == pytest.approx(round(pit.depth / low))
        assert pit.side == pytest.approx(layout.boxes[0].length + 0.2)


@pytest.mark.parametrize(
    ("name", "hole", "before"),
    [("easy", 4, 3), ("easy", 30, 13), ("medium", 20, 12), ("hard", 20, 12), ("hard", 29, 13), ("junction", 5, 2)],
)
def test_pits_are_turned_along_the_edge_they_are_filled_over(name: str, hole: int, before: int) -> None:
    scenario = load_scenario(name)
    layout, index = lay_out(scenario), scenario.topology.index
    pit = layout.terrain.pits[layout.pit_at[index[hole]]]
    (x, y), (bx, by) = layout.places[index[hole]], layout.places[index[before]]
    assert quarter(pit.yaw - math.atan2(y - by, x - bx)) == pytest.approx(0.0, abs=1e-9)


def test_hard_has_a_pit_two_boxes_deep_and_a_ramp_down_to_low_ground() -> None:
    scenario = load_scenario("hard")
    layout, index = lay_out(scenario), scenario.topology.index
    assert [layout.terrain.pits[layout.pit_at[index[n]]].depth for n in (4, 20, 29)] == pytest.approx(
        [0.25, 0.25, 0.5], abs=1e-3
    )
    (ramp,) = layout.terrain.ramps
    foot, top = index[30], index[17]
    assert (ramp.x0, ramp.y0, ramp.z0) == (*layout.places[foot], layout.heights[foot])
    assert (ramp.x1, ramp.y1, ramp.z1) == (*layout.places[top], layout.heights[top])
    low = layout.heights[foot]
    assert layout.heights[top] - low == pytest.approx(0.5 * 0.696)
    x, y = layout.places[index[31]]
    for dx, dy in ((-1.7, 0.0), (0.0, 1.7), (0.0, -1.7), (1.0, 0.0)):
        assert layout.terrain.height(x + dx, y + dy) == pytest.approx(low)


@pytest.mark.parametrize(
    ("name", "way"), [(name, way) for name, ways in NEEDED.items() for way in ways], ids=lambda v: str(v)
)
def test_every_push_that_a_map_needs_can_be_staged(name: str, way: tuple[str, ...]) -> None:
    scenario = load_scenario(name)
    layout, index = lay_out(scenario), scenario.topology.index
    nodes = [index[int(n)] for n in way]
    box = next(i for i, start in enumerate(scenario.boxes) if start.node == nodes[0])
    with Scene(layout.terrain, layout.boxes, ()) as scene:
        # Boxes on the way have been pushed on before.
        others = tuple(i for i, start in enumerate(scenario.boxes) if i != box and start.node not in nodes)
        filled = {layout.pit_at.get(node) for node in nodes[:-1]}
        pits = tuple(i for i in range(len(layout.terrain.pits)) if i not in filled)
        yaw = layout.boxes[box].yaw
        for at, to in itertools.pairwise(nodes):
            (x, y), goal = layout.places[at], layout.places[to]
            scene.place_box(box, x, y, layout.heights[at], yaw)
            pit = layout.pit_at.get(to) if layout.pit_at.get(to) in pits else None
            kind = "hole" if pit is not None else "slope" if (at, to) in scenario.topology.rises else "flat"
            task = PushTask(box, (x, y), goal, kind, layout.heights[to], pit)  # type: ignore[arg-type]
            plan = plan_push(scene, box, task, Surroundings((), others, pits))
            assert plan.margin >= 0.0, (way, scenario.topology.ids[at], scenario.topology.ids[to], plan.reason)
            if abs(quarter(task.line - yaw)) <= MAX_MISMATCH:
                yaw = task.line  # the bumper straightens it


@pytest.mark.parametrize("name", SHIPPED)
def test_every_edge_is_a_way_without_gaps(name: str) -> None:
    scenario = load_scenario(name)
    layout = lay_out(scenario)
    with Scene(layout.terrain, layout.boxes, ()) as scene:
        space = FreeSpace(scene, Surroundings())
        for i, others in enumerate(scenario.topology.neighbours):
            for j in others:
                start, goal = layout.places[i], layout.places[j]
                way = space.path(start, goal)
                assert way is not None
                # Straight, but for a slight bend round the side of a ramp, where there is a step.
                length = sum(math.dist(a, b) for a, b in itertools.pairwise([start, *way]))
                assert length <= 1.05 * math.dist(start, goal)


def test_a_box_is_not_pushed_where_its_corner_would_run_against_a_step() -> None:
    # Across the top of hard's ramp, along the edge of the ground beside it.
    scenario = load_scenario("hard")
    layout, index = lay_out(scenario), scenario.topology.index
    start, goal = layout.places[index[17]], layout.places[index[15]]
    with Scene(layout.terrain, layout.boxes[:1], ()) as scene:
        scene.place_box(0, *start, layout.heights[index[17]], math.pi / 2)
        plan = plan_push(scene, 0, PushTask(0, start, goal, "flat", layout.heights[index[15]]), Surroundings())
    assert (plan.margin < 0.0, plan.reason) == (True, "way of the box blocked")


# -- maps of one's own -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("turned", [0.0, 0.5 * math.pi, math.pi, -0.5 * math.pi, 0.4, 0.785, 2.2, -1.1])
def test_a_ramp_joins_two_levels_in_any_direction(turned: float) -> None:
    scenario = two_levels(turned)
    layout = lay_out(scenario)
    stands_on_ground(scenario, layout)
    (foot, top), previous = (layout.places[2], layout.places[3]), None
    for k in range(-6, 27):
        share = k / 20
        at = (foot[0] + share * (top[0] - foot[0]), foot[1] + share * (top[1] - foot[1]))
        height = layout.terrain.height(*at)
        # Neither steps nor gaps on the way up.
        assert previous is None or 0.0 - 1e-9 <= height - previous < 0.04
        previous = height
    # A robot may turn on every node and on the ways between them.
    for node, (x, y) in enumerate(layout.places):
        for k in range(24):
            near = layout.terrain.height(x + 0.6 * math.cos(k * math.pi / 12), y + 0.6 * math.sin(k * math.pi / 12))
            assert near == pytest.approx(layout.heights[node], abs=0.15)


@pytest.mark.parametrize("turned", [0.0, math.pi / 2, 0.6])
def test_robots_and_boxes_rest_where_they_start(turned: float) -> None:
    layout = lay_out(two_levels(turned))
    with Scene(layout.terrain, layout.boxes, layout.robots) as scene:
        for _ in range(60):
            scene.tick()
        for i, robot in enumerate(layout.robots):
            assert scene.robot(i)[:3] == pytest.approx((robot.x, robot.y, robot.z), abs=2e-3)
        for i, box in enumerate(layout.boxes):
            assert scene.box(i)[:3] == pytest.approx((box.x, box.y, box.z + box.height / 2), abs=2e-3)


def test_a_generated_grid_with_holes() -> None:
    scenario = place(
        {
            "topology": {"kind": "grid", "columns": 4, "rows": 3, "spacing": 1.8},
            "holes": [{"node": 2, "depth": 0.35}, {"node": 9, "depth": 0.7}],
            "boxes": [[1, 0.35], [5, 0.35], [6, 0.35]],
            "agents": [0, 4],
            "goal": 11,
        }
    )
    layout = lay_out(scenario)
    stands_on_ground(scenario, layout)
    assert [pit.depth for pit in layout.terrain.pits] == pytest.approx([0.25, 0.5])
    with Scene(layout.terrain, layout.boxes, layout.robots) as scene:
        task = PushTask(0, layout.places[1], layout.places[2], "hole", layout.heights[2], 0)
        assert plan_push(scene, 0, task, Surroundings((), (1, 2), (0, 1))).margin >= 0.0


def test_the_physics_section_takes_precedence() -> None:
    scenario = place(
        LANE,
        physics={
            "xy_scale": 2.0, "z_scale": 1.0, "box_length": 0.8, "box_height": 0.2, "pit_side": 1.1, "margin": 3,
        },
    )  # fmt: skip
    layout = lay_out(scenario)
    assert layout.places[4] == pytest.approx((9.6, 0.0))
    assert (layout.boxes[0].length, layout.boxes[0].height) == (0.8, 0.2)
    assert (layout.terrain.pits[0].side, layout.terrain.pits[0].depth) == pytest.approx((1.1, 0.4))
    assert layout.terrain.grounds[0].xmin == pytest.approx(-3.0)


TERRAIN: dict[str, Any] = {
    "grounds": [{"xmin": -4, "ymin": -4, "xmax": 12, "ymax": 4, "z": 0.0}],
    "pits": [{"x": 3.84, "y": 0.0, "yaw": 0.1, "side": 1.3, "rim": 0.0, "depth": 0.25}],
}


def test_terrain_can_be_given_in_full() -> None:
    layout = lay_out(place(LANE, physics={"terrain": TERRAIN}))
    assert len(layout.terrain.grounds) == 1
    assert (layout.terrain.pits[0].side, layout.terrain.pits[0].yaw) == (1.3, 0.1)
    assert set(layout.heights) == {0.0}


def test_given_pits_belong_to_the_holes_they_lie_at_whatever_their_order() -> None:
    pits = [{"x": -2.0, "y": 0.0, "depth": 0.25}, *TERRAIN["pits"]]
    layout = lay_out(place(LANE, physics={"terrain": TERRAIN | {"pits": pits}}))
    assert layout.pit_at == {2: 1}


# -- impossible places -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scenario", "field", "words"),
    [
        (lambda: place(LANE, physics={"pit_side": 0.9}), "physics.pit_side", "takes no box"),
        (
            lambda: place(
                LANE,
                holes=[{"node": 2, "depth": 0.35}, {"node": 3, "depth": 0.35}],
                boxes=[[1, 0.35], [2, 0.35]],
                agents=[0],
                goal=4,
                physics={"xy_scale": 0.8},
            ),
            "holes.1",
            "holes 2 and 3 are 0.96 m apart, with pits 1.20 m wide, expected at least 1.35 m; physics.xy_scale: 1.15",
        ),
        (
            # The upper level leads across the lower one.
            lambda: place(
                {
                    "nodes": [
                        [0, 0, 0, 1], [1, 4, 0, 1], [2, 6, 0, 1.5], [3, 6, 3, 1.5], [4, 2, 1.5, 1.5], [5, 2, -1, 1.5],
                    ],
                    "edges": [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5]],
                    "slopes": [[1, 2]],
                    "agents": [0],
                    "goal": 5,
                }
            ),
            "edges.0",
            "edge 0-1 (0.25 m high) and edge 4-5 (0.38 m high) are 0.00 m apart in the plane, expected at least 1.10 m;"
            " no physics.xy_scale up to 6.4 would do",
        ),
        (
            lambda: place(LANE, physics={"terrain": TERRAIN | {"pits": [{"x": 30.0, "y": 0.0, "depth": 0.25}]}}),
            "physics",
            "no ground",
        ),
        (
            lambda: place(
                LANE,
                physics={
                    "terrain": TERRAIN | {"grounds": [{"xmin": -4, "ymin": -4, "xmax": 6.5, "ymax": 4, "z": 0}]}
                },
            ),
            "physics.terrain",
            "no ground under node 4",
        ),
        (
            # A step that agents pass over on paper.
            lambda: place(LANE, nodes=[[0, 0, 0], [1, 1.2, 0], [2, 2.4, 0], [3, 3.6, 0], [4, 4.8, 0, 0.2]]),
            "edges.3",
            "nodes 3 and 4 count as level (reach 0.3), and the step between them is 0.14 m high, expected less than"
            " 0.02 m for wheels: list [3, 4] under slopes",
        ),
        (
            lambda: place(
                LANE,
                nodes=[[0, 0, 0, 1.2], [1, 1.2, 0], [2, 2.4, 0], [3, 3.6, 0], [4, 4.8, 0]],
                slopes=[[0, 1]],
            ),
            "slopes.0",
            "slope 1-0 rises 0.86 m over 1.92 m (physics.z_scale is 0.7143 by default, which makes the lowest box 0.25"
            " m high), expected at least 2.86 m; physics.xy_scale: 2.4 would do",
        ),
        (
            lambda: place(LANE, physics={"margin": 0.2}),
            "physics.margin",
            "0.2 m of ground beyond the outermost nodes, expected at least 0.45 m",
        ),
        (
            lambda: place(
                LANE,
                physics={
                    "terrain": TERRAIN
                    | {
                        "grounds": [
                            {"xmin": -4, "ymin": -4, "xmax": 6.5, "ymax": 4, "z": 0},
                            {"xmin": 7, "ymin": -4, "xmax": 12, "ymax": 4, "z": 0},
                        ]
                    }
                },
            ),
            "edges.3",
            "between 3 and 4 has a gap",
        ),
        (
            lambda: place(LANE, physics={"terrain": TERRAIN | {"pits": [{"x": 0.0, "y": 2.0, "depth": 0.25}]}}),
            "physics.terrain.pits",
            "no pit at the hole 2",
        ),
    ],
    ids=[
        "narrow pit", "close pits", "levels cross", "pit on no ground", "node on no ground", "step", "steep", "margin",
        "gap", "hole without a pit",
    ],
)  # fmt: skip
def test_what_cannot_be_built_is_answered_with_its_place(scenario: Any, field: str, words: str) -> None:
    with pytest.raises(ScenarioError) as told:
        lay_out(scenario())
    assert f": {field}" in str(told.value)
    assert words in str(told.value)
