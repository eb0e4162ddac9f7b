"""What the fields converge to, on random graphs."""

from __future__ import annotations

import copy
import math
import random

import networkx as nx
import pytest
from small_worlds import place, visit

from colonysim.pheromones import Distance, Exploration, HoleTrail, Write, extent
from colonysim.world.state import World

GRAPHS = 200


def random_place(seed: int, holes: int = 0, radius: float = 1.0) -> World:
    """A random graph, not always connected, on two levels that no edge joins except a slope."""
    rng = random.Random(seed)
    count = rng.randint(3, 12)
    points = [(rng.uniform(0, 5), rng.uniform(0, 5), rng.choice((0.0, 0.0, 0.1, 1.0))) for _ in range(count)]
    pairs = [(i, j) for i in range(count) for j in range(i)]
    edges = rng.sample(pairs, rng.randint(min(2, len(pairs)), len(pairs)))
    slopes = rng.sample(edges, min(1, len(edges)))
    chosen = rng.sample(range(1, count), min(holes, count - 1))
    return World(
        place(points, edges, goal=0, agents=[], slopes=slopes, detection_radius=radius,
              holes={node: (points[node][2] - 0.2, points[node][2]) for node in chosen})
    )  # fmt: skip


def reachable_graph(world: World) -> nx.Graph[int]:
    graph: nx.Graph[int] = nx.Graph()
    graph.add_nodes_from(range(len(world.topology)))
    for i, others in enumerate(world.topology.neighbours):
        for j, length in zip(others, world.topology.lengths[i], strict=True):
            if world.reachable(i, j):
                graph.add_edge(i, j, weight=length)
    return graph


def sweep(world: World, field, seed: int, times: int) -> None:
    rng = random.Random(seed)
    nodes = list(range(len(world.topology)))
    for _ in range(times):
        rng.shuffle(nodes)
        for node in nodes:
            field.deposit(visit(world, node))


@pytest.mark.parametrize("rule", ["lrta", "literal"])
def test_distance_becomes_dijkstra_s(rule):
    for seed in range(GRAPHS):
        world = random_place(seed)
        field = Distance(world, d_max=100.0, rule=rule)
        true = nx.single_source_dijkstra_path_length(reachable_graph(world), 0)
        # LRTA* comes from below, by an edge's length at a time where a dead end looks near: until nothing moves.
        before: list[float] = []
        for turn in range(1000):
            sweep(world, field, seed + turn, 3)
            now = [field.d[node] for node in true]
            if now == before:
                break
            before = now
        for node, far in true.items():
            assert field.d[node] == pytest.approx(far), (seed, node)
            assert field.at(node) == pytest.approx(100.0 - far)
            assert field.official[node]
        assert sum(field.official) == len(true), "officiality spreads from the goal along passable edges only"


def test_oracle_needs_no_feet():
    world = random_place(7)
    field = Distance(world, d_max=100.0, everywhere=True)
    for _ in range(len(world.topology) + 2):
        field.deposit(visit(world, 1))
        field.deposit(visit(world, 0))
    for node, far in nx.single_source_dijkstra_path_length(reachable_graph(world), 0).items():
        assert field.d[node] == pytest.approx(far)


def test_hole_trail_becomes_the_shortest_way_to_where_the_hole_is_seen():
    trails = 0
    for seed in range(GRAPHS):
        world = random_place(seed, holes=2, radius=1.5)
        field = HoleTrail(world)
        sweep(world, field, seed, len(world.topology) + 2)
        graph, topology = reachable_graph(world), world.topology
        for key, hole in enumerate(world.scenario.holes):
            seers = [n for n in range(len(topology)) if topology.distance(n, hole.node) <= 1.5]
            true = nx.multi_source_dijkstra_path_length(graph, set(seers))
            for node in range(len(topology)):
                wanted = math.exp(-true[node]) if node in true else 0.0
                assert field.at(node, key) == pytest.approx(wanted), (seed, node, key)
                assert (key in field.keys(node)) == (node in true)
                trails += 0.0 < wanted < 1.0
    assert trails > 500


def test_hole_trails_of_many_holes_on_many_nodes_and_a_copy_of_them():
    """Far more of them than there is room for at first, so that they are moved about."""
    points = [(i % 12, i // 12, 0.0) for i in range(144)]
    edges = [(i, j) for i in range(144) for j in (i + 1, i + 12) if j < 144 and (j % 12 or j == i + 12)]
    holes = dict.fromkeys(range(5, 144, 6), (0.0, 0.0))
    world = World(place(points, edges, goal=0, agents=[], detection_radius=1.0, holes=holes))
    field = HoleTrail(world)
    sweep(world, field, 0, 12)
    graph = reachable_graph(world)
    for key, hole in enumerate(world.scenario.holes):
        seers = {n for n in range(144) if world.topology.distance(n, hole.node) <= 1.0}
        true = nx.multi_source_dijkstra_path_length(graph, seers)
        for node in range(144):
            assert field.at(node, key) == pytest.approx(math.exp(-true[node]))
    twin, before = copy.deepcopy(field), list(field.frame())
    assert list(twin.frame()) == before and len(before) == 144 * len(holes)
    twin.load([Write(0, 0, 0.5)])
    assert twin.at(0, 0) == pytest.approx(0.5) and list(field.frame()) == before


def test_distance_counts_up_but_d_stays_at_zero_when_the_goal_is_cut_off():
    """Two nodes that see only each other count to infinity; D is clipped."""
    world = World(place([(0, 0), (1, 0), (2, 0)], [(1, 2)], goal=0))
    field = Distance(world, d_max=5.0)
    sweep(world, field, 0, 20)
    assert field.d[1] > 5.0
    assert field.at(1) == field.at(2) == 0.0


def test_d_max_covers_detours_and_unjoined_nodes_do_not_make_it_infinite():
    world = World(place([(0, 0), (9, 0), (9, 1), (0, 1), (50, 50)], [(0, 1), (1, 2), (2, 3)], goal=0))
    assert extent(world) == pytest.approx(19.0)


@pytest.mark.parametrize("evaporation", [0.5, 0.9, 0.0, 1.0])
def test_hole_trail_evaporates_by_its_factor_and_comes_back(evaporation):
    world = random_place(3, holes=2, radius=1.5)
    field = HoleTrail(world, evaporation=evaporation)
    sweep(world, field, 0, 15)
    before = {(w.node, w.key): w.value for w in field.frame()}
    assert before
    field.end_episode()
    field.end_episode()
    for (node, key), value in before.items():
        assert field.at(node, key) == pytest.approx(value * evaporation**2)
    sweep(world, field, 1, 15)
    assert {(w.node, w.key): w.value for w in field.frame()} == pytest.approx(before)


def test_exploration_survives_a_thousand_evaporations():
    world = World(place([(0, 0), (1, 0)], [(0, 1)]))
    field = Exploration(world, evaporation=0.5)
    for _ in range(1000):
        assert field.deposit(visit(world, 0))[0].value == pytest.approx(field.at(0))
        field.end_episode()
    assert field.at(0) == pytest.approx(1.0)
    assert field.at(1) == 0.0
    for _ in range(1000):
        field.end_episode()
    field.deposit(visit(world, 1))
    assert field.at(1) == 1.0 and field.at(0) < 1e-100


def test_the_smallest_exploration_is_zero_until_every_node_was_visited():
    world = World(place([(0, 0), (1, 0)], [(0, 1)]))
    field = Exploration(world, evaporation=None)
    for _ in range(3):
        field.deposit(visit(world, 0))
    field.end_episode()
    assert field.at(0) == 3.0
    field.load([Write(1, -1, 2.0)])
    field.end_episode()
    assert (field.at(0), field.at(1)) == (1.0, 0.0)
