"""What a user brings, as the cases time it: written the way docs/extending.md shows, on public names only."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.backends.nodeworld import NodeWorld
from colonysim.pheromones.distance import Distance, extent
from colonysim.pheromones.exploration import Exploration
from colonysim.policies.policy import Choice
from colonysim.policies.presets import Colony
from colonysim.world.intents import Travel, Wait

if TYPE_CHECKING:
    import random
    from collections.abc import Iterable, Mapping, Sequence

    from colonysim.pheromones.field import Field, Visit, Write
    from colonysim.policies.view import LocalView
    from colonysim.scenario.scenario import Scenario
    from colonysim.world.state import World

__all__ = ["ExtraField", "OwnBackend", "OwnRule", "OwnWalk", "Subclass"]


class OwnWalk:
    """A random walk in ten lines: any free neighbour, no marks, no memory."""

    name = "own-walk"

    def __init__(self, scenario: Scenario) -> None:
        pass

    def fields(self, world: World) -> Mapping[str, Field]:
        """None."""
        return {}

    def begin(self, agent: int, memory: None) -> None:
        """Nothing to remember."""

    def decide(self, view: LocalView, memory: None, random: random.Random) -> Choice:
        """One of the free neighbours, all equally likely."""
        nodes = view.exits()
        if not nodes:
            return Choice(Wait(tuple(view.neighbours)), memory)
        return Choice(Travel(nodes[int(random.random() * len(nodes))]), memory)


class OwnRule(OwnWalk):
    """Follows D away from E, in plain Python on the built-in fields."""

    name = "own-rule"

    def fields(self, world: World) -> Mapping[str, Field]:
        """D and E, as they come with the package."""
        return {"D": Distance(world, d_max=extent(world)), "E": Exploration(world)}

    def decide(self, view: LocalView, memory: None, random: random.Random) -> Choice:
        """The neighbour that promises most: near to the goal as far as is known, and not visited much."""
        distance, visits = view.fields["D"], view.fields["E"]
        nodes = view.exits()
        if not nodes:
            return Choice(Wait(tuple(view.neighbours)), memory)
        return Choice(Travel(max(nodes, key=lambda node: distance.at(node) - visits.at(node))), memory)


class ExtraField:
    """A field that never writes anything."""

    name = "X"
    by_box = False

    def __init__(self, world: World) -> None:
        pass

    def at(self, node: int, key: int = -1) -> float:
        """Always 0."""
        return 0.0

    def keys(self, node: int) -> Sequence[int]:
        """None."""
        return ()

    def deposit(self, visit: Visit) -> Iterable[Write]:
        """Nothing."""
        return ()

    def end_episode(self) -> None:
        """Nothing changes."""

    def frame(self) -> Iterable[Write]:
        """No value was ever written."""
        return ()

    def load(self, frame: Iterable[Write]) -> None:
        """Nothing is taken over."""

    def state(self) -> dict[str, object]:
        """Nothing is known."""
        return {}

    def restore(self, state: dict[str, object]) -> None:
        """Nothing is taken over."""


class Subclass(Colony):
    """The colony, derived from and not changed."""


class OwnBackend(NodeWorld):
    """The node world, derived from and not changed."""

    name = "own-backend"
