"""The push as a Gymnasium environment, for learners other than the package's own."""

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from colonysim.physics import MissingEngineError, default_engine, engine_trouble
from colonysim.push.controls import CONTROLS, Control
from colonysim.push.judging import PAPER_RULES, Rules
from colonysim.push.task import Kind
from colonysim.push.training.episode import Episode
from colonysim.push.training.picture import picture
from colonysim.push.training.starts import KINDS, distribution, draw

__all__ = ["PushEnv"]

Observation = npt.NDArray[np.float32]


_FARTHEST = 50.0
"""Bound of every observed number; a robot that fell off the ground ends its episode long before."""


class PushEnv(gymnasium.Env[Observation, np.int64]):
    """Push a box to a node on level ground, up a slope, or into a pit.

    Observations are the nine numbers of paper Eq. 4; actions are the eight controls, each held for T ticks of
    1/60 s; rewards are paper Eq. 8 with what the rules add. A scene is rebuilt at each reset, so that the
    same seed and actions give the same episode bit for bit.

    Args:
        terrain: `"flat"`, `"slope"`, `"hole"`, or `"mixed"`, which draws one at each reset with the
            paper's probabilities .3, .2 and .5.
        rules: How an episode is run and rewarded; the paper's by default.
        starts: Name of a start distribution.
        engine: The rigid-body engine; by default the first that is installed.
        render_mode: `"rgb_array"` for `render` to give images from above, drawn without a display.

    Raises:
        ValueError: An unknown terrain, start distribution, engine or render mode.
        MissingEngineError: The engine is not installed.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - declared so by Gymnasium
        "render_modes": ["rgb_array"], "render_fps": 60 // PAPER_RULES.ticks + 1,
    }  # fmt: skip

    def __init__(
        self, terrain: str = "mixed", *, rules: Rules = PAPER_RULES, starts: str = "push", engine: str | None = None,
        render_mode: str | None = None,
    ) -> None:  # fmt: skip
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"no render mode {render_mode!r}; there is rgb_array")
        self.render_mode = render_mode
        if terrain not in (*KINDS, "mixed"):
            raise ValueError(f"no terrain {terrain!r}; there are {', '.join(KINDS)} and mixed")
        self._terrain = terrain
        self._rules = rules
        self._engine = engine or default_engine()
        if trouble := engine_trouble(self._engine):
            raise MissingEngineError(trouble)
        self._starts = distribution(starts)
        self._episode: Episode | None = None
        self.observation_space = gymnasium.spaces.Box(-_FARTHEST, _FARTHEST, (9,), np.float32)
        self.action_space = gymnasium.spaces.Discrete(CONTROLS)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; see `gymnasium.Env.reset`. There are no options."""
        super().reset(seed=seed)
        self.close()
        kind = self._draw_kind()
        self._episode = Episode(draw(kind, self._starts, self.np_random), self._rules, engine=self._engine)
        return self._observation(self._episode), {"terrain": kind}

    def step(self, action: np.int64) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Hold a control for T ticks; see `gymnasium.Env.step`.

        Raises:
            RuntimeError: `reset` has not been called.
        """
        if self._episode is None:
            raise RuntimeError("call reset before step")
        step = self._episode.step(Control(int(action)))
        told = {"reason": step.reason, "success": step.verdict == "success", "ticks": step.ticks}
        return self._observation(self._episode), step.reward, step.verdict is not None, step.truncated, told

    def render(self) -> npt.NDArray[np.uint8] | None:
        """The push from above, shape (360, 360, 3); None without a render mode.

        Raises:
            RuntimeError: `reset` has not been called.
        """
        if self.render_mode is None:
            return None
        if self._episode is None:
            raise RuntimeError("call reset before render")
        return picture(self._episode.scene, self._episode.start.task)

    def close(self) -> None:
        """Free the scene."""
        if self._episode is not None:
            self._episode.close()
            self._episode = None

    def _draw_kind(self) -> Kind:
        if self._terrain == "mixed":
            kinds: tuple[Kind, ...] = ("flat", "slope", "hole")
            return kinds[int(np.searchsorted([0.3, 0.5, 1.0], self.np_random.random(), side="right"))]
        return next(kind for kind in KINDS if kind == self._terrain)

    def _observation(self, episode: Episode) -> Observation:
        return np.clip(np.array(episode.state, dtype=np.float32), -_FARTHEST, _FARTHEST)
