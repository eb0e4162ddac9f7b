"""A colony as a PettingZoo environment: one call for each decision, in simulated time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium import spaces
from pettingzoo import AECEnv

from colonysim.errors import ColonysimError
from colonysim.rendering import RENDER_MODES, Rendering
from colonysim.rl.picture import FPS
from colonysim.rl.turns import Turns, name_of

if TYPE_CHECKING:
    from typing import Self

    from numpy.typing import NDArray

    from colonysim.policies.policy import Choice
    from colonysim.rl.turns import Action
    from colonysim.simulation import Colony

__all__ = ["ColonyAEC"]


class ColonyAEC(AECEnv):  # type: ignore[misc]
    """Agents are asked one after the other, each when it has to decide, ties in the simulation's own order.

    An agent that has reached the goal or is lost has terminated; one that has used up `max_steps`, and all that are
    left at a time limit or a deadlock, are truncated. `infos` of the agent that is asked say `t` and `dt`: simulated
    seconds of the episode, and since its last decision.

    Args:
        turns: The colony as a game of turns.
        render_mode: "rgb_array" for `render` to give images, "human" for a window that follows (extra `window`).
    """

    metadata: dict[str, Any] = {  # noqa: RUF012
        "name": "colonysim_v0", "render_modes": [*RENDER_MODES], "render_fps": FPS, "is_parallelizable": False,
    }  # fmt: skip

    def __init__(self, turns: Turns, render_mode: str | None = None) -> None:
        super().__init__()
        self.turns, self.render_mode = turns, render_mode
        self._rendering = Rendering(render_mode, turns.scenario.name, FPS)
        self.possible_agents = [name_of(agent) for agent in range(len(turns.scenario.agents))]
        self._number = {name: agent for agent, name in enumerate(self.possible_agents)}
        observer, size = turns.observer, (turns.state_size,)
        self.observation_spaces = dict.fromkeys(self.possible_agents, observer.observation_space)
        # Spaces draw from a random stream of their own: each agent has one.
        self.action_spaces = {name: spaces.Discrete(observer.actions) for name in self.possible_agents}
        self.state_space = spaces.Box(-np.inf, np.inf, size, np.float32)
        self.agents: list[str] = []
        self._ended = 0

    @property
    def colony(self) -> Colony | None:
        """The colony of the episode under way, to look at."""
        return self.turns.colony

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """What an agent is told."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """What an agent can do, see `colonysim.rl.moves.Moves`."""
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begins an episode.

        Args:
            seed: Begins a new run, which it makes together with the scenario; None for the next episode.
            options: None are known; they are left aside, as PettingZoo's wrappers may hand some on.
        """
        self.turns.reset(seed)
        self.agents = [name_of(agent) for agent in self.turns.agents]
        self.rewards = dict.fromkeys(self.agents, 0.0)
        self._cumulative_rewards = dict.fromkeys(self.agents, 0.0)
        self.terminations = dict.fromkeys(self.agents, False)
        self.truncations = dict.fromkeys(self.agents, False)
        self.infos: dict[str, dict[str, Any]] = {name: {} for name in self.agents}
        self._skip_agent_selection, self._ended = None, 0
        self._take_over()
        self._rendering.follow(self.turns.picture)

    def step(self, action: Action | None) -> None:
        """Has the agent that is asked act; None for one whose episode is over.

        Raises:
            ColonysimError: `reset` has not been called, the episode is over for all, or that is no action.
        """
        if not self.agents:
            raise ColonysimError("nobody is asked: call reset")
        name = self.agent_selection
        if self.terminations[name] or self.truncations[name]:
            self._was_dead_step(action)
            return
        self.turns.answer(action)  # type: ignore[arg-type]  # None is refused there
        self._cumulative_rewards[name] = 0.0
        self._take_over()
        self._rendering.follow(self.turns.picture)

    def _take_over(self) -> None:
        """What came of the last stretch, and whose turn it is."""
        turns, paid = self.turns, self.turns.paid
        rewards, owed, number = self.rewards, self._cumulative_rewards, self._number
        for name in self.agents:
            reward = rewards[name] = paid[number[name]]
            owed[name] += reward
        if len(turns.ends) > self._ended:
            for agent in [*turns.ends][self._ended :]:
                name = name_of(agent)
                self.terminations[name], self.truncations[name] = turns.over(agent)
                self.infos[name] = turns.info(agent, turns.since(agent), turns.observer.mask(None))
            self._ended = len(turns.ends)
        asked = turns.asked
        if asked is not None:
            name = self.agent_selection = self.possible_agents[asked]
            self.infos[name] = turns.info(asked, turns.since(asked), turns.mask(asked))
        elif self.agents:
            self.agent_selection = self.agents[0]
        if turns.ends:
            self._deads_step_first()

    def observe(self, agent: str) -> Any:
        """What an agent sees; the mask allows something only to the one that is asked."""
        return self.turns.observation(self._number[agent])

    def state(self) -> NDArray[np.float32]:
        """All that is so, for a critic that may know it; see `Turns.state`."""
        return self.turns.state()

    def choice(self) -> Choice:
        """What the scenario's own policy would have the agent that is asked do; `step` takes it."""
        return self.turns.choice()

    def fork(self, seed: int | None = None) -> Self:
        """Another environment in the same state, which goes on by itself.

        Args:
            seed: All that is random from now on is drawn anew from it; None for a twin.
        """
        if not hasattr(self, "agent_selection"):
            raise ColonysimError("there is nothing to fork yet: call reset first")
        twin = type(self)(self.turns.fork(seed), self.render_mode)
        twin.agents, twin._skip_agent_selection = self.agents[:], self._skip_agent_selection
        twin.rewards, twin._cumulative_rewards = dict(self.rewards), dict(self._cumulative_rewards)
        twin.terminations, twin.truncations = dict(self.terminations), dict(self.truncations)
        twin.infos = {name: dict(info) for name, info in self.infos.items()}
        twin.agent_selection, twin._ended = self.agent_selection, self._ended
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
