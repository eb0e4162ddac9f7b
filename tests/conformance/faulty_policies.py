"""Policies that each break one promise; `check_policy` must name it."""

from __future__ import annotations

import dataclasses
import random as shared_random
import secrets
from typing import Any

from colonysim.pheromones import Distance, Exploration, Write
from colonysim.policies.policy import Choice
from colonysim.policies.stigmergy import Stigmergy
from colonysim.policies.uniform import Uniform
from colonysim.world.intents import Push, Travel, Wait


class SeesAllBoxes(Uniform):
    """Reaches through the view for boxes that are out of sight."""

    def decide(self, view, memory, random):
        exits, boxes = view.exits(), view._world.box_node
        if boxes and exits:
            return Choice(Travel(exits[sum(boxes) % len(exits)]), memory)
        return super().decide(view, memory, random)


class ReadsFarMarks(Stigmergy):
    """Reaches through a field's window for what is written elsewhere."""

    def decide(self, view, memory, random):
        exits = view.exits()
        if not exits:
            return super().decide(view, memory, random)
        marks = view.fields["D"]._field
        best = max(range(len(view._world.topology)), key=marks.at)
        return Choice(Travel(min(exits, key=lambda node: (abs(node - best), node))), memory)


class KnowsTheMap(Uniform):
    """Reads heights in the scenario that no agent has seen."""

    def __init__(self, scenario):
        super().__init__(scenario)
        self.total = sum(scenario.topology.z)

    def decide(self, view, memory, random):
        exits = view.exits()
        if exits:
            return Choice(Travel(exits[int(self.total * 10) % len(exits)]), memory)
        return super().decide(view, memory, random)


class SeesReservations(Uniform):
    """Draws once more if anything is reserved anywhere."""

    def decide(self, view, memory, random):
        if any(agent >= 0 for agent in view._world.node_holder):
            random.random()
        return super().decide(view, memory, random)


class KnowsWhereOthersAre(Uniform):
    """Waits as long as some agent is far away."""

    def decide(self, view, memory, random):
        if sum(view._world.agent_node) % 2:
            return Choice(Wait((), 1.0), memory)
        return super().decide(view, memory, random)


class KeepsCount(Uniform):
    """Keeps state in itself."""

    def __init__(self, scenario):
        super().__init__(scenario)
        self.count = 0

    def decide(self, view, memory, random):
        self.count += 1
        exits = view.exits()
        if exits and self.count % 3 == 0:
            return Choice(Travel(exits[0]), memory)
        return super().decide(view, memory, random)


class SharesMemory(Uniform):
    """One list for all agents and all colonies."""

    visited: list[int] = []  # noqa: RUF012

    def decide(self, view, memory, random):
        exits = [node for node in view.exits() if self.visited[-3:].count(node) == 0]
        self.visited.append(view.node)
        return Choice(Travel(exits[0]), memory) if exits else super().decide(view, memory, random)


class Gambles(Uniform):
    """Draws from the generator that belongs to everybody."""

    def decide(self, view, memory, random):
        return super().decide(view, memory, shared_random)


class Unpredictable(Uniform):
    """Has randomness that no seed reaches."""

    def decide(self, view, memory, random):
        exits = view.exits()
        return Choice(Travel(secrets.choice(exits)), memory) if exits else super().decide(view, memory, random)


class Diary(Uniform):
    """Writes into the memory that it is given."""

    def begin(self, agent, memory):
        return []

    def decide(self, view, memory, random):
        choice = super().decide(view, None, random)
        memory.append(view.node)
        return choice._replace(memory=memory)


class Rewriter(Stigmergy):
    """Changes a frozen memory by force."""

    def decide(self, view, memory, random):
        object.__setattr__(memory, "epsilon", memory.epsilon / 2)
        return super().decide(view, dataclasses.replace(memory), random)


class Leaper(Uniform):
    """Wants to be at once where it wants to be."""

    def decide(self, view, memory, random):
        far = [node for node in range(len(view._world.topology)) if node != view.node and node not in view.neighbours]
        return Choice(Travel(far[0]), memory) if far else super().decide(view, memory, random)


class Telekinetic(Uniform):
    """Pushes boxes from afar."""

    def decide(self, view, memory, random):
        for box in view.boxes():
            if view.box_node(box) not in (view.node, *view.neighbours):
                return Choice(Push(box, view.neighbours[0], -1), memory)
        return super().decide(view, memory, random)


class Miscounts(Uniform):
    """Its chances do not add up."""

    def decide(self, view, memory, random):
        choice = super().decide(view, memory, random)
        return choice._replace(probabilities=tuple(p / 2 for p in choice.probabilities))


class Ubiquitous(Stigmergy):
    """Its marks reach everywhere at once."""

    def fields(self, world):
        return {**super().fields(world), "D": Distance(world, d_max=100.0, everywhere=True)}


class Spills(Stigmergy):
    """Its marks run over onto the neighbours."""

    def fields(self, world):
        return {**super().fields(world), "E": _Spilling(world)}


class _Spilling(Exploration):
    def deposit(self, visit: Any) -> list[Write]:
        writes = list(super().deposit(visit))
        for node in self._world.topology.neighbours[visit.node]:
            self.stored[node] += 0.1
        return writes


class LosesItsMind(Uniform):
    """Remembers a set, and writes down nothing of it."""

    def begin(self, agent, memory):
        return memory or {agent}

    def decide(self, view, memory, random):
        if len(memory) > 3 and len(view.neighbours) > 1:
            return Choice(Travel(view.neighbours[0]), {view.agent})
        return super().decide(view, None, random)._replace(memory=memory | {view.node + 1000})

    def state(self, agent, memory):
        return []

    def restore(self, agent, state):
        return {agent}


FAULTS: list[tuple[Any, str]] = [
    (LosesItsMind, "saving"),
    (SeesAllBoxes, "local decisions"),
    (ReadsFarMarks, "local decisions"),
    (KnowsTheMap, "local decisions"),
    (SeesReservations, "local decisions"),
    (KnowsWhereOthersAre, "local decisions"),
    (KeepsCount, "no state of its own"),
    (SharesMemory, "no state of its own"),
    (Gambles, "randomness"),
    (Unpredictable, "repeatable"),
    (Diary, "memory"),
    (Rewriter, "memory"),
    (Leaper, "legal intents"),
    (Telekinetic, "legal intents"),
    (Miscounts, "legal intents"),
    (Ubiquitous, "local marks"),
    (Spills, "local marks"),
]
