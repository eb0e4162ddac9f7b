"""A baseline without pheromones: every possible move is equally likely."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.policies.parameters import NoParameters
from colonysim.policies.policy import Choice
from colonysim.world.intents import Push, Travel, Wait

if TYPE_CHECKING:
    import random
    from collections.abc import Mapping

    from colonysim.pheromones.field import Field
    from colonysim.policies.view import LocalView
    from colonysim.scenario.scenario import Scenario
    from colonysim.world.intents import Intent
    from colonysim.world.state import World

__all__ = ["Uniform"]


class Uniform:
    """Travels, takes hold of boxes and pushes them uniformly at random.

    Args:
        scenario: Its `policy:` section must hold no parameters.

    Raises:
        ScenarioError: It holds some.
    """

    name = "random"
    parameters = NoParameters

    def __init__(self, scenario: Scenario) -> None:
        if scenario.parameters:
            first = next(iter(scenario.parameters))
            raise scenario.fault(f"policy.{first}", f"no such parameter; the policy {self.name!r} has none")

    def __repr__(self) -> str:
        return f"<policy {self.name}>"

    def fields(self, world: World) -> Mapping[str, Field]:
        """None: it leaves and reads no marks."""
        return {}

    def begin(self, agent: int, memory: None) -> None:
        """Nothing to remember."""

    def decide(self, view: LocalView, memory: None, random: random.Random) -> Choice:
        """One of all moves that the place allows."""
        moves: list[tuple[Intent, int, int]] = [(Travel(j), j, -1) for j in view.exits()]
        for box in view.boxes():
            at = view.box_node(box)
            if at == view.node and view.graspable_from(at, box):
                pushes = [j for j in view.neighbours if view.can_slide(box, at, j) and view.free(j)]
                chances = view.feasible(box, pushes) if pushes else ()
                moves += [(Push(box, j, -1), j, box) for j, c in zip(pushes, chances, strict=True) if c > 0.0]
            elif at in view.neighbours and view.graspable_from(view.node, box) and view.free(at):
                moves.append((Push(box, at, -1), at, box))
        if not moves:
            return Choice(Wait(tuple(view.neighbours)), memory)
        intent, _, _ = moves[int(random.random() * len(moves))]
        nodes = tuple(node for _, node, _ in moves)
        boxes = tuple(box for _, _, box in moves)
        return Choice(intent, memory, False, nodes, boxes, (1.0 / len(moves),) * len(moves))
