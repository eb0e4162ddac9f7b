"""A colony by the conventions of RLlib's `MultiAgentEnv`: the dicts hold those who act next. Ray is not needed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gymnasium import spaces

from colonysim.rendering import RENDER_MODES, Rendering
from colonysim.rl.picture import FPS
from colonysim.rl.turns import Turns, name_of

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Self

    import numpy as np
    from numpy.typing import NDArray

    from colonysim.rl.spaces import Observation
    from colonysim.rl.turns import Action
    from colonysim.simulation import Colony

__all__ = ["ColonyMultiAgent"]


class ColonyMultiAgent:
    """`reset` and `step` tell of the agents that act next, and of those whose episode has just ended.

    What an agent was paid since it acted last comes with its next observation, and so does `dt`, simulated seconds.

    Args:
        turns: The colony as a game of turns.
        render_mode: "rgb_array" for `render` to give images, "human" for a window that follows (extra `window`).
    """

    metadata: dict[str, Any] = {"render_modes": [*RENDER_MODES], "render_fps": FPS}  # noqa: RUF012

    def __init__(self, turns: Turns, render_mode: str | None = None) -> None:
        self.turns, self.render_mode = turns, render_mode
        self._rendering = Rendering(render_mode, turns.scenario.name, FPS)
        self.possible_agents = [name_of(agent) for agent in range(len(turns.scenario.agents))]
        self.agents: list[str] = []
        observer = turns.observer
        self.observation_spaces = dict.fromkeys(self.possible_agents, observer.observation_space)
        self.action_spaces = {name: spaces.Discrete(observer.actions) for name in self.possible_agents}
        self._owed = [0.0] * len(self.possible_agents)

    @property
    def colony(self) -> Colony | None:
        """The colony of the episode under way, to look at."""
        return self.turns.colony

    @property
    def num_agents(self) -> int:
        """How many agents are left."""
        return len(self.agents)

    def get_observation_space(self, agent: str) -> spaces.Space[Any]:
        """What an agent is told."""
        return self.observation_spaces[agent]

    def get_action_space(self, agent: str) -> spaces.Space[Any]:
        """What an agent can do, see `colonysim.rl.moves.Moves`."""
        return self.action_spaces[agent]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Begins an episode.

        Args:
            seed: Begins a new run, which it makes together with the scenario; None for the next episode.
            options: None are known; they are left aside.
        """
        self.turns.reset(seed)
        self.agents = [name_of(agent) for agent in self.turns.agents]
        self._owed = self.turns.paid[:]
        self._rendering.follow(self.turns.picture)
        return self._told(self.turns.together)

    def step(
        self, action_dict: Mapping[str, Action]
    ) -> tuple[
        dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
    ]:
        """Has the agents that are asked act, and goes on to the next decision.

        Args:
            action_dict: By agent. One that is asked and given nothing to do waits for one edge's time.
        """
        turns = self.turns
        turns.decide_together(action_dict)
        before = {name: agent for agent, name in enumerate(self.possible_agents) if name in self.agents}
        turns.go_on()
        self._rendering.follow(turns.picture)
        for agent in before.values():
            self._owed[agent] += turns.paid[agent]
        ended = [agent for agent in before.values() if agent in turns.ends]
        told = [*turns.together, *ended]
        observations, infos = self._told(told)
        paid = {name_of(agent): self._owed[agent] for agent in told}
        for agent in told:
            self._owed[agent] = 0.0
        self.agents = [name for name, agent in before.items() if agent not in turns.ends]
        ends = {name_of(agent): turns.over(agent) for agent in told}
        terminated, truncated = ({name: end[which] for name, end in ends.items()} for which in (0, 1))
        all_ends = [turns.over(agent)[0] for agent in turns.agents] if not self.agents else [False]
        terminated["__all__"] = all(all_ends)
        truncated["__all__"] = not self.agents and not all(all_ends)
        return observations, paid, terminated, truncated, infos

    def _told(self, agents: list[int]) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        observations, infos = {}, {}
        for agent in agents:
            observations[name_of(agent)] = self.turns.observation(agent)
            infos[name_of(agent)] = self.turns.info(agent, self.turns.since(agent), self.turns.mask(agent))
        return observations, infos

    def fork(self, seed: int | None = None) -> Self:
        """Another environment in the same state, which goes on by itself; see `Colony.fork`."""
        twin = type(self)(self.turns.fork(seed), self.render_mode)
        twin.agents, twin._owed = self.agents[:], self._owed[:]
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
