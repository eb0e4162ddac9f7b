"""The push as a Gymnasium environment, for learners other than the package's own."""

from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from colonysim.physics import STANDARD, MissingEngineError, WheelSpeeds, default_engine, engine_trouble
from colonysim.push.controls import CONTROLS, Control
from colonysim.push.judging import PAPER_RULES, Rules
from colonysim.push.task import Kind
from colonysim.push.training.episode import Episode
from colonysim.push.training.picture import picture
from colonysim.push.training.starts import KINDS, distribution, draw
from colonysim.rendering import RENDER_MODES, Rendering

__all__ = ["WHEEL_RULES", "PushEnv"]

Observation = npt.NDArray[np.float32]
Action = np.int64 | npt.NDArray[np.float32]

WHEEL_RULES = replace(PAPER_RULES, ticks=12, check_every=12)
"""The paper's rules for actions that are wheel speeds: these are held for .2 s, not for a control's .83 s."""

_FARTHEST = 50.0
"""Bound of every observed number; a robot that fell off the ground ends its episode long before."""


class PushEnv(gymnasium.Env[Observation, Action]):
    """Push a box to a node on level ground, up a slope, or into a pit.

    Observations are the nine numbers of paper Eq. 4; actions are the eight controls or the speeds of the two wheels,
    each held for T ticks of 1/60 s; rewards are paper Eq. 8 with what the rules add. A scene is rebuilt at each reset,
    so that the same seed and actions give the same episode bit for bit.

    Args:
        terrain: `"flat"`, `"slope"`, `"hole"`, or `"mixed"`, which draws one at each reset with the
            paper's probabilities .3, .2 and .5.
        controls: What an action is. `"eight"`: the number of one of the paper's controls (`Discrete(8)`). `"wheels"`:
            the speeds of the left and the right wheel, -8 to 8 rad/s (`Box`, shape (2,)); positive drives forward.
        rules: How an episode is run and rewarded; by default the paper's, of wheels with 12 ticks an action.
        starts: Name of a start distribution.
        engine: The rigid-body engine; by default the first that is installed.
        render_mode: `"rgb_array"` for `render` to give images from above, drawn without a display; `"human"` for a
            window that follows (extra `window`).

    Raises:
        ValueError: An unknown terrain, kind of controls, start distribution or engine.
        ColonysimError: An unknown render mode.
        MissingEngineError: The engine is not installed.
        MissingExtraError: A window is asked for, and pygame is not installed.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012 - declared so by Gymnasium
        "render_modes": [*RENDER_MODES], "render_fps": 60 // PAPER_RULES.ticks + 1,
    }  # fmt: skip

    def __init__(
        self, terrain: str = "mixed", *, controls: str = "eight", rules: Rules | None = None, starts: str = "push",
        engine: str | None = None, render_mode: str | None = None,
    ) -> None:  # fmt: skip
        if terrain not in (*KINDS, "mixed"):
            raise ValueError(f"no terrain {terrain!r}; there are {', '.join(KINDS)} and mixed")
        if controls not in ("eight", "wheels"):
            raise ValueError(f"no controls {controls!r}; there are eight and wheels")
        wheels = controls == "wheels"
        self._terrain, self._rules = terrain, rules or (WHEEL_RULES if wheels else PAPER_RULES)
        self.metadata = {**self.metadata, "render_fps": 60 // self._rules.ticks + 1}
        self.render_mode = render_mode
        self._rendering = Rendering(render_mode, f"push, {terrain}", self.metadata["render_fps"])
        self._engine = engine or default_engine()
        if trouble := engine_trouble(self._engine):
            raise MissingEngineError(trouble)
        self._starts = distribution(starts)
        self._episode: Episode | None = None
        self.observation_space = gymnasium.spaces.Box(-_FARTHEST, _FARTHEST, (9,), np.float32)
        fastest = STANDARD.wheel_speed
        self.action_space: gymnasium.spaces.Space[Any] = (
            gymnasium.spaces.Box(-fastest, fastest, (2,), np.float32) if wheels else gymnasium.spaces.Discrete(CONTROLS)
        )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; see `gymnasium.Env.reset`. There are no options."""
        super().reset(seed=seed)
        self._free()
        kind = self._draw_kind()
        self._episode = Episode(draw(kind, self._starts, self.np_random), self._rules, engine=self._engine)
        self._rendering.follow(self._picture)
        return self._observation(self._episode), {"terrain": kind}

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Hold a control, or wheel speeds, for T ticks; see `gymnasium.Env.step`.

        Raises:
            RuntimeError: `reset` has not been called.
            ValueError: There is no such control, or wheel speeds are no two finite numbers.
        """
        if self._episode is None:
            raise RuntimeError("call reset before step")
        step = self._episode.step(self._control(action))
        self._rendering.follow(self._picture)
        told = {"reason": step.reason, "success": step.verdict == "success", "ticks": step.ticks}
        return self._observation(self._episode), step.reward, step.verdict is not None, step.truncated, told

    def _control(self, action: Any) -> Control | WheelSpeeds:
        if isinstance(self.action_space, gymnasium.spaces.Discrete):
            return Control(int(action))
        low, high = float(self.action_space.low[0]), float(self.action_space.high[0])  # type: ignore[attr-defined]
        left, right = np.clip(np.asarray(action, np.float64), low, high).tolist()
        return WheelSpeeds(left, right)

    def render(self) -> npt.NDArray[np.uint8] | None:
        """The push from above, shape (360, 360, 3); None in a window, and without a render mode.

        Raises:
            RuntimeError: `reset` has not been called.
        """
        return self._rendering.render(self._picture)

    def _picture(self) -> npt.NDArray[np.uint8]:
        if self._episode is None:
            raise RuntimeError("call reset before render")
        return picture(self._episode.scene, self._episode.start.task)

    def close(self) -> None:
        """Free the scene, and close the window."""
        self._free()
        self._rendering.close()

    def _free(self) -> None:
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
