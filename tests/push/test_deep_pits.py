"""Pits two boxes deep: the box that goes in first leans over the edge before it falls."""

import dataclasses

import pytest

from colonysim.learning.seeds import Purpose, episode_rng
from colonysim.physics import Scene
from colonysim.push.executors import make_executor
from colonysim.push.paths import everything_else
from colonysim.push.task import run_alone
from colonysim.push.training.starts import distribution, draw

pytestmark = pytest.mark.usefixtures("engine")


@pytest.mark.parametrize("i", range(2))
def test_rl_pushes_a_leaning_box_on_until_it_lies(i: int) -> None:
    start = draw("hole", distribution("push"), episode_rng(Purpose.TEST, 78, i))
    pit = dataclasses.replace(start.terrain.pits[0], depth=0.5)
    with Scene(dataclasses.replace(start.terrain, pits=(pit,)), [start.box], [start.robot]) as scene:
        result = run_alone(scene, 0, make_executor("rl")(scene, 0, start.task, everything_else(scene, 0)))
        assert result.success
        for _ in range(60):
            scene.tick()
        assert scene.box_seated(0, pit)
