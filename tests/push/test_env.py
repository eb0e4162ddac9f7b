"""The Gymnasium environment and the episode beneath it."""

import warnings

import numpy as np
import pytest

from colonysim.push.controls import Control
from colonysim.push.judging import Rules
from colonysim.push.seating import lies
from colonysim.push.state import observe
from colonysim.push.training.demonstrator import demonstrate
from colonysim.push.training.env import PushEnv
from colonysim.push.training.episode import Episode
from colonysim.push.training.starts import distribution, draw

pytestmark = pytest.mark.usefixtures("engine")


def test_gymnasium_s_checker_passes() -> None:
    from gymnasium.utils.env_checker import check_env

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        check_env(PushEnv("mixed"), skip_render_check=True)


@pytest.mark.parametrize("terrain", ["flat", "slope", "hole"])
def test_the_same_seed_and_actions_give_the_same_episode_bit_for_bit(terrain: str) -> None:
    def run() -> list[bytes]:
        env = PushEnv(terrain)
        seen = [env.reset(seed=5)[0].tobytes()]
        for action in (7, 3, 4, 4):
            seen.append(env.step(np.int64(action))[0].tobytes())
        env.close()
        return seen

    assert run() == run()


def test_an_action_lasts_50_ticks_of_a_60th_of_a_second() -> None:
    env = PushEnv("flat")
    env.reset(seed=1)
    *_, told = env.step(np.int64(Control.BACK))
    assert told["ticks"] == 50
    env.close()


def test_mixed_terrains_come_with_the_paper_s_probabilities() -> None:
    env = PushEnv("mixed")
    env.reset(seed=0)
    drawn = [env._draw_kind() for _ in range(2000)]
    env.close()
    assert [drawn.count(k) / 2000 for k in ("flat", "slope", "hole")] == pytest.approx([0.3, 0.2, 0.5], abs=0.04)


def test_misuse_is_answered_clearly() -> None:
    with pytest.raises(ValueError, match="no terrain 'swamp'"):
        PushEnv("swamp")
    with pytest.raises(RuntimeError, match="call reset"):
        PushEnv().step(np.int64(0))


@pytest.mark.parametrize("kind", ["flat", "slope", "hole"])
def test_the_demonstrator_pushes_a_box_home(kind: str) -> None:
    wins = 0
    for i in range(2):
        start = draw(kind, distribution("coarse"), np.random.default_rng([3, i]))  # type: ignore[arg-type]
        episode = Episode(start, Rules())
        *_, step = episode.play(demonstrate)
        wins += step.verdict == "success"
        scene, task = episode.scene, start.task
        if kind == "hole":
            assert step.verdict != "success" or lies(scene, task)
        else:
            assert step.state == observe(scene.robot(0), scene.box(0), task)
        episode.close()
    assert wins


def test_success_is_tested_within_an_action() -> None:
    """A whole action is .39 m: from .3 m before the node it would end beyond it."""
    start = draw("flat", distribution("fine"), np.random.default_rng(4))
    episode = Episode(start, Rules(ticks=50, guards=False, at_node=False))
    *_, step = episode.play(demonstrate)
    assert step.verdict == "success"
    assert step.ticks < 50
    assert 0.15 < step.state.distance <= 0.2
    episode.close()
