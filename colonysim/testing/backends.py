"""Does a backend keep the promises of the protocol? A check for those who write one."""

from __future__ import annotations

import os
import threading
import warnings
from array import array
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from colonysim.arguments import as_seed, whole
from colonysim.errors import ColonysimWarning
from colonysim.plugins import lacking
from colonysim.randomness import Streams
from colonysim.simulation import Colony, simulate
from colonysim.states import says
from colonysim.testing.promises import ConformanceError, Recorder, global_randomness, same_futures, same_traces
from colonysim.testing.watched import WatchedBackend
from colonysim.testing.worlds import random_scenario
from colonysim.world.intents import Push, Travel, Wait
from colonysim.world.state import World

if TYPE_CHECKING:
    from colonysim.backends.protocol import Backend
    from colonysim.scenario.scenario import Scenario
    from colonysim.world.intents import Intent

__all__ = ["check_backend"]

Factory: TypeAlias = "Callable[[], Backend]"

WORLDS = (11, 36, 47, 65)
"""Random worlds in which boxes are pushed, with slopes, forbidden pushes and two or three agents."""


def check_backend(
    factory: Factory, *, scenarios: Sequence[Scenario] | None = None, episodes: int = 3, seed: int = 1
) -> None:
    """Runs whole episodes on a backend, and asks it for what it must refuse.

    Args:
        factory: Makes a new backend; called several times.
        scenarios: Where to try it; by default four small random ones. Each is played some thirty times `episodes`: give
            a backend that takes seconds an episode one scenario of a few steps (`max_steps`).
        episodes: How many episodes each run has; at least two, since some faults need a second one.
        seed: Seed of all runs.

    Raises:
        ConformanceError: The first broken promise: "attributes", "determinism", "isolation", "reset", "reads only",
            "hands over", "legal outcomes", "failures are outcomes", "footprint", "feasible", "cancel", "leave",
            "delivers once", "rows", "randomness", "saving" (of one that has `state` and `restore`, or says that it is
            `replayable`) or "close"; the message says what happened.

    Warns:
        ColonysimWarning: No colony on this backend can be saved.

    Example:
        ```python
        from colonysim.testing import check_backend

        def test_my_backend_keeps_its_promises():
            check_backend(MyBackend)
        ```
    """
    episodes, seed = whole("episodes", episodes, 2), as_seed(seed)
    if missing := lacking("backends", factory()):
        raise ConformanceError("attributes", f"what the factory makes {missing}")
    if scenarios is None:
        scenarios = [random_scenario(number, max_agents=3) for number in WORLDS]
    for scenario in scenarios:
        _check_episodes(factory, scenario, episodes, seed)
        _check_refusals(factory, scenario, seed)
        _check_cancel_and_leave(factory, scenario, seed)
    _check_reset(factory, scenarios, episodes, seed)
    _check_close(factory, scenarios[0], seed)
    for scenario in scenarios:
        _check_saving(factory, scenario, episodes, seed)


# -- whole episodes ----------------------------------------------------------------------------------------------------


def _run(body: Backend, scenario: Scenario, episodes: int, seed: int, policy: str = "random") -> Recorder:
    rows = Recorder()
    for _ in simulate(scenario, backend=body, policy=policy, episodes=episodes, seed=seed, sink=rows):
        pass
    return rows


def _check_episodes(factory: Factory, scenario: Scenario, episodes: int, seed: int) -> None:
    for policy in ("random", "colony"):
        with global_randomness(1):
            first = _run(WatchedBackend(factory()), scenario, episodes, seed, policy)
        with global_randomness(1):
            again = _run(WatchedBackend(factory()), scenario, episodes, seed, policy)
        same_traces("determinism", "two runs of one seed differ", first, again)
    with global_randomness(2):
        reseeded = _run(factory(), scenario, episodes, seed, policy)
    same_traces("randomness", "the seed of the `random` module makes a difference", first, reseeded)
    asked = _run(WatchedBackend(factory(), curious=True), scenario, episodes, seed, policy)
    same_traces("feasible", "asking for feasibility and footprints more often makes a difference", first, asked)
    what = "a caller that empties the lists it was given makes a difference"
    try:
        emptied = _run(WatchedBackend(factory(), vandal=True), scenario, episodes, seed, policy)
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


def _check_saving(factory: Factory, scenario: Scenario, episodes: int, seed: int) -> None:
    """Colonies that take over the state of another one do what that one does."""
    body = factory()
    has = [name for name in ("state", "restore") if says(body, name)]
    if len(has) == 1:
        raise ConformanceError("saving", f"it has a method {has[0]!r}, and no other to go with it")
    if not has and not getattr(body, "replayable", False):
        why = "it has no methods 'state' and 'restore' of its own and does not say that it is 'replayable'"
        what = f"a colony on backend {body.name!r} cannot be saved, forked or resumed: {why}"
        warnings.warn(what, ColonysimWarning, stacklevel=3)
    else:
        for policy in ("random", "colony"):
            same_futures(
                lambda policy=policy: Colony(  # type: ignore[misc]
                    scenario, backend=factory(), policy=policy, episodes=episodes, seed=seed
                ),
                lambda colony, number: colony.fork(number, backend=factory()),
                reseeds=callable(getattr(body, "reseed", None)),
            )


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
    body, world = WatchedBackend(factory()), World(scenario)
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
    body, world = WatchedBackend(factory()), World(scenario)
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


def _exits(world: World, agent: int) -> list[int]:
    """The neighbours that an agent can travel to now."""
    found = array("i", [0]) * world.topology.most_neighbours
    return found[: world.exits(agent, found)].tolist()


def _begin_a_move(body: WatchedBackend, world: World, agent: int) -> bool:
    """Whether an action is now pending."""
    exits = _exits(world, agent)
    if not exits or body.start(agent, Travel(exits[0]), body.now) is not None:
        return False
    body.run(2.0 * (body.tick or 0.0))
    return agent in body.pending


def _finish_a_move(body: WatchedBackend, world: World, agent: int) -> None:
    exits = _exits(world, agent)
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
