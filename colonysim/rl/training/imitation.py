"""Behaviour cloning of the rule: a network learns the decisions of `colony` from what agents are told."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from colonysim.learning.seeds import Purpose, episode_rng
from colonysim.rl.training.games import Decided, Game, play
from colonysim.world.intents import Push, Travel

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from colonysim.rl.sight import Sight
    from colonysim.rl.training.games import Path
    from colonysim.rl.training.presets import PolicyConfig
    from colonysim.scenario.scenario import Scenario
    from colonysim.world.intents import Intent

__all__ = ["Lessons", "action_of", "gather"]

_TOGETHER = 24
"""Games that are held at once."""


class Lessons:
    """Decisions of the rule.

    Args:
        paths: The agents' sequences of decisions.

    Attributes:
        told: What was told before each, shape (n, numbers).
        mask: For each action whether it was allowed, shape (n, actions).
        action: What the rule did, shape (n,).
    """

    def __init__(self, paths: Sequence[Path]) -> None:
        rows = [(*told, action) for path in paths for told, action in zip(path.told, path.action, strict=True)]
        kept = [row for row in rows if row[3] >= 0 and row[1].sum() > 1]
        self.told: NDArray[np.float32] = np.stack([row[0] for row in kept])
        self.mask: NDArray[np.bool_] = np.stack([row[1] for row in kept]).astype(bool)
        self.action: NDArray[np.int64] = np.array([row[3] for row in kept], np.int64)

    def __len__(self) -> int:
        return len(self.action)


def action_of(intent: Intent, sight: Sight, neighbours: int) -> int:
    """The number of the action that an intent comes to where holes are chosen by the rule; -1 if there is none.

    Args:
        intent: What an agent will do.
        sight: What it sees.
        neighbours: Rows of neighbours.
    """
    wait = 2 * neighbours
    if not isinstance(intent, (Travel, Push)):
        return wait
    if intent.node not in sight.neighbours:
        return -1
    k = sight.neighbours.index(intent.node)
    action = neighbours + k if isinstance(intent, Push) and intent.box == sight.box else k
    same = type(sight.intent(action)) is type(intent)
    return action if same and sight.mask[action] else -1


def _teach(games: Sequence[Game]) -> Decided:
    """What the rule does for the agents that are asked."""
    choices, actions = [], []
    for game in games:
        game.told()
        turns = game.turns
        assert turns.asked is not None
        choices.append(turns.choice())
        actions.append(action_of(choices[-1].intent, turns.sight(turns.asked), turns.observer.moves.neighbours))
    return Decided(choices, actions, [0.0] * len(games))


def gather(places: Sequence[Scenario], config: PolicyConfig, seed: int) -> tuple[Lessons, Lessons]:
    """Plays the rule, and returns its decisions: those to learn from, and those that are held out.

    Args:
        places: The places of the training; runs take them in turn.
        config: The training's parameters.
        seed: The training's seed.
    """
    runs = config.imitation.runs
    held_out = max(1, round(config.imitation.held_out * runs))
    paths: list[list[Path]] = []
    for first in range(0, runs, _TOGETHER):
        games = []
        for run in range(first, min(first + _TOGETHER, runs)):
            rng = episode_rng(Purpose.TRAIN, seed, 0, run)
            games.append(Game(places[run % len(places)], int(rng.integers(2**31)), config))
        play(games, _teach)
        paths += [game.paths for game in games]
    # The last runs are held out as wholes: decisions of one run are much alike.
    return (
        Lessons([path for run in paths[:-held_out] for path in run]),
        Lessons([path for run in paths[-held_out:] for path in run]),
    )
