"""Maps of other programs: what was drawn is what the scenario has, in each of the formats."""

from __future__ import annotations

from pathlib import Path

import map_files
import pytest

from colonysim import import_map, scenario_from_document
from colonysim.scenario.invent import invent


def imported(folder: Path, name: str, content: bytes, **options):
    path = folder / name
    path.write_bytes(content)
    return import_map(path, **options)


@pytest.mark.parametrize("seed", range(24))
def test_a_movingai_map_is_what_was_drawn(seed, tmp_path):
    plan = map_files.random_plan(seed, agents=0, boxes=0, holes=0, goal=False)
    options = {"diagonals": seed % 2 == 1, "spacing": (1.0, 0.5, 2)[seed % 3]}
    document = imported(tmp_path, "random.map", map_files.movingai(plan, seed), agents=2, **options)
    map_files.check(document, plan, **options)
    assert len(document["agents"]) == 2


@pytest.mark.parametrize("seed", range(24))
def test_a_level_of_sokoban_is_what_was_drawn(seed, tmp_path):
    plan = map_files.random_plan(seed, agents=1, boxes=4, holes=3, goal=False)
    options = {"diagonals": seed % 2 == 1, "spacing": (1.0, 0.5, 2)[seed % 3]}
    document = imported(tmp_path, "random.xsb", map_files.sokoban(plan, seed), **options)
    map_files.check(document, plan, **options)


@pytest.mark.parametrize("kind", map_files.PNG_KINDS)
@pytest.mark.parametrize("seed", range(4))
def test_a_picture_is_what_was_drawn(seed, kind, tmp_path):
    plan = map_files.random_plan(seed)
    options = {"diagonals": seed % 2 == 1, "spacing": (1.0, 0.5, 2)[seed % 3]}
    document = imported(tmp_path, "random.png", map_files.picture(plan, kind), **options)
    map_files.check(document, plan, **options)


@pytest.mark.parametrize("kind", map_files.GREY_KINDS)
@pytest.mark.parametrize("seed", range(2))
def test_a_picture_of_shades_is_what_was_drawn(seed, kind, tmp_path):
    shades = not kind.startswith("grey1") or kind.startswith("grey16")
    holes = 3 if shades and not kind.startswith("grey2") else 0
    plan = map_files.random_plan(seed, agents=0, boxes=0, holes=holes, goal=False)
    content = map_files.picture(plan, kind)
    options = {"colours": {"transparent": "wall", "#000000": "goal"}} if kind.endswith("clear") else {}
    map_files.check(imported(tmp_path, "random.png", content, **options), plan)


@pytest.mark.parametrize("form", map_files.TILED_FORMS)
@pytest.mark.parametrize("seed", range(4))
def test_a_map_of_tiled_is_what_was_drawn(seed, form, tmp_path):
    plan = map_files.random_plan(seed)
    options = {"diagonals": seed % 2 == 1, "spacing": (1.0, 0.5, 2)[seed % 3]}
    document = imported(tmp_path, "random.tmj", map_files.tiled_file(plan, form), **options)
    map_files.check(document, plan, **options)


def written(plan, name):
    """A plan as a file of a format, and the options by which no more is drawn than stands there."""
    goal = map_files.squares(plan, "g")[0]
    if name == "grid.map":
        return map_files.movingai(plan), {"agents": map_files.squares(plan, "a"), "goal": goal}
    if name == "grid.xsb":
        walled = ["#" * (len(plan[0]) + 2), *(f"#{row.replace('g', '.')}#" for row in plan), "#" * (len(plan[0]) + 2)]
        crop = (1, 1, len(plan[0]), len(plan))
        return map_files.sokoban(walled, 9), {"goal": (goal[0] + 1, goal[1] + 1), "crop": crop}
    return (map_files.picture(plan, "rgb") if name == "grid.png" else map_files.tiled_file(plan, "tiles")), {}


@pytest.mark.parametrize("name", ["grid.map", "grid.xsb", "grid.png", "grid.tmj"])
@pytest.mark.parametrize("seed", range(3))
def test_a_grid_comes_back_as_it_was_written(seed, name, tmp_path):
    """Nodes with their numbers and positions, edges, agents and goal; and where boxes and holes can be drawn, these."""
    made = invent("grid", columns=9, rows=8, agents=1, holes=0 if name == "grid.map" else 2, seed=seed)
    document = made | {"agents": [40], "goal": 71}
    taken = {hole["node"] for hole in made["holes"]} | {box[0] for box in made["boxes"]} | {40, 71}
    document["topology"]["without"] = [node for node in (3, 12, 21, 30, 48, 57, 66) if node not in taken]
    grid = scenario_from_document(document)
    kinds = dict.fromkeys(grid.topology.ids, ".") | {hole["node"]: "h" for hole in made["holes"]}
    kinds |= {box[0]: "b" for box in made["boxes"]} | {40: "a", 71: "g"}
    plan = ["".join(kinds.get(9 * row + column, "#") for column in range(9)) for row in reversed(range(8))]
    content, options = written(plan, name)
    back = scenario_from_document(imported(tmp_path, name, content, **options))
    place, expected = back.topology, grid.topology
    assert (place.ids, place.x, place.y) == (expected.ids, expected.x, expected.y)
    assert list(map(set, place.neighbours)) == list(map(set, expected.neighbours))
    assert (back.agents, back.goal) == (grid.agents, grid.goal)
    assert sorted(hole.node for hole in back.holes) == sorted(hole.node for hole in grid.holes)
    assert sorted((box.node, box.height) for box in back.boxes) == sorted((box.node, box.height) for box in grid.boxes)


@pytest.mark.parametrize(
    ("content", "holes", "without"),
    [
        # Grey of 16 bits: its upper byte counts, whatever the lower one is.
        (map_files.png(4, 1, 16, 0, [bytes.fromhex("ffffffff80120055")]), [2], [3]),
        # The colour that stands for nothing, as deep as the pixels are: white of two bits and of one, grey of sixteen.
        (map_files.png(4, 1, 2, 0, [b"\x03"], (b"tRNS", b"\0\3")), [], [3]),
        (map_files.png(4, 1, 1, 0, [b"\x10"], (b"tRNS", b"\0\1")), [], [3]),
        (map_files.png(4, 1, 16, 2, [b"\xff" * 18 + b"\x80" * 6], (b"tRNS", b"\x80" * 6)), [], [3]),
    ],
    ids=["grey16", "clear2", "clear1", "clear16"],
)
def test_shades_and_what_is_transparent_are_read_as_deep_as_the_file_has_them(content, holes, without, tmp_path):
    colours = {} if content[24] == 16 else {"#000000": "floor"}
    document = imported(tmp_path, "x.png", content, agents=1, colours=colours)
    assert [hole["node"] for hole in document["holes"]] == holes
    assert document["topology"]["without"] == without


def test_the_goal_lies_behind_holes_if_anything_does(tmp_path):
    plan = ["...........", "a.b.h.#####"]
    assert imported(tmp_path, "x.png", map_files.picture(plan, "rgb"))["goal"] == 21
    gated = ["...........", "##b########", "##ah.######"]
    assert imported(tmp_path, "y.png", map_files.picture(gated, "rgb"))["goal"] == 4
