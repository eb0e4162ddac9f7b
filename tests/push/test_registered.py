"""The push under Gymnasium's names: made, checked, drawn, vectorised."""

from __future__ import annotations

import subprocess
import sys
import warnings
from importlib.util import find_spec

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from colonysim.errors import ColonysimError
from colonysim.physics.shapes import wrap
from colonysim.push.registered import PUSHES, register
from colonysim.push.training.env import PushEnv

register()
pytestmark = pytest.mark.usefixtures("engine")


EXPECTED = ".*not within the observation space|.*from the original environment|.*symmetric and normalized"
"""What the checkers advise of: a start is none of the space's corners, and wheels turn at up to 8 rad/s."""


@pytest.mark.parametrize("name", PUSHES)
def test_gymnasium_makes_and_checks_each(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    terrain = PUSHES[name]["terrain"]
    env = gymnasium.make(f"colonysim/{name}", render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=EXPECTED)
        check_env(env.unwrapped, skip_render_check=find_spec("pygame") is None)  # it opens a window
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
    with pytest.raises(ColonysimError, match="no render mode 'humans'; did you mean 'human'"):
        PushEnv(terrain, render_mode="humans")


def test_a_window_follows_the_push(monkeypatch: pytest.MonkeyPatch) -> None:
    pygame = pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env, images = PushEnv("flat", render_mode="human"), PushEnv("flat", render_mode="rgb_array")
    for each in (env, images):
        each.reset(seed=3)
        each.step(np.int64(7))
    assert env.render() is None
    shown, image = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1), images.render()
    assert image is not None and (shown == image).all()
    env.close()
    assert not pygame.display.get_init()
    images.close()


@pytest.mark.parametrize(("name", "actions"), [("Push-flat-v0", [1, 2]), ("Push-flat-wheels-v0", [[8, 8], [-8, 8]])])
@pytest.mark.parametrize("mode", ["sync", "async"])
def test_vectorised(name: str, actions: list[object], mode: str) -> None:
    envs = gymnasium.make_vec(f"colonysim/{name}", num_envs=2, vectorization_mode=mode)
    observations, _ = envs.reset(seed=5)
    assert observations.shape == (2, 9)
    observations, rewards, *_ = envs.step(np.array(actions, envs.action_space.dtype))
    assert observations.shape == (2, 9) and rewards.shape == (2,)
    envs.close()


def test_wheels_turn_as_they_are_told() -> None:
    env = gymnasium.make("colonysim/Push-flat-v0", controls="wheels")
    fastest = env.action_space.high.tolist()
    assert fastest == [8.0, 8.0] and env.action_space.low.tolist() == [-8.0, -8.0]

    def scene_after(*speeds: tuple[float, float]) -> tuple[float, float, float]:
        env.reset(seed=4)
        robot = env.unwrapped._episode.scene.robot(0)
        before = robot.x, robot.y, robot.yaw
        for pair in speeds:
            *_, info = env.step(np.array(pair, np.float32))
            assert info["ticks"] == 12
        robot = env.unwrapped._episode.scene.robot(0)
        ahead = (robot.x - before[0]) * np.cos(before[2]) + (robot.y - before[1]) * np.sin(before[2])
        away = np.hypot(robot.x - before[0], robot.y - before[1])
        return float(ahead), float(away), float(wrap(robot.yaw - before[2]))

    ahead, away, turn = scene_after((-4.0, -4.0), (-4.0, -4.0))
    assert ahead < -0.05 and away == pytest.approx(-ahead, abs=0.02) and abs(turn) < 0.05
    ahead, away, turn = scene_after((-3.0, 3.0), (-3.0, 3.0))  # counterclockwise
    assert turn > 0.2 and away < 0.1
    assert scene_after((3.0, -3.0), (3.0, -3.0))[2] < -0.2
    assert scene_after((-40.0, -40.0)) == scene_after((-8.0, -8.0))  # a motor's fastest
    with pytest.raises(ValueError, match="finite"):
        scene_after((np.nan, 0.0))
    with pytest.raises(ValueError, match="no controls 'wheel'; there are eight and wheels"):
        PushEnv("flat", controls="wheel")
    env.close()


def test_a_name_may_say_what_is_to_be_imported_for_it() -> None:
    code = "import gymnasium; print(gymnasium.make('colonysim.rl:colonysim/Push-flat-v0'))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "colonysim/Push-flat-v0" in done.stdout


def test_to_register_loads_no_engine() -> None:
    code = (
        "import sys; from colonysim.push.registered import register; register(); register();"
        "assert not {'pybullet', 'mujoco', 'torch', 'colonysim.simulation'} & sys.modules.keys()"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("name", ["Push-v0", "Push-wheels-v0"])
def test_the_checker_of_stable_baselines_passes(name: str) -> None:
    checker = pytest.importorskip("stable_baselines3.common.env_checker")
    env = gymnasium.make(f"colonysim/{name}")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=EXPECTED)
        checker.check_env(env)
    env.close()
