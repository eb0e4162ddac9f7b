"""A colony goes on otherwise: with other random streams, other fields of its scenario, or another timeline."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError, ScenarioError
from colonysim.provenance import files_of
from colonysim.randomness import Streams
from colonysim.simulation.colony_state import memories_of, says_state
from colonysim.simulation.episode_state import episode_state, restore_episode
from colonysim.simulation.groups import decider_of
from colonysim.simulation.order import CHANGE_STEP, CHANGES
from colonysim.simulation.settings import changed

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.scenario.scenario import Scenario
    from colonysim.simulation.colony import Colony

__all__ = ["adopt", "diverge"]


def diverge(colony: Colony, seed: int | None, settings: Mapping[str, Any] | Sequence[str] | None) -> None:
    """Gives a colony other random streams from now on, or changes fields of its scenario.

    Args:
        colony: The colony, between two events.
        seed: What the streams are derived from; None for those that it has.
        settings: Fields of the scenario by dotted path, as for `load_scenario`; None for none.

    Raises:
        ColonysimError: A field cannot change under way.
    """
    now: dict[str, Any] = {}
    if settings:
        asked = colony._asked
        if not (asked is None or isinstance(asked, str) or callable(asked)):
            raise ColonysimError(
                "this policy was given as an object, whose parameters no field of the scenario can set"
            )
        scenario = changed(colony.scenario, settings)
        now = scenario.settings
        _refuse_past(colony, scenario, now)
        for path in now:  # what is set now holds from now on, whatever a timeline has set before
            section, _, name = path.partition(".")
            if section == "policy":
                colony._tuning.get("", {}).pop(name, None)
        adopt(colony, scenario, tuned=True)
    if seed is not None:
        colony._streams = Streams(seed, "fork/")
        if colony._running:
            own = colony._streams.within(f"episode/{colony._number}")
            colony._episode.reseed(own)
            colony._body.reseed(own)  # type: ignore[attr-defined]
    if seed is not None or settings:
        colony._course.note_change(colony, seed=seed, settings=now)


def _refuse_past(colony: Colony, scenario: Scenario, settings: Mapping[str, Any]) -> None:
    """Refuses settings that speak of what has happened already."""
    fixed = {name for n in range(len(colony._agents)) for name in getattr(decider_of(colony._policy, n), "fixed", ())}
    for path in settings:
        if path.removeprefix("policy.") in fixed:
            raise ScenarioError(f"--set {path}: cannot change under way, as marks are kept by it")
    if colony._running and scenario.time_limit is not None and scenario.time_limit <= colony.now:
        limit = f"--set time_limit={scenario.time_limit:g}"
        raise ScenarioError(f"{limit}: the episode under way is at {colony.now:g} s, expected more than that")


def adopt(colony: Colony, scenario: Scenario, due: float | None = None, *, tuned: bool = False) -> None:
    """Goes on with another scenario of the same place: policy and fields are made anew and take over the states.

    Args:
        colony: The colony, between two events.
        scenario: The scenario. Its timeline may have one change more at its end, and with that one box more.
        due: When that change comes in the episode under way, simulated seconds; None if it does not come in it.
        tuned: Whether policies have other parameters from now on, by which marks may fade otherwise.

    Raises:
        ColonysimError: The policy would have other fields.
    """
    world, number, before, policy = colony._world, colony._number, colony._episode, colony._policy
    for field in colony._fields.values() if tuned else ():
        field.refresh()
    fields, state = (
        {name: field.state() for name, field in colony._fields.items()},
        episode_state(before) if number else None,
    )
    memories = memories_of(colony)
    if state is not None and len(scenario.changes) > len(colony.scenario.changes):
        timeline, comes = state["timeline"], due is not None
        timeline["due"].append(due if comes else 0.0)
        timeline["orders"].append(CHANGES + CHANGE_STEP * scenario.changes[-1].number if comes else -1.0)
    colony.scenario = scenario
    world.adopt(scenario)
    colony._take_policies(colony._make_policies())
    colony._files = files_of(scenario.parameters, colony._origin.options, scenario.parts_of_groups)
    if other := fields.keys() ^ colony._fields.keys():
        raise ColonysimError(f"other pheromone fields cannot come or go under way: {', '.join(sorted(other))}")
    if "episodes" in scenario.overrides:
        colony._count = max(number, scenario.episodes)
    for name, field in colony._fields.items():
        field.restore(fields[name])
    if memories is not None:
        for agent, memory in enumerate(memories):
            now, then = decider_of(colony._policy, agent), decider_of(policy, agent)
            colony._memories[agent] = now.take_over(now.restore(agent, memory), then)
    colony._set_up()
    colony._episode.slice = before.slice
    own = colony._streams.within(f"episode/{number}")
    if colony._running and says_state(colony._body):  # which may have read the scenario when it was reset
        body: Any = colony._body
        moved = body.state()
        body.reset(world, own)
        body.restore(moved)
    if state is not None:
        restore_episode(
            colony._episode, state, number, colony._memories, own, synchronous=colony.mode == "synchronous",
            under_way=colony._running,
        )  # fmt: skip
    before.close()
