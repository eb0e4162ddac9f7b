# cython: initializedcheck=False
"""The exploration pheromone E: how often a node was visited recently (paper Section 3.3.4, Algorithm 7)."""

from __future__ import annotations

import copy
from array import array
from typing import TYPE_CHECKING, Any

from colonysim.pheromones.field import Write
from colonysim.pheromones.marks import Fading, Marks, each_node
from colonysim.pheromones.spreading import NodeValues
from colonysim.states import LARGEST, Stored

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.pheromones.field import Moment, Visit
    from colonysim.states import State
    from colonysim.world.state import World

__all__ = ["Exploration"]

SMALLEST_SCALE = 1e-100
"""When `scale` falls below this, it is multiplied into the stored values, long before it could underflow."""


class Exploration(Marks):
    """E counts visits; an episode's end maps every value by E -> a E - b, applied when a value is read, as is fading.

    Args:
        world: The world whose nodes are marked.
        evaporation: What remains of E after an episode, 0 to 1; None to subtract the smallest E instead, as
            Algorithm 7 prints it.
        on_wait: Whether an agent that waits deposits too.
        at_start: Whether an agent deposits before its first step too.
        half_life: Simulated seconds in which E halves, None for never.
        diffusion: Share of E that a node gives to its neighbours at a tick, see `NodeValues`; 0 for none.
        period: Simulated seconds between two ticks.

    Attributes:
        stored: One value for each node, from which E = stored * scale - shift. If E spreads, `spread` has all.
        visited: For each node 1 if an agent has left a mark that still counts, else 0.
        scale: Product of all evaporation factors so far.
        shift: What has been subtracted from all values so far.
        spread: The values of a field that spreads, else None.
    """

    name = "E"

    def __init__(
        self,
        world: World,
        *,
        evaporation: float | None = 0.5,
        on_wait: bool = False,
        at_start: bool = True,
        half_life: float | None = None,
        diffusion: float = 0.0,
        period: float = 1.0,
    ) -> None:
        super().__init__()
        self._world = world
        self._keep, self._on_wait, self._at_start = evaporation, on_wait, at_start
        self.stored = array("d", bytes(8 * len(world.topology)))
        self.visited = bytearray(len(world.topology))
        self.scale = 1.0
        self.shift = 0.0
        self._fading = Fading(world, half_life)
        self.spread: NodeValues | None = None
        if diffusion:
            self.spread = NodeValues(world, half_life=half_life, diffusion=diffusion, period=period)

    def __deepcopy__(self, memo: dict[int, Any]) -> Exploration:
        """The same values in a copy of the world; typed views of arrays cannot be copied as they are."""
        world = copy.deepcopy(self._world, memo)
        twin = Exploration(
            world,
            evaporation=self._keep,
            on_wait=self._on_wait,
            at_start=self._at_start,
            half_life=self._fading.half_life,
        )
        if self.spread is not None:
            twin.spread = copy.deepcopy(self.spread, memo)
        twin._fading.restart(self._fading.since)
        twin.stored, twin.visited = array("d", self.stored), bytearray(self.visited)
        twin.scale, twin.shift = self.scale, self.shift
        return twin

    def at(self, node: int, key: int = -1) -> float:
        """E of a node."""
        if self.spread is not None:
            return self.spread.at(node)
        value = self.stored[node] * self.scale - self.shift
        return value * self._fading.left() if self._fading.on else value

    def keys(self, node: int) -> Sequence[int]:
        """None: one value a node."""
        return ()

    def mark(self, visit: Visit) -> int:
        """E grows by 1 at each visit."""
        moment, node = visit.moment, visit.node
        if moment != "arrive" and not self._counts(moment):
            return 0
        if self.spread is not None:
            self.spread.add(node, 1.0)
            self.visited[node], self._wrote = 1, 0
            self._note(node, -1, 0.0)  # its value is computed only when asked for: that is to look
            return 1
        one = self.scale
        if self._fading.on:
            if self._fading.faint():
                self._fade(self._world.now)
            one = self.scale * self._fading.left()
        self.stored[node] += 1.0 / one
        self.visited[node] = 1
        self._wrote = 0
        self._note(node, -1, self.at(node))
        return 1

    def value(self, i: int) -> float:
        """E as the last `mark` wrote it."""
        return self._values[i] if self.spread is None else self.spread.at(self._places[i])

    def _fade(self, second: float) -> None:
        """Takes what has faded into the values; what fades later counts from a second of the episode."""
        left = self._fading.left()
        self.scale, self.shift = self.scale * left, self.shift * left
        self._fading.restart(second)
        if self.scale < SMALLEST_SCALE:
            self.stored = array("d", [value * self.scale for value in self.stored])
            self.scale = 1.0

    def _counts(self, moment: Moment) -> bool:
        """Whether a visit that is no arrival leaves a mark."""
        return (moment == "wait" and self._on_wait) or (moment == "start" and self._at_start)

    def end_episode(self) -> None:
        """Evaporates all values or subtracts their minimum (which is 0 until every node was visited)."""
        if self.spread is not None:
            self.spread.end_episode(-1.0 if self._keep is None else self._keep)
            if self._keep is not None and self._keep <= 0.0:
                self.visited = bytearray(len(self.visited))
            return
        if self._fading.on:
            self._fade(0.0)
        if self._keep is None:
            if all(self.visited):
                self.shift = min(self.stored) * self.scale
        elif self._keep <= 0.0:
            self.stored = array("d", bytes(8 * len(self.stored)))
            self.visited = bytearray(len(self.visited))
        else:
            self.scale *= self._keep
            if self.scale < SMALLEST_SCALE:
                self.stored = array("d", [value * self.scale for value in self.stored])
                self.scale = 1.0

    def refresh(self) -> None:
        """See `Marks.refresh`."""
        if self.spread is not None:
            self.spread.refresh()
        elif self._fading.on:
            self._fade(self._world.now)
        self._fading.restart(self._world.now)

    def state(self) -> State:
        """The stored values with what they are multiplied by and lessened by."""
        return {
            "stored": array("d", bytes(self.stored)), "visited": bytes(self.visited), "scale": self.scale,
            "shift": self.shift, "since": self._fading.since,
            "spread": None if self.spread is None else self.spread.state(),
        }  # fmt: skip

    def restore(self, state: State) -> None:
        """See `Marks.restore`."""
        told, nodes = Stored(state, "field E"), len(self.visited)
        stored, visited = told.column("stored", "d", nodes, -LARGEST, LARGEST), told.octets("visited", nodes, 1)
        self.scale, self.shift = told.real("scale", SMALLEST_SCALE, 1.0), told.real("shift", -LARGEST, LARGEST)
        if self.spread is not None:
            self.spread.restore(told.take("spread"), "field E, 'spread'")
        self._fading.restore(told)
        self.stored, self.visited = array("d", stored), bytearray(visited)

    def frame(self) -> Iterable[Write]:
        """E of every node that was visited, or to which some has spread."""
        if self.spread is not None:
            return [Write(node, -1, value) for node, value in self.spread.items()]
        return [Write(node, -1, self.at(node)) for node in range(len(self.visited)) if self.visited[node]]

    def load(self, frame: Iterable[Write]) -> None:
        """Takes over values."""
        for node, _, value in frame:
            if self.spread is not None:
                self.spread.put(node, value)
            else:
                self.stored[node] = (value + self.shift) / self.scale
            self.visited[node] = 1

    def wipe(self, nodes: Iterable[int]) -> None:
        """Makes E 0 on some nodes."""
        found = each_node(nodes, len(self.visited))
        if self.spread is not None:
            self.spread.wipe(found)
        for node in found:
            self.stored[node], self.visited[node] = self.shift / self.scale, 0

    def settle(self) -> None:
        """See `Marks.settle`."""
        if self.spread is not None:
            self.spread.settle()
