"""Level grounds and the ramps between them, derived from the graph or given, and what to change where none fit."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from colonysim.geometry.plan import Plan, Trouble, edge_path, node_path, steps
from colonysim.geometry.ramps import steep
from colonysim.geometry.rectangles import rectangles
from colonysim.geometry.tiles import tiles
from colonysim.geometry.troubles import broken, crowded_pits, misplaced_pit, narrow_margin
from colonysim.geometry.ways import first_broken
from colonysim.physics import Ground, Pit, Ramp, Terrain

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.geometry.plan import Point
    from colonysim.scenario.scenario import Scenario

__all__ = ["check_given", "derived_terrain", "given_terrain"]

_STEPS = 20
"""An xy_scale is proposed in parts of 1 / 20."""
_LARGEST = 4.0
"""No xy_scale is proposed that is more than so many times the present one."""


def derived_terrain(plan: Plan) -> Terrain:
    """Ground, pits and ramps for any graph whose levels are apart by more than `reach` or joined by slopes.

    Raises:
        ScenarioError: Something has too little room.
    """
    if trouble := steps(plan) or narrow_margin(plan):
        raise plan.scenario.fault(trouble.path, trouble.message)
    found = _derived(plan)
    if isinstance(found, Terrain):
        return found
    scale, now = _scale_that_does(plan), f"it is {plan.scale:g}"
    if plan.scenario.physics.get("xy_scale") is None:
        now += " by default"
    if scale:
        advice = f"physics.xy_scale: {scale:g} would do ({now})"
    else:
        advice = f"no physics.xy_scale up to {_LARGEST * plan.scale:.2f} would do ({now}): move nodes apart, or give"
        advice += " physics.terrain"
    expected = ""
    if found.needed > 0.0:
        # Often less than what is surely enough will do.
        needed = min(found.needed, found.away * scale / plan.scale) if scale and found.away else found.needed
        expected = f", expected at least {needed:.2f} m"
    raise plan.scenario.fault(found.path, f"{found.message}{expected}; {advice}")


def _derived(plan: Plan) -> Terrain | Trouble:
    trouble = crowded_pits(plan) or steep(plan)
    if trouble:
        return trouble
    whole = rectangles(plan)
    if whole and _trouble_on(plan, whole) is None:
        return _with_pits(plan, whole)
    tiled = tiles(plan)
    return _trouble_on(plan, tiled) or _with_pits(plan, tiled)


def _trouble_on(plan: Plan, terrain: Terrain) -> Trouble | None:
    """What is wrong with ground that has no pits yet: one would have no ground round it, or robots would not."""
    for n, pit in enumerate(plan.pits):
        if not terrain.carries(pit):
            return misplaced_pit(plan, n)
    where = first_broken(plan.scenario, plan.places, plan.heights, terrain)
    return broken(plan, where) if where else None


def _with_pits(plan: Plan, terrain: Terrain) -> Terrain:
    return replace(terrain, pits=plan.pits)


def _scale_that_does(plan: Plan) -> float:
    """An xy_scale, in steps of .05, at which ground can be derived, found by trying; 0 if there is none."""

    def does(steps: int) -> bool:
        return isinstance(_derived(plan.at_scale(steps / _STEPS)), Terrain)

    low, most = int(plan.scale * _STEPS), int(_LARGEST * plan.scale * _STEPS) + 1
    high = low + 1
    while not does(high):
        if high >= most:
            return 0.0
        low, high = high, min(max(high + 1, int(1.2 * high)), most)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if does(middle) else (middle, high)
    return high / _STEPS


def given_terrain(scenario: Scenario, given: Mapping[str, Any], pits: Sequence[Pit]) -> Terrain:
    """The ground that stands in `physics.terrain`; its pits are the holes' own if it lists none.

    Raises:
        ScenarioError: A pit has no ground around it, or too little.
    """
    try:
        return Terrain(
            tuple(Ground(**ground) for ground in given["grounds"]),
            tuple(Pit(**pit) for pit in given["pits"]) if given.get("pits") else tuple(pits),
            tuple(Ramp(**ramp) for ramp in given.get("ramps") or ()),
        )
    except ValueError as error:
        raise scenario.fault("physics.terrain", str(error)) from None


def check_given(scenario: Scenario, places: Sequence[Point], heights: Sequence[float], terrain: Terrain) -> None:
    """Refuses given ground with a gap or a step where robots have to drive.

    Raises:
        ScenarioError: There is one at a node or between two.
    """
    where = first_broken(scenario, places, heights, terrain)
    if where is None:
        return
    ids = [scenario.topology.ids[node] for node in where]
    if len(where) == 1:
        (x, y), path = places[where[0]], node_path(scenario, where[0])
        what = f"at node {ids[0]} ({x:.2f}, {y:.2f} m) the ground ends or has a step within .4 m"
    else:
        path = edge_path(scenario, *where)
        what = f"the ground between {ids[0]} and {ids[1]} has a gap or a step"
    raise scenario.fault(path, f"{what}; change physics.terrain")
