"""Who waits for a change on which nodes."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

__all__ = ["Waiting"]

FEW = 64
"""Longer lists are cleared of waits that are over whenever they have become twice as long as after the last time."""
_NOT, _ASLEEP, _CALLED = 0, 1, 2


class Waiting:
    """The agents that wait, and the nodes whose change wakes them.

    A wait has a number of its own (it tells the agent too), and is over when its agent has another: nothing has to be
    taken out of the nodes' lists, which in a crowd are long and change all the time.

    Args:
        agents: How many agents there are.
        nodes: How many nodes there are.
        rouse: Called with an agent that waits when it shall wait no more, once; `end` is then to follow.
    """

    def __init__(self, agents: int, nodes: int, rouse: Callable[[int], None]) -> None:
        self._agents, self._rouse = agents, rouse
        self._count = 0
        self._states = bytearray(agents)
        self._waits = array("q", range(agents))
        self._at: list[list[int] | None] = [None] * nodes
        self._full = array("q", [FEW]) * nodes

    def begin(self, agent: int, nodes: Iterable[int]) -> int:
        """An agent begins to wait for a change on one of the nodes, or to be called; returns the wait's number."""
        self._states[agent] = _ASLEEP
        self._count += 1
        wait = self._waits[agent]
        for node in nodes:
            if not 0 <= node < len(self._at):
                continue  # what a policy names need not exist
            waits = self._at[node]
            if waits is None:
                waits = self._at[node] = []
            waits.append(wait)
            if len(waits) >= self._full[node]:
                waits = self._at[node] = [w for w in waits if self._waits[w % self._agents] == w]
                self._full[node] = max(FEW, 2 * len(waits))
        return wait

    def waits(self, agent: int) -> bool:
        """Whether an agent waits, called or not."""
        return self._states[agent] != _NOT

    def end(self, agent: int) -> None:
        """An agent waits no more."""
        self._states[agent] = _NOT
        self._count -= 1
        self._waits[agent] += self._agents

    def wake(self, nodes: Iterable[int]) -> bool:
        """Calls whoever waits for a change on one of the nodes; returns whether anybody does, called before or not."""
        if self._count == 0:
            return False
        found = False
        for node in sorted(nodes):
            if self._wake_at(node):
                found = True
        return found

    def wake_two(self, one: int, other: int) -> bool:
        """`wake` for two nodes."""
        if self._count == 0:
            return False
        found = self._wake_at(min(one, other))
        return self._wake_at(max(one, other)) or found

    def _wake_at(self, node: int) -> bool:
        waits, found = self._at[node], False
        if waits is not None:
            for wait in waits:
                agent = wait % self._agents
                if self._waits[agent] == wait and self._states[agent] != _NOT:
                    self.call(agent)
                    found = True
        return found

    def call(self, agent: int) -> None:
        """Calls an agent (-1: nobody), if it waits and has not been called."""
        if agent >= 0 and self._states[agent] == _ASLEEP:
            self._states[agent] = _CALLED
            self._rouse(agent)

    def expire(self, wait: int) -> None:
        """Calls the agent of a wait, if it is not over."""
        agent = wait % self._agents
        if self._waits[agent] == wait:
            self.call(agent)
