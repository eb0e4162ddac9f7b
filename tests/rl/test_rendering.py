"""What environments of colonies show of themselves: images, and a window that follows."""

from __future__ import annotations

import subprocess
import sys
import warnings

import pytest

pytest.importorskip("pettingzoo")

import numpy as np
from pettingzoo.test import render_test

from colonysim import rl
from colonysim.errors import ColonysimError, MissingExtraError
from colonysim.rl.picture import SIZE
from colonysim.scenario.loading import scenario_from_document

AGENT, BOX, GOAL, HOLE, FILLED = (204, 121, 167), (0, 114, 178), (0, 158, 115), (58, 58, 58), (143, 187, 217)
DOCUMENT = {
    "nodes": [[0, 0.0, 0.0, 0.0], [1, 2.0, 0.0, 0.0], [2, 4.0, 0.0, -0.359], [3, 6.0, 0.0, 0.0]],
    "edges": [[0, 1], [1, 2], [2, 3]], "holes": [2], "boxes": [[1, 0.359]], "agents": [0], "goal": 3,
    "detection_radius": 10.0, "max_steps": 10, "episodes": 1, "timing": {"jitter": 0.0},
}  # fmt: skip
LINE = scenario_from_document(DOCUMENT)


def columns_of(image, colour):
    """The first and the last column in which a colour is, in widths of the image; None if it is nowhere."""
    found = np.flatnonzero((image == colour).all(axis=2).any(axis=0))
    return None if not len(found) else (found[0] / image.shape[1], found[-1] / image.shape[1])


def test_an_image_shows_what_is_where():
    env = rl.aec(LINE, render_mode="rgb_array")
    with pytest.raises(ColonysimError, match="call reset"):
        env.render()
    env.reset()
    image = env.render()
    assert image.dtype == np.uint8 and image.shape[1] == SIZE and image.shape[2] == 3
    agent, box, hole, goal = (columns_of(image, colour) for colour in (AGENT, BOX, HOLE, GOAL))
    assert agent < box < hole < goal and agent[1] < box[0] and box[1] < hole[0] and hole[1] < goal[0]
    assert columns_of(image, FILLED) is None
    env.step(0)  # takes the box
    env.step(3)  # pushes it into the hole
    image = env.render()
    assert columns_of(image, FILLED) is not None and columns_of(image, BOX) is columns_of(image, HOLE) is None
    assert agent[1] < columns_of(image, AGENT)[0]
    assert rl.aec(LINE).render() is None
    twin = env.fork()
    assert (twin.render() == image).all()
    for each in (twin, env):
        each.close()


@pytest.mark.parametrize("door", [rl.parallel, rl.multi_agent])
def test_all_doors_show_the_same(door):
    one, other = rl.aec("hard", render_mode="rgb_array", seed=4), door("hard", render_mode="rgb_array", seed=4)
    for env in (one, other):
        env.reset()
    assert (one.render() == other.render()).all()
    for env in (one, other):
        env.close()


def test_pettingzoo_s_render_test_passes(monkeypatch):
    pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        render_test(lambda render_mode: rl.aec("hard", render_mode=render_mode))


@pytest.mark.parametrize("door", [rl.aec, rl.parallel, rl.multi_agent])
def test_a_window_follows(door, monkeypatch):
    pygame = pytest.importorskip("pygame")
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    window, images = door("hard", render_mode="human", seed=4), door("hard", render_mode="rgb_array", seed=4)
    for env in (window, images):
        env.reset()
        agent = env.turns.asked
        action = int(env.turns.mask(agent).argmax())
        env.step(action if door is rl.aec else {f"robot_{agent}": action})
    shown = pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)
    assert (shown == images.render()).all() and window.render() is None
    for env in (window, images):
        env.close()
    assert not pygame.display.get_init()


def test_what_is_missing_is_told(monkeypatch):
    with pytest.raises(ColonysimError, match="no render mode 'human_'; did you mean 'human'"):
        rl.aec("hard", render_mode="human_")
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(MissingExtraError, match=r"render_mode='human' needs pygame .*: .*pip install .*\[window\]"):
        rl.parallel("hard", render_mode="human")


def test_a_machine_without_a_display_is_told_of():
    pytest.importorskip("pygame")
    code = (
        "import os; os.environ['SDL_VIDEODRIVER'] = 'nothing'\n"
        "from colonysim import rl; from colonysim.errors import ColonysimError\n"
        "env = rl.aec('hard', render_mode='human')\n"
        "try: env.reset()\n"
        "except ColonysimError as error: assert \"render_mode='rgb_array'\" in str(error), error\n"
        "else: raise AssertionError\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
