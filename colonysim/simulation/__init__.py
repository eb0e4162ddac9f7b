"""The discrete-event simulation, the only place that knows SimPy: agents in their own time, episode after episode."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from colonysim.arguments import as_seed, whole
from colonysim.errors import ColonysimError
from colonysim.geometry.robot_choice import with_robot
from colonysim.pheromones.field import Write
from colonysim.plugins import make_backend, make_policy
from colonysim.policies.view import LocalView
from colonysim.randomness import Streams
from colonysim.simulation.episode import Episode
from colonysim.simulation.foreign import checked_backend, checked_fields, checked_policy
from colonysim.suggest import nearest
from colonysim.trace.rows import Rows
from colonysim.trace.schema import EVENT_KINDS
from colonysim.trace.writer import TraceWriter
from colonysim.world.state import World

if TYPE_CHECKING:
    from colonysim.backends.protocol import Backend
    from colonysim.pheromones.field import Field
    from colonysim.policies.policy import Policy
    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.schema import Event, Frame, Sink

__all__ = ["MODES", "mode_of", "simulate"]

MODES = ("asynchronous", "synchronous")


def simulate(
    scenario: Scenario,
    *,
    backend: str | Backend = "nodeworld",
    policy: str | Policy | Callable[[Scenario], Policy] | None = None,
    mode: str | None = None,
    episodes: int | None = None,
    seed: int = 0,
    sink: Sink | None = None,
    initial: Mapping[str, Iterable[Frame]] | None = None,
    decisions: bool = True,
    backend_options: Mapping[str, Any] | None = None,
    kinds: Collection[str] | None = None,
) -> Iterator[Event]:
    """Runs a colony and yields what happens, as it happens.

    Pheromones and the agents' own memories persist over the episodes, everything else starts anew.

    Args:
        scenario: The colony.
        backend: Name of a backend, or one.
        policy: Name of a policy, a factory, or a policy; the scenario's own if None.
        mode: "asynchronous" or "synchronous"; the scenario's own if None.
        episodes: How many; the scenario's own number if None.
        seed: Together with the scenario it makes the run; a whole number from 0.
        sink: Takes the rows of all tables of the trace.
        initial: Pheromones to start with, by field name: the key frames of another run's episode, as they would
            have been at the start of its next one.
        decisions: Whether the sink also gets the decisions.
        backend_options: Keyword arguments for a backend given by name.
        kinds: Kinds of the events to yield; None for all. A large world runs faster if nobody asks for "end".

    Yields:
        Events in the order of simulated time. An "episode" event closes each episode.

    Raises:
        ColonysimError: Something that the caller asked for does not exist or does not fit.
    """
    scenario = with_robot(scenario)
    mode = mode_of(scenario, mode)
    count = scenario.episodes if episodes is None else whole("episodes", episodes)
    streams = Streams(as_seed(seed))
    if isinstance(kinds, str):
        raise ColonysimError(f"kinds is {kinds!r}, expected a list of kinds, such as [{kinds!r}]")
    for kind in () if kinds is None else kinds:
        if kind not in EVENT_KINDS:
            raise ColonysimError(f"kinds: no events of kind {kind!r}; {nearest(str(kind), EVENT_KINDS)}")
    world, rows = World(scenario), Rows(scenario, sink, decisions, kinds)
    chosen = checked_policy(make_policy(policy, scenario), world, rows)
    fields = checked_fields(chosen, world, rows)
    if isinstance(sink, TraceWriter):
        sink.describe({name: bool(field.by_box) for name, field in fields.items()})
    if initial:
        _load_fields(world, fields, initial)
    made = make_backend(backend, backend_options, scenario)
    body = checked_backend(made, world, rows, recording=sink is not None)
    memories: list[Any] = [None] * len(scenario.agents)
    episode: Episode | None = None
    try:
        views = [LocalView(world, fields, body, agent) for agent in range(len(scenario.agents))]
        episode = Episode(world, fields, body, chosen, views, rows)
        for number in range(1, count + 1):
            own = streams.within(f"episode/{number}")
            world.reset()
            body.reset(world, own)
            memories = [chosen.begin(agent, memory) for agent, memory in enumerate(memories)]
            yield from episode.run(number, memories, own, synchronous=mode == "synchronous")
            for field in fields.values():
                field.end_episode()
    except BaseException:
        with suppress(Exception):  # what went wrong first is what counts
            body.close()
        raise
    else:
        body.close()
    finally:
        if episode is not None:
            episode.close()


def mode_of(scenario: Scenario, mode: str | None) -> str:
    """The mode that is asked for, or the scenario's own.

    Raises:
        ColonysimError: There is no such mode.
    """
    chosen = scenario.mode if mode is None else mode
    if chosen not in MODES:
        raise ColonysimError(f"no mode {chosen!r}; {nearest(str(chosen), MODES)}")
    return chosen


def _load_fields(world: World, fields: Mapping[str, Field], initial: Mapping[str, Iterable[Frame]]) -> None:
    """Puts another run's key frames into the fields; numbers of the file become indices again."""
    index = world.topology.index
    if not fields.keys() & initial.keys():
        names = ", ".join(fields) or "none"
        raise ColonysimError(
            f"pheromones {', '.join(initial)} to start with: this policy would not see them, its own are: {names}"
        )
    hole_key = {world.topology.ids[hole.node]: key for key, hole in enumerate(world.scenario.holes)}
    for name, frames in initial.items():
        field = fields.get(name)
        if field is None:
            continue
        writes = []
        for frame in frames:
            node = frame.node if field.by_box else index.get(frame.node, -1)
            key = hole_key.get(frame.key, -1) if frame.key >= 0 else -1
            if node < 0 or (frame.key >= 0 and key < 0):
                raise ColonysimError(f"the other run's {name} speaks of node {frame.node}; this map has no such node")
            if field.by_box and node >= len(world.scenario.boxes):
                raise ColonysimError(f"the other run's {name} speaks of box {node}; there is no such box here")
            if not math.isfinite(frame.value):
                raise ColonysimError(
                    f"the other run's {name} holds {frame.value} at {frame.node}, expected a finite number"
                )
            writes.append(Write(node, key, frame.value))
        field.load(writes)
        # The frames were taken before the end of their episode did its work.
        field.end_episode()
