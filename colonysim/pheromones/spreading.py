# cython: boundscheck=False, wraparound=False, initializedcheck=False
"""Values at nodes that fade with time and spread along edges."""

from __future__ import annotations

import copy
from array import array
from typing import TYPE_CHECKING, Any

from colonysim.arguments import real
from colonysim.pheromones.marks import Fading, each_node
from colonysim.states import LARGEST, Stored

if TYPE_CHECKING:
    from collections.abc import Iterable

    from colonysim.states import State
    from colonysim.world.state import World

__all__ = ["FAINT", "NodeValues"]

FAINT = 1e-15
"""Two neighbours that both have less exchange nothing. In a million ticks that makes a difference of 1e-9 at most."""
SHORTEST_PERIOD, LONGEST_PERIOD = 0.01, 1e9
SMALLEST_SCALE = 1e-100
"""When `scale` falls below this, it is multiplied into the stored values, long before it could underflow."""
LONGEST_LOG = 1 << 22
"""Deposits that are written down at most before they are worked off, though nobody has looked."""
END = -1
"""Stands in the log for a node: an episode has ended."""


class NodeValues:
    """One value a node, which fades with time and spreads along edges; 0 where there are no marks.

    Fading: every value halves with every half-life, without a break. Spreading: at every tick, that is after each
    `period` of the episode's time, each node i gives its neighbour j the share w_ij of its value and gets the same
    share of the neighbour's, all at once: v_i += sum over j of w_ij (v_j - v_i), with w_ij = diffusion / (the larger of
    the two nodes' numbers of edges). No mark is lost or made by it, and where all values are the same nothing changes.
    On a grid this is `diffuse` of NetLogo. An edge's length and height do not matter; along an edge that is not there
    (its rise is nan) nothing goes.

    A deposit is only written down. The deposits and ticks since then are worked off, in the order of their times, when
    somebody looks: the result has the same bits whenever and however often that is. A tick visits the nodes whose value
    is at least `FAINT` and their neighbours.

    Args:
        world: Whose nodes they are, and whose time it is.
        half_life: Simulated seconds in which values halve, None for never.
        diffusion: Share of its value that a node gives away at a tick if no neighbour has more edges, 0 to 1.
        period: Simulated seconds between two ticks.

    Raises:
        ColonysimError: An argument is out of its range.

    Attributes:
        held: One number for each node, from which its value is held * scale * what is left of the values of `since`.
        scale: Product of all factors so far.
        ticks: The number of ticks of this episode that are in `held`.
        fading: The evaporation, with the second `since`.
        diffusion: As given.
        period: As given.

    Example:
        >>> values = NodeValues(world, half_life=20.0, diffusion=0.5)
        >>> values.add(3, 1.0)
        >>> values.at(3)
        1.0
    """

    def __init__(
        self, world: World, *, half_life: float | None = None, diffusion: float = 0.0, period: float = 1.0
    ) -> None:
        self._world, self.fading = world, Fading(world, half_life)
        self.diffusion = real("diffusion", diffusion, 0.0, 1.0)
        self.period = real("period", period, SHORTEST_PERIOD, LONGEST_PERIOD)
        topology, self._spreads = world.topology, self.diffusion > 0.0
        size = self._size = len(topology)
        self._first, self._ends = topology.edges[:2]
        self._portions = array("d", [0.0] + [self.diffusion / k for k in range(1, topology.most_neighbours + 1)])
        self.held, self.scale, self.ticks = array("d", bytes(8 * size)), 1.0, 0
        # The nodes that a tick has to visit: all that have marks and could give or get some. `_next`: their new values.
        room = size if self._spreads else 0
        self._listed, self._active, self._count = bytearray(size), array("i", bytes(4 * room)), 0
        self._next = array("d", bytes(8 * room))
        # What has been deposited and is not in `held` yet. At the node END: the share that remains of all values, or -1
        # to take the smallest off.
        self._logged = 0
        self._seconds, self._nodes, self._amounts = array("d", [0.0]), array("i", [0]), array("d", [0.0])

    def __deepcopy__(self, memo: dict[int, Any]) -> NodeValues:
        """The same values in a copy of the world; typed views of arrays cannot be copied as they are."""
        world = copy.deepcopy(self._world, memo)
        twin = NodeValues(world, half_life=self.fading.half_life, diffusion=self.diffusion, period=self.period)
        twin.fading.restart(self.fading.since)
        twin.held, twin.scale, twin.ticks = array("d", self.held), self.scale, self.ticks
        twin._listed, twin._active, twin._count = bytearray(self._listed), array("i", self._active), self._count
        twin._logged, twin._seconds = self._logged, array("d", self._seconds)
        twin._nodes, twin._amounts = array("i", self._nodes), array("d", self._amounts)
        return twin

    # -- for fields --------------------------------------------------------------------------------------------------

    def at(self, node: int) -> float:
        """The value at a node now.

        Raises:
            IndexError: There is no such node.
        """
        self._check(node)
        if self._spreads:
            self.settle()
        value = self.held[node] * self.scale
        return value * self.fading.left() if self.fading.on else value

    def add(self, node: int, amount: float) -> None:
        """Adds to the value at a node; looks at nothing.

        Raises:
            IndexError: There is no such node.
        """
        self._check(node)
        if self._spreads:
            self._write_down(self._world.now, node, amount)
        else:
            self._add(self._world.now, node, amount)

    def put(self, node: int, value: float) -> None:
        """Sets the value at a node.

        Raises:
            IndexError: There is no such node.
        """
        self._check(node)
        self.settle()
        self.held[node] = 0.0
        if value != 0.0:
            self._add(self._world.now, node, value)

    def wipe(self, nodes: Iterable[int]) -> None:
        """Sets the values at some nodes to 0; what has spread from there stays where it is.

        Raises:
            IndexError: There is no such node.
        """
        self.settle()
        for node in each_node(nodes, self._size):
            self.held[node] = 0.0

    def end_episode(self, keep: float = 1.0) -> None:
        """What the end of an episode does to the values; the time begins anew at 0.

        Args:
            keep: Share of every value that remains; -1 to take the smallest value off all of them instead.
        """
        if keep == 0.0:
            self._logged = 0
            self._clear()
        elif self._spreads:
            self._write_down(self._world.now, END, keep)
        else:
            self._end(self._world.now, keep)

    def items(self) -> list[tuple[int, float]]:
        """Every node whose value is not 0, ascending, with its value."""
        self.settle()
        return [(node, self.at(node)) for node in range(self._size) if self.held[node] != 0.0]

    def settle(self) -> None:
        """Works off the deposits and ticks up to now, as a look does; see `Marks.settle` for when that is needed."""
        if self._logged > 0:
            for i in range(self._logged):
                node, second, amount = self._nodes[i], self._seconds[i], self._amounts[i]
                self._spread(second)
                if node == END:
                    self._end(second, amount)
                else:
                    self._add(second, node, amount)
            self._logged = 0
        self._spread(self._world.now)

    def state(self) -> State:
        """The values, and what has been deposited since they were worked out; arrays of the first so many numbers."""
        return {
            "held": array("d", bytes(self.held)), "scale": self.scale, "ticks": self.ticks, "since": self.fading.since,
            "active": array("i", self._active[: self._count]), "seconds": array("d", self._seconds[: self._logged]),
            "nodes": array("i", self._nodes[: self._logged]), "amounts": array("d", self._amounts[: self._logged]),
        }  # fmt: skip

    def restore(self, state: State, what: str = "the values at nodes") -> None:
        """Takes over what `state` has returned.

        Args:
            state: That.
            what: Whose it is, for messages.

        Raises:
            ColonysimError: It is no such state.
        """
        told = Stored(state, what)
        held = told.column("held", "d", self._size, -LARGEST, LARGEST)
        active = told.column("active", "i", None, 0, self._size - 1)
        nodes = told.column("nodes", "i", None, END, self._size - 1)
        seconds = told.column("seconds", "d", len(nodes), 0.0, LARGEST)
        amounts = told.column("amounts", "d", len(nodes), -LARGEST, LARGEST)
        if len({*active}) < len(active) or (active and not self._spreads):
            raise told.fault("active", active.tolist(), "each node once")
        self.scale, self.ticks = told.real("scale", SMALLEST_SCALE, 1.0), told.whole("ticks")
        self.fading.restore(told)
        self.held, self._listed, self._count = array("d", held), bytearray(self._size), len(active)
        for k in range(self._count):
            self._active[k], self._listed[active[k]] = active[k], 1
        self._logged = len(nodes)
        if nodes:
            self._seconds, self._nodes, self._amounts = array("d", seconds), array("i", nodes), array("d", amounts)

    def refresh(self) -> None:
        """See `Marks.refresh`."""
        self.settle()
        if self.fading.on:
            self._renew(self._world.now)
        self.fading.restart(self._world.now)

    # -- inside ------------------------------------------------------------------------------------------------------

    def _check(self, node: int) -> None:
        if not 0 <= node < self._size:
            raise IndexError(f"there is no node {node}")

    def _write_down(self, second: float, node: int, amount: float) -> None:
        """Adds a deposit, or the end of an episode, to the log."""
        i = self._logged
        if i == len(self._nodes):
            # Not in place: compiled code looks at the old arrays.
            self._seconds, self._nodes = array("d", bytes(self._seconds) * 2), array("i", bytes(self._nodes) * 2)
            self._amounts = array("d", bytes(self._amounts) * 2)
        self._seconds[i], self._nodes[i], self._amounts[i] = second, node, amount
        self._logged = i + 1
        if self._logged >= LONGEST_LOG and node != END:
            self.settle()

    def _add(self, second: float, node: int, amount: float) -> None:
        """Adds to the value that a node has at a second; all ticks before are in `held`."""
        one = self.scale
        if self.fading.on:
            if self.fading.faint_at(second):
                self._renew(second)
            one = self.scale * self.fading.left_at(second)
        self.held[node] += amount / one
        if self._spreads and not self._listed[node]:
            self._listed[node], self._active[self._count] = 1, node
            self._count += 1

    def _renew(self, second: float) -> None:
        """Takes what has faded into the scale; what fades later counts from a second of the episode."""
        self.scale *= self.fading.left_at(second)
        self.fading.restart(second)
        self._rescale()

    def _rescale(self) -> None:
        """Multiplies a scale that has become too small into the values."""
        if self.scale < SMALLEST_SCALE:
            for node in range(self._size):
                self.held[node] *= self.scale
            self.scale = 1.0

    def _end(self, second: float, keep: float) -> None:
        """An episode has ended after a number of seconds; all its ticks are in `held`."""
        if self.fading.on:
            self._renew(second)
            self.fading.restart(0.0)
        self.ticks = 0
        if keep < 0.0:
            least = self.held[0]
            for node in range(self._size):
                if self.held[node] < least:
                    least = self.held[node]
            for node in range(self._size):
                self.held[node] -= least
        elif keep < 1.0:
            self.scale *= keep
            self._rescale()

    def _clear(self) -> None:
        """Nobody has left a mark, and the time is 0."""
        self.held, self.scale, self.ticks = array("d", bytes(8 * self._size)), 1.0, 0
        self._listed, self._count = bytearray(self._size), 0
        self.fading.restart(0.0)

    def _spread(self, second: float) -> None:
        """Makes all ticks up to a second of the episode."""
        due = int(second / self.period)
        while self.ticks < due and self._count > 0:
            self.ticks += 1
            # What no longer changes without fading never will.
            if not self._tick() and not self.fading.on:
                break
        if self.ticks < due:
            self.ticks = due

    def _tick(self) -> bool:
        """One tick, the one with the number `ticks`; whether it has changed any value."""
        changed, rises, factor = False, self._world.terrain.rises, self.scale
        if self.fading.on:
            factor = self.scale * self.fading.left_at(self.ticks * self.period)
        least = FAINT / factor if factor > 0.0 else float("inf")
        # Those that could get something from a neighbour are visited too.
        for k in range(self._count):
            i = self._active[k]
            own = self.held[i]
            if own >= least or own <= -least:
                for edge in range(self._first[i], self._first[i + 1]):
                    j = self._ends[edge]
                    if not self._listed[j]:
                        self._listed[j], self._active[self._count] = 1, j
                        self._count += 1
        # All at once; who neither gives nor gets is not visited again before a neighbour has something to give.
        count = 0
        for k in range(self._count):
            i = self._active[k]
            own = self.held[i]
            strong, fresh, takes_part = own >= least or own <= -least, own, False
            edges = self._first[i + 1] - self._first[i]
            for edge in range(self._first[i], self._first[i + 1]):
                j = self._ends[edge]
                other, rise = self.held[j], rises[edge]
                if (strong or other >= least or other <= -least) and rise == rise:  # not nan
                    others = self._first[j + 1] - self._first[j]
                    fresh += self._portions[edges if edges > others else others] * (other - own)
                    takes_part = True
            if takes_part or strong:
                self._active[count], self._next[count] = i, fresh
                count += 1
                if fresh != own:
                    changed = True
            else:
                self._listed[i] = 0
        self._count = count
        for k in range(count):
            self.held[self._active[k]] = self._next[k]
        return changed
