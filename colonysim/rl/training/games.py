"""Runs played side by side, and of each agent its own sequence of decisions, rewards and the time between them."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import dist
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from colonysim.rl.turns import TERMINAL, Turns

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from numpy.typing import NDArray

    from colonysim.rl.training.presets import PolicyConfig
    from colonysim.scenario.scenario import Scenario

    Symmetry: TypeAlias = "tuple[NDArray[np.intp], NDArray[np.float32]]"

__all__ = ["MARKS", "SUMMARY", "Decided", "Episode", "Game", "Path", "play"]

REWARD_UNIT = 20.0
"""Travelled edges' time that one unit of reward stands for, so that returns are of the size of 1."""
MARKS = "colony"
"""The policy whose marks the agents leave, and which is the teacher."""
SUMMARY = 8
"""So many numbers tell a central critic of the whole state."""
NOTHING = np.zeros(0, np.float32)


@dataclass(slots=True)
class Path:
    """The decisions of one agent in one episode.

    Attributes:
        told: What it was told before each, the mask of its actions, and what a critic was told besides.
        action: What it did.
        chance: Logarithm of the chance with which it did that.
        reward: What it was paid until its next decision, or the end, discounted to the time of the decision.
        discount: What a reward at that next decision is worth at the decision.
        away: How far from the goal it was at its last decision, graph units.
    """

    told: list[tuple[NDArray[np.float32], NDArray[np.int8], NDArray[np.float32]]] = field(default_factory=list)
    action: list[int] = field(default_factory=list)
    chance: list[float] = field(default_factory=list)
    reward: list[float] = field(default_factory=list)
    discount: list[float] = field(default_factory=list)
    away: float = 0.0


@dataclass(frozen=True, slots=True)
class Episode:
    """How an episode ended.

    Attributes:
        place: Name of the scenario.
        number: Of the run, from 1.
        success: Share of agents that reached the goal.
        seconds: Simulated seconds until all had; of an episode that fails, the place's time limit.
        ended: Why it ended.
    """

    place: str
    number: int
    success: float
    seconds: float
    ended: str


@dataclass(frozen=True, slots=True)
class Decided:
    """What was decided for agents of several games, in their order.

    Attributes:
        answers: What to do, as an environment takes it.
        actions: The same as numbers of the action space.
        chances: Logarithms of the chances of that.
    """

    answers: Sequence[Any]
    actions: Sequence[int]
    chances: Sequence[float]


class Game:
    """A run: some episodes at one place, between which marks last.

    Args:
        scenario: The place; it has a time limit.
        seed: Makes the run.
        config: The training's parameters.
        symmetry: How what the agents are told is turned and mirrored, or None.

    Attributes:
        turns: The environment.
        episodes: How the episodes ended, so far.
        paths: The decisions of the episodes that have ended.
    """

    def __init__(self, scenario: Scenario, seed: int, config: PolicyConfig, symmetry: Symmetry | None = None) -> None:
        self.turns = Turns(
            scenario, seed=seed, flat=True, pheromones="keep", neighbours=config.neighbours, boxes=config.boxes,
            holes=config.holes, policy=MARKS,
        )  # fmt: skip
        self._symmetry, self._config, self._left = symmetry, config, config.episodes
        self._central = config.ppo.critic == "central"
        self.episodes: list[Episode] = []
        self.paths: list[Path] = []
        self._open: dict[int, Path] = {}
        self.over = False
        self._begin()

    def _begin(self) -> None:
        """The next episode in which anybody has to decide, or the end of the run."""
        while self._left and self.turns.asked is None:
            self._left -= 1
            self.turns.reset()
            self._open = {agent: Path() for agent in self.turns.agents}
            if self.turns.asked is None:
                self._end()
        if self.turns.asked is None:
            self.over = True
            self.turns.close()

    def told(self) -> tuple[NDArray[np.float32], NDArray[np.int8], NDArray[np.float32]]:
        """What the agent that is asked is told, the mask of its actions, and what a critic is told besides."""
        turns = self.turns
        agent = turns.asked
        assert agent is not None
        numbers, mask = turns.observe(agent)
        path = self._open[agent]
        path.away = dist((0.0, 0.0), numbers[:2].tolist())
        if self._symmetry is not None:
            order, signs = self._symmetry
            numbers = numbers[order] * signs
        more = self._summary() if self._central else NOTHING
        if path.action:
            path.discount.append(self._worth(turns.info(agent, turns.since(agent), mask)["dt"]))
        path.told.append((numbers, mask, more))
        return path.told[-1]

    def _summary(self) -> NDArray[np.float32]:
        """The whole state in `SUMMARY` numbers, for a critic that may know it, whatever the place is like."""
        turns, count = self.turns, max(1, len(self._open))
        colony = turns.colony
        assert colony is not None
        away = [path.away for agent, path in self._open.items() if agent not in turns.ends]
        there = sum(end == TERMINAL[0] for end in turns.ends.values())
        return np.array([
            len(away) / count, there / count, len(turns.ends) / count - there / count,
            sum(away) / 10.0 / max(1, len(away)), max(away, default=0.0) / 10.0,
            colony.now / turns.edge_seconds / 100.0, len(turns.scenario.topology) / 100.0, len(self.episodes) / 10.0,
        ], np.float32)  # fmt: skip

    def _worth(self, seconds: float) -> float:
        """What a reward is worth so much earlier."""
        return float(self._config.ppo.discount ** (seconds / self.turns.edge_seconds))

    def answer(self, answer: Any, action: int, chance: float) -> None:
        """Has the agent that is asked act.

        Args:
            answer: What to do, as an environment takes it.
            action: The number of that action, for the agent's path.
            chance: Logarithm of its chance.
        """
        turns = self.turns
        agent = turns.asked
        assert agent is not None
        path = self._open[agent]
        path.action.append(action)
        path.chance.append(chance)
        path.reward.append(0.0)
        there = [agent for agent in self._open if agent not in turns.ends]
        turns.answer(answer)
        self._pay(there)
        if turns.asked is None:
            self._end()
            self._begin()

    def _pay(self, there: Iterable[int]) -> None:
        """What the last stretch brought to the agents that were on their way, and the end of those that are not now."""
        turns, ppo = self.turns, self._config.ppo
        colony = turns.colony
        assert colony is not None
        for agent in there:
            path, begin, ended = self._open[agent], turns.begin, turns.ends.get(agent)
            if not path.action:
                continue  # it has not decided yet, so that nothing depends on it
            end, since = colony.now, turns.since(agent)
            if ended is not None:
                told = turns.info(agent, since, turns.observer.mask(None))
                end = told["t"]
            paid = turns.paid[agent] - ppo.own_time * (end - begin) / turns.edge_seconds
            if ended is not None:
                path.discount.append(0.0)
                if ended != TERMINAL[0]:
                    paid -= ppo.failure
            path.reward[-1] += self._worth(end - since) * paid / REWARD_UNIT

    def _end(self) -> None:
        """Keeps the paths of an episode that has ended, and how it did."""
        turns, scenario = self.turns, self.turns.scenario
        self.paths += [path for path in self._open.values() if path.action]
        there = sum(end == TERMINAL[0] for end in turns.ends.values())
        success = there / max(1, len(turns.agents))
        colony, limit = turns.colony, scenario.time_limit
        assert colony is not None and limit is not None
        seconds = min(colony.now, limit) if success == 1.0 else limit
        reasons = set(turns.ends.values()) - {TERMINAL[0]}
        number = len(self.episodes) + 1
        self.episodes.append(Episode(scenario.name, number, success, seconds, ", ".join(sorted(reasons)) or "goal"))


def play(games: Sequence[Game], decide: Callable[[Sequence[Game]], Decided]) -> None:
    """Plays games to their ends; in each round one agent of each is asked, and all of them are decided at once.

    Args:
        games: The games.
        decide: Decides for the agents that are asked; it is given the games that are not over.
    """
    while left := [game for game in games if not game.over]:
        decided = decide(left)
        for game, *answer in zip(left, decided.answers, decided.actions, decided.chances, strict=True):
            game.answer(*answer)
