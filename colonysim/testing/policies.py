"""Does a policy keep the promises of the protocol? A check for those who write one."""

from __future__ import annotations

import copy
import dataclasses
import math
import random
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from colonysim.arguments import as_seed, whole
from colonysim.errors import ColonysimWarning, PluginError, UnsavableError
from colonysim.pheromones.field import Visit, Write
from colonysim.simulation import Colony, simulate
from colonysim.testing.promises import ConformanceError, Recorder, frozen, global_randomness, same_futures, same_traces
from colonysim.testing.worlds import random_scenario
from colonysim.world.intents import Push, Travel, Wait

if TYPE_CHECKING:
    from colonysim.pheromones.field import Field
    from colonysim.policies.policy import Choice, Policy
    from colonysim.policies.view import LocalView
    from colonysim.scenario.scenario import Scenario
    from colonysim.world.state import World

__all__ = ["change_what_is_hidden", "check_policy"]

Factory: TypeAlias = "Callable[[Scenario], Policy]"

DECISIONS = 2
"""How many decisions are taken apart in each world."""

FIRST_DECISIONS = 16
"""Among how many: later ones seldom differ in kind."""


def check_policy(
    factory: Factory, *, local: bool = True, worlds: int = 500, runs: int = 6, episodes: int = 3, seed: int = 1
) -> None:
    """Lets a policy decide in random worlds, and looks at what its decisions depend on.

    Args:
        factory: The policy's class, or what else makes one from a scenario.
        local: Whether its fields keep to the place: False for a yardstick that by design marks all nodes at once.
        worlds: In how many random worlds decisions are repeated with everything changed that their agent cannot see.
        runs: In how many of them whole runs are compared.
        episodes: How many episodes those runs have.
        seed: The first random world.

    Raises:
        ConformanceError: The first broken promise: "repeatable", "no state of its own", "memory", "randomness",
            "legal intents", "local decisions", "local marks" or, where its memories are plain data or it has `state`
            and `restore`, "saving"; the message says what happened.

    Warns:
        ColonysimWarning: Memories or fields are such that no colony with this policy can be saved.

    Example:
        ```python
        from colonysim.testing import check_policy

        def test_my_policy_keeps_its_promises():
            check_policy(MyPolicy)
        ```
    """
    episodes, seed = whole("episodes", episodes), as_seed(seed)
    worlds, runs = whole("worlds", worlds, 0), whole("runs", runs, 0)
    for number in range(runs):
        _check_runs(factory, random_scenario(seed + number), episodes, number)
    for number in range(worlds):
        _check_decisions(factory, seed + number, local)
    for number in range(runs):
        _check_saving(factory, random_scenario(seed + number), episodes, number)


# -- whole runs --------------------------------------------------------------------------------------------------------


def _run(policy: Policy, scenario: Scenario, episodes: int, seed: int) -> Recorder:
    rows = Recorder()
    try:
        for _ in simulate(scenario, policy=policy, episodes=episodes, seed=seed, sink=rows):
            pass
    except PluginError as error:
        if error.__cause__ is None:  # nothing was raised, the simulation did not like what it was told
            raise ConformanceError("legal intents", str(error)) from error
        raise
    return rows


def _check_runs(factory: Factory, scenario: Scenario, episodes: int, seed: int) -> None:
    with global_randomness(1):
        first = _run(factory(scenario), scenario, episodes, seed)
    with global_randomness(2):
        reseeded = _run(factory(scenario), scenario, episodes, seed)
    with global_randomness(2):
        again = _run(factory(scenario), scenario, episodes, seed)
    with global_randomness(1):
        late = _run(factory(scenario), scenario, episodes, seed)
    same_traces("repeatable", "two runs of one seed differ", reseeded, again)
    same_traces("no state of its own", "after other runs the same run is another one", first, late)
    same_traces("randomness", "the seed of the `random` module makes a difference", first, reseeded)
    renewed = _run(_Renewed(factory, scenario), scenario, episodes, seed)
    same_traces("no state of its own", "a new policy object for each decision makes a difference", first, renewed)
    shared, sinks = factory(scenario), [Recorder(), Recorder()]
    pair = [
        simulate(scenario, policy=shared, episodes=episodes, seed=own, sink=sink)
        for own, sink in zip((seed, seed + 1), sinks, strict=True)
    ]
    while pair:
        pair = [run for run in pair if next(run, None) is not None]
    same_traces("no state of its own", "a second colony with the same object makes a difference", first, sinks[0])


def _check_saving(factory: Factory, scenario: Scenario, episodes: int, seed: int) -> None:
    """A colony in which the agents' memories were written down and read again does the same as before."""
    policy = factory(scenario)
    has = [name for name in ("state", "restore") if callable(getattr(policy, name, None))]
    if len(has) == 1:
        raise ConformanceError("saving", f"it has a method {has[0]!r}, and no other to go with it")

    def make() -> Colony:
        return Colony(scenario, policy=factory, episodes=episodes, seed=seed)

    if not has:
        try:
            with make() as colony:
                colony.step()
                colony.fork().close()
        except UnsavableError as error:
            what = f"a colony with it cannot be saved, forked or resumed: {error}"
            warnings.warn(what, ColonysimWarning, stacklevel=3)
            return
        except PluginError as error:
            raise ConformanceError("saving", str(error)) from error
    same_futures(make, lambda colony, number: colony.fork(number))


class _Renewed:
    """A policy whose object is thrown away after each call: what it remembers is only what it returns."""

    def __init__(self, factory: Factory, scenario: Scenario) -> None:
        self._factory = factory
        self._scenario = scenario
        self.name = self._make().name

    def _make(self) -> Policy:
        return self._factory(self._scenario)

    def fields(self, world: World) -> Mapping[str, Field]:
        return self._make().fields(world)

    def begin(self, agent: int, memory: Any) -> Any:
        return self._make().begin(agent, memory)

    def decide(self, view: LocalView, memory: Any, random: random.Random) -> Choice:
        return self._make().decide(view, memory, random)


# -- single decisions --------------------------------------------------------------------------------------------------


def _check_decisions(factory: Factory, number: int, local: bool) -> None:
    """Runs through some decisions, examining all on the way, and takes a few apart."""
    stream = random.Random(f"check/{number}")
    # Small radii, so that most of the place is out of sight.
    radius = stream.choice((0.5, 1.1, 1.5, 2.0, 3.0))
    scenario = dataclasses.replace(random_scenario(number, max_nodes=14), detection_radius=radius)
    probe = _Probe(factory, scenario, stream, stream.sample(range(FIRST_DECISIONS), DECISIONS), local)
    for _ in simulate(scenario, policy=probe, episodes=2, seed=number):
        if not probe.remaining:
            return


class _Probe:
    """Stands between the simulation and a policy, and examines what it answers."""

    def __init__(
        self, factory: Factory, scenario: Scenario, stream: random.Random, chosen: Sequence[int], local: bool
    ) -> None:
        self._factory = factory
        self._policy = factory(scenario)
        self._stream = stream
        self._decisions = 0
        self._local = local
        self.name = self._policy.name
        self.remaining = set(chosen)

    def fields(self, world: World) -> Mapping[str, Field]:
        made = self._policy.fields(world)
        again = self._factory(world.scenario).fields(world)
        for (name, field), (other, twin) in zip(made.items(), again.items(), strict=True):
            if name != other or _values(field, world) != _values(twin, world):
                raise ConformanceError("repeatable", f"fields gives another answer the second time, see {name}")
        return {name: _Watched(field, world) for name, field in made.items()} if self._local else made

    def begin(self, agent: int, memory: Any) -> Any:
        before = frozen(memory)
        begun = self._policy.begin(agent, memory)
        if frozen(memory) != before:
            raise ConformanceError("memory", f"begin changes the memory it is given: {before} is now {frozen(memory)}")
        if frozen(self._policy.begin(agent, memory)) != frozen(begun):
            raise ConformanceError("repeatable", "begin gives another memory the second time")
        return begun

    def decide(self, view: LocalView, memory: Any, random: random.Random) -> Choice:
        if self._decisions in self.remaining:
            self.remaining.discard(self._decisions)
            self._take_apart(view, memory, random)
        self._decisions += 1
        before, shared = frozen(memory), _global_state()
        choice = self._policy.decide(view, memory, random)
        if frozen(memory) != before:
            raise ConformanceError(
                "memory", f"decide changes the memory it is given: {before} is now {frozen(memory)}"
            )
        if _global_state() != shared:
            raise ConformanceError("randomness", "decide draws from the `random` module instead of its stream")
        _examine(choice, view, view._world)
        return choice

    def _take_apart(self, view: LocalView, memory: Any, random: random.Random) -> None:
        """The same decision again, and in a twin of the world that differs only out of sight."""
        here = _answer(self._policy, view, copy.deepcopy(memory), copy.deepcopy(random))
        again = _answer(self._policy, view, copy.deepcopy(memory), copy.deepcopy(random))
        if here != again:
            raise ConformanceError("repeatable", f"{here} and then {again} for one view, memory and stream")
        scenario = view._world.scenario
        # What is only read when a policy is built need not be copied.
        kept = (scenario.document, scenario.positions, scenario.physics, scenario.parameters)
        twin: LocalView = copy.deepcopy(view, {id(part): part for part in kept})
        changes = change_what_is_hidden(twin, self._stream)
        policy = self._factory(twin._world.scenario)
        there = _answer(policy, twin, copy.deepcopy(memory), copy.deepcopy(random))
        if here != there:
            what = ", ".join(changes) or "nothing at all"
            raise ConformanceError(
                "local decisions",
                f"agent {view.agent} on node {view.node} (R = {view.radius:g}) decides otherwise when only what it"
                f" cannot see changes ({what}): {here[0]} becomes {there[0]}",
            )


def _answer(policy: Policy, view: LocalView, memory: Any, random: random.Random) -> tuple[str, Any, Any]:
    choice = policy.decide(view, memory, random)
    return repr(choice._replace(memory=None)), frozen(choice.memory), random.getstate()


def _global_state() -> Any:
    return random.getstate()


def _examine(choice: Choice, view: LocalView, world: World) -> None:
    """Whether a choice speaks of what there is."""
    intent, size = choice.intent, len(world.topology)

    def wrong(why: str) -> ConformanceError:
        return ConformanceError("legal intents", f"{why} (agent {view.agent} on node {view.node}: {intent})")

    if isinstance(intent, Travel):
        if intent.node not in view.neighbours:
            raise wrong(f"travel to node {intent.node}, which is no neighbour")
    elif isinstance(intent, Push):
        if not 0 <= intent.box < len(world.box_node):
            raise wrong(f"no box {intent.box}")
        if not -1 <= intent.hole < len(world.scenario.holes):
            raise wrong(f"no hole {intent.hole}")
        if intent.node not in view.neighbours:
            raise wrong(f"a push to node {intent.node}, which is no neighbour")
        if world.box_node[intent.box] not in (view.node, intent.node):
            raise wrong(f"box {intent.box} is on node {world.box_node[intent.box]}")
    elif isinstance(intent, Wait):
        if intent.seconds is not None and not 0.0 <= intent.seconds < math.inf:
            raise wrong(f"a wait of {intent.seconds!r} seconds")
        if not all(0 <= node < size for node in intent.nodes) or not -1 <= intent.clear < size:
            raise wrong("a wait for nodes that do not exist")
    else:
        raise wrong(f"a {type(intent).__name__}, expected a Travel, Push or Wait")
    lengths = {len(choice.targets), len(choice.boxes or choice.targets), len(choice.probabilities)}
    if len(lengths) > 1:
        raise wrong("targets, boxes and probabilities are not of one length")
    if choice.probabilities and abs(sum(choice.probabilities) - 1.0) > 1e-6:
        raise wrong(f"probabilities add up to {sum(choice.probabilities)!r}")


# -- what an agent cannot see ------------------------------------------------------------------------------------------


def change_what_is_hidden(view: LocalView, stream: random.Random, *, terrain: bool = True) -> list[str]:
    """Changes a copy of the world in everything that the view does not show; says what was changed.

    Boxes and agents out of sight move, terrain out of sight rises or falls, claims, reservations and requests beyond
    the neighbours appear, other agents' states change, and marks that cannot be read get other values.

    Args:
        view: The view of an agent of that copy.
        stream: Draws what changes.
        terrain: Whether heights change too: no copy shares its scenario with another world then.
    """
    world, changes = view._world, []
    hidden = [node for node in range(len(world.topology)) if not view.sees(node)]
    if terrain:
        changes += _change_terrain(world, hidden, stream)
    changes += _move_boxes(view, hidden, stream)
    changes += _move_agents(view, hidden, stream)
    beyond = [node for node in range(len(world.topology)) if node != view.node and node not in view.neighbours]
    for node in beyond:
        if stream.random() < 0.5:
            world.node_holder[node] = stream.randrange(-1, len(world.agent_node))
            changes.append(f"reservation of {node}")
        if stream.random() < 0.3:
            world.clear_requests[node] = stream.randrange(len(world.agent_node))
    for edge in [(i, j) for i in beyond for j in world.topology.neighbours[i] if i < j]:
        world.edge_holder[edge] = stream.randrange(len(world.agent_node))
    for field in view.fields.values():
        changes += _change_marks(view, field._field, stream)
    return changes


def _change_terrain(world: World, hidden: Sequence[int], stream: random.Random) -> list[str]:
    """Other heights, as well in the scenario that the policy is built with, and other starts there."""
    topology, scenario = world.topology, world.scenario
    z = list(topology.z)
    for node in hidden:
        z[node] += stream.choice((0.0, stream.uniform(-1.0, 1.0)))
    object.__setattr__(topology, "z", tuple(z))
    for node in hidden:
        _stack_up(world, node)
    other: dict[str, list[Any]] = {
        "boxes": [dataclasses.replace(box, node=stream.choice(hidden)) if box.node in hidden else box
                  for box in scenario.boxes],
        "holes": [dataclasses.replace(hole, rim=hole.rim + 1.0) if hole.node in hidden else hole
                  for hole in scenario.holes],
        "agents": [stream.choice(hidden) if node in hidden else node for node in scenario.agents],
    }  # fmt: skip
    for name, values in other.items():
        object.__setattr__(scenario, name, tuple(values))
    world.survey()
    return [f"height of {node}" for node in hidden]


def _stack_up(world: World, node: int) -> None:
    height = world.topology.z[node]
    for box in world.stacks.get(node, ()):
        world.box_base[box] = height
        height += world.scenario.boxes[box].height
    world.surface[node] = height


def _move_boxes(view: LocalView, hidden: Sequence[int], stream: random.Random) -> list[str]:
    world, changes = view._world, []
    for box, node in enumerate(world.box_node):
        if node in hidden:
            to = stream.choice(hidden)
            world.move_box(box, to)
            world.box_claim[box] = stream.randrange(-1, len(world.agent_node))
            changes.append(f"box {box} from {node} to {to}")
    return changes


def _move_agents(view: LocalView, hidden: Sequence[int], stream: random.Random) -> list[str]:
    world, changes = view._world, []
    for agent, node in enumerate(world.agent_node):
        if agent != view.agent and node in hidden and world.occupant[node] == agent:
            free = [other for other in hidden if world.occupant[other] < 0]
            if free:
                to = stream.choice(free)
                world.occupant[node], world.occupant[to] = -1, agent
                world.agent_node[agent], world.agent_from[agent] = to, -1
                changes.append(f"agent {agent} from {node} to {to}")
    return changes


def _change_marks(view: LocalView, field: Field, stream: random.Random) -> list[str]:
    world, writes = view._world, []
    before = {(write.node, write.key): write for write in field.frame()}
    if field.by_box:
        unseen = [box for box, node in enumerate(world.box_node) if not view.sees(node)]
        writes = [Write(box, key, stream.uniform(0.1, 50.0)) for box in unseen for key in field.keys(box)]
    else:
        keys = range(len(world.scenario.holes))
        for node in range(len(world.topology)):
            if node != view.node and node not in view.neighbours and not view.beside_box(node):
                single = Write(node, -1, stream.uniform(0.0, 20.0))
                keyed = [Write(node, key, stream.uniform(0.01, 1.0)) for key in keys]
                writes += keyed if _has_keys(field, world) else [single]
    field.load(writes)
    changed = {(write.node, write.key) for write in writes}
    kept = [write for place, write in before.items() if place not in changed]
    if any(field.at(write.node, write.key) != write.value for write in kept):
        # It forgets what it is not told.
        field.load([*kept, *writes])
    return [f"{field.name} of {write.node}" for write in writes]


def _has_keys(field: Field, world: World) -> bool:
    return any(len(field.keys(node)) for node in range(len(world.topology)))


def _values(field: Field, world: World) -> dict[tuple[int, int], float]:
    """Every value of a field."""
    count = len(world.box_node) if field.by_box else len(world.topology)
    return {(node, key): field.at(node, key) for node in range(count) for key in field.keys(node) or (-1,)}


# -- marks -------------------------------------------------------------------------------------------------------------


class _Watched:
    """A field whose deposits must stay where the agent is."""

    def __init__(self, field: Field, world: World) -> None:
        self._field = field
        self._world = world
        self.name = field.name
        self.by_box = field.by_box

    def at(self, node: int, key: int = -1) -> float:
        return self._field.at(node, key)

    def keys(self, node: int) -> Sequence[int]:
        return self._field.keys(node)

    def deposit(self, visit: Visit) -> Iterable[Write]:
        before = _values(self._field, self._world)
        writes = list(self._field.deposit(visit))
        here = {visit.node, visit.left}
        places = {visit.node}
        if self.by_box:
            places = {visit.box, *(box for box, node in enumerate(self._world.box_node) if node in here)}
        for (node, key), value in _values(self._field, self._world).items():
            was = before.get((node, key))
            if value != was and node not in places:
                raise ConformanceError(
                    "local marks",
                    f"agent {visit.agent} on node {visit.node} changes {self.name} of {node} from {was} to {value}",
                )
        return writes

    def end_episode(self) -> None:
        self._field.end_episode()

    def frame(self) -> Iterable[Write]:
        return self._field.frame()

    def load(self, frame: Iterable[Write]) -> None:
        self._field.load(frame)

    @property
    def wipe(self) -> Any:
        return getattr(self._field, "wipe", None)

    @property
    def settle(self) -> Any:
        return getattr(self._field, "settle", None)
