"""The tables of a trace and their columns; `VERSION` changes whenever a reader would notice.

Nodes are written by their numbers in the scenario file, boxes and agents by their position in it, holes by the
number of their node. -1 stands for "none" in every integer column.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Mapping

    from colonysim.trace.packing import Codes, Packed

__all__ = [
    "EVENT_KINDS", "TABLES", "VERSION", "Column", "Decision", "Deposit", "EpisodeResult", "Event", "Frame",
    "Measurement", "Sink", "Table", "Tap",
]  # fmt: skip

VERSION = 1
EVENT_KINDS = ("start", "end", "wait", "goal", "spent", "lost", "change", "episode")
"""The kinds of an `Event`."""

Column: TypeAlias = Literal["int", "float", "text", "bool", "ints", "floats"]
Table: TypeAlias = Literal["events", "decisions", "deposits", "poses", "controls", "frames", "episodes", "measurements"]


class Event(NamedTuple):
    """Something that happened. `simulate` yields these as they occur.

    Attributes:
        episode: Counted from 1.
        time: Simulated seconds since the episode's start.
        kind: "start" (an agent stands on its first node), "end" (an action ended), "wait" (an agent began to wait),
            "goal" (the agent reached the goal and left), "spent" (max_steps used up), "lost", "change" (of the
            scenario's timeline), "episode" (it ended).
        agent: Which agent.
        action: "travel", "push", "take" (the first step of a push: onto the box's node) or "wait"; at a "change" what
            it does, such as "remove_edge"; else empty.
        node: Where the agent is; at an "end", where the action began.
        target: Where the action led, or was meant to lead.
        box: Which box.
        hole: Node of the hole the box is meant for.
        status: "arrived", "blocked", "failed"; for kind "episode" the way it ended.
        reason: Why it did not arrive.
        step: Steps the agent has begun so far; at a "change" its position in the scenario's timeline.
        began: At an "end", the simulated second at which the action began; else equal to `time`.
        now_at: At an "end", the node the agent now belongs to; else equal to `node`.
    """

    episode: int
    time: float
    kind: str
    agent: int = -1
    action: str = ""
    node: int = -1
    target: int = -1
    box: int = -1
    hole: int = -1
    status: str = ""
    reason: str = ""
    step: int = 0
    began: float = 0.0
    now_at: int = -1


class Decision(NamedTuple):
    """What an agent could choose from; `targets`, `boxes` and `probabilities` run in parallel."""

    episode: int
    time: float
    agent: int
    node: int
    explored: bool
    chosen: int
    targets: tuple[int, ...]
    boxes: tuple[int, ...]
    probabilities: tuple[float, ...]


class Deposit(NamedTuple):
    """A pheromone value written by an agent: `key` is the hole (H) or hole and `node` the box (B), else -1."""

    episode: int
    time: float
    field: str
    agent: int
    node: int
    key: int
    value: float


class Frame(NamedTuple):
    """One pheromone value at the end of an episode, before what the end of an episode does to it."""

    episode: int
    field: str
    node: int
    key: int
    value: float


class EpisodeResult(NamedTuple):
    """How an episode went; `wall_seconds` is no part of the trace's hash.

    Attributes:
        episode: Counted from 1.
        steps: Largest count of steps of its agents if it ended with "goal", else max_steps.
        success: Share of agents at the goal.
        ended: "goal", "max_steps", "deadlock", "lost", "timeout" or "interrupted".
        sim_seconds: Simulated seconds it took.
        seated: Boxes that lie in a hole at its end.
        wall_seconds: Seconds of wall clock it took.
    """

    episode: int
    steps: int
    success: float
    ended: str
    sim_seconds: float
    seated: int
    wall_seconds: float

    def __repr__(self) -> str:
        end = f"{self.ended}, {self.sim_seconds:.1f} s"
        return f"<episode {self.episode}: {self.steps} steps, success {self.success:.2f}, {end}>"


class Measurement(NamedTuple):
    """A value of something that the user measures, see `Colony.measure`.

    Attributes:
        episode: Counted from 1.
        time: Simulated seconds since the episode's start.
        name: What was measured.
        value: The value; may be no number (nan).
    """

    episode: int
    time: float
    name: str
    value: float


TABLES: dict[Table, dict[str, Column]] = {
    "events": {
        "episode": "int", "time": "float", "kind": "text", "agent": "int", "action": "text", "node": "int",
        "target": "int", "box": "int", "hole": "int", "status": "text", "reason": "text", "step": "int",
        "began": "float", "now_at": "int",
    },
    "decisions": {
        "episode": "int", "time": "float", "agent": "int", "node": "int", "explored": "bool", "chosen": "int",
        "targets": "ints", "boxes": "ints", "probabilities": "floats",
    },
    "deposits": {
        "episode": "int", "time": "float", "field": "text", "agent": "int", "node": "int", "key": "int",
        "value": "float",
    },
    "poses": {
        "episode": "int", "time": "float", "body": "text", "number": "int", "x": "float", "y": "float", "z": "float",
        "roll": "float", "pitch": "float", "yaw": "float",
    },
    "controls": {
        "episode": "int", "time": "float", "agent": "int", "chooser": "text", "control": "text", "ticks": "int",
    },
    "frames": {"episode": "int", "field": "text", "node": "int", "key": "int", "value": "float"},
    "episodes": {
        "episode": "int", "steps": "int", "success": "float", "ended": "text", "sim_seconds": "float",
        "seated": "int", "wall_seconds": "float",
    },
    "measurements": {"episode": "int", "time": "float", "name": "text", "value": "float"},
}  # fmt: skip


class Sink(Protocol):
    """Where a simulation's rows go; a trace writer is one."""

    def write(self, table: Table, row: tuple[object, ...]) -> None:
        """Takes one row, in the order of the table's columns."""
        ...


class Tap(Protocol):
    """Is told the rows of a run while they come, as columns: for whoever follows a run under way."""

    def take(self, table: Table, columns: Mapping[str, Packed], codes: Mapping[str, Codes]) -> None:
        """Takes a table's next rows; the columns go on growing, so what is kept has to be copied."""
        ...

    def cut(self) -> None:
        """Learns that the rows so far are all there are up to one moment of the simulation, of every table."""
        ...
