"""The scenarios that come with the package hold the data of the paper's maps."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from colonysim.policies.schema import scenario_schema
from colonysim.scenario.loading import list_scenarios, load_scenario, load_variants, scenario_from_document
from colonysim.scenario.source import read_text

ROOT = Path(__file__).parent.parent.parent

EDGES = {"sanity": 13, "easy": 52, "medium": 50, "hard": 52, "deadlock": 5, "junction": 8}
NODES = {"sanity": 9, "easy": 31, "medium": 30, "hard": 32, "deadlock": 6, "junction": 9}
HOLES = {
    "sanity": {3: 1.0, 7: 3.0},
    "easy": {4: 0.35, 30: 0.35},
    "medium": {4: 0.35, 20: 0.35, 29: 0.35},
    "hard": {4: 0.35, 20: 0.35, 29: 0.7},
    "deadlock": {2: 2.0},
    "junction": {5: 2.0},
}
VARIANTS = {"hard": ("r20-4", "r5-4", "r5-6"), "sanity": ("r3",)}


def joined(scenario, a, b):
    index = scenario.topology.index
    return index[b] in scenario.topology.neighbours[index[a]]


@pytest.mark.parametrize("name", sorted(EDGES))
def test_maps_have_the_counts_of_their_data(name):
    scenario = load_scenario(name)
    assert scenario.name == name
    assert scenario.description
    assert len(scenario.topology) == NODES[name]
    assert scenario.topology.edge_count == EDGES[name]
    ids = scenario.topology.ids
    assert {ids[hole.node]: round(hole.depth, 9) for hole in scenario.holes} == HOLES[name]
    assert tuple(variant for variant, _ in load_variants(name)) == (None, *VARIANTS.get(name, ()))


def test_all_are_listed_with_description_and_variants():
    listed = {name: (path, description, variants) for name, path, description, variants in list_scenarios()}
    assert sorted(listed) == sorted(EDGES)
    assert listed["hard"][2] == VARIANTS["hard"]
    assert all(path.is_file() and description for path, description, _ in listed.values())


def test_pairs_that_only_nearly_are_edges():
    easy = load_scenario("easy")
    assert not joined(easy, 22, 24)
    assert not joined(easy, 29, 30)
    assert joined(easy, 11, 2)
    medium = load_scenario("medium")
    assert not any(joined(medium, *pair) for pair in [(19, 20), (20, 21), (25, 27)])


def test_hard_has_its_ramp_its_forbidden_pushes_and_its_variants():
    hard = load_scenario("hard")
    index = hard.topology.index
    assert hard.topology.rises == pytest.approx({(index[30], index[17]): 0.5, (index[17], index[30]): -0.5})
    pairs = [(3, 2), (25, 24), (17, 16), (16, 18)]
    assert hard.no_push == {(index[a], index[b]) for a, b in pairs}
    assert (hard.detection_radius, hard.max_steps, hard.episodes) == (20, 80, 30)
    assert [hard.topology.ids[a] for a in hard.agents] == [2, 8, 26, 31]
    assert load_scenario("hard", "r20-4").digest == hard.digest
    assert load_scenario("hard", "r5-4").detection_radius == 5
    six = load_scenario("hard", "r5-6")
    assert six.detection_radius == 5
    assert [six.topology.ids[a] for a in six.agents] == [2, 8, 26, 31, 19, 28]
    assert six.positions["agents.5"][0] > hard.positions["agents.3"][0]


def test_hard_without_its_slope_is_refused():
    with pytest.raises(Exception, match=r"agent on node 31 .* smallest step in its way is 0\.5 up from 30 to 17"):
        load_scenario("hard", overrides=["slopes=[]"])


@pytest.mark.parametrize("name", ["easy", "medium", "hard"])
def test_boxes_become_a_quarter_of_a_metre_high_in_physics(name):
    scenario = load_scenario(name)
    heights = {round(box.height * scenario.physics["z_scale"], 3) for box in scenario.boxes}
    assert heights == {0.25}
    for hole in scenario.holes:  # and pits about a whole number of boxes deep
        boxes = hole.depth * scenario.physics["z_scale"] / 0.25
        assert abs(boxes - round(boxes)) < 0.06


def test_the_committed_schema_is_current():
    path = ROOT / "colonysim" / "schema" / "scenario.schema.json"
    current = json.loads(json.dumps(scenario_schema()))
    assert json.loads(path.read_text()) == current, f"run: colonysim schema > {path.relative_to(ROOT)}"


def test_shipped_files_name_the_schema_for_editors():
    for _, path, _, _ in list_scenarios():
        first = path.read_text().splitlines()[0]
        assert first.startswith("# yaml-language-server: $schema=")
        assert (path.parent / first.partition("=")[2]).resolve().is_file()


def test_every_field_is_described_in_the_documentation():
    text = "".join((ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("scenarios.md", "policies.md"))
    schema = scenario_schema()
    fields = set(schema["properties"])
    for name, part in schema["$defs"].items():
        if name != "Variant":
            fields |= set(part.get("properties", ()))
    assert not [field for field in sorted(fields) if f"`{field}`" not in text]


def test_the_examples_of_the_documentation_load():
    text = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")
    blocks = [block.partition("```")[0] for block in text.split("```yaml\n")[1:]]
    whole, place, *_ = (read_text(block, "docs")[0] for block in blocks)
    assert scenario_from_document(whole).topology.edge_count == 3
    assert scenario_from_document(whole, variant="short-sighted").detection_radius == 1.5
    assert len(scenario_from_document({**place, "agents": [0], "goal": 199}).topology) == 197


def test_every_field_has_a_description_in_the_schema():
    schema = scenario_schema()
    for owner in (schema, *schema["$defs"].values()):
        for name, field in owner.get("properties", {}).items():
            assert name == "kind" or field.get("description"), name


def test_an_installed_package_finds_them_by_name(tmp_path):
    shutil.copytree(
        ROOT / "colonysim", tmp_path / "colonysim", ignore=shutil.ignore_patterns("__pycache__", "*.npz", "*.urdf")
    )
    shutil.copytree(ROOT / "scenarios", tmp_path / "colonysim" / "scenarios")
    code = "from colonysim.scenario.loading import load_scenario; print(load_scenario('hard').source)"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(tmp_path)}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert Path(tmp_path, done.stdout.strip()).resolve() == (tmp_path / "colonysim/scenarios/hard.yaml").resolve()
