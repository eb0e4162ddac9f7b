"""The box pheromone B: what it is worth to push a box into a hole (paper Section 3.3.2, Algorithm 3)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from colonysim.pheromones.field import Write
from colonysim.pheromones.marks import Marks

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.pheromones.field import Visit
    from colonysim.world.state import World

__all__ = ["BoxWorth"]


class BoxWorth(Marks):
    """B of each pair of box and hole: lowered when the box is claimed, raised when somebody crosses on it.

    Args:
        world: The world whose boxes are marked.
        start: B of a pair that was never touched; must exceed every D.
        decay: B_decay, the factor at a claim; crossing divides by it.
        cap: B never rises above this; infinity for no cap.
        credit: "leave": crossing counts when the agent leaves the hole's node towards another node than it came
            from. "enter": when it enters the hole's node.
        stack: Whether "all" boxes of a crossed stack are credited, or the "top" one only.
    """

    name = "B"
    by_box = True

    def __init__(
        self,
        world: World,
        *,
        start: float,
        decay: float = 0.95,
        cap: float = float("inf"),
        credit: Literal["enter", "leave"] = "leave",
        stack: Literal["all", "top"] = "all",
    ) -> None:
        self._world = world
        self._start = start
        self._decay = decay
        self._cap = cap
        self._on_entry = credit == "enter"
        self._whole_stack = stack == "all"
        self._worth: dict[tuple[int, int], float] = {}

    def at(self, node: int, key: int = -1) -> float:
        """B of the box `node` for the hole `key`."""
        return self._worth.get((node, key), self._start)

    def keys(self, node: int) -> Sequence[int]:
        """Every hole: an untouched pair has the value that B starts with."""
        return range(len(self._world.scenario.holes))

    def deposit(self, visit: Visit) -> Sequence[Write]:
        """Algorithm 3: a claim lowers B, a crossing raises B of every box in the stack that was crossed."""
        if visit.moment == "claim" and visit.hole < 0:  # taken to be passed, not to be pushed
            return ()
        if visit.moment == "claim":
            value = self._worth[visit.box, visit.hole] = self.at(visit.box, visit.hole) * self._decay
            return (Write(visit.box, visit.hole, value),)
        if visit.moment != "arrive":
            return ()
        crossed = visit.node if self._on_entry else visit.left
        if crossed < 0 or (not self._on_entry and visit.node == visit.before):
            return ()
        hole = self._world.hole_at[crossed]
        if hole < 0:
            return ()
        # A box that shares the crosser's node is being pushed over the hole, not crossed.
        pushed = self._world.agent_box[visit.agent]
        crossed_on = [box for box in self._world.stacks.get(crossed, ()) if box != pushed]
        writes = []
        for box in crossed_on if self._whole_stack else crossed_on[-1:]:
            value = self._worth[box, hole] = min(self.at(box, hole) / self._decay, self._cap)
            writes.append(Write(box, hole, value))
        return writes

    def end_episode(self) -> None:
        """B outlives the episode: the same boxes will stand in the same places."""

    def frame(self) -> Iterable[Write]:
        """B of every pair that was ever touched."""
        return [Write(box, hole, self._worth[box, hole]) for box, hole in sorted(self._worth)]

    def load(self, frame: Iterable[Write]) -> None:
        """Takes over the worth of pairs."""
        for box, hole, value in frame:
            self._worth[box, hole] = value
