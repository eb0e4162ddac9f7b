# cython: auto_pickle=False
"""What an agent sees as numbers, and what it can do from there: all that a `LocalView` tells, and nothing else."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.rl.moves import OUTCOMES
from colonysim.world.intents import Push, Travel, Wait

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from colonysim.policies.view import FieldWindow, LocalView
    from colonysim.rl.moves import Moves
    from colonysim.world.intents import Intent

__all__ = ["BOX", "HOLE", "NEIGHBOUR", "SELF", "Sight"]

SELF, NEIGHBOUR, BOX, HOLE = 10, 11, 5, 4
"""So many numbers are told of the agent itself, of each neighbour, of each box before its worth, and of each hole."""
UNKNOWN = -1.0
"""Chance of a push that the agent is too far away to ask about."""


class Sight:
    """What the agent that is asked sees, and what it can do.

    Args:
        view: The agent's view.
        moves: The actions.
        most_holes: Of the holes in sight, so many are told of.

    Attributes:
        node: Where the agent stands.
        neighbours: The nodes next to that.
        holes: The holes in sight that are told of.
        box: The box at hand, which the agent could push, or -1.
        mask: For each action a byte: 1 if the agent can do that now, else 0.
    """

    def __init__(self, view: LocalView, moves: Moves, most_holes: int) -> None:
        self._view, self._moves = view, moves
        node = self.node = view.node
        self.neighbours, holes = view.neighbours, view.holes()
        self.holes = holes if len(holes) <= most_holes else holes[:most_holes]
        self.free, self.passable, self.tops, self.graspable = [], [], [], []
        for j in self.neighbours:
            top = view.top_box(j)
            self.free.append(view.free(j))
            self.passable.append(view.passable(j))
            self.tops.append(top)
            self.graspable.append(top >= 0 and view.graspable_from(node, top))
        top = view.top_box(node)
        self.box = top if top >= 0 and view.graspable_from(node, top) else -1
        self.chance = UNKNOWN
        self.pushable = [False] * len(self.neighbours)
        if self.box >= 0:
            self._look_at_pushes()
        self.mask = self._mask()

    def _look_at_pushes(self) -> None:
        """For each neighbour whether the box at hand can be pushed there, and the best chance of all pushes."""
        view, best = self._view, 0.0
        slides = [k for k, j in enumerate(self.neighbours) if view.can_slide(self.box, self.node, j)]
        if slides:
            chances = view.feasible(self.box, [self.neighbours[k] for k in slides])
            for k, chance in zip(slides, chances, strict=True):
                self.pushable[k] = chance > 0.0 and self.free[k]
                best = max(best, chance)
        self.chance = best

    # -- actions -------------------------------------------------------------------------------------------------------

    def _mask(self) -> bytearray:
        moves = self._moves
        each, pushes = moves.each, moves.neighbours * moves.each
        named = len(self.holes) if moves.by_action else 0
        found = bytearray(moves.moves)
        found[moves.wait] = found[moves.pause] = 1
        for k in range(len(self.neighbours)):
            if self.free[k] and (self.graspable[k] or self.passable[k]):
                for action in range(k * each, k * each + 1 + (named if self.graspable[k] else 0)):
                    found[action] = 1
            if self.pushable[k]:
                for action in range(pushes + k * each, pushes + k * each + 1 + named):
                    found[action] = 1
        return found + found if moves.marks else found

    def intent(self, action: int) -> Intent | None:
        """What an action would have the agent do, whether or not it can; None if there is no such neighbour or box."""
        view, moves = self._view, self._moves
        if moves.marks and action >= 0:
            action %= moves.moves
        if action == moves.wait:
            return Wait(view.around())
        if action == moves.pause:
            return Wait((), view.edge_seconds)
        group, which = divmod(action, moves.each)
        pushes, k = divmod(group, moves.neighbours)
        if not 0 <= action < moves.wait or k >= len(self.neighbours) or which > len(self.holes):
            return None
        node = self.neighbours[k]
        box = self.box if pushes else self.tops[k] if self.graspable[k] else -1
        if box < 0:
            return None if pushes or which else Travel(node)
        return Push(box, node, self.holes[which - 1] if which else -1 if moves.by_action else self.meant_for(box))

    def meant_for(self, box: int) -> int:
        """The hole in sight for which a box is worth most by B, of equal ones the nearest; -1 if none is in sight."""
        view, best, least, most = self._view, -1, 0.0, 0.0
        x, y = view.position(view.box_node(box))
        for hole in self.holes:
            hole_x, hole_y = view.position(view.hole_node(hole))
            away = (hole_x - x) ** 2 + (hole_y - y) ** 2
            worth = view.fields["B"].at(box, hole) if "B" in view.fields else 0.0
            if best < 0 or worth > most or (worth == most and away < least):
                best, least, most = hole, away, worth
        return best

    # -- numbers -------------------------------------------------------------------------------------------------------

    def write(
        self, parts: Sequence[tuple[str, int]], names: Sequence[str], boxes: int, holes: int, found: NDArray[np.float32]
    ) -> None:
        """Writes an observation.

        Args:
            parts: Its parts, and where in the array each begins.
            names: The fields whose values at nodes are told.
            boxes: Of the boxes in sight, so many are told of, the nearest first.
            holes: For so many holes there is room.
            found: The array, of zeros.
        """
        for part, at in parts:
            if part == "self":
                self._of_self(found, at)
            elif part == "neighbours":
                self._of_neighbours(found, at)
            elif part == "pheromones":
                windows = [self._view.fields[name] for name in names]
                self._of_pheromones(windows, self.neighbours, found, at)
                self._of_pheromones(windows, (self.node,), found, at + self._moves.neighbours * len(windows))
            elif part == "boxes":
                self._of_boxes(boxes, holes, found, at)
            else:
                self._of_holes(found, at)

    def _of_self(self, found: NDArray[np.float32], at: int) -> None:
        """Writes `SELF` numbers of the agent itself."""
        view = self._view
        x, y = view.position(self.node)
        goal_x, goal_y = view.goal_position
        found[at], found[at + 1], found[at + 2] = goal_x - x, goal_y - y, view.held_box >= 0
        found[at + 3], found[at + 4], found[at + 5] = view.waited, view.failures, view.steps_left
        outcome = "refused" if view.refused is not None else view.outcome
        if outcome:
            found[at + 6 + OUTCOMES.index(outcome)] = 1.0

    def _of_neighbours(self, found: NDArray[np.float32], at: int) -> None:
        """Writes `NEIGHBOUR` numbers of each neighbour."""
        view, asked = self._view, self._view.requested()
        lengths, here = view.lengths, view.position(self.node)
        x, y = here
        for k in range(len(self.neighbours)):
            j = self.neighbours[k]
            other_x, other_y = view.position(j)
            found[at], found[at + 1], found[at + 2], found[at + 3] = 1.0, other_x - x, other_y - y, lengths[k]
            found[at + 4], found[at + 5], found[at + 6] = self.passable[k], self.free[k], view.occupied(j)
            found[at + 7] = asked and view.wanted(j)
            found[at + 8], found[at + 9] = self.tops[k] >= 0, self.graspable[k]
            for hole in self.holes:
                if view.hole_node(hole) == j:
                    found[at + 10] = view.headroom(hole)
            at += NEIGHBOUR

    def _of_pheromones(
        self, windows: Sequence[FieldWindow], nodes: Sequence[int], found: NDArray[np.float32], at: int
    ) -> None:
        """Writes for each node the value of each field; of one that has a value for each hole the largest."""
        for j in nodes:
            for window in windows:
                keys = window.keys(j)
                found[at] = max([window.at(j, key) for key in keys]) if keys else window.at(j)
                at += 1

    def _of_boxes(self, most: int, most_holes: int, found: NDArray[np.float32], at: int) -> None:
        """Writes of each box in sight, the nearest first, `BOX` numbers and its worth B for each hole in sight."""
        view = self._view
        boxes = view.boxes()
        if not boxes:
            return
        worth = view.fields.get("B")
        x, y = view.position(self.node)
        near = []
        for box in boxes:
            node = view.box_node(box)
            box_x, box_y = view.position(node)
            near.append(((box_x - x) ** 2 + (box_y - y) ** 2, box, node, box_x - x, box_y - y))
        if len(near) > 1:
            near.sort()
        for _, box, node, dx, dy in near[:most]:
            found[at], found[at + 1], found[at + 2] = 1.0, dx, dy
            found[at + 3], found[at + 4] = view.box_height(box), self._chance(box, node)
            if worth is not None:
                for k in range(len(self.holes)):
                    found[at + BOX + k] = worth.at(box, self.holes[k])
            at += BOX + most_holes

    def _chance(self, box: int, at: int) -> float:
        """The best chance of a push of a box at hand or on a neighbouring node; -1 of any other."""
        if box == self.box:
            return self.chance
        if at not in self.neighbours or not self.graspable[self.neighbours.index(at)]:
            return UNKNOWN
        targets = self._view.pushes(box)
        return max(self._view.feasible(box, targets), default=0.0) if targets else 0.0

    def _of_holes(self, found: NDArray[np.float32], at: int) -> None:
        """Writes `HOLE` numbers of each hole in sight, ascending."""
        view = self._view
        if not self.holes:
            return
        x, y = view.position(self.node)
        for hole in self.holes:
            hole_x, hole_y = view.position(view.hole_node(hole))
            found[at], found[at + 1], found[at + 2] = 1.0, hole_x - x, hole_y - y
            found[at + 3] = view.headroom(hole)
            at += HOLE
