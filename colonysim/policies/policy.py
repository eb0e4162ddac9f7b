"""The protocol of policies: a policy decides from a local view and the agent's memory, and has no other state."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

if TYPE_CHECKING:
    import random
    from collections.abc import Mapping

    from colonysim.pheromones.field import Field
    from colonysim.policies.view import LocalView
    from colonysim.world.intents import Intent
    from colonysim.world.state import World

__all__ = ["Choice", "Policy"]


class Choice(NamedTuple):
    """A decision and, for the trace, the options that it was chosen from.

    Attributes:
        intent: What the agent wants to do.
        memory: What it will remember; handed back at its next decision.
        explored: Whether it followed E instead of D and B.
        targets: The nodes it could choose from.
        boxes: For each of them the box meant, or -1; empty if no box is meant.
        probabilities: For each of them its chance; empty if there was no choice.
        mark: What it wants to leave where its move ends or where it waits, 0 to 1: for fields whose marks are decided
            on (`colonysim.pheromones.Signal`); all others go by rules of their own.
    """

    intent: Intent
    memory: Any
    explored: bool = False
    targets: tuple[int, ...] = ()
    boxes: tuple[int, ...] = ()
    probabilities: tuple[float, ...] = ()
    mark: float = 0.0


class Policy(Protocol):
    """Decides for every agent of a colony; agents differ by memory, view and random stream only.

    A policy is built with the scenario (`Policy(scenario)`) and reads its parameters from it.

    A colony is saved with what its agents remember. Memories that are plain data (None, numbers, text, lists, tuples,
    mappings, arrays) need nothing for that; for others a policy has the methods `state(self, agent, memory)`, which
    returns plain data for a memory, and `restore(self, agent, state)`, which makes the memory again.

    Attributes:
        name: As results and traces call it.
    """

    name: str

    def fields(self, world: World) -> Mapping[str, Field]:
        """The pheromone fields that its agents write and read; built once for a run."""
        ...

    def begin(self, agent: int, memory: Any) -> Any:
        """An agent's memory at the start of an episode; `memory` is that of the episode before, None at first."""
        ...

    def decide(self, view: LocalView, memory: Any, random: random.Random) -> Choice:
        """What the agent does next."""
        ...
