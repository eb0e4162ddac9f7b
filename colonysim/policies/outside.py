"""A policy whose decisions come from outside: from whoever holds the colony."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.pheromones import Signal
from colonysim.plugins import make_policy

if TYPE_CHECKING:
    import random
    from collections.abc import Callable, Mapping

    from colonysim.pheromones.field import Field
    from colonysim.policies.policy import Choice, Policy
    from colonysim.policies.view import LocalView
    from colonysim.scenario.scenario import Scenario
    from colonysim.world.state import World

__all__ = ["Outside"]


class Outside:
    """Has the simulation stop where an agent has to decide, and ask whoever holds the colony.

    Pheromones, and what agents remember, are those of another policy, which `Colony.choice` asks for its own opinion.

    Args:
        scenario: The scenario.
        policy: That other policy, as for a colony: the scenario's own if None.
        signal: Whether there is, in place of its pheromones, one field of marks that decisions leave (`Choice.mark`).
        half_life: Simulated seconds in which those halve; None for never.

    Attributes:
        name: As results and traces call it.
        outside: True of every policy whose decisions come from outside.

    Example:
        ```python
        colony = colonysim.Colony("hard", policy=Outside, episodes=1)
        while not colony.over:
            event = colony.step()
            if event is None and colony.asked is not None:
                colony.answer(colony.choice())  # or a Travel, a Push or a Wait
        ```
    """

    name = "outside"
    outside = True

    def __init__(
        self, scenario: Scenario, policy: str | Policy | Callable[[Scenario], Policy] | None = None, *,
        signal: bool = False, half_life: float | None = None,
    ) -> None:  # fmt: skip
        self._policy: Any = make_policy(policy, scenario)
        self._signal, self._half_life = signal, half_life

    def __repr__(self) -> str:
        return f"<policy {self.name} over {self._policy}>"

    @classmethod
    def over(
        cls, policy: str | Policy | Callable[[Scenario], Policy] | None, *, signal: bool = False,
        half_life: float | None = None,
    ) -> Callable[[Scenario], Outside]:  # fmt: skip
        """What makes such a policy over another one: to be given to a colony as its policy."""
        return _Over(policy, signal, half_life)

    def fields(self, world: World) -> Mapping[str, Field]:
        """Those of the other policy, or the signal."""
        if self._signal:
            return {Signal.name: Signal(world, half_life=self._half_life)}
        found: Mapping[str, Field] = self._policy.fields(world)
        return found

    def begin(self, agent: int, memory: Any) -> Any:
        """As the other policy has it."""
        return self._policy.begin(agent, memory)

    def decide(self, view: LocalView, memory: Any, random: random.Random) -> Choice:
        """What the other policy would do."""
        choice: Choice = self._policy.decide(view, memory, random)
        return choice

    def state(self, agent: int, memory: Any) -> Any:
        """A memory as plain data."""
        said = getattr(self._policy, "state", None)
        return memory if said is None else said(agent, memory)

    def restore(self, agent: int, state: Any) -> Any:
        """A memory from plain data."""
        taken = getattr(self._policy, "restore", None)
        return state if taken is None else taken(agent, state)

    def take_over(self, memory: Any, before: Outside) -> Any:
        """What an agent remembers from now on whose other policy had other parameters until now."""
        taken = getattr(self._policy, "take_over", None)
        return memory if taken is None else taken(memory, before._policy)


class _Over:
    """Makes an `Outside` over a policy."""

    def __init__(
        self, policy: str | Policy | Callable[[Scenario], Policy] | None, signal: bool, half_life: float | None
    ) -> None:
        self.name, self._policy, self._signal, self._half_life = Outside.name, policy, signal, half_life

    def __call__(self, scenario: Scenario) -> Outside:
        return Outside(scenario, self._policy, signal=self._signal, half_life=self._half_life)
