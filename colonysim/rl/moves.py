"""The actions of a place, and the words of observations."""

from __future__ import annotations

__all__ = ["OUTCOMES", "PARTS", "Moves"]

PARTS = ("self", "neighbours", "pheromones", "boxes", "holes")
"""The parts of an observation, in their order in the flat form."""
OUTCOMES = ("arrived", "blocked", "failed", "refused")
"""How an agent's last move came out; `refused`: the place was taken, and it did not begin."""


class Moves:
    """The actions of a place: whole numbers from 0, in groups.

    First one for each neighbour: to travel there, or to take the box that stands there. Then one for each
    neighbour: to push the box at hand there. Then to wait for a change, and to wait for the time of one edge. With
    `by_action` each of the first two groups has for each neighbour one action without a hole, followed by one for each
    hole in sight: the box is meant for that one.

    With `marks` all of these come twice: from `moves` on the same again, and the agent leaves a mark where the move
    ends, or where it waits.

    Args:
        neighbours: Most neighbours of a node.
        holes: Most holes in sight that an action can name.
        by_action: Whether the action says which hole a box is meant for.
        marks: Whether the action says if the agent leaves a mark.

    Attributes:
        neighbours: The same.
        by_action: The same.
        marks: The same.
        each: How many actions each neighbour has in a group.
        wait: The action to wait for a change.
        pause: The action to wait for one edge's time.
        moves: How many actions there are without the marks.
        count: How many actions there are.
    """

    def __init__(self, neighbours: int, holes: int, by_action: bool, marks: bool = False) -> None:
        self.neighbours, self.by_action, self.marks = neighbours, by_action, marks
        self.each = 1 + holes if by_action else 1
        self.wait = 2 * neighbours * self.each
        self.pause = self.wait + 1
        self.moves = self.wait + 2
        self.count = 2 * self.moves if marks else self.moves
