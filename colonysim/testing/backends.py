"""Does a backend keep the promises of the protocol? A check for those who write one."""

from __future__ import annotations

import math
import os
import threading
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from colonysim.backends.protocol import Done, Finished
from colonysim.randomness import Streams
from colonysim.simulation import simulate
from colonysim.testing.promises import ConformanceError, Recorder, global_randomness, same_traces, world_state
from colonysim.testing.worlds import random_scenario
from colonysim.trace.schema import TABLES
from colonysim.world.intents import Outcome, Push, Travel, Wait
from colonysim.world.state import World

if TYPE_CHECKING:
    from colonysim.backends.protocol import Backend, TraceRow
    from colonysim.world.intents import Intent
    from colonysim.world.scenario import Scenario
    from colonysim.world.state import Place

__all__ = ["check_backend"]

Factory: TypeAlias = "Callable[[], Backend]"

WORLDS = (11, 36, 47, 50)
"""Random worlds in which boxes are pushed, with slopes, forbidden pushes and two or three agents."""

_PROMISES = {
    "reset": "reset", "feasible": "feasible", "footprint": "footprint", "cancel": "cancel", "leave": "leave",
    "rows": "rows",
}  # fmt: skip
"""What an exception in a method breaks; in any other, that failures are outcomes."""

_TYPES: dict[str, type | tuple[type, ...]] = {
    "int": int, "float": (float, int), "text": str, "bool": bool, "ints": Sequence, "floats": Sequence,
}  # fmt: skip


def check_backend(
    factory: Factory, *, scenarios: Sequence[Scenario] | None = None, episodes: int = 3, seed: int = 1
) -> None:
    """Runs whole episodes on a backend, and asks it for what it must refuse.

    Args:
        factory: Makes a new backend; called several times.
        scenarios: Where to try it; by default a few small random ones. A slow backend may be given fewer.
        episodes: How many episodes each run has; at least two, since some faults need a second one.
        seed: Seed of all runs.

    Raises:
        ConformanceError: The first broken promise: "attributes", "determinism", "isolation", "reset", "reads only",
            "hands over", "legal outcomes", "failures are outcomes", "footprint", "feasible", "cancel", "leave",
            "delivers once", "rows", "randomness" or "close"; the message says what happened.

    Example:
        ```python
        from colonysim.testing import check_backend

        def test_my_backend_keeps_its_promises():
            check_backend(MyBackend)
        ```
    """
    if episodes < 2:
        raise ValueError("episodes must be at least 2: some faults only show in the second")
    if scenarios is None:
        scenarios = [random_scenario(number, max_agents=3) for number in WORLDS]
    for scenario in scenarios:
        _check_episodes(factory, scenario, episodes, seed)
        _check_refusals(factory, scenario, seed)
        _check_cancel_and_leave(factory, scenario, seed)
    _check_reset(factory, scenarios, episodes, seed)
    _check_close(factory, scenarios[0], seed)


# -- whole episodes ----------------------------------------------------------------------------------------------------


def _run(body: Backend, scenario: Scenario, episodes: int, seed: int, policy: str = "random") -> Recorder:
    rows = Recorder()
    for _ in simulate(scenario, backend=body, policy=policy, episodes=episodes, seed=seed, sink=rows):
        pass
    return rows


def _check_episodes(factory: Factory, scenario: Scenario, episodes: int, seed: int) -> None:
    for policy in ("random", "colony"):
        with global_randomness(1):
            first = _run(_Watched(factory()), scenario, episodes, seed, policy)
        with global_randomness(1):
            again = _run(_Watched(factory()), scenario, episodes, seed, policy)
        same_traces("determinism", "two runs of one seed differ", first, again)
    with global_randomness(2):
        reseeded = _run(factory(), scenario, episodes, seed, policy)
    same_traces("randomness", "the seed of the `random` module makes a difference", first, reseeded)
    asked = _run(_Watched(factory(), curious=True), scenario, episodes, seed, policy)
    same_traces("feasible", "asking for feasibility and footprints more often makes a difference", first, asked)
    what = "a caller that empties the lists it was given makes a difference"
    try:
        emptied = _run(_Watched(factory(), vandal=True), scenario, episodes, seed, policy)
    except ConformanceError as error:
        raise ConformanceError("hands over", f"{what}: {error}") from error
    same_traces("hands over", what, first, emptied)
    _check_isolation(factory, scenario, episodes, seed, first, policy)


def _check_isolation(
    factory: Factory, scenario: Scenario, episodes: int, seed: int, alone: Recorder, policy: str
) -> None:
    """Two instances take turns, event by event; each must do what it does alone."""
    sinks = [Recorder(), Recorder()]
    seeds = (seed, seed + 1)
    try:
        runs = [
            simulate(scenario, backend=factory(), policy=policy, episodes=episodes, seed=own, sink=sink)
            for own, sink in zip(seeds, sinks, strict=True)
        ]
        while runs:
            runs = [run for run in runs if next(run, None) is not None]
    except ConformanceError:
        raise
    except Exception as error:
        raise ConformanceError("isolation", f"two instances side by side: {error!r}") from error
    same_traces("isolation", "another instance running beside it makes a difference", alone, sinks[0])


def _check_reset(factory: Factory, scenarios: Sequence[Scenario], episodes: int, seed: int) -> None:
    """One instance used for several runs; each must be as with a new one."""
    used = factory()
    for scenario in scenarios:
        fresh = _run(factory(), scenario, episodes, seed)
        for _ in range(2):
            try:
                same_traces("reset", "a used instance behaves otherwise than a new one", fresh,
                            _run(used, scenario, episodes, seed))  # fmt: skip
            except ConformanceError:
                raise
            except Exception as error:
                raise ConformanceError("reset", f"closed and reset again, it fails: {error!r}") from error


# -- single calls ------------------------------------------------------------------------------------------------------


def _refusable(world: World, agent: int) -> list[tuple[str, Intent]]:
    """Intents that the rules of the place do not allow."""
    topology, at = world.topology, world.agent_node[agent]
    near, size, boxes = topology.neighbours[at], len(topology), len(world.box_node)
    far = next((i for i in range(size) if i != at and i not in near), None)
    wrong: list[tuple[str, Intent]] = [
        ("a wait", Wait()),
        ("travel to its own node", Travel(at)),
        ("travel to a node that does not exist", Travel(size)),
        ("travel to node -1", Travel(-1)),
        ("a push of a box that does not exist", Push(boxes, near[0], -1)),
        ("a push of box -1", Push(-1, near[0], -1)),
    ]
    if far is not None:
        wrong.append(("travel to a node that is no neighbour", Travel(far)))
    wrong += [("travel over a step", Travel(j)) for j in near if not world.passable(world.level(agent), at, j)]
    for box, stands in enumerate(world.box_node):
        if stands != at:
            wrong += [("a push of a box that is elsewhere", Push(box, j, -1)) for j in near if j != stands][:1]
            if stands not in near:
                wrong.append(("taking hold of a box that is no neighbour", Push(box, stands, -1)))
            elif not world.graspable(agent, box, world.level(agent), at):
                wrong.append(("taking hold of a box on another level", Push(box, stands, -1)))
    return wrong


def _check_refusals(factory: Factory, scenario: Scenario, seed: int) -> None:
    body, world = _Watched(factory()), World(scenario)
    body.reset(world, Streams(seed))
    try:
        for agent in range(len(world.agent_node)):
            for what, intent in _refusable(world, agent):
                body.footprint(agent, intent)
                if body.outcome_of(agent, intent).status == "arrived":
                    raise ConformanceError("failures are outcomes", f"{what} ({intent}) is said to have arrived")
    finally:
        body.close()


def _check_cancel_and_leave(factory: Factory, scenario: Scenario, seed: int) -> None:
    """An action that was cancelled, or whose agent has left, gives no outcome; others do."""
    body, world = _Watched(factory()), World(scenario)
    body.reset(world, Streams(seed))
    try:
        for agent in range(len(world.agent_node)):
            body.cancel(agent)  # with nothing pending
            if _begin_a_move(body, world, agent):
                body.cancel(agent)
                body.run(10.0 * body.edge_seconds)
            _finish_a_move(body, world, agent)
        _begin_a_move(body, world, 0)
        body.leave(0)
        world.leave(0)
        body.run(10.0 * body.edge_seconds)
        for agent in range(1, len(world.agent_node)):
            _finish_a_move(body, world, agent)
    finally:
        body.close()


def _begin_a_move(body: _Watched, world: World, agent: int) -> bool:
    """Whether an action is now pending."""
    exits = world.exits(agent)
    if not exits or body.start(agent, Travel(exits[0]), body.now) is not None:
        return False
    body.run(2.0 * (body.tick or 0.0))
    return agent in body.pending


def _finish_a_move(body: _Watched, world: World, agent: int) -> None:
    exits = world.exits(agent)
    if exits:
        move = Travel(exits[0])
        world.apply(agent, move, body.outcome_of(agent, move))


def _resources() -> tuple[int, int]:
    """Threads and open files of this process."""
    files = Path("/proc/self/fd")
    return threading.active_count(), len(os.listdir(files)) if files.is_dir() else 0  # noqa: PTH208


def _check_close(factory: Factory, scenario: Scenario, seed: int) -> None:
    def once() -> None:
        body = factory()
        body.close()  # before any reset
        body.reset(World(scenario), Streams(seed))
        body.close()
        body.close()

    try:
        once()
        before = _resources()
        for _ in range(3):
            once()
    except Exception as error:
        raise ConformanceError("close", f"closing, twice or before a reset, raises {error!r}") from error
    after = _resources()
    if after[0] > before[0] or after[1] > before[1]:
        raise ConformanceError(
            "close", f"threads and open files go from {before} to {after} when three instances are made and closed"
        )


# -- a backend under observation ---------------------------------------------------------------------------------------


class _Watched:
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
        if not (isinstance(self.name, str) and self.name):
            raise ConformanceError("attributes", f"name is {self.name!r}, expected some text")
        if self.tick is not None and not (isinstance(self.tick, float | int) and 0.0 < self.tick < math.inf):
            raise ConformanceError("attributes", f"tick is {self.tick!r}, expected None or seconds above 0")

    def reset(self, world: World, streams: Streams) -> None:
        self._world = world
        self.pending.clear()
        self._stopped.clear()
        self._given.clear()
        self.now = 0.0
        self._unchanged("reset", lambda: self._body.reset(world, streams))
        self.edge_seconds = self._body.edge_seconds
        if not (isinstance(self.edge_seconds, float | int) and 0.0 < self.edge_seconds < math.inf):
            raise ConformanceError("attributes", f"edge_seconds is {self.edge_seconds!r} after reset, not above 0")

    def feasible(self, agent: int, box: int, targets: Sequence[int]) -> Sequence[float]:
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

    def footprint(self, agent: int, intent: Intent) -> frozenset[Place]:
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
        self._unchanged("cancel", lambda: self._body.cancel(agent))
        self.pending.pop(agent, None)
        self._stopped[agent] = "cancel"

    def leave(self, agent: int) -> None:
        self._unchanged("leave", lambda: self._body.leave(agent))
        self.pending.pop(agent, None)
        self._stopped[agent] = "leave"

    def rows(self) -> Iterable[TraceRow]:
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
