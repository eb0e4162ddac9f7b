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

PAIRS = 1 << 31
"""No hole has a key like this: box and hole make one number."""


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
        self._holes = len(world.scenario.holes)
        self._worth: dict[int, float] = {}  # by box times PAIRS plus hole

    def at(self, node: int, key: int = -1) -> float:
        """B of the box `node` for the hole `key`."""
        known = self._worth.get(node * PAIRS + key) if self._worth else None
        return self._start if known is None else known

    def keys(self, node: int) -> Sequence[int]:
        """Every hole: an untouched pair has the value that B starts with."""
        return range(self._holes)

    def deposit(self, visit: Visit) -> Sequence[Write]:
        """Algorithm 3: a claim lowers B, a crossing raises B of every box in the stack that was crossed."""
        if visit.moment == "claim":
            # A box may be taken to be passed, not to be pushed.
            return () if visit.hole < 0 else (Write(visit.box, visit.hole, self.lower(visit.box, visit.hole)),)
        if visit.moment != "arrive":
            return ()
        hole = self.crossed(visit.node, visit.left, visit.before)
        if hole < 0:
            return ()
        return [Write(box, hole, self.at(box, hole)) for box in self.credit(hole, visit.agent)]

    def lower(self, box: int, hole: int) -> float:
        """Somebody claims the box for the hole; returns what B is then."""
        value = self._worth[box * PAIRS + hole] = self.at(box, hole) * self._decay
        return value

    def crossed(self, node: int, left: int, before: int) -> int:
        """The hole that counts as crossed by who arrives on a node, or -1; see `Visit`."""
        crossed = node if self._on_entry else left
        if crossed < 0 or (not self._on_entry and node == before):
            return -1
        return self._world.hole_at[crossed]

    def credit(self, hole: int, agent: int) -> list[int]:
        """Raises B of the boxes in a hole that an agent has crossed; returns them, from bottom to top."""
        # A box that shares the crosser's node is being pushed over the hole, not crossed.
        pushed, stack = self._world.agent_box[agent], self._world.stacks.get(self._world.hole_node(hole), ())
        crossed_on = [box for box in stack if box != pushed]
        if not self._whole_stack:
            crossed_on = crossed_on[-1:]
        for box in crossed_on:
            value = self.at(box, hole) / self._decay
            self._worth[box * PAIRS + hole] = value if value < self._cap else self._cap
        return crossed_on

    def end_episode(self) -> None:
        """B outlives the episode: the same boxes will stand in the same places."""

    def frame(self) -> Iterable[Write]:
        """B of every pair that was ever touched."""
        pairs = [(*divmod(pair + 1, PAIRS), pair) for pair in sorted(self._worth)]
        return [Write(box, key - 1, self._worth[pair]) for box, key, pair in pairs]

    def load(self, frame: Iterable[Write]) -> None:
        """Takes over the worth of pairs."""
        for box, hole, value in frame:
            self._worth[box * PAIRS + hole] = value
