"""The adapter that checks the answers of third parties' backends."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from colonysim.backends.protocol import Done, TraceRow
from colonysim.simulation.foreign.answers import (
    LONGEST_TEXT,
    SHOWN,
    Foreign,
    fits,
    is_text,
    listed,
    plain,
    real,
    truth,
    whole,
)  # fmt: skip
from colonysim.states import Stored
from colonysim.trace.schema import TABLES
from colonysim.world.intents import BoxPlace, Outcome
from colonysim.world.plain import move_of, move_state

if TYPE_CHECKING:
    from colonysim.backends.protocol import Backend, Finished
    from colonysim.randomness import Streams
    from colonysim.scenario.changes import Change
    from colonysim.states import State
    from colonysim.trace.rows import Rows
    from colonysim.world.intents import Move
    from colonysim.world.state import Place, World

__all__ = ["ForeignBackend"]

_OF_BACKENDS = ("poses", "controls")
"""The tables whose rows a backend may give; the others are the simulation's own."""
SHORTEST_TICK = 1e-6
"""Seconds; with shorter ticks no waiting would ever end."""


class ForeignBackend(Foreign):
    """A third party's backend; checks each of its answers against the protocol."""

    def __init__(self, backend: Backend, world: World, rows: Rows) -> None:
        super().__init__(backend, "backend", world, rows)
        self.tick: float | None = None
        self.edge_seconds = 1.0
        self._under_way: dict[int, Move] = {}
        self.feasible_way = self._along if getattr(backend, "feasible_way", None) is not None else None
        self.changed = self._hear_of if getattr(backend, "changed", None) is not None else None

    def reset(self, world: World, streams: Streams) -> None:
        """The times that it is known by are above 0 then."""
        self._under_way.clear()
        self._call("reset", world, streams)
        for name in ("tick", "edge_seconds"):
            given = getattr(self._part, name, None)
            seconds = real(given)
            if (seconds is None or seconds <= 0.0) and not (name == "tick" and given is None):
                raise self._fault(f"{name} is {SHOWN.repr(given)}, expected seconds above 0")
            if name == "tick" and seconds is not None and seconds < SHORTEST_TICK:
                raise self._fault(f"tick is {SHOWN.repr(given)}, expected at least {SHORTEST_TICK:g} seconds")
            setattr(self, name, seconds)

    def feasible(self, agent: int, box: int, targets: Sequence[int]) -> Sequence[float]:
        """A chance for each target."""
        return self._chances("feasible", agent, self._call("feasible", agent, box, targets, agent=agent), len(targets))

    def _hear_of(self, change: Change) -> None:
        self._call("changed", change)

    def _along(self, agent: int, box: int, way: Sequence[int]) -> Sequence[float]:
        given = self._call("feasible_way", agent, box, way, agent=agent)
        return self._chances("feasible_way", agent, given, max(0, len(way) - 1))

    def _chances(self, method: str, agent: int, given: Any, count: int) -> list[float]:
        chances = [real(chance) for chance in self._listed(method, given, agent)]
        if len(chances) != count:
            raise self._fault(f"{method} returns {len(chances)} chances, expected {count}", agent)
        found = [chance for chance in chances if chance is not None and 0.0 <= chance <= 1.0]
        if len(found) != count:
            raise self._fault(f"{method} returns {SHOWN.repr(given)}, expected chances from 0 to 1", agent)
        return found

    def footprint(self, agent: int, intent: Move) -> frozenset[Place]:
        """Nodes and edges that exist, the intent's own node among them."""
        given = self._call("footprint", agent, intent, agent=agent)
        found: list[Place] = []
        for place in self._listed("footprint", given, agent):
            ends = tuple(whole(end) for end in (place if isinstance(place, tuple) else (place,)))
            sound = len(ends) == (2 if isinstance(place, tuple) else 1)
            if not sound or not all(end is not None and 0 <= end < self._nodes for end in ends):
                why = f"footprint of {SHOWN.repr(intent)} holds {SHOWN.repr(place)}, expected a node or an edge"
                raise self._fault(why, agent)
            # An edge is one place, whichever of its ends is named first.
            found.append(tuple(sorted(ends)) if isinstance(place, tuple) else ends[0])  # type: ignore[arg-type, type-var]
        if intent.node not in found:
            why = f"footprint of {SHOWN.repr(intent)} is {SHOWN.repr(given)}, but that lacks node {intent.node} itself"
            raise self._fault(why, agent)
        return frozenset(found)

    def start(self, agent: int, intent: Move, now: float) -> Done | None:
        """An outcome with its time, or none yet if there is a clock."""
        done = self._call("start", agent, intent, now, agent=agent)
        if done is None:
            if self.tick is None:
                why = f"start returns None for {SHOWN.repr(intent)}, expected a Done, as it has no tick"
                raise self._fault(why, agent)
            self._under_way[agent] = intent
            return None
        try:
            given, outcome = done.seconds, done.outcome
        except AttributeError:
            raise self._fault(f"start returns {SHOWN.repr(done)}, expected a Done or None", agent) from None
        seconds = real(given)
        if seconds is None or seconds < 0.0 or not math.isfinite(now + seconds):
            why = f"{SHOWN.repr(intent)} takes {SHOWN.repr(given)} seconds, expected a number that is not negative"
            raise self._fault(why, agent)
        checked = self._outcome(agent, intent, outcome)
        return Done(seconds, checked)

    def advance(self, now: float) -> Sequence[Finished]:
        """Outcomes of what is under way."""
        finished = self._listed("advance", self._call("advance", now))
        found: list[Any] = []
        for each in finished:
            try:
                given_agent, outcome = each
            except (TypeError, ValueError):
                raise self._fault(f"advance returns {SHOWN.repr(each)}, expected a Finished") from None
            agent = whole(given_agent)
            if agent not in self._under_way:
                raise self._fault(f"advance returns {SHOWN.repr(each)}, but no such agent has an action under way")
            assert agent is not None
            found.append((agent, self._outcome(agent, self._under_way.pop(agent), outcome)))
        return found

    def _outcome(self, agent: int, intent: Move, outcome: Any) -> Outcome:
        """The outcome with plain numbers."""
        why = ""
        if not isinstance(outcome, Outcome):
            why = "expected an Outcome"
        elif outcome.status not in ("arrived", "blocked", "failed"):
            why = "there is no such status"
        elif not is_text(outcome.reason) or not isinstance(outcome.lost, bool):
            why = f"expected a reason in at most {LONGEST_TEXT} characters, and for lost True or False"
        else:
            try:
                node, kept = whole(outcome.node), tuple([whole(each) for each in listed(outcome.keeps)])
                places = tuple([BoxPlace(*place) for place in listed(outcome.boxes)])
            except Exception:  # whatever goes wrong in going through them
                why = "expected nodes that it keeps, and a BoxPlace for each box"
            else:
                if not all(each is not None and 0 <= each < self._nodes for each in (node, *kept)):
                    why = "there is no such node"
                boxes = [BoxPlace(whole(b), whole(n), bool(stray)) for b, n, stray in places]  # type: ignore[arg-type]
                for box, place, _ in boxes:
                    if box is None or not 0 <= box < self._boxes:
                        why = "there is no such box"
                    elif place is None or not 0 <= place < self._nodes:
                        why = "there is no such node for the box"
                if not why and node is not None:
                    why = self._misplaced(agent, intent, outcome.status, node)
        if why:
            raise self._fault(f"{SHOWN.repr(intent)} came to {SHOWN.repr(outcome)}: {why}", agent)
        if type(outcome.node) is int and not kept and not boxes:
            return outcome  # type: ignore[no-any-return]
        return Outcome(outcome.status, node, tuple(boxes), outcome.reason, outcome.lost, kept)  # type: ignore[arg-type]

    def _misplaced(self, agent: int, intent: Move, status: str, node: int) -> str:
        """Why an agent cannot be where an outcome puts it, or ""."""
        world = self._world
        here = world.agent_node[agent]
        if status == "arrived" and node not in (here, intent.node):
            return f"it did not set out for node {node}"
        occupant = world.occupant[node]
        return "" if node == here or occupant < 0 else f"agent {occupant} stands on node {node}"

    def cancel(self, agent: int) -> None:
        """No outcome may come of it."""
        self._under_way.pop(agent, None)
        self._call("cancel", agent, agent=agent)

    def leave(self, agent: int) -> None:
        """No outcome may come of it."""
        self._under_way.pop(agent, None)
        self._call("leave", agent, agent=agent)

    def rows(self) -> Iterable[TraceRow]:
        """Rows that fit their table."""
        found: list[TraceRow] = []
        for each in self._listed("rows", self._call("rows")):
            try:
                table, row = each
                kinds = [*TABLES[table].values()][1:]  # the simulation puts the episode in front
                sound = table in _OF_BACKENDS and len(row) == len(kinds)
                row = tuple(plain(value) for value in row)
                sound = sound and all(fits(value, kind) for value, kind in zip(row, kinds, strict=True))
            except (TypeError, ValueError, LookupError):
                sound = False
            if not sound:
                raise self._fault(f"rows returns {SHOWN.repr(each)}, expected rows of {' and '.join(_OF_BACKENDS)}")
            found.append(TraceRow(table, row))
        return found

    @property
    def replayable(self) -> bool:
        """Whether it says that an episode that is gone through again comes to the same."""
        return truth(getattr(self._part, "replayable", False)) is True

    def state(self) -> State:
        """What the backend says, and the actions that are under way."""
        self.check_savable()
        under_way = [[agent, move_state(intent)] for agent, intent in self._under_way.items()]
        return {"own": self._copied("state", self._call("state")), "under_way": under_way}

    def restore(self, state: State) -> None:
        """It may raise; called after `reset`."""
        self.check_savable()
        told, agents = Stored(state, f"backend {self.name!r}"), len(self._world.agent_node)
        self._under_way = {}
        for each in told.listed("under_way"):
            pair = Stored(dict(zip(("agent", "move"), each if isinstance(each, list) else (), strict=False)), "a move")
            move = move_of(pair.take("move"), self._world, "a move under way")
            if move is not None:
                self._under_way[pair.whole("agent", 0, agents - 1)] = move
        self._call("restore", told.take("own"))

    def reseed(self, streams: Streams) -> None:
        """It may raise, or be unable to."""
        if not callable(getattr(self._part, "reseed", None)):
            raise self._fault(
                f"{type(self._part).__name__} has no method 'reseed', by which a fork with a seed of its own gives it "
                "other random streams"
            )
        self._call("reseed", streams)

    def close(self) -> None:
        """It may raise."""
        self._call("close")
