"""The exploration pheromone E: how often a node was visited of late (paper Section 3.3.4, Algorithm 7)."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

from colonysim.pheromones.field import Write
from colonysim.pheromones.marks import Marks

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.pheromones.field import Visit
    from colonysim.world.state import World

__all__ = ["Exploration"]

# Below this the lazily applied factor is folded into the stored values, long before it could underflow.
SMALLEST_SCALE = 1e-100


class Exploration(Marks):
    """E counts visits; an episode's end maps every value by E -> a E - b, applied when a value is read.

    Args:
        world: The world whose nodes are marked.
        evaporation: What remains of E after an episode, 0 to 1; None to subtract the smallest E instead, as
            Algorithm 7 prints it.
        on_wait: Whether an agent that waits deposits too.
        at_start: Whether an agent deposits before its first step too.

    Attributes:
        stored: For each node what E is made of: E = stored * scale - shift.
        visited: For each node 1 if somebody has left a mark that still counts, else 0.
        scale: What has evaporated since.
        shift: What has been subtracted since.
    """

    name = "E"

    def __init__(
        self, world: World, *, evaporation: float | None = 0.5, on_wait: bool = False, at_start: bool = True
    ) -> None:
        self._world = world
        self._keep = evaporation
        self._silent = {"claim"} | ({"wait"} if not on_wait else set()) | ({"start"} if not at_start else set())
        self.stored = array("d", bytes(8 * len(world.topology)))
        self.visited = bytearray(len(world.topology))
        self.scale = 1.0
        self.shift = 0.0

    def at(self, node: int, key: int = -1) -> float:
        """E of a node."""
        return self.stored[node] * self.scale - self.shift

    def keys(self, node: int) -> Sequence[int]:
        """None: one value a node."""
        return ()

    def deposit(self, visit: Visit) -> Sequence[Write]:
        """E grows by 1 at each visit."""
        if visit.moment in self._silent:
            return ()
        node, scale = visit.node, self.scale
        stored = self.stored[node] = self.stored[node] + 1.0 / scale
        self.visited[node] = 1
        return (Write(node, -1, stored * scale - self.shift),)

    def end_episode(self) -> None:
        """Evaporates all values or subtracts their minimum (which is 0 until every node was visited)."""
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

    def frame(self) -> Iterable[Write]:
        """E of every node that was visited."""
        return [Write(node, -1, self.at(node)) for node, visited in enumerate(self.visited) if visited]

    def load(self, frame: Iterable[Write]) -> None:
        """Takes over values."""
        for node, _, value in frame:
            self.stored[node] = (value + self.shift) / self.scale
            self.visited[node] = 1
