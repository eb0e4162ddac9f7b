"""What an environment can be asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypedDict

from colonysim.rl.moves import PARTS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path
    from typing import Any

    from colonysim.policies.policy import Policy
    from colonysim.rl.rewards import Reward
    from colonysim.scenario.scenario import Scenario

__all__ = ["DEFAULTS", "WORDS", "Options"]


class Options(TypedDict, total=False):
    """What an environment can be asked for; all of it has a default.

    Attributes:
        variant: One of the scenario file's variants.
        overrides: Fields of the scenario to set, as for `load_scenario`.
        backend: Name of the backend; "nodeworld" by default.
        backend_options: Its options.
        policy: The policy whose marks the agents leave and which `choice` asks; the scenario's own by default.
        mode: "asynchronous" or "synchronous"; the scenario's own by default.
        seed: Of the first episode, unless `reset` is given one; 0 by default.
        pheromones: "clear" (by default): each episode begins without marks, as a run of its own. "keep": marks last for
            as many episodes as the scenario has, which are one run; then the next run begins.
        reward: A name of `colonysim.rl.rewards.REWARDS`, or a function of a `Stretch`.
        parts: Which parts an observation has, of `colonysim.rl.moves.PARTS`; all by default.
        flat: Whether an observation is one array; the mask of actions is in `infos` anyway.
        boxes: Of the boxes in sight, so many are told of; 8 by default.
        holes: The same of holes.
        neighbours: None (by default): an observation has as many rows as a node of the place has neighbours at most,
            and none for boxes and holes that the place does not have. A number: so many rows of neighbours, and `boxes`
            and `holes` of the others, whatever the place is like, so that one network fits many places.
        deposits: Who says where marks are left: "rule" (the policy's rules), or "action": each action says whether the
            agent leaves a mark where its move ends or where it waits. There is one field then, S, see
            `colonysim.pheromones.Signal`.
        half_life: Simulated seconds in which marks of actions halve; None (by default) for never.
        hole: Which hole a box is meant for: "rule" (the one in sight for which B is largest), or "action".
        illegal: What an action does that the mask forbids: "wait" (for one edge's time; `infos` say "illegal"), or
            "raise".
        trace: A folder in which every run leaves an ordinary run directory, `run-000001` and so on.
    """

    variant: str | None
    overrides: Mapping[str, Any] | Sequence[str] | None
    backend: str
    backend_options: Mapping[str, Any] | None
    policy: str | Policy | Callable[[Scenario], Policy] | None
    mode: str | None
    seed: int
    pheromones: str
    reward: str | Reward
    parts: Sequence[str]
    flat: bool
    boxes: int
    holes: int
    neighbours: int | None
    deposits: str
    half_life: float | None
    hole: str
    illegal: str
    trace: str | Path | None


DEFAULTS = Options(
    variant=None, overrides=None, backend="nodeworld", backend_options=None, policy=None, mode=None, seed=0,
    pheromones="clear", reward="team_time", parts=PARTS, flat=False, boxes=8, holes=8, neighbours=None,
    deposits="rule", half_life=None, hole="rule", illegal="wait", trace=None,
)  # fmt: skip
WORDS = {
    "pheromones": ("clear", "keep"), "deposits": ("rule", "action"), "hole": ("rule", "action"),
    "illegal": ("wait", "raise"),
}  # fmt: skip
"""The words that some options take."""
