"""Who waits for a change on which nodes."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

    import simpy

__all__ = ["Waiting"]

FEW = 64
"""Longer lists are cleared of waits that are over whenever they have become twice as long as after the last time."""


class Waiting:
    """The agents that wait, and the nodes whose change wakes them.

    A wait has a number of its own (it tells the agent too), and is over when its agent has another: nothing has to be
    taken out of the nodes' lists, which in a crowd are long and change all the time.

    Args:
        agents: How many agents there are.

    Attributes:
        events: For each agent that waits, the event that it waits for.
    """

    def __init__(self, agents: int) -> None:
        self.events: dict[int, simpy.Event] = {}
        self._agents = agents
        self._waits = array("q", range(agents))
        self._at: dict[int, list[int]] = {}
        self._full: dict[int, int] = {}

    def begin(self, agent: int, nodes: Iterable[int], event: simpy.Event) -> None:
        """An agent begins to wait for a change on one of the nodes, or for the event to come otherwise."""
        self.events[agent] = event
        wait = self._waits[agent]
        for node in nodes:
            waits = self._at.get(node)
            if waits is None:
                waits = self._at[node] = []
            waits.append(wait)
            if len(waits) >= FEW and len(waits) >= self._full.get(node, FEW):
                waits = self._at[node] = [w for w in waits if self._waits[w % self._agents] == w]
                self._full[node] = max(FEW, 2 * len(waits))

    def end(self, agent: int) -> None:
        """An agent waits no more."""
        del self.events[agent]
        self._waits[agent] += self._agents

    def wake(self, nodes: Iterable[int]) -> bool:
        """Wakes whoever waits for a change on one of the nodes; returns whether anybody does."""
        if not self.events:
            return False
        found = False
        for node in sorted(nodes):
            waits = self._at.get(node)
            if waits is not None:
                for wait in waits:
                    agent = wait % self._agents
                    if self._waits[agent] == wait and agent in self.events:
                        self.call(agent)
                        found = True
        return found

    def call(self, agent: int) -> None:
        """Wakes an agent, if it waits."""
        event = self.events.get(agent)
        if event is not None and not event.triggered:
            event.succeed()
