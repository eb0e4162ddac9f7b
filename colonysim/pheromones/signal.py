"""The signal S: marks that no rule leaves, but the agents' own decisions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.pheromones.field import Write
from colonysim.pheromones.spreading import NodeValues

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from colonysim.pheromones.field import Visit
    from colonysim.states import State
    from colonysim.world.state import World

__all__ = ["Signal"]


class Signal:
    """S of a node is the last mark that an agent has decided to leave there (`Choice.mark`), and fades.

    A mark is left where a move ends, and where an agent begins to wait; a decision to leave 0 changes nothing. The end
    of an episode leaves all values as they are.

    Args:
        world: The world whose nodes are marked.
        half_life: Simulated seconds in which S halves, None for never.
    """

    name, by_box = "S", False

    def __init__(self, world: World, *, half_life: float | None = None) -> None:
        self._held = NodeValues(world, half_life=half_life)

    def at(self, node: int, key: int = -1) -> float:
        """S of a node."""
        return self._held.at(node)

    def keys(self, node: int) -> Sequence[int]:
        """None: one value a node."""
        return ()

    def deposit(self, visit: Visit) -> Iterable[Write]:
        """What the agent has decided to leave."""
        if visit.moment not in ("arrive", "wait") or visit.mark == 0.0:
            return ()
        self._held.put(visit.node, visit.mark)
        return (Write(visit.node, -1, visit.mark),)

    def end_episode(self) -> None:
        """Nothing but that the time begins anew."""
        self._held.end_episode()

    def state(self) -> State:
        """The values."""
        return self._held.state()

    def restore(self, state: State) -> None:
        """Takes over the state of such a field."""
        self._held.restore(state, "field S")

    def frame(self) -> Iterable[Write]:
        """S of every node where it is not 0."""
        return [Write(node, -1, value) for node, value in self._held.items()]

    def load(self, frame: Iterable[Write]) -> None:
        """Takes over values."""
        for node, _, value in frame:
            self._held.put(node, value)

    def wipe(self, nodes: Iterable[int]) -> None:
        """Makes S 0 on some nodes."""
        self._held.wipe(nodes)
