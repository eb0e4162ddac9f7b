"""Maps of our own: `benchmarks/bullet_tables.py run --maps tests/push/maps/quarry.yaml` drives on them."""

from pathlib import Path

import pytest

from colonysim import simulate
from colonysim.geometry.layout import lay_out
from colonysim.physics import BoxSpec, RobotSpec, Scene
from colonysim.push import drive_to, everything_else, run_alone
from colonysim.scenario.loading import load_scenario

pytestmark = pytest.mark.usefixtures("engine")

MAPS = sorted((Path(__file__).parent / "maps").glob("*.yaml"))
PITS_AND_RAMPS = {"causeway": (0.25, 0), "weir": (0.25, 1), "dogleg": (0.5, 0)}


@pytest.mark.parametrize("path", MAPS, ids=lambda path: path.stem)
def test_they_can_be_built(path: Path) -> None:
    layout = lay_out(load_scenario(path))
    assert {box.height for box in layout.boxes} == {0.25}
    deep, ramps = PITS_AND_RAMPS.get(path.stem, (0.5, 1))
    assert max(pit.depth for pit in layout.terrain.pits) == pytest.approx(deep)
    assert len(layout.terrain.ramps) == ramps


@pytest.mark.parametrize("target", [(4.6, 3.0), (3.1, 4.5), (3.1, 1.5)])
def test_a_robot_on_a_ramp_goes_round_the_step_at_its_side(target: tuple[float, float]) -> None:
    layout = lay_out(load_scenario(MAPS[-1]))
    crest = layout.terrain.ramps[0].x1, layout.terrain.ramps[0].y1
    box = BoxSpec(*crest, layout.terrain.ramps[0].z1, 0.0)
    robot = RobotSpec(crest[0] - 0.86, crest[1], layout.terrain.height(crest[0] - 0.86, crest[1]), 0.0)
    with Scene(layout.terrain, [box], [robot]) as scene:
        goal = (1.6 * target[0], 1.6 * target[1])
        result = run_alone(scene, 0, drive_to(scene, 0, *goal, everything_else(scene, 0)))
        assert result.reason == "done"


@pytest.mark.parametrize("path", MAPS, ids=lambda path: path.stem)
def test_they_are_solved_without_physics(path: Path) -> None:
    ends = [event.status for event in simulate(load_scenario(path), seed=1, episodes=5) if event.kind == "episode"]
    assert ends == ["goal"] * 5
