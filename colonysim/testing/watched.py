"""A backend under observation: every answer is held against what the protocol promises."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from colonysim.testing.promises import ConformanceError, world_state
from colonysim.trace.schema import TABLES
from colonysim.world.intents import Outcome, Push, Wait

if TYPE_CHECKING:
    from colonysim.backends.protocol import Backend, Done, FeasibleWay, Finished, TraceRow
    from colonysim.randomness import Streams
    from colonysim.world.intents import Intent
    from colonysim.world.state import Place, World

__all__ = ["WatchedBackend"]

_PROMISES = {
    "reset": "reset", "feasible": "feasible", "footprint": "footprint", "cancel": "cancel", "leave": "leave",
    "rows": "rows",
}  # fmt: skip
"""What an exception in a method breaks; in any other, that failures are outcomes."""

_TYPES: dict[str, type | tuple[type, ...]] = {
    "int": int, "float": (float, int), "text": str, "bool": bool, "ints": Sequence, "floats": Sequence,
}  # fmt: skip


class WatchedBackend:
    """Passes every call on to a backend and looks at what it answers.

    Args:
        body: The backend.
        curious: Asks for feasibility and footprints more often than it has to.
        vandal: Empties every list that it was given, after a copy was made.
    """

    def __init__(self, body: Backend, *, curious: bool = False, vandal: bool = False) -> None:
        self.name = body.name
        self.tick = body.tick
        self.edge_seconds = 1.0
        self.now = 0.0
        self._body = body
        self._curious = curious
        self._vandal = vandal
        self.pending: dict[int, tuple[float, Intent]] = {}
        self._stopped: dict[int, str] = {}
        self._given: list[tuple[str, Any, list[Any]]] = []
        # Optional: a policy must find it missing where it is missing.
        self._asked_along: FeasibleWay | None = getattr(body, "feasible_way", None)
        self.feasible_way = self._along if self._asked_along else None
        if not (isinstance(self.name, str) and self.name):
            raise ConformanceError("attributes", f"name is {self.name!r}, expected some text")
        if self.tick is not None and not (isinstance(self.tick, float | int) and 0.0 < self.tick < math.inf):
            raise ConformanceError("attributes", f"tick is {self.tick!r}, expected None or seconds above 0")

    def reset(self, world: World, streams: Streams) -> None:
        """Begins an episode; nothing is owed from the one before."""
        self._world = world
        self.pending.clear()
        self._stopped.clear()
        self._given.clear()
        self.now = 0.0
        self._unchanged("reset", lambda: self._body.reset(world, streams))
        self.tick, self.edge_seconds = self._body.tick, self._body.edge_seconds
        if not (isinstance(self.edge_seconds, float | int) and 0.0 < self.edge_seconds < math.inf):
            raise ConformanceError("attributes", f"edge_seconds is {self.edge_seconds!r} after reset, not above 0")

    def feasible(self, agent: int, box: int, targets: Sequence[int]) -> Sequence[float]:
        """A chance from 0 to 1 for each target, however often it is asked for."""
        answers = [
            self._unchanged("feasible", lambda: self._body.feasible(agent, box, targets))
            for _ in range(3 if self._curious else 1)
        ]
        chances = self._taken("feasible", answers[0])
        if len(chances) != len(targets):
            raise ConformanceError("feasible", f"{len(chances)} chances for {len(targets)} targets")
        for chance in chances:
            if not 0.0 <= chance <= 1.0:
                raise ConformanceError("feasible", f"a chance of {chance!r}, expected 0 to 1")
        return chances

    def _along(self, agent: int, box: int, way: Sequence[int]) -> Sequence[float]:
        """A chance from 0 to 1 for each push of a way, however often it is asked for."""
        along = self._asked_along
        assert along is not None
        answers = [
            self._unchanged("feasible", lambda: along(agent, box, way)) for _ in range(3 if self._curious else 1)
        ]
        chances = self._taken("feasible", answers[0])
        if len(chances) != len(way) - 1:
            raise ConformanceError("feasible", f"{len(chances)} chances for {len(way) - 1} pushes of a way")
        for chance in chances:
            if not 0.0 <= chance <= 1.0:
                raise ConformanceError("feasible", f"a chance of {chance!r}, expected 0 to 1")
        return chances

    def footprint(self, agent: int, intent: Intent) -> frozenset[Place]:
        """Nodes and edges that exist, the target among them, however often it is asked for."""
        answers = [
            self._unchanged("footprint", lambda: self._body.footprint(agent, intent))
            for _ in range(3 if self._curious else 1)
        ]
        places: frozenset[Place] = answers[0]
        if any(answer != places for answer in answers):
            raise ConformanceError("footprint", f"two answers for one intent ({intent}): {answers}")
        if isinstance(intent, Wait) or self._what_is_wrong_with(agent, intent):
            return places
        if not isinstance(places, frozenset):
            raise ConformanceError("footprint", f"a {type(places).__name__}, expected a frozenset")
        if intent.node not in places:
            raise ConformanceError("footprint", f"{set(places)} for {intent} lacks the target")
        neighbours = self._world.topology.neighbours
        for place in places:
            legal = (
                0 <= place < len(neighbours)
                if isinstance(place, int)
                else place[0] < place[1] and place[1] in neighbours[place[0]]
            )
            if not legal:
                raise ConformanceError("footprint", f"{place!r} is neither a node nor an edge (i, j) with i < j")
        return places

    def start(self, agent: int, intent: Intent, now: float) -> Done | None:
        """A legal outcome at once, or None from a backend with a clock of its own."""
        self.now = now
        done = self._unchanged("start", lambda: self._body.start(agent, intent, now))
        if done is None:
            if self.tick is None:
                raise ConformanceError("delivers once", "start answers None, though there is no tick")
            self.pending[agent] = (now, intent)
            self._stopped.pop(agent, None)
            return None
        if not (isinstance(done.seconds, float | int) and 0.0 <= done.seconds < math.inf):
            raise ConformanceError("legal outcomes", f"an action takes {done.seconds!r} seconds")
        self._examine(agent, intent, done.outcome)
        answer: Done = done
        return answer

    def advance(self, now: float) -> Sequence[Finished]:
        """A legal outcome for each action that was under way, once, and none that never comes."""
        self.now = now
        finished = self._taken("advance", self._unchanged("advance", lambda: self._body.advance(now)))
        for agent, outcome in finished:
            if agent not in self.pending:
                promise = self._stopped.get(agent, "delivers once")
                raise ConformanceError(promise, f"agent {agent} has no action under way, but an outcome: {outcome}")
            self._examine(agent, self.pending.pop(agent)[1], outcome)
        for agent, (since, intent) in self.pending.items():
            # Somewhat earlier than the simulation, which ends the episode as a deadlock.
            if now - since > 0.9 * self._world.scenario.stall_seconds:
                raise ConformanceError(
                    "delivers once", f"agent {agent}'s {intent} has had no outcome for {now - since:g} seconds"
                )
        return finished

    def cancel(self, agent: int) -> None:
        """From now on no outcome may come of the action."""
        self._unchanged("cancel", lambda: self._body.cancel(agent))
        self.pending.pop(agent, None)
        self._stopped[agent] = "cancel"

    def leave(self, agent: int) -> None:
        """From now on no outcome may come of the agent."""
        self._unchanged("leave", lambda: self._body.leave(agent))
        self.pending.pop(agent, None)
        self._stopped[agent] = "leave"

    def rows(self) -> Iterable[TraceRow]:
        """Rows that fit their table, handed over once."""
        rows = self._taken("rows", self._unchanged("rows", self._body.rows))
        for table, row in rows:
            if table not in ("poses", "controls"):
                raise ConformanceError("rows", f"a row for table {table!r}, expected 'poses' or 'controls'")
            kinds = list(TABLES[table].items())[1:]  # the simulation puts the episode in front
            if len(row) != len(kinds):
                raise ConformanceError("rows", f"{len(row)} values for the {len(kinds)} columns of {table}: {row}")
            for value, (name, kind) in zip(row, kinds, strict=True):
                if not isinstance(value, _TYPES[kind]):
                    raise ConformanceError("rows", f"{table}.{name} is {value!r}, expected {kind}")
        if list(self._body.rows()):
            raise ConformanceError("rows", "rows that were handed over are handed over again")
        return rows

    def close(self) -> None:
        """What was handed over must be until now what it was."""
        for what, given, copy in self._given:
            if not self._vandal and list(given) != copy:
                raise ConformanceError("hands over", f"what {what} gave has changed since: {copy} is now {given}")
        self._given.clear()
        try:
            self._body.close()
        except Exception as error:
            raise ConformanceError("close", f"close raises {error!r}") from error

    # -- what the checks of single calls need --------------------------------------------------------------------------

    def run(self, seconds: float) -> list[Finished]:
        """Advances a ticking backend."""
        found: list[Finished] = []
        if self.tick is not None:
            for _ in range(math.ceil(seconds / self.tick)):
                found += self.advance(self.now + self.tick)
        return found

    def outcome_of(self, agent: int, intent: Intent) -> Outcome:
        """Starts an action and waits for its outcome, for about as long as an episode would."""
        done = self.start(agent, intent, self.now)
        if done is not None:
            return done.outcome
        while True:  # `advance` loses its patience with an action that does not end
            for finished in self.run(self.tick or 0.0):
                if finished.agent == agent:
                    return finished.outcome

    # -- looking at answers --------------------------------------------------------------------------------------------

    def _unchanged(self, method: str, call: Callable[[], Any]) -> Any:
        """The call's answer; the world must be after it what it was before."""
        before = world_state(self._world)
        try:
            answer = call()
        except Exception as error:
            promise = _PROMISES.get(method, "failures are outcomes")
            raise ConformanceError(promise, f"{method} raises {error!r}") from error
        after = world_state(self._world)
        for name, value in before.items():
            if after[name] != value:
                raise ConformanceError("reads only", f"{method} has changed world.{name} from {value} to {after[name]}")
        return answer

    def _taken(self, what: str, given: Iterable[Any]) -> list[Any]:
        """A copy of what was given; kept so that a later change can be seen."""
        copy = list(given)
        if self._vandal:
            if isinstance(given, list):
                given.clear()
        elif isinstance(given, list | tuple):
            self._given.append((what, given, list(copy)))
        return copy

    def _what_is_wrong_with(self, agent: int, intent: Intent) -> bool:
        """Whether an intent speaks of what does not exist, so that no footprint can be asked for."""
        near = self._world.topology.neighbours[self._world.agent_node[agent]]
        if isinstance(intent, Push) and not 0 <= intent.box < len(self._world.box_node):
            return True
        return isinstance(intent, Wait) or intent.node not in near

    def _examine(self, agent: int, intent: Intent, outcome: Outcome) -> None:
        """Whether an outcome is possible in the world as it is."""
        world, topology = self._world, self._world.topology
        at = world.agent_node[agent]

        def wrong(why: str) -> ConformanceError:
            return ConformanceError("legal outcomes", f"{why} (agent {agent} on node {at}, {intent}: {outcome})")

        if not isinstance(outcome, Outcome):
            raise wrong(f"a {type(outcome).__name__}, expected an Outcome")
        if outcome.status not in ("arrived", "blocked", "failed"):
            raise wrong(f"no such status {outcome.status!r}")
        if outcome.status != "arrived" and not outcome.reason:
            raise wrong(f"{outcome.status} without a reason")
        if not isinstance(outcome.lost, bool):
            raise wrong("lost is neither True nor False")
        if outcome.node != at and outcome.node not in topology.neighbours[at]:
            raise wrong(f"node {outcome.node} is not next to node {at}")
        if world.occupant[outcome.node] not in (-1, agent):
            raise wrong(f"node {outcome.node} is occupied by agent {world.occupant[outcome.node]}")
        for place in outcome.keeps:
            if not 0 <= place < len(topology):
                raise wrong(f"keeps node {place}, which does not exist")
        moved: dict[int, int] = {}
        for box, node, *_ in outcome.boxes:
            if not 0 <= box < len(world.box_node):
                raise wrong(f"box {box} does not exist")
            if box in moved:
                raise wrong(f"box {box} is listed twice")
            moved[box] = node
            if not 0 <= node < len(topology):
                raise wrong(f"box {box} is on node {node}, which does not exist")
            stood = world.box_node[box]
            if node != stood and node not in topology.neighbours[stood]:
                raise wrong(f"box {box} has jumped from node {stood} to {node}, which are no neighbours")
        if outcome.status == "arrived":
            self._examine_arrival(agent, intent, outcome, moved, wrong)

    def _examine_arrival(
        self, agent: int, intent: Intent, outcome: Outcome, moved: dict[int, int],
        wrong: Callable[[str], ConformanceError],
    ) -> None:  # fmt: skip
        if isinstance(intent, Wait):
            raise wrong("a wait has arrived")
        at = self._world.agent_node[agent]
        if isinstance(intent, Push) and self._world.box_node[intent.box] != intent.node:
            if moved.get(intent.box) != intent.node:
                raise wrong(f"the push has arrived, but box {intent.box} is not on node {intent.node}")
            if outcome.node not in (at, intent.node):
                raise wrong(f"the pusher is on node {outcome.node}, neither behind its box nor with it")
        elif outcome.node != intent.node:
            raise wrong(f"it has arrived, but on node {outcome.node}")
