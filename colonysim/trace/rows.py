# cython: auto_pickle=False
"""From what happens in a simulation to the rows of its trace: indices become the numbers of the scenario's file."""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING, Any

from colonysim.errors import TraceError
from colonysim.states import Stored
from colonysim.suggest import nearest
from colonysim.trace.schema import TABLES, Event, Frame
from colonysim.trace.writer import TraceWriter

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping, Sequence

    from colonysim.pheromones.field import Field
    from colonysim.pheromones.marks import Marks
    from colonysim.scenario.scenario import Scenario
    from colonysim.states import State
    from colonysim.trace.block import Block
    from colonysim.trace.schema import EpisodeResult, Measurement, Sink, Table

__all__ = ["Rows"]


class Rows:
    """Writes the rows of episodes to a sink, if there is one, and keeps their events until they are taken.

    Args:
        scenario: Whose numbers to write.
        sink: Takes the rows; None to keep events only.
        decisions: Whether the sink gets the decisions.
        kinds: Kinds of the events to keep; None for all.

    Attributes:
        now: Simulated seconds, set by the simulation.
        kept: Whether there is a sink.
        hears_ends: Whether the events of ends are kept.
        hears_waits: Whether those of waits are.
        events: Events that have not been taken yet.
    """

    __slots__ = (
        "_before", "_chosen", "_decisions", "_deposits", "_ended", "_episode", "_holes", "_kinds", "_marked",
        "_numbers", "_write", "_writer", "events", "hears_ends", "hears_waits", "kept", "now",
    )  # fmt: skip

    def __init__(
        self,
        scenario: Scenario,
        sink: Sink | None,
        decisions: bool,
        kinds: Collection[str] | None = None,
    ) -> None:
        self._episode = 0
        self._write = sink.write if sink else None
        self.kept = self._write is not None
        self._decisions, self._deposits = decisions and sink is not None, sink is not None
        self._kinds = kinds
        self.hears_ends, self.hears_waits = self._heard("end"), self._heard("wait")
        ids = scenario.topology.ids
        # -1 ("none") must stay -1 when indices become numbers.
        self._numbers = array("q", (*ids, -1))
        self._holes = array("q", (*(ids[hole.node] for hole in scenario.holes), -1))
        self.events: list[Event] = []
        self.now = 0.0
        # The rows of travels go straight into the columns of such a writer, without objects to carry them.
        self._writer = sink if type(sink) is TraceWriter else None
        self._ended: Block | None = None
        self._chosen: Block | None = None
        self._marked: Block | None = None
        self._before: tuple[Any, ...] | None = None
        if self._writer is not None:
            self._decisions = decisions and self._writer.keeps("decisions", 1)
            self._deposits = self._writer.keeps("deposits", 1)
            self._marked = self._writer.block("deposits")
            self._chosen = self._writer.block("decisions") if decisions else None
            self._ended = None if self.hears_ends else self._writer.block("events")

    def begin(self, episode: int) -> None:
        """What comes from now on belongs to the episode of that number."""
        self._episode, self.now = episode, 0.0

    def _heard(self, kind: str) -> bool:
        return self._kinds is None or kind in self._kinds

    def event(
        self,
        kind: str,
        agent: int = -1,
        action: str = "",
        node: int = -1,
        target: int = -1,
        box: int = -1,
        hole: int = -1,
        status: str = "",
        reason: str = "",
        step: int = 0,
        began: float | None = None,
        now_at: int | None = None,
    ) -> None:
        """Something happened now; the arguments are the columns of `Event`, nodes and holes by index."""
        heard = self._heard(kind)
        if not heard and self._write is None:
            return
        numbers, now = self._numbers, self.now
        # Event(...) itself takes three times as long, and there is no more frequent object.
        event = tuple.__new__(
            Event,
            (
                self._episode, now, kind, agent, action, numbers[node], numbers[target], box, self._holes[hole], status,
                reason, step, now if began is None else began, numbers[node if now_at is None else now_at],
            ),
        )  # fmt: skip
        if heard:
            self.events.append(event)
        if self._write is not None:
            self._write("events", event)

    def decision(
        self,
        agent: int,
        node: int,
        explored: bool,
        chosen: int,
        targets: Sequence[int],
        boxes: Sequence[int],
        probabilities: Sequence[float],
    ) -> None:
        """An agent chose among `targets`; the arguments are the columns of `Decision`, nodes by index."""
        if self._decisions and self._write:
            numbers = self._numbers
            # A plain tuple in the order of Decision: there are too many to name their fields.
            self._write(
                "decisions",
                (
                    self._episode, self.now, agent, numbers[node], explored, numbers[chosen],
                    tuple([numbers[target] for target in targets]), tuple(boxes), tuple(probabilities),
                ),
            )  # fmt: skip

    def ended(
        self,
        agent: int,
        action: str,
        origin: int,
        target: int,
        box: int,
        hole: int,
        status: str,
        reason: str,
        step: int,
        began: float,
        now_at: int,
    ) -> None:
        """The event of an action's end; the arguments are the columns of `Event`, nodes and holes by index."""
        block, numbers = self._ended, self._numbers
        if block is None:
            if self.kept or self.hears_ends:
                self.event("end", agent, action, origin, target, box, hole, status, reason, step, began, now_at)
            return
        block.whole(self._episode)
        block.real(self.now)
        block.word("end")
        block.whole(agent)
        block.word(action)
        block.whole(numbers[origin])
        block.whole(numbers[target])
        block.whole(box)
        block.whole(self._holes[hole])
        block.word(status)
        block.word(reason)
        block.whole(step)
        block.real(began)
        block.whole(numbers[now_at])
        self._settle("events", block)

    def chose(
        self,
        agent: int,
        node: int,
        explored: bool,
        chosen: int,
        targets: Sequence[int],
        boxes: Sequence[int],
        probabilities: Sequence[float],
        count: int,
    ) -> None:
        """`decision` among the first `count` of `targets`."""
        block, numbers = self._chosen, self._numbers
        if block is None:
            if self._decisions:
                self.decision(
                    agent, node, explored, chosen, tuple(targets[:count]), tuple(boxes[:count]),
                    tuple(probabilities[:count]),
                )  # fmt: skip
            return
        block.whole(self._episode)
        block.real(self.now)
        block.whole(agent)
        block.whole(numbers[node])
        block.flag(explored)
        block.whole(numbers[chosen])
        for i in range(count):
            block.item(numbers[targets[i]])
        block.items(count)
        for i in range(count):
            block.item(boxes[i])
        block.items(count)
        for i in range(count):
            block.real_item(probabilities[i])
        block.items(count)
        self._settle("decisions", block)

    def marked(self, field: Marks, agent: int, count: int) -> None:
        """An agent left the `count` marks that the last `mark` of a field has written."""
        block, name, by_box = self._marked, field.name, field.by_box
        if not self._deposits:
            return
        for i in range(count):
            place, key, value = field.place(i), field.key(i), field.value(i)
            if not by_box:
                place = self._numbers[place]
            if block is None:
                if self._write:
                    self._write("deposits", (self._episode, self.now, name, agent, place, self._holes[key], value))
                continue
            block.whole(self._episode)
            block.real(self.now)
            block.word(name)
            block.whole(agent)
            block.whole(place)
            block.whole(self._holes[key])
            block.real(value)
            self._settle("deposits", block)

    def _settle(self, table: Table, block: Block) -> None:
        if self._writer is not None and block.rows >= self._writer.block_rows:
            self._writer.pack(table)

    def measured(self, row: Measurement) -> None:
        """The user has measured something."""
        if self._write:
            self._write("measurements", row)

    def foreign(self, rows: Iterable[tuple[str, tuple[object, ...]]]) -> None:
        """Rows that a backend hands over; the episode is put in front of each.

        Raises:
            TraceError: There is no such table.
        """
        if self._write:
            for table, row in rows:
                if table not in TABLES:
                    raise TraceError(f"the backend wrote to a table {table!r}; {nearest(table, TABLES)}")
                self._write(table, (self._episode, *row))

    def hush(self, silent: bool) -> None:
        """Writes and keeps nothing from now on, or again what it did: for what is gone through a second time."""
        if silent:
            self._before = (
                self._write, self._writer, self._kinds, self._ended, self._chosen, self._marked, self._decisions,
                self._deposits, self.kept, self.hears_ends, self.hears_waits,
            )  # fmt: skip
            self._write = self._writer = self._ended = self._chosen = self._marked = None
            self._kinds = frozenset()
            self._decisions = self._deposits = self.kept = self.hears_ends = self.hears_waits = False
            return
        assert self._before is not None
        (
            self._write, self._writer, self._kinds, self._ended, self._chosen, self._marked, self._decisions,
            self._deposits, self.kept, self.hears_ends, self.hears_waits,
        ) = self._before  # fmt: skip
        self._before = None

    def state(self) -> State:
        """The events that have not been taken yet; all other rows are in the sink."""
        return {"events": [list(event) for event in self.events]}

    def restore(self, state: State, episode: int, now: float) -> None:
        """Takes over the events that these rows hand out, and goes on in an episode at a time."""
        told = Stored(state, "events")
        self._episode, self.now = episode, now
        events, kinds = [], [*TABLES["events"].values()]
        for event in told.listed("events"):
            if not isinstance(event, list) or len(event) != len(kinds):
                raise told.fault("events", event, f"{len(kinds)} values for each event")
            each = Stored(dict(zip(Event._fields, event, strict=True)), "an event")
            values: list[Any] = []
            for name, kind in zip(Event._fields, kinds, strict=True):
                if kind == "text":
                    values.append(each.text(name))
                else:
                    values.append(each.whole(name, -1) if kind == "int" else each.real(name, 0.0))
            events.append(Event._make(values))
        self.events[:] = [event for event in events if self._heard(event.kind)]

    def close(self, fields: Mapping[str, Field], result: EpisodeResult) -> None:
        """The episode has ended: a key frame of every field, if the sink keeps that of this one, and the result."""
        if self._write:
            kept = self._writer is None or self._writer.keeps("frames", self._episode)
            for name, field in fields.items() if kept else ():
                for node, key, value in field.frame():
                    place = node if field.by_box else self._numbers[node]
                    self._write("frames", Frame(self._episode, name, place, self._holes[key], value))
            self._write("episodes", result)
