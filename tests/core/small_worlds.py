"""Tiny places made by hand, and the few stand-ins that tests of the core need."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from colonysim.backends.protocol import Done, Finished, TraceRow
from colonysim.pheromones import Visit, Write
from colonysim.policies.policy import Choice
from colonysim.policies.view import LocalView
from colonysim.scenario.scenario import BoxStart, Hole, Scenario, Timing
from colonysim.simulation import simulate
from colonysim.trace.schema import EpisodeResult, Event
from colonysim.world.intents import BoxPlace, Intent, Outcome, Push, Travel
from colonysim.world.state import World
from colonysim.world.topology import Topology


def place(
    points: Sequence[tuple[float, ...]],
    edges: Iterable[tuple[int, int]],
    *,
    goal: int = 0,
    agents: Sequence[int] = (),
    holes: Mapping[int, tuple[float, float]] | None = None,
    boxes: Sequence[tuple[int, float]] = (),
    slopes: Iterable[tuple[int, int]] = (),
    **fields: Any,
) -> Scenario:
    """A scenario without the checks of a file: (x, y) or (x, y, z) per node, holes as {node: (floor, rim)}."""
    holes = holes or {}
    heights = [point[2] if len(point) > 2 else 0.0 for point in points]
    for node, (floor, _) in holes.items():
        heights[node] = floor
    positions = [(p[0], p[1], z) for p, z in zip(points, heights, strict=True)]
    fields.setdefault("timing", Timing(jitter=0.0))
    return Scenario(
        name="tiny",
        topology=Topology.build(range(len(points)), positions, edges, slopes),
        holes=tuple(Hole(node, floor, rim) for node, (floor, rim) in holes.items()),
        boxes=tuple(BoxStart(node, height) for node, height in boxes),
        agents=tuple(agents),
        goal=goal,
        **fields,
    )


def line(count: int, **fields: Any) -> Scenario:
    """Nodes 0, 1, 2, ... one unit apart in a row."""
    return place([(float(i), 0.0) for i in range(count)], [(i, i + 1) for i in range(count - 1)], **fields)


def stand(world: World, agent: int, node: int, boxes: tuple[BoxPlace, ...] = ()) -> None:
    """Puts an agent on a node, as the outcome of a step does."""
    world.apply(agent, Travel(node), Outcome("arrived", node, boxes))


def push(world: World, agent: int, box: int, node: int, hole: int = -1) -> None:
    """Takes hold of a box or pushes it, as the node world does."""
    from colonysim.backends.nodeworld import NodeWorld
    from colonysim.randomness import Streams

    body = NodeWorld()
    body.reset(world, Streams(0))
    intent = Push(box, node, hole)
    world.claim(agent, box)
    done = body.start(agent, intent, 0.0)
    assert done is not None and done.outcome.status == "arrived", done
    world.apply(agent, intent, done.outcome)


def visit(world: World, node: int, moment: Any = "arrive", agent: int = 0, **more: int) -> Visit:
    """An agent on a node at a moment, at the height of the node's surface."""
    return Visit(moment, agent, node, world.surface[node], **more)


class Rows:
    """A sink that keeps every row in lists."""

    def __init__(self) -> None:
        self.tables: dict[str, list[Any]] = {}

    def write(self, table: str, row: tuple[object, ...]) -> None:
        self.tables.setdefault(table, []).append(row)

    @property
    def episodes(self) -> list[EpisodeResult]:
        return self.tables.get("episodes", [])


class Script:
    """A policy that does what a function of (agent, view, how often it was asked) says."""

    name = "script"

    def __init__(self, act: Callable[[int, LocalView, int], Intent]) -> None:
        self.act = act

    def fields(self, world: World) -> Mapping[str, Any]:
        return {}

    def begin(self, agent: int, memory: Any) -> int:
        return 0

    def decide(self, view: LocalView, memory: int, random: Any) -> Choice:
        return Choice(self.act(view.agent, view, memory), memory + 1)


class Scripted:
    """A backend whose answer to each action is whatever a function of (agent, intent, now) says."""

    name = "scripted"
    tick: float | None = None
    edge_seconds = 1.0

    def __init__(self, answer: Callable[[int, Any, float], Done | None]) -> None:
        self.answer = answer
        self.cancelled: list[int] = []
        self.left: list[int] = []
        self.closed = 0

    def reset(self, world: World, streams: Any) -> None:
        self.world = world

    def feasible(self, agent: int, box: int, targets: Sequence[int]) -> Sequence[float]:
        return [1.0] * len(targets)

    def footprint(self, agent: int, intent: Any) -> frozenset[Any]:
        return frozenset((intent.node,))

    def start(self, agent: int, intent: Any, now: float) -> Done | None:
        return self.answer(agent, intent, now)

    def advance(self, now: float) -> Sequence[Finished]:
        return ()

    def cancel(self, agent: int) -> None:
        self.cancelled.append(agent)

    def leave(self, agent: int) -> None:
        self.left.append(agent)

    def rows(self) -> Iterable[TraceRow]:
        return ()

    def close(self) -> None:
        self.closed += 1


class Wrapped:
    """Another's part that does what one of ours does: it is called by its protocol, and its answers are looked at."""

    def __init__(self, part: Any) -> None:
        self._part, self.name = part, part.name

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._part, name)


class Scent:
    """A field A that is 1 at node 1 from the start on; agents leave nothing."""

    name, by_box = "A", False

    def __init__(self, world: World) -> None:
        pass

    def at(self, node: int, key: int = -1) -> float:
        return 1.0 if node == 1 else 0.0

    def keys(self, node: int) -> Sequence[int]:
        return ()

    def deposit(self, visit: Visit) -> Iterable[Write]:
        return ()

    def end_episode(self) -> None:
        pass

    def frame(self) -> Iterable[Write]:
        return [Write(1, -1, 1.0)]

    def load(self, frame: Iterable[Write]) -> None:
        pass


SCENT = f"{__name__}:Scent"
"""As scenarios name it."""


def play(scenario: Scenario, **options: Any) -> tuple[list[Event], Rows]:
    """Runs a scenario; its events, and the rows of all tables."""
    rows = Rows()
    return list(simulate(scenario, sink=rows, **options)), rows
