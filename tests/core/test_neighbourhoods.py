"""What lies near: found by cells, known once for a place, or gathered where that would take too much room."""

from __future__ import annotations

import gc
import math
import random

import pytest
from small_worlds import place

import colonysim
from colonysim.testing.worlds import random_scenario
from colonysim.world import neighbourhoods as module
from colonysim.world.neighbourhoods import Neighbourhoods, neighbourhoods
from colonysim.world.topology import Topology


def scattered(seed: int, count: int = 60) -> Topology:
    rng = random.Random(seed)
    points = [(rng.uniform(-9, 9), rng.uniform(-9, 9)) for _ in range(count)]
    return place(points, [(i, i + 1) for i in range(count - 1)], goal=0, agents=[1]).topology


@pytest.mark.parametrize("radius", [0.0, 0.7, 3.0, 40.0])
def test_it_is_whatever_is_not_farther_than_the_radius(radius):
    for seed in range(5):
        topology = scattered(seed)
        found = Neighbourhoods(topology, radius)
        for node in range(len(topology)):
            wanted = [j for j in range(len(topology)) if topology.distance(node, j) <= radius]
            assert sorted(found.nodes[found.first[node] : found.first[node + 1]]) == wanted
            assert [j for j in range(len(topology)) if found.both(node, j)] == wanted
            assert len(wanted) <= found.most


def test_it_is_known_as_long_as_the_place_is():
    topology = scattered(1)
    found = neighbourhoods(topology, 2.0)
    assert neighbourhoods(topology, 2.0) is found and neighbourhoods(topology, 3.0) is not found
    before = len(module._KNOWN)
    del topology
    gc.collect()
    assert len(module._KNOWN) < before


def test_a_run_is_the_same_where_nothing_is_kept(monkeypatch):
    scenario = random_scenario(4, max_nodes=40, max_agents=6)
    kept = colonysim.run(scenario, episodes=3, seed=1, trace=False).trace_sha256

    def unkept(topology: Topology, radius: float) -> Neighbourhoods:
        return Neighbourhoods(topology, radius, room=0)

    monkeypatch.setattr("colonysim.world.visibility.neighbourhoods", unkept)
    assert not unkept(scenario.topology, 1.0).kept
    assert colonysim.run(scenario, episodes=3, seed=1, trace=False).trace_sha256 == kept
    assert math.isfinite(scenario.detection_radius)
