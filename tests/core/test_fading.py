"""Marks that fade with time: whoever looks, and however seldom, sees what stepping through time would give."""

from __future__ import annotations

import copy
import math
import random

import pytest
from small_worlds import line, play, visit

from colonysim import load_scenario
from colonysim.errors import ColonysimError
from colonysim.pheromones import BoxWorth, Distance, Exploration, HoleTrail
from colonysim.testing.worlds import random_scenario
from colonysim.world.state import World

TICK, HALF_LIFE = 0.25, 3.0
FACTOR = 0.5 ** (TICK / HALF_LIFE)


def make(name, world, half_life=HALF_LIFE, **more):
    if name == "D":
        return Distance(world, d_max=20.0, half_life=half_life, **more)
    if name == "B":
        return BoxWorth(world, start=40.0, half_life=half_life, **more)
    if name == "H":
        return HoleTrail(world, half_life=half_life, **more)
    return Exploration(world, half_life=half_life, **more)


class Dense:
    """Every value of a field in a table, all of them changed at every tick."""

    def __init__(self, world):
        self.world = world
        self.values, self.rest = {}, {}

    def tick(self):
        for place, value in self.values.items():
            rest = self.rest.get(place, 0.0)
            self.values[place] = rest + (value - rest) * FACTOR


class DenseE(Dense):
    def visit(self, event):
        if event.moment != "claim" and event.moment != "wait":
            self.values[event.node, -1] = self.values.get((event.node, -1), 0.0) + 1.0

    def end(self):
        self.values = {place: 0.5 * value for place, value in self.values.items()}


class DenseB(Dense):
    def visit(self, event):
        if event.moment == "claim":
            place = event.box, event.hole
            self.rest[place] = 40.0
            self.values[place] = 0.95 * self.values.get(place, 40.0)

    def end(self):
        pass


class DenseH(Dense):
    def visit(self, event):
        world, node = self.world, event.node
        if event.moment == "claim":
            return
        for hole in range(len(world.hole_node)):
            near = world.topology.distance(node, world.hole_node[hole]) <= world.scenario.detection_radius
            best = 1.0 if near else self.values.get((node, hole), 0.0)
            for j, length in world.reachable_neighbours(event.level, node):
                best = max(best, math.exp(-length) * self.values.get((j, hole), 0.0))
            if best > 0.0:
                self.values[node, hole] = best

    def end(self):
        self.values = {place: 0.5 * value for place, value in self.values.items()}


class DenseD(Dense):
    """Keeps distances; a value is 20 less the distance."""

    def straight(self, node):
        return self.world.topology.distance(node, self.world.scenario.goal)

    def visit(self, event):
        world, node = self.world, event.node
        if event.moment == "claim":
            return
        ways = [length + self.values.get((j, -1), self.straight(j))
                for j, length in world.reachable_neighbours(event.level, node)]  # fmt: skip
        goal = node == world.scenario.goal
        self.values[node, -1] = 0.0 if goal else min(ways, default=self.straight(node))
        self.rest[node, -1] = self.straight(node)

    def end(self):
        pass


DENSE = {"D": DenseD, "B": DenseB, "H": DenseH, "E": DenseE}


@pytest.mark.parametrize("name", "DBHE")
def test_reading_late_is_the_same_as_stepping(name):
    looks = 0
    for seed in range(200):
        rng, scenario = random.Random(seed), random_scenario(seed)
        world = World(scenario)
        field, dense = make(name, world), DENSE[name](world)
        shown = (lambda value: max(0.0, 20.0 - value)) if name == "D" else (lambda value: value)
        for tick in range(1, 400):
            world.now += TICK
            dense.tick()
            if rng.random() < 0.2:
                node = rng.randrange(len(scenario.topology))
                event = visit(world, node, "arrive", left=node)
                if scenario.boxes and scenario.holes and rng.random() < 0.3:
                    event = visit(world, node, "claim", box=rng.randrange(len(scenario.boxes)),
                                  hole=rng.randrange(len(scenario.holes)))  # fmt: skip
                field.deposit(event)
                if name != "B" or event.moment == "claim":
                    dense.visit(event)
            if rng.random() < 0.03:
                for (place, key), value in dense.values.items():
                    looks += 1
                    assert field.at(place, key) == pytest.approx(shown(value), rel=1e-9, abs=1e-12)
            if tick % 150 == 0:
                field.end_episode()
                dense.end()
                world.now = 0.0
    assert looks > 1000


@pytest.mark.parametrize("name", "DBHE")
def test_who_looks_in_between_changes_nothing(name):
    """Not even the last bit: a run that is watched would have another trace."""
    world = World(random_scenario(7))
    one, other = make(name, world), make(name, world)
    rng = random.Random(1)
    for tick in range(3000):
        world.now += TICK
        if rng.random() < 0.2:
            event = visit(world, rng.randrange(len(world.topology)), "arrive")
            assert one.deposit(event) == other.deposit(event)
        [one.at(node, 0) for node in range(len(world.topology))]
        one.keys(0), one.frame()
        if tick % 500 == 499:
            assert list(one.frame()) == list(other.frame())
            one.end_episode(), other.end_episode()
            world.now = 0.0
            assert list(one.frame()) == list(other.frame())


@pytest.mark.parametrize("name", "DBHE")
def test_after_a_half_life_half_is_left_and_in_the_end_nothing(name):
    world = World(line(6, goal=5, agents=[0], holes={2: (-1.0, 0.0)}, boxes=[(1, 1.0)], detection_radius=1.2))
    field, kept = make(name, world), make(name, world, None)
    place, key = (0, 0) if name == "B" else (3, 0) if name == "H" else (3, -1)
    blank = field.at(place, key)
    for each in (field, kept):
        each.deposit(visit(world, 4))
        each.deposit(visit(world, 3, "claim", box=0, hole=0))
        each.deposit(visit(world, 3))
        each.deposit(visit(world, 3, "claim", box=0, hole=0))
    if name == "D":
        field.d[3] = 4.0  # as if a detour were known
        kept.d[3] = 4.0
    there = kept.at(place, key)
    assert field.at(place, key) == there != blank
    for half_lives in (1, 2, 7):
        world.now = half_lives * HALF_LIFE
        assert field.at(place, key) - blank == pytest.approx((there - blank) * 0.5**half_lives, rel=1e-12)
        assert kept.at(place, key) == there
    world.now = 1e9
    assert field.at(place, key) == pytest.approx(blank, abs=1e-12)
    field.deposit(visit(world, 3))
    field.deposit(visit(world, 3, "claim", box=0, hole=0))
    field.end_episode()
    world.now = 0.0
    assert all(math.isfinite(write.value) for write in field.frame())


@pytest.mark.parametrize("name", "DBHE")
def test_a_copy_fades_as_the_original(name):
    world = World(random_scenario(11))
    field = make(name, world)
    for node in range(len(world.topology)):
        world.now += 1.0
        field.deposit(visit(world, node))
    twin = copy.deepcopy(field)
    assert list(twin.frame()) == list(field.frame())
    twin._world.now = world.now = 50.0
    assert list(twin.frame()) == list(field.frame())


def test_fading_marks_change_a_run_and_none_do_not():
    plain = play(load_scenario("hard"), seed=1, episodes=2)[0]
    for name in ("distance", "box", "hole", "exploration"):
        never = load_scenario("hard", None, {f"policy.{name}_half_life": None})
        assert play(never, seed=1, episodes=2)[0] == plain
        soon = load_scenario("hard", None, {f"policy.{name}_half_life": 1.0})
        assert play(soon, seed=1, episodes=2)[0] != plain or name == "hole", name
        for wrong in (0, -1.0, 1e-310, float("nan"), "soon"):
            with pytest.raises(ColonysimError, match=f"policy.{name}_half_life"):
                play(load_scenario("hard", None, {f"policy.{name}_half_life": wrong}), seed=1, episodes=1)
