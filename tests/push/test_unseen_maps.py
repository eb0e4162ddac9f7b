"""Maps that nothing was tuned on: `benchmarks/bullet_tables.py run --maps tests/push/maps/yard.yaml` drives on them."""

from pathlib import Path

import pytest

from colonysim import simulate
from colonysim.backends.layout import lay_out
from colonysim.world.loading import load_scenario

MAPS = sorted((Path(__file__).parent / "maps").glob("*.yaml"))


@pytest.mark.parametrize("path", MAPS, ids=lambda path: path.stem)
def test_they_can_be_built_and_have_a_ramp_and_a_pit_two_deep(path: Path) -> None:
    layout = lay_out(load_scenario(path))
    assert layout.terrain.ramps
    assert max(pit.depth for pit in layout.terrain.pits) == pytest.approx(0.5)
    assert {box.height for box in layout.boxes} == {0.25}


@pytest.mark.parametrize("path", MAPS, ids=lambda path: path.stem)
def test_they_are_solved_without_physics(path: Path) -> None:
    ends = [event.status for event in simulate(load_scenario(path), seed=1, episodes=5) if event.kind == "episode"]
    assert ends == ["goal"] * 5
