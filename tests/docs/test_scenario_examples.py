"""The whole scenarios in docs/scenarios.md load, and those with a `terrain` can be built and solved."""

import re
from pathlib import Path

import pytest

from colonysim import simulate
from colonysim.geometry.layout import lay_out
from colonysim.scenario.loading import load_scenario

PAGE = Path(__file__).parents[2] / "docs" / "scenarios.md"
EXAMPLES = [block for block in re.findall(r"```yaml\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL) if "goal:" in block]


def test_two_of_them_give_their_terrain() -> None:
    assert sum("terrain:" in block for block in EXAMPLES) == 2


@pytest.mark.parametrize("block", EXAMPLES, ids=lambda block: block.split("name: ")[1].split()[0])
def test_they_load_and_can_be_solved(block: str, tmp_path: Path) -> None:
    path = tmp_path / "example.yaml"
    path.write_text(block, "utf-8")
    scenario = load_scenario(path)
    ends = [event.status for event in simulate(scenario, seed=1, episodes=1) if event.kind == "episode"]
    assert ends == ["goal"]
    if "terrain:" in block:
        layout = lay_out(scenario)
        given = scenario.physics["terrain"]
        assert len(layout.terrain.grounds) == len(given["grounds"])
        assert len(layout.terrain.pits) == len(scenario.holes)
        ends = [e.status for e in simulate(scenario, backend="bullet", seed=1, episodes=1) if e.kind == "episode"]
        assert ends == ["goal"]
