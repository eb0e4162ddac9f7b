"""Agents that differ: each group decides by its own policy, and reads the fields that it does not ignore."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError, PluginError
from colonysim.plugins import locate, make_policy
from colonysim.policies.decision import Decider
from colonysim.policies.settings import OF_FIELDS
from colonysim.policies.stigmergy import Stigmergy
from colonysim.scenario.groups import refuse_unknown_fields
from colonysim.simulation.foreign import checked_fields, checked_policy

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from colonysim.pheromones.field import Field
    from colonysim.pheromones.marks import Marks
    from colonysim.policies.decision import Decision, Stream
    from colonysim.policies.policy import Policy
    from colonysim.policies.view import LocalView
    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.rows import Rows
    from colonysim.world.state import World

__all__ = ["GroupPolicies", "Mixed", "decider_of", "located", "policy_of_group"]


class Mixed(Decider):
    """Decides by the policy of each agent's group.

    Args:
        name: Name of the scenario's own policy.
        deciders: The policy of each agent.
    """

    def __init__(self, name: str, deciders: Sequence[Decider]) -> None:
        self.name, self._deciders = name, list(deciders)

    def of(self, agent: int) -> Decider:
        """The policy of an agent."""
        return self._deciders[agent]

    def begin(self, agent: int, memory: Any) -> Any:
        """What its policy says."""
        return self._deciders[agent].begin(agent, memory)

    def think(self, view: LocalView, memory: Any, stream: Stream) -> Decision:
        """What its policy says."""
        return self._deciders[view.agent].think(view, memory, stream)

    def state(self, agent: int, memory: Any) -> Any:
        """What its policy says."""
        return self._deciders[agent].state(agent, memory)

    def restore(self, agent: int, state: Any) -> Any:
        """What its policy says."""
        return self._deciders[agent].restore(agent, state)


def decider_of(decider: Decider, agent: int) -> Decider:
    """The policy of an agent, of one that may be that of groups."""
    return decider.of(agent) if isinstance(decider, Mixed) else decider


def located(scenario: Scenario) -> str:
    """The "package.module:Name" of a scenario's policy; nothing is imported.

    Raises:
        PluginError: There is none of that name.
        ScenarioError: It is that of a group, see `Scenario.of_group`.
    """
    try:
        return locate("policies", scenario.policy)
    except PluginError as error:
        if scenario.policy_path == "policy":
            raise
        raise scenario.fault("policy.name", str(error)) from None


def policy_of_group(
    scenario: Scenario, number: int, main: Policy, given: str | Policy | Callable[[Scenario], Policy] | None = None
) -> Policy:
    """The policy of a group, made anew unless it is the one of all.

    Args:
        scenario: The scenario.
        number: Place of the group in `Scenario.groups`.
        main: The policy of all who have none of their own.
        given: What `main` was made from, where that is not what the scenario says.

    Raises:
        ScenarioError: A parameter does not fit, or is one of the fields', which belong to all.
        ColonysimError: The group's parameters are those of a policy that is made already.
    """
    group = scenario.groups[number]
    if group.policy is None and not group.parameters:
        return main
    own, what = scenario.of_group(number), group.policy or given
    if what is not None and not isinstance(what, str) and not callable(what):
        raise ColonysimError(
            f"group {group.name!r} has parameters of its own, which a policy that is made already cannot take;"
            " give its class or its name"
        )
    if group.policy is not None:
        located(own)
    made = make_policy(what, own)
    if isinstance(main, Stigmergy) and isinstance(made, Stigmergy):
        for name in OF_FIELDS:
            one, other = getattr(main.settings, name), getattr(made.settings, name)
            if one != other:
                place = f"policy.{name}" if name in group.parameters else "policy"
                raise own.fault(place, f"{name} is {other!r} here and {one!r} in the policy of all, but belongs to the"
                                " fields, which all agents share; expected the same")  # fmt: skip
    return made


class GroupPolicies:
    """The policies of a scenario's groups, and the fields that its agents share.

    Args:
        given: Name of the policy of all who have none of their own, a factory, or a policy; the scenario's if None.
        scenario: The scenario.
        world: The world.
        rows: The trace.

    Attributes:
        decider: What decides for each agent.
        fields: All fields by name: those of the policy of all, and what others have besides.
        unmarked: Fields like these in which nobody leaves marks, if any group ignores some; see `read_by`.

    Raises:
        ColonysimError: Something that the scenario says of a group does not exist or does not fit.
    """

    def __init__(
        self, given: str | Policy | Callable[[Scenario], Policy] | None, scenario: Scenario, world: World, rows: Rows
    ) -> None:
        main = make_policy(given, scenario)
        policies = [main, *(policy_of_group(scenario, n, main, given) for n in range(len(scenario.groups)))]
        checked = {id(policy): checked_policy(policy, world, rows) for policy in policies}
        self._distinct = [*checked.values()]
        if len(checked) > 1 and any(policy.outside for policy in self._distinct):
            which = next(n for n, policy in enumerate(policies[1:]) if policy is not main)
            raise ColonysimError(
                f"decisions from outside are those of all agents, and group {scenario.groups[which].name!r} has a "
                f"policy of its own: leave it out, as by overrides={{'groups.{which}.policy': None}}"
            )
        self._world, self._rows = world, rows
        self.fields: dict[str, Marks] = self._made()
        self.decider = self._distinct[0]
        self.unmarked: list[Marks] = []
        if len(checked) > 1:
            deciders = [self.decider] * len(scenario.agents)
            for group, policy in zip(scenario.groups, policies[1:], strict=True):
                for agent in group.agents:
                    deciders[agent] = checked[id(policy)]
            self.decider = Mixed(self.decider.name, deciders)
        refuse_unknown_fields(scenario, self.fields)

    def _made(self) -> dict[str, Marks]:
        found: dict[str, Marks] = {}
        for policy in self._distinct:
            found = {**checked_fields(policy, self._world, self._rows), **found}
        return found

    def read_by(self) -> list[Mapping[str, Field]]:
        """The fields that each agent reads: of those that its group ignores, one in which nobody leaves marks."""
        scenario = self._world.scenario
        found: list[Mapping[str, Field]] = [self.fields] * len(scenario.agents)
        if any(group.ignores for group in scenario.groups):
            unmarked = self._made()
            self.unmarked = list(unmarked.values())
            for group in scenario.groups:
                own = {name: unmarked[name] if name in group.ignores else self.fields[name] for name in self.fields}
                for agent in group.agents:
                    found[agent] = own
        return found
