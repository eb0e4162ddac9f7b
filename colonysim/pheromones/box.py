# cython: initializedcheck=False
"""The box pheromone B: what it is worth to push a box into a hole (paper Section 3.3.2, Algorithm 3)."""

from __future__ import annotations

import copy
from array import array
from typing import TYPE_CHECKING, Any, Literal

from colonysim.pheromones.field import Write
from colonysim.pheromones.marks import Fading, Marks, each_node
from colonysim.states import LARGEST, Stored

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.pheromones.field import Visit
    from colonysim.states import State
    from colonysim.world.state import World

__all__ = ["BoxWorth"]

PAIRS = 1 << 31
"""Larger than any hole's key: a pair of box and hole is stored under the integer box * PAIRS + hole."""


class BoxWorth(Marks):
    """B of each pair of box and hole: lowered when the box is claimed, raised when an agent crosses the hole on it.

    Args:
        world: The world whose boxes are marked.
        start: B of a pair that was never touched; must exceed every D.
        decay: B_decay, the factor at a claim; crossing divides by it.
        cap: B never rises above this; infinity for no cap.
        credit: "leave": crossing counts when the agent leaves the hole's node towards another node than it came
            from. "enter": when it enters the hole's node.
        stack: Whether "all" boxes of a crossed stack are credited, or the "top" one only.
        half_life: Simulated seconds in which the difference of B from `start` halves, None for never.
    """

    name = "B"
    by_box = by_hole = True

    def __init__(
        self,
        world: World,
        *,
        start: float,
        decay: float = 0.95,
        cap: float = float("inf"),
        credit: Literal["enter", "leave"] = "leave",
        stack: Literal["all", "top"] = "all",
        half_life: float | None = None,
    ) -> None:
        super().__init__()
        self._world = world
        self._fading = Fading(world, half_life)
        self._start = start
        self._decay = decay
        self._cap = cap
        self._on_entry = credit == "enter"
        self._whole_stack = stack == "all"
        self._holes, self._hole_at = len(world.scenario.holes), world.hole_at
        self._worth: dict[int, float] = {}  # by box times PAIRS plus hole

    def __deepcopy__(self, memo: dict[int, Any]) -> BoxWorth:
        """The same values in a copy of the world; typed views of arrays cannot be copied as they are."""
        twin = BoxWorth(
            copy.deepcopy(self._world, memo),
            start=self._start,
            decay=self._decay,
            cap=self._cap,
            credit="enter" if self._on_entry else "leave",
            stack="all" if self._whole_stack else "top",
            half_life=self._fading.half_life,
        )
        twin._fading.restart(self._fading.since)
        twin._worth = dict(self._worth)
        return twin

    def at(self, node: int, key: int = -1) -> float:
        """B of the box `node` for the hole `key`."""
        known = self._worth.get(node * PAIRS + key) if self._worth else None
        if known is None:
            return self._start
        return self._start + (known - self._start) * self._fading.left() if self._fading.on else known

    def keys(self, node: int) -> Sequence[int]:
        """Every hole: an untouched pair has the value that B starts with."""
        return range(self._holes)

    def mark(self, visit: Visit) -> int:
        """Algorithm 3: a claim lowers B, a crossing raises B of every box in the stack that was crossed."""
        self._wrote = 0
        if self._holes == 0:
            return 0
        if visit.moment == "arrive":
            hole = self._crossed(visit.node, visit.left, visit.before)
            if hole >= 0:
                self._credit(hole, visit.agent)
        elif visit.moment == "claim" and visit.hole >= 0:  # a box may be taken to be passed, not to be pushed
            self._set(visit.box, visit.hole, self.at(visit.box, visit.hole) * self._decay)
        return self._wrote

    def _set(self, box: int, hole: int, value: float) -> None:
        """Stores B of a pair and adds it to what this `mark` has written."""
        known = value
        if self._fading.on:
            if self._fading.faint():
                self._fade(self._world.now)
            known = self._start + (value - self._start) / self._fading.left()
        self._worth[box * PAIRS + hole] = known
        self._note(box, hole, value)

    def _fade(self, second: float) -> None:
        """Takes what has faded into the values; what fades later counts from a second of the episode."""
        left, start = self._fading.left(), self._start
        self._worth = {pair: start + (known - start) * left for pair, known in self._worth.items()}
        self._fading.restart(second)

    def _crossed(self, node: int, left: int, before: int) -> int:
        """The hole that an agent counts as having crossed when it arrives on `node`, or -1; arguments as in `Visit`."""
        crossed = node if self._on_entry else left
        if crossed < 0 or (not self._on_entry and node == before):
            return -1
        return self._hole_at[crossed]

    def _credit(self, hole: int, agent: int) -> None:
        """Raises B of the boxes in a hole that an agent has crossed, from bottom to top."""
        # A box that shares the crosser's node is being pushed over the hole, not crossed.
        pushed, stack = self._world.agent_box[agent], self._world.stacks.get(self._world.hole_node[hole], ())
        crossed_on = [box for box in stack if box != pushed]
        if not self._whole_stack:
            crossed_on = crossed_on[-1:]
        for box in crossed_on:
            value = self.at(box, hole) / self._decay
            self._set(box, hole, value if value < self._cap else self._cap)

    def end_episode(self) -> None:
        """Changes nothing by itself: B outlives the episode, as the same boxes will stand in the same places."""
        if self._fading.on:
            self._fade(0.0)

    def refresh(self) -> None:
        """See `Marks.refresh`."""
        if self._fading.on:
            self._fade(self._world.now)
        self._fading.restart(self._world.now)

    def state(self) -> State:
        """B of every pair that was ever touched."""
        pairs = sorted(self._worth)
        return {
            "pairs": array("q", pairs), "worth": array("d", [self._worth[pair] for pair in pairs]),
            "since": self._fading.since,
        }  # fmt: skip

    def restore(self, state: State) -> None:
        """See `Marks.restore`."""
        told = Stored(state, "field B")
        boxes = len(self._world.box_node)
        pairs = told.column("pairs", "q", None, -1, boxes * PAIRS)
        worth = told.column("worth", "d", len(pairs), -LARGEST, LARGEST)
        for pair in pairs:
            box, hole = divmod(pair + 1, PAIRS)
            if not (box < boxes and hole <= self._holes):
                raise told.fault("pairs", pair, "pairs of a box and a hole that exist")
        self._fading.restore(told)
        self._worth = dict(zip(pairs, worth, strict=True))

    def frame(self) -> Iterable[Write]:
        """B of every pair that was ever touched."""
        pairs = [divmod(pair + 1, PAIRS) for pair in sorted(self._worth)]
        return [Write(box, key - 1, self.at(box, key - 1)) for box, key in pairs]

    def load(self, frame: Iterable[Write]) -> None:
        """Takes over B of pairs."""
        for box, hole, value in frame:
            self._worth[box * PAIRS + hole] = value

    def wipe(self, nodes: Iterable[int]) -> None:
        """Makes B of the boxes that stand on some nodes, for every hole, what it starts with."""
        places = set(each_node(nodes, len(self._world.topology)))
        boxes = {box for box, node in enumerate(self._world.box_node) if node in places}
        self._worth = {pair: known for pair, known in self._worth.items() if (pair + 1) // PAIRS not in boxes}
