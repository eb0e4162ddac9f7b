"""What an agent sees as numbers, and what it can do from there: all that a `LocalView` tells, and nothing else."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from colonysim.world.intents import Push, Travel, Wait

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.policies.view import LocalView
    from colonysim.world.intents import Intent

__all__ = ["OUTCOMES", "PARTS", "Moves", "Own", "Sight"]

PARTS = ("self", "neighbours", "pheromones", "boxes", "holes")
"""The parts of an observation, in their order in the flat form."""
OUTCOMES = ("arrived", "blocked", "failed", "refused")
"""How an agent's last move came out; `refused`: the place was taken, and it did not begin."""
UNKNOWN = -1.0
"""Chance of a push that the agent is too far away to ask about."""


class Own(NamedTuple):
    """What an agent knows of itself beyond its view.

    Attributes:
        left: Steps that it may still begin, as a share of `max_steps`.
        outcome: How its last move came out, see `OUTCOMES`; "" before the first.
    """

    left: float
    outcome: str


class Moves:
    """The actions of a place: whole numbers from 0, in groups.

    First one for each neighbour: to travel there, or to take the box that stands there. Then one for each
    neighbour: to push the box at hand there. Then to wait for a change, and to wait for the time of one edge. With
    `by_action` each of the first two groups has for each neighbour one action without a hole, followed by one for each
    hole in sight: the box is meant for that one.

    Args:
        neighbours: Most neighbours of a node.
        holes: Most holes in sight that an action can name.
        by_action: Whether the action says which hole a box is meant for.

    Attributes:
        count: How many actions there are.
        wait: The action to wait for a change.
        pause: The action to wait for one edge's time.
    """

    def __init__(self, neighbours: int, holes: int, by_action: bool) -> None:
        self.neighbours, self.by_action = neighbours, by_action
        self.each = 1 + holes if by_action else 1
        self.wait = 2 * neighbours * self.each
        self.pause = self.wait + 1
        self.count = self.wait + 2


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
        mask: For each action 1 if the agent can do that now, else 0.
    """

    def __init__(self, view: LocalView, moves: Moves, most_holes: int) -> None:
        self._view, self._moves = view, moves
        node = self.node = view.node
        self.neighbours = view.neighbours
        self.holes = view.holes()[:most_holes]
        self.free = [view.free(j) for j in self.neighbours]
        self.passable = [view.passable(j) for j in self.neighbours]
        self.tops = [view.top_box(j) for j in self.neighbours]
        self.graspable = [top >= 0 and view.graspable_from(node, top) for top in self.tops]
        top = view.top_box(node)
        self.box = top if top >= 0 and view.graspable_from(node, top) else -1
        self.pushable, self.chance = self._pushes()
        self.mask = self._mask()

    def _pushes(self) -> tuple[list[bool], float]:
        """For each neighbour whether the box at hand can be pushed there, and the best chance of all pushes."""
        view, box, node = self._view, self.box, self._view.node
        if box < 0:
            return [False] * len(self.neighbours), UNKNOWN
        slides = [view.can_slide(box, node, j) for j in self.neighbours]
        asked = [j for j, can in zip(self.neighbours, slides, strict=True) if can]
        chances = iter(view.feasible(box, asked) if asked else ())
        each = [next(chances) if can else 0.0 for can in slides]
        return [chance > 0.0 and free for chance, free in zip(each, self.free, strict=True)], max(each, default=0.0)

    # -- actions -------------------------------------------------------------------------------------------------------

    def _mask(self) -> list[int]:
        moves = self._moves
        found = [0] * moves.count
        found[moves.wait] = found[moves.pause] = 1
        each, pushes, named = moves.each, moves.neighbours * moves.each, len(self.holes) if moves.by_action else 0
        for k, free in enumerate(self.free):
            if free and (self.graspable[k] or self.passable[k]):
                found[k * each] = 1
                if self.graspable[k]:
                    found[k * each + 1 : k * each + 1 + named] = [1] * named
            if self.pushable[k]:
                at = pushes + k * each
                found[at : at + 1 + named] = [1] * (1 + named)
        return found

    def intent(self, action: int) -> Intent | None:
        """What an action would have the agent do, whether or not it can; None if there is no such neighbour or box."""
        view, moves = self._view, self._moves
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
        view = self._view
        if not self.holes:
            return -1
        x, y = view.position(view.box_node(box))
        worth = view.fields["B"].at if "B" in view.fields else None

        def rank(hole: int) -> tuple[float, float]:
            hole_x, hole_y = view.position(view.hole_node(hole))
            return (0.0 if worth is None else -worth(box, hole)), (hole_x - x) ** 2 + (hole_y - y) ** 2

        return min(self.holes, key=rank)

    # -- numbers -------------------------------------------------------------------------------------------------------

    def of_self(self, own: Own, found: list[float]) -> None:
        """Appends 10 numbers of the agent itself."""
        view = self._view
        x, y = view.position(view.node)
        goal_x, goal_y = view.goal_position
        outcome = "refused" if view.refused is not None else own.outcome
        found += (
            goal_x - x, goal_y - y, view.held_box >= 0, view.waited, view.failures, own.left,
            *[outcome == each for each in OUTCOMES],
        )  # fmt: skip

    def of_neighbours(self, found: list[float]) -> None:
        """Appends 11 numbers of each neighbour."""
        view = self._view
        x, y = view.position(view.node)
        below = {view.hole_node(hole): view.headroom(hole) for hole in self.holes}
        asked = view.requested()
        for k, (j, length) in enumerate(zip(self.neighbours, view.lengths, strict=True)):
            other_x, other_y = view.position(j)
            found += (
                1.0, other_x - x, other_y - y, length, self.passable[k], self.free[k], view.occupied(j),
                asked and view.wanted(j), self.tops[k] >= 0, self.graspable[k], below.get(j, 0.0),
            )  # fmt: skip

    def of_pheromones(self, names: Sequence[str], nodes: Sequence[int], found: list[float]) -> None:
        """Appends for each node the value of each field; of one that has a value for each hole the largest."""
        windows = [self._view.fields[name] for name in names]
        for j in nodes:
            for window in windows:
                keys = window.keys(j)
                found.append(max([window.at(j, key) for key in keys]) if keys else window.at(j))

    def of_boxes(self, most: int, most_holes: int, found: list[float]) -> None:
        """Appends of each box in sight, the nearest first, 5 numbers and its worth B for each hole in sight."""
        view = self._view
        boxes = view.boxes()
        if not boxes:
            return
        x, y = view.position(view.node)
        worth = view.fields["B"].at if "B" in view.fields else None
        near, none = [], [0.0] * (most_holes if worth is None else most_holes - len(self.holes))
        for box in boxes:
            at = view.box_node(box)
            box_x, box_y = view.position(at)
            near.append(((box_x - x) ** 2 + (box_y - y) ** 2, box, at, box_x - x, box_y - y))
        near.sort()
        for _, box, at, dx, dy in near[:most]:
            found += (1.0, dx, dy, view.box_height(box), self._chance(box, at))
            if worth is not None:
                found += [worth(box, hole) for hole in self.holes]
            found += none

    def _chance(self, box: int, at: int) -> float:
        """The best chance of a push of a box at hand or on a neighbouring node; -1 of any other."""
        if box == self.box:
            return self.chance
        if at not in self.neighbours or not self.graspable[self.neighbours.index(at)]:
            return UNKNOWN
        targets = self._view.pushes(box)
        return max(self._view.feasible(box, targets), default=0.0) if targets else 0.0

    def of_holes(self, found: list[float]) -> None:
        """Appends 4 numbers of each hole in sight, ascending."""
        if not self.holes:
            return
        view = self._view
        x, y = view.position(view.node)
        for hole in self.holes:
            hole_x, hole_y = view.position(view.hole_node(hole))
            found += (1.0, hole_x - x, hole_y - y, view.headroom(hole))
