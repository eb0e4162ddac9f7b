"""Agents that were not at the goal when their episode ended, and what each did last."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

from colonysim.errors import TraceError
from colonysim.trace.failures import UNTOLD
from colonysim.trace.replay import follow, with_boxes

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.reader import Run
    from colonysim.trace.schema import Event
    from colonysim.world.state import World

__all__ = ["Stranded", "stranded"]

State: TypeAlias = Literal["lost", "steps used up", "waiting", "acting"]
RECENT = 12
"""Attempts that say on which nodes an agent was at last; its last stretch goes back as far as it kept to them."""
NAMED = 6
"""Most nodes that a sentence names."""


@dataclass(frozen=True, slots=True)
class Stranded:
    """An agent that did not reach the goal in an episode. Times are simulated seconds of the episode.

    Attributes:
        episode: Counted from 1.
        agent: Which agent.
        ended: How the episode ended: "max_steps", "deadlock", ...
        state: What the agent was at the end: lost, with its steps used up, waiting or still acting.
        node: Where it was at the end.
        waits_for: The node it was waiting for at the end, -1 for none.
        since: Start of its last stretch, in which it kept to `nodes`.
        until: Time of its last event; if it was waiting at the end, of that wait's beginning, however often renewed.
        nodes: The nodes of the last stretch, in the order in which they were first met.
        attempts: How often it tried each action in that stretch.
        failures: How many of these attempts did not arrive, by reason, the most frequent first.
        waited: Seconds of the last stretch that it waited before it acted again, the wait at the end left out.
        reason: Why its very last attempt did not arrive; empty if it did.
        way_open: Whether the goal could be reached from there on foot, other agents aside.
    """

    episode: int
    agent: int
    ended: str
    state: State
    node: int
    waits_for: int
    since: float
    until: float
    nodes: tuple[int, ...]
    attempts: dict[str, int]
    failures: dict[str, int]
    waited: float
    reason: str
    way_open: bool

    @property
    def why(self) -> str:
        """What kept it from the goal, as one sentence."""
        if self.state == "lost":
            return f"lost at node {self.node}: {self.reason or UNTOLD}"
        sentence = f"{self.state}, from {self.since:.1f} s on {self._place}: {self._tried}"
        if self.waited > 0:
            sentence += f", waited {self.waited:.1f} s in between"
        if self.state == "waiting":
            own = self.waits_for in (-1, self.node)
            aim = " for a change around it" if own else f" for a change at node {self.waits_for}"
            sentence += f"; at node {self.node} it waits{aim} from {self.until:.1f} s"
        return f"{sentence}; the goal could {'' if self.way_open else 'not '}be reached on foot from there"

    @property
    def _place(self) -> str:
        if len(self.nodes) > NAMED:
            return f"{len(self.nodes)} nodes"
        return ("node " if len(self.nodes) == 1 else "nodes ") + ", ".join(str(node) for node in self.nodes)

    @property
    def _tried(self) -> str:
        if not self.attempts:
            return "nothing tried"
        tried = ", ".join(f"{action} {count}" for action, count in self.attempts.items())
        if not self.failures:
            return f"{tried}, all arrived"
        return f"{tried}, not arrived " + ", ".join(f"{count} ({reason})" for reason, count in self.failures.items())


def stranded(run: Run, episodes: Collection[int] | None = None) -> list[Stranded]:
    """The agents that were not at the goal when an episode of a run ended, by episode and agent.

    Episodes that were interrupted or are under way have none, and neither have single pushes.

    Args:
        run: The run.
        episodes: Only these.

    Raises:
        TraceError: A damaged part, a place that the scenario does not have, or no trace.
        ScenarioError: The scenario of the run is wrong.
    """
    found: list[Stranded] = []
    if run.manifest.get("scenario") is None:
        return found
    run.check_places("events")
    events: list[Event] = []
    for event in run.events():
        if episodes is not None and event.episode not in episodes:
            continue
        if event.kind != "episode":
            events.append(event)
            continue
        if event.status != "interrupted":
            found += _of_episode(run.scenario, events, event.status)
        events = []
    return found


def _of_episode(scenario: Scenario, events: list[Event], ended: str) -> Iterator[Stranded]:
    ways = follow(scenario, events)
    absent = sorted(set(ways.agents) - ways.gone)
    if not absent:
        return
    world = with_boxes(scenario, ways.boxes_at_end(), ways.changed)
    events_of: defaultdict[int, list[Event]] = defaultdict(list)
    for event in events:
        events_of[event.agent].append(event)
    for agent in absent:
        own = events_of[agent]
        if not own or not all({event.node, event.now_at} <= scenario.topology.index.keys() for event in own):
            raise TraceError(f"events: episode {events[0].episode} does not tell where agent {agent} is")
        yield _last_stretch(scenario, world, own, ended)


def _way_open(world: World, last: Event, node: int) -> bool:
    """Whether an agent whose last attempt this was can get from a node (an index) to the goal on foot."""
    level = world.surface[node]
    if last.action in ("take", "push") and world.top[node] == last.box:
        level = world.box_base[last.box]
    reached = {node} | {j for j, _ in world.reachable_neighbours(level, node)}
    ahead = list(reached - {node})
    while ahead:
        for j, _ in world.reachable_neighbours(world.surface[i := ahead.pop()], i):
            if j not in reached:
                reached.add(j)
                ahead.append(j)
    return world.goal in reached


def _last_stretch(scenario: Scenario, world: World, events: list[Event], ended: str) -> Stranded:
    """What an agent did last: as far back as it kept to the nodes of its last attempts."""
    ends = [event for event in events if event.kind == "end"]
    first = len(ends)
    nodes: dict[int, None] = {}
    for event in ends[-RECENT:]:
        nodes |= dict.fromkeys((event.node, event.now_at))
    while first > 0 and ends[first - 1].node in nodes and ends[first - 1].now_at in nodes:
        first -= 1
    stretch, last = ends[first:], events[-1]
    since = stretch[0].began if stretch else events[0].time
    node = last.now_at if last.kind == "end" else last.node
    return Stranded(
        last.episode,
        last.agent,
        ended,
        _state(events),
        node,
        last.target if last.kind == "wait" else -1,
        since,
        _since_when(events),
        tuple(nodes) or (last.node,),
        dict(Counter(event.action for event in stretch).most_common()),
        dict(Counter(event.reason or UNTOLD for event in stretch if event.status != "arrived").most_common()),
        _waited(events, since),
        ends[-1].reason if ends else "",
        _way_open(world, ends[-1] if ends else last, scenario.topology.index[node]),
    )


def _since_when(events: list[Event]) -> float:
    """The time of an agent's last event; of several waits in a row, that of the first."""
    last = len(events) - 1
    while last > 0 and events[last].kind == events[last - 1].kind == "wait":
        last -= 1
    return events[last].time


def _state(events: list[Event]) -> State:
    kinds = {event.kind for event in events}
    if "lost" in kinds:
        return "lost"
    if "spent" in kinds:
        return "steps used up"
    return "waiting" if events[-1].kind == "wait" else "acting"


def _waited(events: list[Event], since: float) -> float:
    """Seconds from each wait's beginning to that of the next action."""
    waited, begun = 0.0, None
    for event in events:
        if event.kind == "wait" and begun is None:
            begun = max(event.time, since)
        elif event.kind == "end" and begun is not None:
            waited += max(0.0, event.began - begun)
            begun = None
    return waited
