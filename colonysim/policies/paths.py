"""Ways within what an agent sees: to the nearest box, and for a box to a hole, the shortest or a likely one."""

from __future__ import annotations

import heapq
import itertools
import math
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from colonysim.policies.view import LocalView

__all__ = ["Way", "likely_way", "nearest_box", "way_to_hole"]

Way: TypeAlias = tuple[int, ...]
"""The nodes to push a box over, its own first; empty for no way."""


def nearest_box(view: LocalView, shunned: Collection[int] = (), barred: int = -1) -> tuple[int, int] | None:
    """The closest box by path that the agent could hold (paper Algorithm 4).

    Args:
        view: What the agent sees.
        shunned: Boxes to leave out.
        barred: A node that no way may lead over (the goal: who comes there leaves), or -1.

    Returns:
        The box and the first node on the way to it (the box's own node if it is adjacent or underfoot), or None.
    """
    at: dict[int, int] = {}
    for box in view.boxes():
        if box not in shunned and view.on_top(box):
            at[view.box_node(box)] = box
    if not at:
        return None
    beside: dict[int, list[tuple[int, float]]] = {}
    for j in at:
        for node, length in view.ways(j):
            beside.setdefault(node, []).append((j, length))
    start = view.node
    queue: list[tuple[float, int, int, int]] = [(0.0, start, -1, -1)]
    done: set[int] = set()
    while queue:
        far, node, first, box = heapq.heappop(queue)
        if box >= 0:
            return box, first
        if node in done:
            continue
        done.add(node)
        if node == start and start in at and view.graspable_from(start, at[start]):
            return at[start], start
        for j, length in beside.get(node, ()):
            if view.graspable_from(node, at[j]):
                heapq.heappush(queue, (far + length, j, j if node == start else first, at[j]))
        for j, length in view.open_ways(node):
            if j not in done and j != barred:
                heapq.heappush(queue, (far + length, j, j if node == start else first, -1))
    return None


def way_to_hole(
    view: LocalView, box: int, hole: int, barred: int = -1, avoided: Collection[tuple[int, int]] = ()
) -> Way:
    """The shortest way over which a visible box could be pushed into a visible hole.

    Args:
        view: What the agent sees.
        box: The box.
        hole: The hole's key.
        barred: A node that the way may not lead over (the goal: the pusher would leave there), or -1.
        avoided: Pushes (from, to) that the way shall do without.

    Returns:
        The nodes from the box's to the hole's; none if there is no way within sight, or the box is there.
    """
    start, end = view.box_node(box), view.hole_node(hole)
    queue: list[tuple[float, int, Way]] = [(0.0, start, (start,))]
    done: set[int] = set()
    while queue:
        far, node, way = heapq.heappop(queue)
        if node == end:
            return way if node != start else ()
        if node in done:
            continue
        done.add(node)
        for j, length in view.ways(node):
            if j in done or j == barred or (node, j) in avoided or not view.can_slide(box, node, j):
                continue
            if j == end or view.can_follow(box, node, j):
                heapq.heappush(queue, (far + length, j, (*way, j)))
    return ()


def likely_way(
    view: LocalView, box: int, way: Way, planned: Way, least: float, hole: int = -1, barred: int = -1
) -> Way:
    """A way whose pushes will, together, succeed with at least a given chance; empty if there is none.

    A plan is kept while it is likely. Else it is the way given, or the next shortest once the least likely push of that
    is left out, and so on; but never straight back to where the box has just come from. Pushes out of sight are not
    asked about.

    Args:
        view: What the agent sees.
        box: The box.
        way: The way that would be taken otherwise.
        planned: The box's way as planned before, or empty.
        least: The chance asked for.
        hole: The hole (key) to which other ways may be looked for, or -1.
        barred: A node that other ways may not lead over, or -1.
    """
    at = way[0]
    avoided: set[tuple[int, int]] = set()
    if at in planned[1:-1]:
        i = planned.index(at)
        avoided.add((at, planned[i - 1]))
        rest = planned[i:]
        if _is_open(view, box, rest) and math.prod(_chances(view, box, rest)) >= least:
            return rest
    while way:
        chances = _chances(view, box, way)
        if math.prod(chances) >= least and way[:2] not in avoided:
            return way
        weakest = min(range(len(chances)), key=chances.__getitem__)
        avoided.add((way[weakest], way[weakest + 1]))
        way = way_to_hole(view, box, hole, barred, avoided) if hole >= 0 else ()
    return ()


def _chances(view: LocalView, box: int, way: Way) -> Sequence[float]:
    """The chance of each push of a way as far as the agent sees it."""
    return view.feasible_way(box, tuple(itertools.takewhile(view.sees, way)))


def _is_open(view: LocalView, box: int, way: Way) -> bool:
    """Whether the terrain lets a box follow a planned way as far as the agent sees it, and its pusher with it."""
    seen = tuple(itertools.takewhile(view.sees, way))
    last = len(way) - 2
    return len(seen) > 1 and all(
        view.can_slide(box, i, j) and (k == last or view.can_follow(box, i, j))
        for k, (i, j) in enumerate(itertools.pairwise(seen))
    )
