"""The exploration pheromone E: how often a node was visited of late (paper Section 3.3.4, Algorithm 7)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.pheromones.field import Write

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.pheromones.field import Visit
    from colonysim.world.state import World

__all__ = ["Exploration"]

# Below this the lazily applied factor is folded into the stored values, long before it could underflow.
SMALLEST_SCALE = 1e-100


class Exploration:
    """E counts visits; an episode's end maps every value by E -> a E - b, applied when a value is read.

    Args:
        world: The world whose nodes are marked.
        evaporation: What remains of E after an episode, 0 to 1; None to subtract the smallest E instead, as
            Algorithm 7 prints it.
        on_wait: Whether an agent that waits deposits too.
        at_start: Whether an agent deposits before its first step too.

    Attributes:
        stored: For each visited node what E is made of: E = stored * scale - shift.
        scale: What has evaporated since.
        shift: What has been subtracted since.
    """

    name = "E"
    by_box = False

    def __init__(
        self, world: World, *, evaporation: float | None = 0.5, on_wait: bool = False, at_start: bool = True
    ) -> None:
        self._world = world
        self._keep = evaporation
        self._silent = {"claim"} | ({"wait"} if not on_wait else set()) | ({"start"} if not at_start else set())
        self._size = len(world.topology)
        self.stored: dict[int, float] = {}
        self.scale = 1.0
        self.shift = 0.0

    def at(self, node: int, key: int = -1) -> float:
        """E of a node."""
        return self.stored.get(node, 0.0) * self.scale - self.shift

    def keys(self, node: int) -> Sequence[int]:
        """None: one value a node."""
        return ()

    def deposit(self, visit: Visit) -> Sequence[Write]:
        """E grows by 1 at each visit."""
        if visit.moment in self._silent:
            return ()
        node, scale = visit.node, self.scale
        stored = self.stored[node] = self.stored.get(node, 0.0) + 1.0 / scale
        return (Write(node, -1, stored * scale - self.shift),)

    def end_episode(self) -> None:
        """Evaporates all values or subtracts their minimum (which is 0 until every node was visited)."""
        if self._keep is None:
            if len(self.stored) == self._size:
                self.shift = min(self.stored.values()) * self.scale
        elif self._keep <= 0.0:
            self.stored.clear()
        else:
            self.scale *= self._keep
            if self.scale < SMALLEST_SCALE:
                self.stored = {node: value * self.scale for node, value in self.stored.items()}
                self.scale = 1.0

    def frame(self) -> Iterable[Write]:
        """E of every node that was visited."""
        return [Write(node, -1, self.at(node)) for node in sorted(self.stored)]

    def load(self, frame: Iterable[Write]) -> None:
        """Takes over values."""
        for node, _, value in frame:
            self.stored[node] = (value + self.shift) / self.scale
