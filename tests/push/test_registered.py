"""The push under Gymnasium's names: made, checked, drawn, vectorised."""

from __future__ import annotations

import subprocess
import sys
import tomllib
import warnings
from importlib.metadata import EntryPoint
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.envs import registration
from gymnasium.utils.env_checker import check_env

from colonysim.push.registered import TERRAINS, register
from colonysim.push.training.env import PushEnv

register()
pytestmark = pytest.mark.usefixtures("engine")


@pytest.mark.parametrize(("name", "terrain"), TERRAINS.items())
def test_gymnasium_makes_and_checks_each(name: str, terrain: str) -> None:
    env = gymnasium.make(f"colonysim/{name}", render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*not within the observation space|.*from the original environment")
        check_env(env.unwrapped)
    _, info = env.reset(seed=1)
    assert terrain in ("mixed", info["terrain"])
    env.close()


def test_a_terrain_can_be_named() -> None:
    env = gymnasium.make("colonysim/Push-v0", terrain="slope")
    assert env.reset(seed=1)[1]["terrain"] == "slope"
    env.close()


@pytest.mark.parametrize("terrain", ["flat", "slope", "hole"])
def test_images_show_the_push(terrain: str) -> None:
    env = PushEnv(terrain, render_mode="rgb_array")
    with pytest.raises(RuntimeError, match="call reset"):
        env.render()
    env.reset(seed=3)
    before = env.render()
    assert before is not None and before.shape == (360, 360, 3) and before.dtype == np.uint8
    for colour in ((0, 114, 178), (204, 121, 167), (0, 158, 115)):  # box, robot and goal
        assert (before == colour).all(axis=2).sum() > 100, colour
    assert ((before == (58, 58, 58)).all(axis=2).sum() > 100) == (terrain == "hole")
    env.step(np.int64(7))
    after = env.render()
    assert after is not None and (before != after).any()
    env.close()
    assert PushEnv(terrain).render() is None
    with pytest.raises(ValueError, match="no render mode 'human'"):
        PushEnv(terrain, render_mode="human")


def test_vectorised() -> None:
    envs = gymnasium.make_vec("colonysim/Push-flat-v0", num_envs=2, vectorization_mode="sync")
    observations, _ = envs.reset(seed=5)
    assert observations.shape == (2, 9)
    observations, rewards, *_ = envs.step(np.array([1, 2]))
    assert observations.shape == (2, 9) and rewards.shape == (2,)
    envs.close()


def test_gymnasium_finds_them_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())
    [(space, place)] = project["project"]["entry-points"]["gymnasium.envs"].items()
    monkeypatch.setattr(registration, "registry", {})
    with registration.namespace(space):  # as Gymnasium does with what is installed under that entry point
        EntryPoint(space, place, "gymnasium.envs").load()()
    assert set(registration.registry) == {f"colonysim/{name}" for name in TERRAINS}


def test_to_register_loads_no_engine() -> None:
    code = (
        "import sys; from colonysim.push.registered import register; register(); register();"
        "assert not {'pybullet', 'mujoco', 'torch', 'colonysim.simulation'} & sys.modules.keys()"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_checker_of_stable_baselines_passes() -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    env = gymnasium.make("colonysim/Push-v0")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checker.check_env(env)
    env.close()
