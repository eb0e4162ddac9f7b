"""Marks that spread along edges: whoever looks, and however seldom, sees what a table of all nodes would hold."""

from __future__ import annotations

import copy
import math
import random

import numpy as np
import pytest
from plain_python import compiled_and_plain
from small_worlds import line, place, play, visit

import colonysim
from colonysim import load_scenario
from colonysim.errors import ColonysimError
from colonysim.pheromones import BoxWorth, Distance, Exploration, HoleTrail, NodeValues
from colonysim.policies.presets import Colony
from colonysim.scenario.groups import Group
from colonysim.testing.worlds import random_scenario
from colonysim.world.state import World

STEP, PERIOD, HALF_LIFE, SHARE = 0.25, 1.0, 7.0, 0.6
"""Binary fractions: sums of them are exact."""


def make(name, world, half_life=HALF_LIFE, **more):
    more = {"half_life": half_life, "diffusion": SHARE, "period": PERIOD, **more}
    if name == "D":
        return Distance(world, d_max=20.0, **more)
    return HoleTrail(world, **more) if name == "H" else Exploration(world, **more)


def exchange(topology, share=SHARE, absent=()):
    """The matrix of a tick: rows get, columns give."""
    matrix = np.eye(len(topology))
    for i, others in enumerate(topology.neighbours):
        for j in others:
            if (i, j) not in absent and (j, i) not in absent:
                part = share / max(len(others), len(topology.neighbours[j]))
                matrix[i, j] += part
                matrix[i, i] -= part
    return matrix


class Dense:
    """All nodes in a table, for each key; all of it changes at every step."""

    def __init__(self, world, half_life=HALF_LIFE, share=SHARE):
        self.world, self.matrix = world, exchange(world.topology, share)
        self.values = np.zeros((max(1, len(world.hole_node)), len(world.topology)))
        self.factor = 1.0 if half_life is None else 0.5 ** (STEP / half_life)

    def step(self):
        self.values *= self.factor
        if self.world.now % PERIOD == 0.0:
            self.values = self.values @ self.matrix.T


class DenseE(Dense):
    keep = 0.5

    def visit(self, event):
        self.values[0, event.node] += 1.0

    def end(self):
        if self.keep is None:
            self.values[0] -= self.values[0].min()
        else:
            self.values *= self.keep

    def shown(self):
        return {(node, -1): value for node, value in enumerate(self.values[0])}


class DenseH(Dense):
    def visit(self, event):
        world, node = self.world, event.node
        for hole in range(len(world.hole_node)):
            near = world.topology.distance(node, world.hole_node[hole]) <= world.scenario.detection_radius
            ways = [math.exp(-length) * self.values[hole, j]
                    for j, length in world.reachable_neighbours(event.level, node)]  # fmt: skip
            self.values[hole, node] = 1.0 if near else max([self.values[hole, node], *ways])

    def end(self):
        self.values *= 0.5

    def shown(self):
        return {(node, hole): self.values[hole, node]
                for hole in range(len(self.world.hole_node)) for node in range(len(self.world.topology))}  # fmt: skip


class DenseHPrinted(DenseH):
    def visit(self, event):
        world, node = self.world, event.node
        for hole in range(len(world.hole_node)):
            ways = [math.exp(-length) * self.values[hole, j]
                    for j, length in world.reachable_neighbours(event.level, node)]  # fmt: skip
            self.values[hole, node] = min(ways, default=0.0)


class DenseD(Dense):
    """Keeps by how much distances exceed the straight ones."""

    def straight(self, node):
        return self.world.topology.distance(node, self.world.scenario.goal)

    def visit(self, event):
        world, node = self.world, event.node
        ways = [length + self.straight(j) + self.values[0, j]
                for j, length in world.reachable_neighbours(event.level, node)]  # fmt: skip
        far = 0.0 if node == world.scenario.goal else min(ways, default=self.straight(node))
        self.values[0, node] = far - self.straight(node)

    def end(self):
        pass

    def shown(self):
        return {(node, -1): max(0.0, 20.0 - self.straight(node) - value) for node, value in enumerate(self.values[0])}


class DenseDBlank(DenseD):
    """D of an unvisited node is 0, and what has spread there tells no distance."""

    def __init__(self, world, half_life=HALF_LIFE):
        super().__init__(world, half_life)
        self.visited = set()

    def visit(self, event):
        world, node = self.world, event.node
        self.visited.add(node)
        ways = [length + (20.0 + self.values[0, j] if j in self.visited else self.straight(j))
                for j, length in world.reachable_neighbours(event.level, node)]  # fmt: skip
        far = 0.0 if node == world.scenario.goal else min(ways, default=self.straight(node))
        self.values[0, node] = far - 20.0

    def shown(self):
        return {(node, -1): max(0.0, -value) for node, value in enumerate(self.values[0])}


def least_off(world, half_life):
    dense = DenseE(world, half_life)
    dense.keep = None
    return dense


CASES = {
    "D": ("D", DenseD, {}),
    "H": ("H", DenseH, {}),
    "E": ("E", DenseE, {}),
    "E, less its least": ("E", least_off, {"evaporation": None}),
    "D of 0": ("D", DenseDBlank, {"unvisited": "zero"}),
    "H as printed": ("H", DenseHPrinted, {"rule": "min"}),
}


def check_against_a_table(case, seeds):
    name, dense_kind, more = CASES[case]
    looks = 0
    for seed in seeds:
        rng, scenario = random.Random(seed), random_scenario(seed, max_nodes=12 + 28 * (seed % 2))
        half_life = (HALF_LIFE, 0.8, None)[seed % 3]
        world = World(scenario)
        field, dense = make(name, world, half_life, **more), dense_kind(world, half_life)
        for step in range(1, 400):
            world.now += STEP
            dense.step()
            if rng.random() < 0.2:
                event = visit(world, rng.randrange(len(scenario.topology)))
                field.deposit(event) if rng.random() < 0.5 else field.mark(event)
                dense.visit(event)
            if rng.random() < 0.03:
                for (node, key), value in dense.shown().items():
                    looks += 1
                    assert field.at(node, key) == pytest.approx(value, rel=1e-9, abs=1e-9), (seed, step, node)
            if step % 150 == 0:
                field.end_episode()
                dense.end()
                world.now = 0.0
    return looks


@pytest.mark.parametrize("case", CASES)
def test_reading_late_is_the_same_as_a_table_of_all_nodes_and_ticks(case):
    assert check_against_a_table(case, range(12)) > 1000


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_on_two_hundred_random_graphs(case):
    assert check_against_a_table(case, range(200)) > 20_000


def grid(columns, rows, seed=0, less=0.1):
    """A grid with some edges missing and some more than there should be."""
    rng, points = random.Random(seed), [(float(x), float(y)) for y in range(rows) for x in range(columns)]
    edges = [(i, i + 1) for i in range(len(points)) if (i + 1) % columns]
    edges += [(i, i + columns) for i in range(len(points) - columns)]
    edges = [edge for edge in edges if rng.random() > less]
    edges += [tuple(rng.sample(range(len(points)), 2)) for _ in range(int(100 * less))]
    return place(points, edges)


@pytest.mark.parametrize("half_life", [None, 30.0])
def test_what_is_too_faint_to_spread_makes_no_difference(half_life):
    world = World(grid(100, 12, seed=3))
    field, matrix = NodeValues(world, half_life=half_life, diffusion=0.9), exchange(world.topology, 0.9)
    values, factor = np.zeros(1200), 1.0 if half_life is None else 0.5 ** (1.0 / half_life)
    rng = random.Random(1)
    for tick in range(240):
        world.now = float(tick)
        values = matrix @ (values * factor) if tick else values
        if tick < 100:
            node = rng.randrange(1200)
            field.add(node, 1.0)
            values[node] += 1.0
        if tick % 60 == 59:
            found = np.array([field.at(node) for node in range(1200)])
            assert np.abs(found - values).max() < 1e-9
    kept = 100.0 if half_life is None else values.sum()
    assert sum(value for _, value in field.items()) == pytest.approx(kept, rel=1e-12), "none is lost or made"


@pytest.mark.parametrize("half_life", [None, HALF_LIFE, 1e-3])
@pytest.mark.parametrize("name", "DHE")
def test_who_looks_in_between_changes_nothing(name, half_life):
    """Not even the last bit: a run that is watched would have another trace."""
    world = World(random_scenario(7))
    one, other = make(name, world, half_life), make(name, world, half_life)
    rng = random.Random(1)
    for step in range(3000):
        world.now += STEP
        if rng.random() < 0.1:
            event = visit(world, rng.randrange(len(world.topology)))
            one.deposit(event)
            other.mark(event)
        if rng.random() < 0.5:
            [one.at(node, 0) for node in range(len(world.topology))]
            one.keys(0), one.frame()
            assert one.frame() == one.frame()
        if step % 500 == 499:
            if step % 1000 == 999:
                assert list(one.frame()) == list(other.frame())
            one.end_episode(), other.end_episode()
            world.now = 0.0
    assert list(one.frame()) == list(other.frame())


def test_a_deposit_alone_makes_nothing_spread():
    world = World(line(9))
    field = make("E", world)
    for second in range(100):
        world.now = float(second)
        field.mark(visit(world, 4))
    assert field.spread.ticks == 0
    assert field.at(0) > 0.0
    assert field.spread.ticks == 99


@pytest.mark.slow
def test_a_log_of_millions_of_deposits_is_worked_off():
    world = World(line(3))
    one, other = (NodeValues(world, half_life=100.0, diffusion=0.5) for _ in range(2))
    for i in range(5_000_000):
        if i % 1000 == 0:
            world.now += 1.0
            one.at(0)
        one.add(i % 3, 1.0)
        other.add(i % 3, 1.0)
    assert other.ticks > 4000
    assert one.items() == other.items()


def test_each_tick_is_diffuse_of_netlogo_on_a_grid():
    """Inside each neighbour gets a quarter of the share; a node at the border keeps what would go over it."""
    world = World(grid(5, 5, less=0.0))
    field = NodeValues(world, diffusion=0.4, period=2.0)
    field.add(12, 10.0)
    world.now = 1.99
    assert field.items() == [(12, 10.0)]
    world.now = 2.0
    assert field.items() == [(7, 1.0), (11, 1.0), (12, 6.0), (13, 1.0), (17, 1.0)]
    corner = NodeValues(world, diffusion=0.4)
    corner.add(0, 10.0)
    world.now = 3.0
    assert dict(corner.items()) == pytest.approx({0: 10.0 * (1 - 0.8 / 3), 1: 4.0 / 3, 5: 4.0 / 3})


def test_along_an_edge_that_is_gone_nothing_spreads():
    world = World(line(4))
    field = make("E", world, None)
    field.deposit(visit(world, 0))
    world.now = 5.0
    values = np.linalg.matrix_power(exchange(world.topology), 5) @ [1.0, 0.0, 0.0, 0.0]
    field.settle()
    for i, j in ((1, 2), (2, 1)):
        world.terrain.rises[world.terrain.edge(i, j)] = math.nan
    world.now = 11.0
    values = np.linalg.matrix_power(exchange(world.topology, absent=[(1, 2)]), 6) @ values
    assert [field.at(node) for node in range(4)] == pytest.approx(values, abs=1e-12)
    field.settle()
    for i, j in ((1, 2), (2, 1)):
        world.terrain.rises[world.terrain.edge(i, j)] = 0.0
    world.now = 13.0
    values = np.linalg.matrix_power(exchange(world.topology), 2) @ values
    assert [field.at(node) for node in range(4)] == pytest.approx(values, abs=1e-12)


@pytest.mark.parametrize("name", "DHE")
def test_a_copy_spreads_as_the_original(name):
    world = World(random_scenario(11))
    field = make(name, world)
    for node in range(len(world.topology)):
        world.now += 1.5
        field.mark(visit(world, node))
    twin = copy.deepcopy(field)
    twin._world.now = world.now = 50.0
    assert list(twin.frame()) == list(field.frame()) != []
    field.deposit(visit(world, 0))
    assert list(twin.frame()) != list(field.frame())


@pytest.mark.parametrize("name", "DHE")
def test_key_frames_are_taken_over(name):
    world = World(random_scenario(11))
    field, other = make(name, world, None), make(name, world, None)
    for node in range(len(world.topology)):
        world.now += 1.5
        field.deposit(visit(world, node))
    other.load(field.frame())
    found = {(node, key): value for node, key, value in other.frame()}
    assert found == pytest.approx({(node, key): value for node, key, value in field.frame()}, rel=1e-12)


# -- in runs -----------------------------------------------------------------------------------------------------------

OPTIONS = {
    "policy.distance_diffusion": 0.3, "policy.hole_diffusion": 0.2, "policy.exploration_diffusion": 0.5,
    "policy.distance_half_life": 40.0, "policy.exploration_half_life": 20.0, "policy.diffusion_period": 0.5,
}  # fmt: skip


def test_spreading_marks_change_a_run_and_none_do_not():
    plain = play(load_scenario("hard"), seed=1, episodes=2)[0]
    for name in ("distance", "hole", "exploration"):
        option = f"policy.{name}_diffusion"
        assert play(load_scenario("hard", None, {option: 0}), seed=1, episodes=2)[0] == plain
        assert play(load_scenario("hard", None, {option: 0.5}), seed=1, episodes=2)[0] != plain or name == "hole", name
        for wrong in (-0.1, 1.5, float("nan"), "soon", None):
            with pytest.raises(ColonysimError, match=option):
                play(load_scenario("hard", None, {option: wrong}), seed=1, episodes=1)
    for wrong in (0, 0.001, float("inf"), None):
        with pytest.raises(ColonysimError, match=r"policy\.diffusion_period"):
            play(load_scenario("hard", None, {"policy.diffusion_period": wrong}), seed=1, episodes=1)


def test_each_agent_marks_the_holes_within_its_own_radius():
    groups = (Group("near", range(1), 1.0), Group("far", range(1, 2), 4.0))
    scenario = line(6, goal=5, agents=[0, 1], holes={3: (-1.0, 0.0)}, detection_radius=2.0, groups=groups)
    world = World(scenario)
    field = make("H", world, half_life=None)
    field.mark(visit(world, 1, agent=0))
    assert field.at(1, 0) == 0.0
    field.mark(visit(world, 1, agent=1))
    assert field.at(1, 0) == 1.0


def test_that_b_cannot_spread_is_said():
    scenario = load_scenario("hard", None, {"policy.box_diffusion": 0.5})
    with pytest.raises(ColonysimError, match=r"policy\.box_diffusion.*B belongs to boxes.*box_half_life"):
        play(scenario, seed=1, episodes=1)


@pytest.mark.parametrize("wrong", [{"diffusion": -1.0}, {"diffusion": 1.1}, {"diffusion": math.nan}, {"half_life": 0.0},
                                   {"diffusion": 0.5, "period": 0.0}, {"diffusion": "much"}])  # fmt: skip
@pytest.mark.parametrize("kind", [NodeValues, Exploration, HoleTrail])
def test_what_the_classes_do_not_take(kind, wrong):
    with pytest.raises(ColonysimError, match=r"^(diffusion|period|half_life): "):
        kind(World(line(3)), **wrong)


def test_a_watched_run_has_the_trace_of_one_that_is_not(tmp_path):
    scenario = load_scenario("hard", None, OPTIONS)

    def watch(colony):
        colony.on("end", lambda *_: [dict(colony.fields[name].items()) for name in "DHE"])

    plain = colonysim.run(scenario, seed=2, episodes=2, trace=False)
    assert colonysim.run(scenario, seed=2, episodes=2, trace=False, on_begin=watch).trace_sha256 == plain.trace_sha256
    recorded = colonysim.run(scenario, seed=2, episodes=2, out=tmp_path / "run")
    assert list(recorded.events()) == list(colonysim.simulate(scenario, seed=2, episodes=2))


def test_a_run_that_begins_with_the_marks_of_another(tmp_path):
    scenario = load_scenario("medium", None, OPTIONS)
    first = colonysim.run(scenario, seed=1, episodes=2, out=tmp_path / "first")
    again = colonysim.run(scenario, seed=2, episodes=1, out=tmp_path / "again", initial=first)
    assert again.episodes


PROGRAM = """
import colonysim
from colonysim.simulation import episode
from colonysim.testing.worlds import random_scenario
print(episode.__file__)
for seed in range(40):
    scenario = random_scenario(seed, max_nodes=40, max_agents=8)
    scenario.parameters.update(distance_diffusion=0.3, hole_diffusion=0.2, exploration_diffusion=0.7,
                               distance_half_life=30.0, hole_half_life=20.0, exploration_half_life=5.0 + seed,
                               hole_rule=("max", "min")[seed % 5 == 0], diffusion_period=0.7)
    print(seed, colonysim.run(scenario, episodes=2, seed=seed, trace=False).trace_sha256)
"""


def test_compiled_and_plain_spread_the_same(tmp_path):
    lines, again = compiled_and_plain(PROGRAM, tmp_path)
    assert len(lines) == 40 and lines == again


# -- marks that are wiped ----------------------------------------------------------------------------------------------


def wiped_world():
    return World(line(6, goal=5, agents=[0], holes={2: (-1.0, 0.0)}, boxes=[(1, 1.0), (4, 1.0)], detection_radius=1.2))


@pytest.mark.parametrize("diffusion", [0.0, 0.5])
@pytest.mark.parametrize("half_life", [None, 10.0])
@pytest.mark.parametrize("name", "DBHE")
def test_where_marks_are_wiped_nobody_has_been(name, half_life, diffusion):
    if name == "B" and diffusion:
        return
    world = wiped_world()
    if name == "B":
        field, fresh = (BoxWorth(world, start=40.0, half_life=half_life) for _ in range(2))
    else:
        field, fresh = (make(name, world, half_life, diffusion=diffusion) for _ in range(2))
    field.deposit(visit(world, 5))
    for node in (4, 3, 2, 1, 0, 1, 3):
        world.now += 0.75
        for moment in ("arrive", "claim"):
            field.deposit(visit(world, node, moment, **({"box": node % 2, "hole": 0} if moment == "claim" else {})))
    before = {(w.node, w.key): w.value for w in field.frame()}
    nodes = (node for node in (1, 3))
    field.wipe(nodes)
    after = {(w.node, w.key): w.value for w in field.frame()}
    if name == "B":  # box 0 stands on node 1, box 1 on node 4
        assert {box for box, _ in before} == {0, 1} and {box for box, _ in after} == {1}
        assert field.at(0, 0) == 40.0
        return
    key = 0 if name == "H" else -1
    for node in range(6):
        assert field.at(node, key) == (fresh.at(node, key) if node in (1, 3) else before.get((node, key), 0.0)), node
    assert not {1, 3} & {node for node, _ in after}
    if name == "D":
        assert not field.visited[3] and not field.official[3] and field.visited[2]
    for wrong in (-1, 6):
        with pytest.raises(IndexError):
            field.wipe([wrong])
    field.wipe([])
    assert {(w.node, w.key): w.value for w in field.frame()} == after


def test_e_is_wiped_after_its_least_was_taken_off():
    world = World(line(3))
    field = Exploration(world, evaporation=None)
    for node in (0, 0, 0, 1, 1, 2):
        field.deposit(visit(world, node))
    field.end_episode()
    assert [field.at(node) for node in range(3)] == [2.0, 1.0, 0.0]
    field.wipe([0])
    assert [field.at(node) for node in range(3)] == [0.0, 1.0, 0.0]
    field.deposit(visit(world, 0))
    assert field.at(0) == 1.0


class Bare:
    """A field of a third party without a method to wipe it."""

    name, by_box = "X", False

    def __init__(self, world):
        self.values = NodeValues(world, half_life=20.0, diffusion=0.3)

    def at(self, node, key=-1):
        return self.values.at(node)

    def keys(self, node):
        return ()

    def deposit(self, visit):
        self.values.add(visit.node, 1.0)
        return ()

    def end_episode(self):
        self.values.end_episode()

    def frame(self):
        return ()

    def load(self, frame):
        pass


class Wipeable(Bare):
    def wipe(self, nodes):
        self.values.wipe(nodes)


def marks_of(kind, scenario):
    """The field of a third party as the simulation calls it."""
    from colonysim.simulation.foreign import checked_fields
    from colonysim.trace.rows import Rows as Table

    class Carrying(Colony):
        def fields(self, world):
            return {**super().fields(world), "X": kind(world)}

    world = World(scenario)
    return world, checked_fields(Carrying(scenario), world, Table(scenario, None, False))["X"]


def test_marks_of_others_are_wiped_or_it_is_said_why_not():
    world, field = marks_of(Wipeable, line(4, agents=[0]))
    field.mark(visit(world, 2))
    world.now = 3.0
    assert field.at(1) > 0.0 < field.at(2)
    field.wipe(iter([2]))
    assert field.at(2) == 0.0 < field.at(1)
    with pytest.raises(IndexError):
        field.wipe([4])
    field.settle()
    _, bare = marks_of(Bare, line(4, agents=[0]))
    with pytest.raises(ColonysimError, match=r"field 'X'.*no method wipe\(nodes\)"):
        bare.wipe([2])
    bare.settle()
