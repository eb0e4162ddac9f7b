"""What to say of a place that has too little room: which nodes, how far apart they are, and how far they should be."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from colonysim.geometry.plan import SAME_LEVEL, edge_path, node_path
from colonysim.geometry.ramps import LEAST_HALF_WIDTH, PAST, ROOM
from colonysim.geometry.tiles import CELL_CENTRE
from colonysim.geometry.trouble import Trouble
from colonysim.physics.pits import closest

if TYPE_CHECKING:
    from collections.abc import Iterator

    from colonysim.geometry.plan import Plan, Point

__all__ = ["broken", "crowded_pits", "misplaced_pit", "narrow_margin", "small_step"]

Way = tuple[int, int]
"""An edge, or a node twice."""

_FURTHEST = 50.0
"""Holes that would have to be this many times as far apart lie on one place."""

LEAST_MARGIN = 0.45
"""Robots plan no way nearer than .4 m to the ground's border."""


def crowded_pits(plan: Plan) -> Trouble | None:
    """The first two holes that are too close to each other for their pits."""
    found = closest(plan.pits)
    if found is None:
        return None
    node_of = {n: node for node, n in plan.pit_at.items()}
    i, j = (node_of[n] for n in found)
    away, share = math.dist(plan.places[i], plan.places[j]), 1.0
    one, other = (plan.pits[n] for n in found)
    while share < _FURTHEST and closest([replace(pit, x=share * pit.x, y=share * pit.y) for pit in (one, other)]):
        share *= 1.001
    words = f"holes {plan.named(i)} and {plan.named(j)} are {{:.2f}} m apart, with pits {{:.2f}} m wide"
    return Trouble(f"holes.{found[1]}", words, away, one.side, away=away, needed=share * away)


def small_step(plan: Plan) -> Trouble | None:
    """The first edge that agents may travel although wheels do not climb it: a small step that is no slope."""
    scenario, level = plan.scenario, plan.level_of
    holes = {hole.node: hole for hole in scenario.holes}
    for i, others in enumerate(scenario.topology.neighbours):
        for j in others:
            if i > j or level[i] == level[j] or (i, j) in scenario.topology.rises:
                continue
            z = [holes[node].rim if node in holes else scenario.topology.z[node] for node in (i, j)]
            if abs(z[0] - z[1]) < scenario.reach:
                # A slope may not end at a hole.
                sloped = "" if {i, j} & set(holes) else f"list [{plan.named(i)}, {plan.named(j)}] under slopes, "
                return Trouble(
                    edge_path(scenario, i, j),
                    f"nodes {plan.named(i)} and {plan.named(j)} count as level (reach {scenario.reach:g}), and the step"
                    " between them is {:.2f} m high, expected less than {:g} m for wheels:"
                    f" {sloped}give both nodes one height, or lower reach",
                    abs(plan.heights[i] - plan.heights[j]),
                    SAME_LEVEL,
                )
    return None


def narrow_margin(plan: Plan) -> Trouble | None:
    """A margin on which a robot cannot turn."""
    if plan.margin >= LEAST_MARGIN:
        return None
    return Trouble(
        "physics.margin",
        "{:g} m of ground beyond the outermost nodes, expected at least {:g} m for a robot to turn there",
        plan.margin, LEAST_MARGIN,
    )  # fmt: skip


def broken(plan: Plan, where: tuple[int, ...]) -> Trouble:
    """What is in the way of a node or an edge for which no sound ground was found."""
    own = (where[0], where[-1])
    path = node_path(plan.scenario, where[0]) if len(where) == 1 else edge_path(plan.scenario, *where)
    if trouble := _too_near(plan, own, path):
        return trouble
    if trouble := _turning_off(plan, own, path):
        return trouble
    what, heights = _told(plan, own)
    return Trouble(path, f"{what} has a gap or a step beside it where robots need level ground", *heights)


def misplaced_pit(plan: Plan, n: int) -> Trouble:
    """What is in the way of a hole's pit, by the hole's position in the file."""
    node, path = next(node for node, index in plan.pit_at.items() if index == n), f"holes.{n}"
    words = f"the pit of hole {plan.named(node)}, {{:.2f}} m wide, has no level ground round it"
    return _too_near(plan, (node, node), path) or Trouble(path, words, plan.pits[n].side)


def _too_near(plan: Plan, own: Way, path: str) -> Trouble | None:
    """What lies on another level and furthest into the room that `own` needs; None if nothing does."""
    lacking, found = 0.0, None
    for other in _others(plan, own):
        needed, away = _half_width(plan, own) + _half_width(plan, other), _apart(plan, own, other)
        if needed - away > lacking:
            lacking = needed - away
            (one, low), (two, high) = _told(plan, own), _told(plan, other)
            words = f"{one} and {two} are {{:.2f}} m apart in the plane"
            found = Trouble(path, words, *low, *high, away, away=away, needed=needed)
    return found


def _turning_off(plan: Plan, own: Way, path: str) -> Trouble | None:
    """A slope past whose end an edge leads, and runs into the side of its ramp; None if there is none."""
    for slope in plan.slopes:
        shared = set(slope) & set(own)
        if len(shared) != 1 or own[0] == own[1]:
            continue
        (end,) = shared
        ahead, aside = (next(node for node in way if node != end) for way in (slope, own))
        (x, y), (x0, y0), (x1, y1) = (plan.places[node] for node in (end, ahead, aside))
        turn = abs(math.remainder(math.atan2(y1 - y, x1 - x) - math.atan2(y0 - y, x0 - x), 2.0 * math.pi))
        if turn < PAST:
            (edge, low), (ramp, high) = _told(plan, own), _told(plan, slope)
            return Trouble(
                path, f"{edge} turns off {ramp} by {math.degrees(turn):.0f} degrees at node {plan.named(end)}, too"
                " close to the side of its ramp: expected a wider turn or a longer slope", *low, *high,
            )  # fmt: skip
    return None


def _others(plan: Plan, own: Way) -> Iterator[Way]:
    """Edges and nodes that lie on other levels than a way, slopes, and, beside a slope, whatever it does not join."""
    level = plan.level_of
    levels, is_slope = {level[node] for node in own}, level[own[0]] != level[own[1]]
    for i, j in plan.lanes:
        if (is_slope or level[i] not in levels) and not {i, j} & set(own):
            yield i, j
    for node in range(len(level)):
        if (is_slope or level[node] not in levels) and node not in own:
            yield node, node
    for i, j in plan.slopes:
        if not {i, j} & set(own):
            yield i, j


def _half_width(plan: Plan, way: Way) -> float:
    """How much ground to each side a way needs, metres; of a hole, towards the corners of its pit's walls and frame."""
    if way[0] == way[1] and way[0] in plan.pit_at:
        return plan.pits[plan.pit_at[way[0]]].reach + CELL_CENTRE
    return ROOM if plan.level_of[way[0]] == plan.level_of[way[1]] else LEAST_HALF_WIDTH


def _told(plan: Plan, way: Way) -> tuple[str, list[float]]:
    """What a way is called, and the heights that stand in it, as a trouble's words and lengths."""
    i, j = way
    if i == j:
        return f"{'hole' if i in plan.pit_at else 'node'} {plan.named(i)} ({{:.2f}} m high)", [plan.heights[i]]
    if plan.level_of[i] == plan.level_of[j]:
        return f"edge {plan.named(i, j)} ({{:.2f}} m high)", [plan.heights[i]]
    return f"slope {plan.named(i, j)} ({{:.2f}} to {{:.2f}} m high)", [plan.heights[i], plan.heights[j]]


def _apart(plan: Plan, one: Way, other: Way) -> float:
    """Distance of two ways in the plane, metres."""
    a, b, c, d = (plan.places[node] for node in (*one, *other))
    if _side(a, b, c) * _side(a, b, d) < 0.0 and _side(c, d, a) * _side(c, d, b) < 0.0:
        return 0.0
    return min(_from(a, c, d), _from(b, c, d), _from(c, a, b), _from(d, a, b))


def _side(start: Point, end: Point, place: Point) -> float:
    return (end[0] - start[0]) * (place[1] - start[1]) - (end[1] - start[1]) * (place[0] - start[0])


def _from(place: Point, start: Point, end: Point) -> float:
    dx, dy = end[0] - start[0], end[1] - start[1]
    square = dx * dx + dy * dy
    share = 0.0 if square == 0.0 else ((place[0] - start[0]) * dx + (place[1] - start[1]) * dy) / square
    share = min(1.0, max(0.0, share))
    return math.dist(place, (start[0] + share * dx, start[1] + share * dy))
