"""What an agent is paid for what happens between two decisions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from colonysim.arguments import shown
from colonysim.errors import ColonysimError
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from colonysim.simulation import Colony
    from colonysim.trace.schema import Event

__all__ = ["KINDS", "REWARDS", "Reward", "Stretch", "reward_of"]

KINDS = ("start", "end", "goal", "lost", "spent", "episode")
"""The kinds of events that the rewards of this module, and the environments themselves, look at."""


class Stretch(NamedTuple):
    """What happened from one decision to the next; it is cut where the episode ends for an agent.

    Attributes:
        events: The events, in order.
        begin: Simulated seconds of the episode at its beginning.
        end: The same at its end.
        unit: Simulated seconds of a travelled edge: the unit in which time is paid for.
        agents: How many agents take part in the episode.
        arrived: How many of them had reached the goal before.
        there: For each agent whether it was neither at the goal nor lost nor absent at the beginning.
        filled: For each hole that has become level with its rim: its node, as the scenario numbers it.
        colony: The colony after it.
    """

    events: Sequence[Event]
    begin: float
    end: float
    unit: float
    agents: int
    arrived: int
    there: Sequence[bool]
    filled: Sequence[int]
    colony: Colony


Reward: TypeAlias = Callable[[Stretch], Sequence[float]]
"""Returns for each agent of the colony what it is paid; whose episode ended before is paid nothing whatever it says."""


def team_time(stretch: Stretch) -> list[float]:
    """Everybody loses the time that passes, in travelled edges, times the share of the agents not yet at the goal.

    Over an episode this adds up to the mean time of arrival, negative.
    """
    left = (stretch.agents - stretch.arrived) / max(1, stretch.agents)
    return [-left * (stretch.end - stretch.begin) / stretch.unit] * len(stretch.there)


def own_time(stretch: Stretch) -> list[float]:
    """Each agent loses the time that passes until it is at the goal, in travelled edges."""
    passed = (stretch.end - stretch.begin) / stretch.unit
    return [-passed if there else 0.0 for there in stretch.there]


def goal(stretch: Stretch) -> list[float]:
    """1 for an agent that has reached the goal."""
    there = {event.agent for event in stretch.events if event.kind == "goal"}
    return [float(agent in there) for agent in range(len(stretch.there))]


def filled(stretch: Stretch) -> list[float]:
    """1 for everybody for each hole that has become level with its rim."""
    return [float(len(stretch.filled))] * len(stretch.there)


def difference(stretch: Stretch) -> list[float]:
    """What the team's count of arrivals and filled holes would lack without the agent's own part in it.

    That is 1 for its own arrival, and 1 for each hole that was filled by its push; all else is taken to have happened
    without it as it did.
    """
    paid = goal(stretch)
    for event in stretch.events:
        if event.kind == "end" and event.action == "push" and event.target in stretch.filled:
            paid[event.agent] += 1.0
    return paid


REWARDS: dict[str, Reward] = {
    "team_time": team_time, "own_time": own_time, "goal": goal, "filled": filled, "difference": difference,
}  # fmt: skip
"""The rewards by name."""


def reward_of(given: str | Reward) -> Reward:
    """The reward of a name, or what is given in its place.

    Raises:
        ColonysimError: There is none of that name.
    """
    if callable(given):
        return _Checked(given)
    if given not in REWARDS:
        raise ColonysimError(f"no reward {given!r}; {nearest(str(given), REWARDS)}")
    return REWARDS[given]


class _Checked:
    """A reward that somebody brings: what it answers is checked before anybody is paid.

    Args:
        given: The function.
    """

    def __init__(self, given: Reward) -> None:
        self._given = given

    def __call__(self, stretch: Stretch) -> list[float]:
        """What it answers.

        Raises:
            ColonysimError: That is not one finite number for each agent.
        """
        answer, count = self._given(stretch), len(stretch.there)
        try:
            paid = None if isinstance(answer, Mapping) else [float(value) for value in answer]
        except (TypeError, ValueError):
            paid = None
        if paid is None or len(paid) != count or not all(map(isfinite, paid)):
            raise ColonysimError(f"reward: {shown(answer)}, expected {count} finite numbers, one for each agent")
        return paid
