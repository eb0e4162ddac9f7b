"""A colony as PettingZoo's parallel environment: a step leads to the next decision, whoever has to take it."""

from __future__ import annotations

from copy import deepcopy
from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium import spaces
from pettingzoo import ParallelEnv

from colonysim.rendering import RENDER_MODES, Rendering
from colonysim.rl.picture import FPS
from colonysim.rl.turns import Turns, name_of

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Self

    from numpy.typing import NDArray

    from colonysim.policies.policy import Choice
    from colonysim.rl.spaces import Observation
    from colonysim.rl.turns import Action
    from colonysim.simulation import Colony

__all__ = ["ColonyParallel"]


class ColonyParallel(ParallelEnv):  # type: ignore[misc]
    """A step leads to the next decision; who is busy can do nothing until it has to decide.

    In `infos` `requires_decision` says whether an agent has to decide. The others see what they saw when they decided
    last, in the same arrays; their mask allows the last action alone, which is to do nothing, and whatever they are
    told to do is left aside. In asynchronous mode one agent decides at a time, in synchronous mode all that act in the
    tick. `dt` is the time that the step took, simulated seconds, for all agents.

    Args:
        turns: The colony as a game of turns, `busy`.
        render_mode: "rgb_array" for `render` to give images, "human" for a window that follows (extra `window`).
    """

    metadata: dict[str, Any] = {"name": "colonysim_parallel_v0", "render_modes": [*RENDER_MODES], "render_fps": FPS}  # noqa: RUF012

    def __init__(self, turns: Turns, render_mode: str | None = None) -> None:
        super().__init__()
        self.turns, self.render_mode = turns, render_mode
        self._rendering = Rendering(render_mode, turns.scenario.name, FPS)
        self.possible_agents = [name_of(agent) for agent in range(len(turns.scenario.agents))]
        self._number = {name: agent for agent, name in enumerate(self.possible_agents)}
        observer = turns.observer
        self.observation_spaces = dict.fromkeys(self.possible_agents, observer.observation_space)
        self.action_spaces = {name: spaces.Discrete(observer.actions) for name in self.possible_agents}
        self.state_space = spaces.Box(-np.inf, np.inf, (turns.state_size,), np.float32)
        self.agents: list[str] = []
        self._seen: dict[str, Observation] = {}

    @property
    def colony(self) -> Colony | None:
        """The colony of the episode under way, to look at."""
        return self.turns.colony

    @property
    def nothing(self) -> int:
        """The action to do nothing."""
        return self.turns.observer.actions - 1

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """What an agent is told."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """What an agent can do, see `colonysim.rl.moves.Moves`; the last action is to do nothing."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begins an episode.

        Args:
            seed: Begins a new run, which it makes together with the scenario; None for the next episode.
            options: None are known; they are left aside.
        """
        self.turns.reset(seed)
        self.agents = [name_of(agent) for agent in self.turns.agents]
        none = self.turns.observer.mask(None)
        self._seen = {name: _busy(self.turns.observation(self._number[name]), none) for name in self.agents}
        self._rendering.follow(self.turns.picture)
        return self._told()

    def step(
        self, actions: Mapping[str, Action]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Has the agents that are asked act, and goes on to the next decision.

        Args:
            actions: By agent. One that is asked and given nothing to do waits for one edge's time.
        """
        turns = self.turns
        turns.decide_together(actions)
        if self.agents:
            turns.go_on()
        observations, infos = self._told()
        paid, number = turns.paid, self._number
        rewards = {name: paid[number[name]] for name in self.agents}
        terminated, truncated = dict.fromkeys(self.agents, False), dict.fromkeys(self.agents, False)
        if turns.ends:
            for name in self.agents:
                terminated[name], truncated[name] = turns.over(number[name])
            self.agents = [name for name in self.agents if not (terminated[name] or truncated[name])]
        self._rendering.follow(turns.picture)
        return observations, rewards, terminated, truncated, infos

    def _told(self) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        turns, observer, seen, observations, infos = self.turns, self.turns.observer, self._seen, {}, {}
        together, ends, none = turns.together, turns.ends, observer.mask(None)
        for name in self.agents:
            agent = self._number[name]
            asked = agent in together
            if asked or agent in ends:
                numbers, mask = turns.observe(agent)
                observations[name] = observer.observation(numbers, mask)
                seen[name] = _busy(observations[name], none)
            else:
                observations[name], mask = seen[name], none
            told = infos[name] = turns.info(agent, turns.begin, mask)
            told["requires_decision"] = asked
        return observations, infos

    def state(self) -> NDArray[np.float32]:
        """All that is so, for a critic that may know it; see `Turns.state`."""
        return self.turns.state()

    def choice(self, agent: str) -> Choice:
        """What the scenario's own policy would have an agent do that has to decide; `step` takes it."""
        return self.turns.choice(self._number[agent])

    def fork(self, seed: int | None = None) -> Self:
        """Another environment in the same state, which goes on by itself.

        Args:
            seed: All that is random from now on is drawn anew from it; None for a twin.
        """
        twin = type(self)(self.turns.fork(seed), self.render_mode)
        twin.agents, twin._seen = self.agents[:], deepcopy(self._seen)
        return twin

    def render(self) -> NDArray[np.uint8] | None:
        """The colony from above, shape (height, width, 3); None in a window, and without a render mode.

        Raises:
            ColonysimError: `reset` has not been called.
        """
        return self._rendering.render(self.turns.picture)

    def close(self) -> None:
        """Lets go of the colony; may be called at any time, and again."""
        self.turns.close()
        self._rendering.close()


def _busy(told: Observation, none: NDArray[np.int8]) -> Observation:
    """What an agent is told until it has to decide again."""
    return {**told, "action_mask": none} if isinstance(told, dict) else told
