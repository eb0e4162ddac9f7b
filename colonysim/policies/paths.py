"""The way of a box to a hole, and how likely its pushes are to succeed."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.policies.view import LocalView

__all__ = ["Way", "likely_way"]

Way: TypeAlias = tuple[int, ...]
"""The nodes to push a box over, its own first; empty for no way."""


def likely_way(
    view: LocalView, box: int, way: Way, planned: Way, least: float, hole: int = -1, barred: int = -1
) -> Way:
    """A way of a box all of whose pushes succeed with at least a given chance; empty if there is none.

    The planned way is kept as long as it is likely enough. Else the way given is tried, then the shortest one without
    the least likely push of that, and so on; but none that begins with the push back to where the box has just come
    from. The backend is asked about visible nodes only.

    Args:
        view: What the agent sees.
        box: The box.
        way: The way to try first.
        planned: The box's way as planned before, or empty.
        least: The least chance of the whole way, 0 to 1.
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
        way = view.way_to_hole(box, hole, barred, avoided) if hole >= 0 else ()
    return ()


def _chances(view: LocalView, box: int, way: Way) -> Sequence[float]:
    """The chance, 0 to 1, of each push of a way between visible nodes."""
    return view.feasible_way(box, tuple(itertools.takewhile(view.sees, way)))


def _is_open(view: LocalView, box: int, way: Way) -> bool:
    """Whether the terrain allows all pushes of a way that are visible, and the pusher to stay level but at the last."""
    seen = tuple(itertools.takewhile(view.sees, way))
    last = len(way) - 2
    return len(seen) > 1 and all(
        view.can_slide(box, i, j) and (k == last or view.can_follow(box, i, j))
        for k, (i, j) in enumerate(itertools.pairwise(seen))
    )
