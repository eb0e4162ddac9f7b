# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True, auto_pickle=False
"""Waiting agents, indexed by the nodes whose change wakes them."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from colonysim.states import State, Stored

__all__ = ["Waiting"]

FEW = 16
"""A list longer than this is cleared of waits that are over when it is twice as long as after the last clearing."""
NOTHING = -1
"""Ends a chain of entries."""
_NOT, _ASLEEP, _CALLED = 0, 1, 2
"""States of an agent: not waiting; waiting; waiting, and called to wait no more."""


class Waiting:
    """The agents that wait, and the nodes whose change wakes them.

    Each wait has a sequence number, from which the agent follows (number modulo agents). A wait is over when its agent
    has another sequence number; it is taken out of the nodes' lists later, since in a crowd these are long and change
    all the time. The lists are chains in flat arrays: `_next` of an entry is the next one of the same node.

    Args:
        agents: How many agents there are.
        nodes: How many nodes there are.
        rouse: Called once with an agent that is to wait no more; the caller then has to call `end`.
    """

    def __init__(self, agents: int, nodes: int, rouse: Callable[[int], None]) -> None:
        self._agents, self._rouse = agents, rouse
        self._states, self._waits = bytearray(agents), array("q", range(agents))
        self._first, self._last = array("i", [NOTHING]) * nodes, array("i", [NOTHING]) * nodes
        self._long, self._full = array("i", [0]) * nodes, array("i", [FEW]) * nodes
        self._next, self._wait = array("i", [NOTHING]) * FEW, array("q", [0]) * FEW
        self._count, self._used, self._spare = 0, 0, NOTHING

    def clear(self) -> None:
        """Ends all waits; nobody is called."""
        self._count, self._used, self._spare = 0, 0, NOTHING
        for agent in range(self._agents):
            self._states[agent], self._waits[agent] = _NOT, agent
        for node in range(len(self._first)):
            self._first[node], self._long[node], self._full[node] = NOTHING, 0, FEW

    def begin(self, agent: int, nodes: Iterable[int]) -> int:
        """Lets an agent wait for a change on one of the nodes, or to be called; returns the wait's sequence number."""
        wait = self._begin(agent)
        for node in nodes:
            if 0 <= node < len(self._first):  # what a policy names need not exist
                self._add(node, wait)
        return wait

    def begin_at(self, agent: int, nodes: array[int], count: int) -> None:
        """`begin` with the first `count` of `nodes`, all of which exist."""
        wait = self._begin(agent)
        for i in range(count):
            self._add(nodes[i], wait)

    def _begin(self, agent: int) -> int:
        self._states[agent] = _ASLEEP
        self._count += 1
        return self._waits[agent]

    def _add(self, node: int, wait: int) -> None:
        """Appends a wait to the list of a node."""
        if self._long[node] >= self._full[node]:
            self._sweep(node)
        entry = self._spare
        if entry == NOTHING:
            if self._used == len(self._next):
                # Not in place: compiled code looks at the old arrays.
                self._next, self._wait = array("i", bytes(self._next) * 2), array("q", bytes(self._wait) * 2)
            entry = self._used
            self._used += 1
        else:
            self._spare = self._next[entry]
        self._next[entry], self._wait[entry] = NOTHING, wait
        if self._first[node] == NOTHING:
            self._first[node] = entry
        else:
            self._next[self._last[node]] = entry
        self._last[node] = entry
        self._long[node] += 1

    def _sweep(self, node: int) -> None:
        """Removes the waits that are over from the list of a node."""
        entry, before = self._first[node], NOTHING
        while entry != NOTHING:
            after, wait = self._next[entry], self._wait[entry]
            if self._waits[wait % self._agents] == wait:
                before = entry
            else:
                if before == NOTHING:
                    self._first[node] = after
                else:
                    self._next[before] = after
                self._next[entry], self._spare = self._spare, entry
                self._long[node] -= 1
            entry = after
        self._last[node] = before
        self._full[node] = max(FEW, 2 * self._long[node])

    def state(self) -> State:
        """The state and the wait of each agent, and node by node the waits that are not over, in their order."""
        nodes, waits = array("i"), array("q")
        for node in range(len(self._first)):
            entry = self._first[node]
            while entry != NOTHING:
                wait = self._wait[entry]
                if self._waits[wait % self._agents] == wait:
                    nodes.append(node)
                    waits.append(wait)
                entry = self._next[entry]
        return {"states": bytes(self._states), "waits": array("q", bytes(self._waits)), "at": nodes, "who": waits}

    def restore(self, state: Stored) -> None:
        """Takes over the state of as many agents on as many nodes."""
        agents = self._agents
        states, waits = state.octets("states", agents, _CALLED), state.column("waits", "q", agents, 0)
        at, who = state.column("at", "i", None, 0, len(self._first) - 1), state.column("who", "q", None, 0)
        if any(wait % agents != agent for agent, wait in enumerate(waits)) or len(at) != len(who):
            raise state.fault("waits", waits, "waits of agents and nodes that exist")
        self.clear()
        self._count = agents - states.count(_NOT)
        for agent in range(agents):
            self._states[agent], self._waits[agent] = states[agent], waits[agent]
        for node, wait in zip(at, who, strict=True):
            self._add(node, wait)

    def waits(self, agent: int) -> bool:
        """Whether an agent waits, called or not."""
        return self._states[agent] != _NOT

    def end(self, agent: int) -> None:
        """Ends the wait of an agent."""
        self._states[agent] = _NOT
        self._count -= 1
        self._waits[agent] += self._agents

    def wake(self, nodes: Iterable[int]) -> bool:
        """Calls whoever waits for a change on one of the nodes; returns whether anybody does, called before or not."""
        if self._count == 0:
            return False
        found = False
        for node in nodes:
            if 0 <= node < len(self._first) and self._wake_at(node):  # a footprint may name what does not exist
                found = True
        return found

    def wake_two(self, one: int, other: int) -> bool:
        """`wake` for two nodes."""
        if self._count == 0:
            return False
        found = self._wake_at(one)
        return self._wake_at(other) or found

    def _wake_at(self, node: int) -> bool:
        entry, found = self._first[node], False
        while entry != NOTHING:
            wait = self._wait[entry]
            agent = wait % self._agents
            if self._waits[agent] == wait and self._states[agent] != _NOT:
                self.call(agent)
                found = True
            entry = self._next[entry]
        return found

    def call(self, agent: int) -> None:
        """Calls an agent (-1: nobody), if it waits and has not been called."""
        if agent >= 0 and self._states[agent] == _ASLEEP:
            self._states[agent] = _CALLED
            self._rouse(agent)

    def expire(self, wait: int) -> None:
        """Calls the agent of the wait with a sequence number, if that wait is not over."""
        agent = wait % self._agents
        if self._waits[agent] == wait:
            self.call(agent)
