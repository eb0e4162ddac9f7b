"""Small maps of our own in each format, after the shapes that public collections have: a colony solves each of them."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

import colonysim
from colonysim.cli import app
from colonysim.errors import ScenarioError

MAPS = Path(__file__).parent / "maps"
OPTIONS = {
    "arena.map": [(), ("--diagonals",)],
    "bottleneck.sok": [()],
    "cave.png": [("--goal", "21,12", "--agents", "3")],
    "city.map": [(), ("--floor", ".GST", "--diagonals", "--agents", "0,0 23,0")],
    "maze.map": [("--agents", "1,1", "--goal", "19,11")],
    "random.png": [()],
    "ring.png": [()],
    "rooms.map": [("--crop", "6,0,18,12", "--spacing", "1.5")],
    "warehouse.tmj": [("--agents", "5", "--seed", "3")],
    "yard.xsb": [(), ("--level", "2")],
}
GATED = ("bottleneck.sok", "ring.png", "warehouse.tmj", "yard.xsb")
"""Those whose goal lies behind a hole."""


def test_there_is_one_of_each_shape():
    assert sorted(path.name for path in MAPS.iterdir()) == sorted(OPTIONS)
    assert sum(path.stat().st_size for path in MAPS.iterdir()) < 10_000


@pytest.mark.parametrize(
    ("name", "words"), [(name, words) for name, some in OPTIONS.items() for words in some]
)
def test_a_colony_solves_it(name, words, tmp_path):
    out = tmp_path / "map.yaml"
    made = CliRunner().invoke(app, ["import", str(MAPS / name), *words, "--out", str(out)])
    assert made.exit_code == 0, made.output
    checked = CliRunner().invoke(app, ["validate", str(out)])
    assert checked.exit_code == 0 and "valid" in checked.stdout, checked.output
    scenario = colonysim.load_scenario(out)
    run = colonysim.run(scenario, episodes=8, seed=1, trace=False)
    assert max(episode.success for episode in run.episodes) == 1.0
    if name in GATED:
        with pytest.raises(ScenarioError, match="no filling of holes"):
            colonysim.scenario_from_document({**scenario.document, "boxes": []})
