"""Whether a goal could be reached at all: a necessary condition that finds a forgotten edge, slope or box."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.world.topology import Topology

__all__ = ["CutOff", "cut_off"]

_MAX_SUMS = 128
_MAX_WORK = 2_000_000
_TOLERANCE = 1e-9


class CutOff(NamedTuple):
    """An agent that cannot reach the goal.

    Attributes:
        agent: Its place among the agents.
        stands: The nodes it could ever stand on.
        edge: The edge (from, to) out of those nodes with the smallest step, or None if no edge leads out.
        step: How much `to` lies above `from` there, both without boxes, graph units.
    """

    agent: int
    stands: frozenset[int]
    edge: tuple[int, int] | None
    step: float


def cut_off(
    topology: Topology, heights: Sequence[float], reach: float, goal: int, agents: Sequence[int]
) -> CutOff | None:
    """Finds the first agent that no placement of the boxes would let reach the goal.

    Every node may carry any choice of the boxes, each node regardless of the others, so that a place
    that can be solved is never refused; not every place that passes can be solved.

    Args:
        topology: The place.
        heights: Height of each box, graph units.
        reach: Surfaces that differ by less are level, graph units.
        goal: The goal's index.
        agents: Start node of each agent, index.
    """
    # Most places have a way that needs no box, and then the flood over bare ground settles it: it is linear.
    reached = _flood(topology, goal, (0.0,), reach)
    if all(agent in reached for agent in agents):
        return None
    piles = _sums(heights, len(topology))
    reached = _flood(topology, goal, piles, reach)
    for number, agent in enumerate(agents):
        if agent not in reached:
            return _explain(topology, number, _flood(topology, agent, piles, reach, bare_start=True))
    return None


def _sums(heights: Sequence[float], nodes: int) -> tuple[float, ...] | None:
    """All heights that piles of some of the boxes can have; None if they are too many to tell apart."""
    sums = {0.0}
    for height in heights:
        sums |= {round(total + height, 9) for total in sums}
        if len(sums) > _MAX_SUMS or len(sums) ** 2 * nodes > max(_MAX_WORK, 16 * nodes):
            return None
    return tuple(sorted(sums))


def _flood(
    topology: Topology, start: int, piles: Sequence[float] | None, reach: float, *, bare_start: bool = False
) -> set[int]:
    """Nodes joined with `start` by level steps, where a standing place is a node and the pile on it.

    The goal may carry any pile; an agent starts on bare ground (`bare_start`). From the goal only nodes
    that are reached bare count, for that is how agents start; steps can be taken both ways.
    """
    if piles is None:
        return _component(topology, start)
    z, rises, limit = topology.z, topology.rises, reach + _TOLERANCE
    seen = {(start, k) for k in range(1 if bare_start else len(piles))}
    waiting = list(seen)
    while waiting:
        i, k = waiting.pop()
        height = z[i] + piles[k]
        for j in topology.neighbours[i]:
            step = z[j] - height - (rises.get((i, j), 0.0) if rises else 0.0)
            for m, pile in enumerate(piles):
                if abs(step + pile) < limit and (j, m) not in seen:
                    seen.add((j, m))
                    waiting.append((j, m))
    return {i for i, k in seen if k == 0 or bare_start}


def _component(topology: Topology, start: int) -> set[int]:
    """All nodes joined with `start` by edges, whatever their heights."""
    seen = {start}
    waiting = [start]
    while waiting:
        for j in topology.neighbours[waiting.pop()]:
            if j not in seen:
                seen.add(j)
                waiting.append(j)
    return seen


def _explain(topology: Topology, agent: int, stands: set[int]) -> CutOff:
    """Names the edge that comes nearest to leading out."""
    borders = [
        (abs(step), i, j, step)
        for i in sorted(stands)
        for j in topology.neighbours[i]
        if j not in stands
        for step in (topology.z[j] - topology.z[i] - topology.rises.get((i, j), 0.0),)
    ]
    if not borders:
        return CutOff(agent, frozenset(stands), None, 0.0)
    _, i, j, step = min(borders)
    return CutOff(agent, frozenset(stands), (i, j), step)
