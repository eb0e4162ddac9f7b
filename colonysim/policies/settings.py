"""The parameters of the stigmergic policy and its two presets; each row of docs/readings.md is one of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import ConfigDict, Field, Strict
from pydantic.dataclasses import dataclass

from colonysim.characters import printable
from colonysim.policies.parameters import Parameter, about, read_parameters
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from colonysim.scenario.scenario import Scenario

__all__ = ["OF_A_RUN", "OF_FIELDS", "PRESET", "PRESETS", "StigmergySettings", "settings_for"]

LARGEST = 1e9
"""No parameter is larger, so that no product of a few of them and of lengths is infinite."""
Flag = Annotated[bool, Strict()]
Share = Annotated[float, Strict(), Field(ge=0.0, le=1.0)]
NotNegative = Annotated[float, Strict(), Field(ge=0.0, le=LARGEST, allow_inf_nan=False)]
AtLeastOne = Annotated[float, Strict(), Field(ge=1.0, le=LARGEST, allow_inf_nan=False)]
Weight = Annotated[float, Strict(), Field(ge=-LARGEST, le=LARGEST, allow_inf_nan=False)]
HalfLife = Annotated[float, Strict(), Field(ge=1e-6, le=LARGEST, allow_inf_nan=False)]
Positive = Annotated[float, Strict(), Field(gt=0.0, le=LARGEST, allow_inf_nan=False)]


@dataclass(frozen=True, slots=True, config=ConfigDict(extra="forbid"))
class StigmergySettings:
    """Parameters of the stigmergic policy; the defaults are the preset `colony`.

    What each one means, and which algorithm of the paper has it, stands beside it: `colonysim policies` prints it, and
    docs/policies.md and the JSON Schema of scenario files are made from it.
    """

    beta: Annotated[NotNegative, about(
        "Factor of the values in every softmax: at 0 all choices are equally likely, the higher the more "
        "decided.", "Alg. 9",
    )] = 4.0
    epsilon: Annotated[Share, about(
        "Chance to explore, at the start of a run and from where a timeline sets it.", "Alg. 9"
    )] = 0.2
    epsilon_floor: Annotated[Share, about("Epsilon never decays below this.")] = 0.01
    epsilon_decay: Annotated[Share, about("Factor by which epsilon decays.", "Alg. 9")] = 0.8
    epsilon_per: Annotated[Literal["choice", "episode"], about(
        'When epsilon decays: at each exploratory "choice" or once an "episode".', "Alg. 9"
    )] = "episode"
    d_max: Annotated[AtLeastOne, about(
        "What D falls from, d_max, in units of the farthest node's distance to the goal along edges.", "Alg. 2"
    )] = 1.5
    distance_rule: Annotated[Literal["lrta", "literal"], about(
        "Whose distances D takes: all reachable neighbours' (\"lrta\"), or those of official ones, as Algorithm "
        '2 is printed ("literal").', "Alg. 2",
    )] = "lrta"
    unvisited: Annotated[Literal["straight", "zero"], about(
        'D of a node nobody has been to: d_max less the straight line to the goal ("straight"), or 0 '
        '("zero").', "Alg. 2",
    )] = "straight"
    updates: Annotated[Literal["occupied", "everywhere"], about(
        'Where D and H are updated: on the "occupied" node only, or "everywhere" at each step (the oracle).', "Alg. 9"
    )] = "occupied"
    distance_half_life: Annotated[HalfLife | None, about(
        "Simulated seconds in which the difference of D from that of an unvisited node halves; null for "
        "never.",
    )] = None
    distance_diffusion: Annotated[Share, about(
        "Share of the difference of D from that of an unvisited node that a node gives to its neighbours at "
        "each tick of `diffusion_period`; 0 for none.",
    )] = 0.0
    deposit_at_start: Annotated[Flag, about(
        "Whether D and E are deposited at an episode's start, before the first step, as H is.", "Alg. 9"
    )] = False
    hole_rule: Annotated[Literal["max", "min"], about(
        'Which of its candidates H becomes: the largest ("max"), or, as Algorithm 5 is printed, the smallest '
        '("min").', "Alg. 5",
    )] = "max"
    hole_evaporation: Annotated[Share, about("Share of H that remains after an episode.")] = 0.5
    hole_half_life: Annotated[HalfLife | None, about("Simulated seconds in which H halves; null for never.")] = None
    hole_diffusion: Annotated[Share, about(
        "Share of H, of each hole, that a node gives to its neighbours at each tick of `diffusion_period`; 0 "
        "for none.",
    )] = 0.0
    box_decay: Annotated[Annotated[float, Strict(), Field(gt=0.0, le=1.0)], about(
        "Factor of B at each claim, B_decay; a crossing divides by it.", "Alg. 3"
    )] = 0.95
    box_start: Annotated[Positive, about("B at first, in units of d_max.", "Alg. 3")] = 2.0
    box_cap: Annotated[Positive | None, about("Most that B can become, in units of d_max; null for no limit.")] = 4.0
    box_half_life: Annotated[HalfLife | None, about(
        "Simulated seconds in which the difference of B from its start halves; null for never."
    )] = None
    box_credit: Annotated[Literal["enter", "leave"], about(
        "When a crossing raises B: as the agent steps onto the hole's node (\"enter\") or off it (\"leave\").", "Alg. 3"
    )] = "leave"
    stack_credit: Annotated[Literal["all", "top"], about(
        'Whose B a crossing raises: that of "all" boxes in the hole, or of the "top" one.', "Alg. 3"
    )] = "all"
    exploration_evaporation: Annotated[Share | None, about(
        "Share of E that remains after an episode; null takes off the smallest E instead.", "Alg. 7"
    )] = 0.5
    exploration_half_life: Annotated[HalfLife | None, about(
        "Simulated seconds in which E halves; null for never."
    )] = None
    exploration_diffusion: Annotated[Share, about(
        "Share of E that a node gives to its neighbours at each tick of `diffusion_period`; 0 for none."
    )] = 0.0
    diffusion_period: Annotated[Annotated[float, Strict(), Field(ge=0.01, le=LARGEST, allow_inf_nan=False)], about(
        "Simulated seconds between two ticks at which marks spread along edges."
    )] = 1.0
    exploration_on_wait: Annotated[Flag, about(
        "Whether waiting counts as a visit, that is, deposits E.", "Alg. 7"
    )] = False
    overfill: Annotated[Flag, about(
        "Whether a box may be meant for a hole whose surface would then stand above the rim.", "Alg. 6"
    )] = False
    candidates_centre: Annotated[Literal["box", "agent"], about(
        'From where holes have to be within R: from the "box" or from the "agent".', "Alg. 6"
    )] = "box"
    look_on: Annotated[Flag, about(
        "Whether the next nearest box is looked at where the nearest one can go to no hole, with an open one "
        "in sight.", "Alg. 4",
    )] = True
    errands: Annotated[Flag, about(
        "Whether an agent on its way to a box remembers the hole it is for, and the box's way, out of sight."
    )] = True
    step_past: Annotated[Flag, about(
        "Whether an agent that is shut in, or that comes to no useful box otherwise, steps to the node of a "
        "box to leave it on another side.", "Alg. 4",
    )] = True
    restless: Annotated[Positive | None, about(
        "Choices in sight of boxes but with none to go for, in edges' lengths and units of the farthest "
        "node's way to the goal, after which an agent tries whatever the place allows, for as many; three "
        "times as many with no open hole in sight; null for never.",
    )] = 3.0
    collision: Annotated[Literal["reservation", "two_node"], about(
        'What keeps agents apart: "reservation" of the nodes that a mover needs, or "two_node", Algorithm 8.', "Alg. 8"
    )] = "reservation"
    patience: Annotated[Annotated[float, Strict(), Field(ge=1e-3, le=LARGEST, allow_inf_nan=False)] | None, about(
        "How long a carrier waits before it drops its box, in the time of a travelled edge; null for ever."
    )] = 5.0
    tries: Annotated[Annotated[int, Strict(), Field(ge=1, le=10**9)] | None, about(
        "Pushes that fail in a row before a carrier gives up its box for now; null for never."
    )] = 2
    ask_to_clear: Annotated[Flag, about("Whether a waiting carrier asks for its next node to be cleared.")] = True
    feasibility: Annotated[Share, about("Least chance at which a push is tried.", "Section 3.4.1")] = 0.5
    extra_fields: Annotated[tuple[str, ...], about(
        'Further fields (entry points of `colonysim.fields` or "package.module:Name") to carry along.'
    )] = ()
    weights: Annotated[Mapping[str, Weight], about(
        "Factors of extra fields, by their names: a field's value at a node, times its factor, is added to D "
        "or -E wherever an agent chooses among nodes. Below 0 it keeps agents off.",
    )] = dataclasses.field(default_factory=dict)


OF_FIELDS = (
    "d_max", "distance_rule", "unvisited", "updates", "distance_half_life", "distance_diffusion", "deposit_at_start",
    "hole_rule", "hole_evaporation", "hole_half_life", "hole_diffusion", "box_decay", "box_start", "box_cap",
    "box_half_life", "box_credit", "stack_credit", "exploration_evaporation", "exploration_half_life",
    "exploration_diffusion", "exploration_on_wait", "diffusion_period",
)  # fmt: skip
"""The parameters that belong to the fields, which all agents share; the others may differ from agent to agent."""

OF_A_RUN = ("distance_diffusion", "hole_diffusion", "exploration_diffusion", "diffusion_period")
"""The parameters that cannot change under way: how marks are kept depends on whether they spread, and how often."""

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
PRESET = Parameter(
    "preset", {"enum": [*PRESETS], "type": "string"}, "colony",
    meaning="The preset from which parameters come that are not given; the policies \"colony\", \"paper\" and"
    " \"oracle\" are each that preset whatever stands here.",
)  # fmt: skip
"""What stands beside the parameters in the section of the policy `stigmergy`."""


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
    if "box_diffusion" in parameters:
        message = "B belongs to boxes, which have no neighbours to give some of it to; box_half_life lets B fade"
        raise scenario.fault("policy.box_diffusion", message)
    return read_parameters(StigmergySettings, scenario, PRESETS[chosen], besides=("preset",))
