"""The protocol of pheromone fields, and the visits at which agents deposit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol, TypeAlias

__all__ = ["Field", "Moment", "Visit", "Write"]

Moment: TypeAlias = Literal["start", "arrive", "wait", "claim"]
"""When an agent may deposit, see `Visit`."""


@dataclass
class Visit:
    """An agent that stands on a node and may leave marks there; one object, reused for every visit.

    Attributes:
        moment: "start" of the episode, "arrive" (a step has ended), "wait", or "claim" (it takes hold of a box).
        agent: The agent.
        node: Where it stands.
        level: The height it stands at, graph units.
        box: The box just claimed (moment "claim"), else -1.
        hole: The hole (key) which that box is meant for, else -1.
        left: The node it has just left ("arrive"), else -1.
        before: The node it was on before `left`, else -1.
        mark: What its decision says that it leaves ("arrive", "wait"), 0 to 1, see `Choice`.
    """

    moment: Moment = "start"
    agent: int = -1
    node: int = -1
    level: float = 0.0
    box: int = -1
    hole: int = -1
    left: int = -1
    before: int = -1
    mark: float = 0.0


class Write(NamedTuple):
    """One value written: by node, and by hole or box where the field keeps more than one value a node."""

    node: int
    key: int
    value: float


class Field(Protocol):
    """A kind of pheromone: what is left where, and what the end of an episode does to it.

    A field is built once for a run, with the world whose episodes it lives through. It reads what an agent that
    stands on the visited node could see and writes its own values there, nothing else; `key` tells the values of
    one node apart (H: by hole) or, for B, `node` is the box and `key` the hole.

    Two more methods may be there. `wipe(nodes)` takes away all marks on some nodes, given by index, as if nobody had
    been there (of a field of boxes: those of the boxes that stand there); without it a run in which marks are wiped
    ends with an error that names the field. `settle()` is called before edges of the place come or go, and before
    `end_episode` if they have: a field whose marks spread lazily brings them up to now then (`NodeValues.settle`).

    A colony can be saved and forked if each of its fields has two more methods: `state(self) -> dict` returns all that
    the field is as plain data (`colonysim.states`), and `restore(self, state)` makes another one for the same world the
    same.

    Attributes:
        name: As policies, traces and plots call it ("D", "B", "H", "E" are the paper's).
        by_box: Whether values belong to boxes instead of nodes.
    """

    name: str
    by_box: bool

    def at(self, node: int, key: int = -1) -> float:
        """The value at a node."""
        ...

    def keys(self, node: int) -> Sequence[int]:
        """The keys that have a value at a node, ascending; empty for a field without keys."""
        ...

    def deposit(self, visit: Visit) -> Iterable[Write]:
        """Leaves marks; returns what was written, for the trace."""
        ...

    def end_episode(self) -> None:
        """What the end of an episode does to every value, lazily where it can."""
        ...

    def frame(self) -> Iterable[Write]:
        """Every value that was ever written and still counts."""
        ...

    def load(self, frame: Iterable[Write]) -> None:
        """Takes over the values of another run, as `frame` has given them; called before agents leave any."""
        ...
