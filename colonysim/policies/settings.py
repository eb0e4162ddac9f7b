"""The parameters of the stigmergic policy and its two presets; each row of docs/readings.md is one of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import ConfigDict, Field, Strict, ValidationError
from pydantic.dataclasses import dataclass

from colonysim.characters import printable
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from colonysim.scenario.scenario import Scenario

__all__ = ["OF_FIELDS", "PRESETS", "StigmergySettings", "settings_for"]

LARGEST = 1e9
"""No parameter is larger, so that no product of a few of them and of lengths is infinite."""
Flag = Annotated[bool, Strict()]
Share = Annotated[float, Strict(), Field(ge=0.0, le=1.0)]
Weight = Annotated[float, Strict(), Field(ge=-LARGEST, le=LARGEST, allow_inf_nan=False)]
HalfLife = Annotated[float, Strict(), Field(ge=1e-6, le=LARGEST, allow_inf_nan=False)]
Positive = Annotated[float, Strict(), Field(gt=0.0, le=LARGEST, allow_inf_nan=False)]


@dataclass(frozen=True, slots=True, config=ConfigDict(extra="forbid"))
class StigmergySettings:
    """Parameters of the stigmergic policy; the defaults are the preset `colony`.

    Attributes:
        beta: Factor of the values in every softmax: at 0 all choices are equally likely, the higher the more decided.
        epsilon: Chance to explore, at the start of a run.
        epsilon_floor: It never decays below this.
        epsilon_decay: Factor by which it decays.
        epsilon_per: When it decays: at each exploratory "choice" or once an "episode".
        d_max: What D falls from, d_max, in units of the farthest node's distance to the goal along edges.
        distance_rule: Whose distances D takes: all reachable neighbours' ("lrta"), or those of official ones, as
            Algorithm 2 is printed ("literal").
        unvisited: D of a node nobody has been to: d_max less the straight line to the goal ("straight"), or 0 ("zero").
        updates: Where D and H are updated: on the "occupied" node only, or "everywhere" at each step (the oracle).
        hole_rule: Which of its candidates H becomes: the largest ("max"), or, as Algorithm 5 is printed, the smallest
            ("min").
        hole_evaporation: Share of H that remains after an episode.
        hole_half_life: Simulated seconds in which H halves; null for never.
        hole_diffusion: Share of H, of each hole, that a node gives to its neighbours at each tick of
            `diffusion_period`; 0 for none.
        box_decay: Factor of B at each claim, B_decay; a crossing divides by it.
        box_start: B at first, in units of d_max.
        box_cap: Most that B can become, in units of d_max; null for no limit.
        box_half_life: Simulated seconds in which the difference of B from its start halves; null for never.
        box_credit: When a crossing raises B: as the agent steps onto the hole's node ("enter") or off it ("leave").
        distance_half_life: Simulated seconds in which the difference of D from that of an unvisited node halves; null
            for never.
        distance_diffusion: Share of the difference of D from that of an unvisited node that a node gives to its
            neighbours at each tick of `diffusion_period`; 0 for none.
        deposit_at_start: Whether D and E are deposited at an episode's start, before the first step, as H is.
        stack_credit: Whose B a crossing raises: that of "all" boxes in the hole, or of the "top" one.
        exploration_evaporation: Share of E that remains after an episode; null takes off the smallest E instead.
        exploration_half_life: Simulated seconds in which E halves; null for never.
        exploration_diffusion: Share of E that a node gives to its neighbours at each tick of `diffusion_period`; 0 for
            none.
        diffusion_period: Simulated seconds between two ticks at which marks spread along edges.
        exploration_on_wait: Whether waiting counts as a visit, that is, deposits E.
        overfill: Whether a box may be meant for a hole whose surface would then stand above the rim.
        candidates_centre: From where holes have to be within R: from the "box" or from the "agent".
        look_on: Whether the next nearest box is looked at where the nearest one can go to no hole, with an open
            one in sight.
        errands: Whether an agent on its way to a box remembers the hole it is for, and the box's way, out of sight.
        step_past: Whether an agent that is shut in, or that comes to no useful box otherwise, steps to the node of a
            box to leave it on another side.
        restless: Choices in sight of boxes but with none to go for, in edges' lengths and units of the farthest node's
            way to the goal, after which an agent tries whatever the place allows, for as many; three times as many
            with no open hole in sight; null for never.
        collision: What keeps agents apart: "reservation" of the nodes that a mover needs, or "two_node", Algorithm 8.
        patience: How long a carrier waits before it drops its box, in the time of a travelled edge; null for ever.
        tries: Pushes that fail in a row before a carrier gives up its box for now; null for never.
        ask_to_clear: Whether a waiting carrier asks for its next node to be cleared.
        feasibility: Least chance at which a push is tried.
        extra_fields: Further fields (entry points of `colonysim.fields` or "package.module:Name") to carry along.
        weights: Factors of extra fields, by their names: a field's value at a node, times its factor, is added to D or
            -E wherever an agent chooses among nodes. Below 0 it keeps agents off.
    """

    beta: Annotated[float, Strict(), Field(ge=0.0, le=LARGEST, allow_inf_nan=False)] = 4.0
    epsilon: Share = 0.2
    epsilon_floor: Share = 0.01
    epsilon_decay: Share = 0.8
    epsilon_per: Literal["choice", "episode"] = "episode"
    d_max: Annotated[float, Strict(), Field(ge=1.0, le=LARGEST, allow_inf_nan=False)] = 1.5
    distance_rule: Literal["lrta", "literal"] = "lrta"
    unvisited: Literal["straight", "zero"] = "straight"
    updates: Literal["occupied", "everywhere"] = "occupied"
    distance_half_life: HalfLife | None = None
    distance_diffusion: Share = 0.0
    deposit_at_start: Flag = False
    hole_rule: Literal["max", "min"] = "max"
    hole_evaporation: Share = 0.5
    hole_half_life: HalfLife | None = None
    hole_diffusion: Share = 0.0
    box_decay: Annotated[float, Strict(), Field(gt=0.0, le=1.0)] = 0.95
    box_start: Positive = 2.0
    box_cap: Positive | None = 4.0
    box_half_life: HalfLife | None = None
    box_credit: Literal["enter", "leave"] = "leave"
    stack_credit: Literal["all", "top"] = "all"
    exploration_evaporation: Share | None = 0.5
    exploration_half_life: HalfLife | None = None
    exploration_diffusion: Share = 0.0
    diffusion_period: Annotated[float, Strict(), Field(ge=0.01, le=LARGEST, allow_inf_nan=False)] = 1.0
    exploration_on_wait: Flag = False
    overfill: Flag = False
    candidates_centre: Literal["box", "agent"] = "box"
    look_on: Flag = True
    errands: Flag = True
    step_past: Flag = True
    restless: Positive | None = 3.0
    collision: Literal["reservation", "two_node"] = "reservation"
    patience: Annotated[float, Strict(), Field(ge=1e-3, le=LARGEST, allow_inf_nan=False)] | None = 5.0
    tries: Annotated[int, Strict(), Field(ge=1, le=10**9)] | None = 2
    ask_to_clear: Flag = True
    feasibility: Share = 0.5
    extra_fields: tuple[str, ...] = ()
    weights: Mapping[str, Weight] = dataclasses.field(default_factory=dict)


OF_FIELDS = (
    "d_max", "distance_rule", "unvisited", "updates", "distance_half_life", "distance_diffusion", "deposit_at_start",
    "hole_rule", "hole_evaporation", "hole_half_life", "hole_diffusion", "box_decay", "box_start", "box_cap",
    "box_half_life", "box_credit", "stack_credit", "exploration_evaporation", "exploration_half_life",
    "exploration_diffusion", "exploration_on_wait", "diffusion_period",
)  # fmt: skip
"""The parameters that belong to the fields, which all agents share; the others may differ from agent to agent."""

PRESETS: dict[str, dict[str, Any]] = {
    "colony": {},
    "paper": {
        "beta": 1.0,
        "epsilon_decay": 0.95,
        "epsilon_per": "choice",
        "distance_rule": "literal",
        "deposit_at_start": True,
        "hole_evaporation": 0.0,
        "box_cap": None,
        "box_credit": "enter",
        "exploration_evaporation": None,
        "exploration_on_wait": True,
        "overfill": True,
        "look_on": False,
        "errands": False,
        "step_past": False,
        "restless": None,
        "collision": "two_node",
        "patience": None,
        "tries": None,
        "ask_to_clear": False,
    },
    "oracle": {"updates": "everywhere"},
}


def settings_for(scenario: Scenario, preset: str = "colony", *, override: Flag = False) -> StigmergySettings:
    """The settings that a scenario asks for: its preset, changed by its own parameters.

    Args:
        scenario: Its `policy:` section holds the parameters.
        preset: The preset where the scenario names none.
        override: Whether `preset` holds even if the scenario names another.

    Raises:
        ScenarioError: A parameter is unknown or out of its range; the message says where and what was expected.
    """
    parameters: Mapping[str, Any] = scenario.parameters
    chosen = preset if override else parameters.get("preset", preset)
    if not isinstance(chosen, str) or chosen not in PRESETS:
        raise scenario.fault("policy.preset", f"no preset {printable(repr(chosen))}; {nearest(str(chosen), PRESETS)}")
    names = [field.name for field in dataclasses.fields(StigmergySettings)]
    values = dict(PRESETS[chosen])
    for name, value in parameters.items():
        if name == "preset":
            continue
        if name == "box_diffusion":
            message = "B belongs to boxes, which have no neighbours to give some of it to; box_half_life lets B fade"
            raise scenario.fault(f"policy.{name}", message)
        if name not in names:
            raise scenario.fault(f"policy.{name}", f"no such parameter; {nearest(name, [*names, 'preset'])}")
        values[name] = value
    try:
        return StigmergySettings(**values)
    except ValidationError as error:
        first = error.errors()[0]
        name = ".".join(part for part in first["loc"] if isinstance(part, str)) or "policy"
        raise scenario.fault(f"policy.{name}", f"{first['msg']}, not {printable(repr(first['input']))}") from None
