"""Maps of other programs: what was drawn is what the scenario has, in each of the formats."""

from __future__ import annotations

from pathlib import Path

import map_files
import pytest

from colonysim import import_map


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
