"""Level grounds and the ramps between them, derived from the graph or given, and what to change where none fit."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from colonysim.geometry.fit import narrow_nodes
from colonysim.geometry.ground_troubles import broken, crowded_pits, misplaced_pit, narrow_margin, small_step
from colonysim.geometry.plan import Plan, edge_path, node_path
from colonysim.geometry.ramps import steep
from colonysim.geometry.rectangles import rectangles
from colonysim.geometry.tiles import tiles
from colonysim.geometry.trouble import Trouble
from colonysim.geometry.ways import first_broken
from colonysim.physics import Ground, Pit, Ramp, Terrain
from colonysim.physics.terrain import TerrainError
from colonysim.push.footing import BORDER_CLEARANCE

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

__all__ = ["check_given", "derived_terrain", "given_terrain"]

_STEPS = 20
"""An xy_scale is proposed in parts of 1 / 20 m."""
_LARGEST = 4.0
"""No xy_scale is proposed that is more than so many times the present one."""


def derived_terrain(plan: Plan, unit: float) -> Terrain:
    """Ground, pits and ramps for any graph whose levels are apart by more than `reach` or joined by slopes.

    Args:
        plan: The graph.
        unit: Metres in a unit of the robot.

    Raises:
        Trouble: Something has too little room.
    """
    if trouble := small_step(plan) or narrow_margin(plan):
        raise trouble
    found = _derived(plan)
    if isinstance(found, Terrain):
        return found
    scale, now = _scale_that_does(plan, unit), "it is {:g}"
    if plan.scenario.physics.get("xy_scale") is None:
        now += " by default"
    lengths = [*found.lengths]
    expected = ""
    if found.needed > 0.0:
        # Often less than what is surely enough will do.
        lengths.append(min(found.needed, found.away * scale / plan.scale) if scale and found.away else found.needed)
        expected = ", expected at least {:.2f} m"
    if scale:
        advice = f"physics.xy_scale: {{:g}} would do ({now})"
        lengths += scale, plan.scale
    else:
        advice = f"no physics.xy_scale up to {{:.3g}} would do ({now}): move nodes apart, or give physics.terrain"
        lengths += _LARGEST * plan.scale, plan.scale
    raise Trouble(found.path, f"{found.words}{expected}; {advice}", *lengths)


def _derived(plan: Plan) -> Terrain | Trouble:
    trouble = crowded_pits(plan) or steep(plan) or narrow_nodes(plan)
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


def _scale_that_does(plan: Plan, unit: float) -> float:
    """An xy_scale, in steps of .05 m, at which ground can be derived, found by trying; 0 if there is none."""

    def does(steps: int) -> bool:
        return isinstance(_derived(plan.at_scale(steps / _STEPS / unit)), Terrain)

    low, most = int(unit * plan.scale * _STEPS), int(_LARGEST * unit * plan.scale * _STEPS) + 1
    high = low + 1
    while not does(high):
        if high >= most:
            return 0.0
        low, high = high, min(max(high + 1, int(1.2 * high)), most)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if does(middle) else (middle, high)
    return high / _STEPS / unit


def given_terrain(given: Mapping[str, Any], pits: Sequence[Pit]) -> Terrain:
    """The ground that stands in `physics.terrain`; its pits are the holes' own if it lists none.

    Raises:
        Trouble: A pit has no ground around it, or too little.
    """
    grounds = tuple(Ground(**ground) for ground in given["grounds"])
    cut = tuple(Pit(**pit) for pit in given["pits"]) if given.get("pits") else tuple(pits)
    ramps = tuple(Ramp(**ramp) for ramp in given.get("ramps") or ())
    try:
        return Terrain(grounds, cut, ramps)
    except TerrainError as error:
        raise Trouble("physics.terrain", error.words, *error.lengths) from None


def check_given(plan: Plan, terrain: Terrain) -> None:
    """Refuses given ground with a gap or a step where robots have to drive, and nodes that have too little room on it.

    Raises:
        Trouble: There is one at a node or between two.
    """
    scenario = plan.scenario
    where = first_broken(scenario, plan.places, plan.heights, terrain)
    if where is None:
        if found := narrow_nodes(plan):
            words = f"{found.words}, expected at least {{:.2f}} m; see physics.xy_scale"
            raise Trouble(found.path, words, *found.lengths, found.needed)
        return
    ids = [scenario.topology.ids[node] for node in where]
    if len(where) == 1:
        raise Trouble(
            node_path(scenario, where[0]), f"at node {ids[0]} ({{:.2f}}, {{:.2f}} m) the ground ends or has a step"
            " within {:g} m; change physics.terrain", *plan.places[where[0]], BORDER_CLEARANCE,
        )  # fmt: skip
    what = f"the ground between {ids[0]} and {ids[1]} has a gap or a step"
    raise Trouble(edge_path(scenario, *where), f"{what}; change physics.terrain")
