# cython: boundscheck=False, wraparound=False, initializedcheck=False
"""Steps of agents that have nothing to do but travel: most of what happens on a large map, told in one breath.

An agent without a box, with none in sight, and that nobody asks to make way, can only choose a neighbour to travel to.
Its look, decision, reservation, step and deposits are written out here on the flat arrays, without the objects that
carry them elsewhere. The same rows come out, bit for bit: `tests/core/test_strides.py` compares both.

Installation compiles this file where there is a C compiler (`hatch_build.py`); `strides.pxd` says what its variables
are then. It runs uncompiled too.
"""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

from colonysim.backends.nodeworld import NodeWorld
from colonysim.exact import exp
from colonysim.pheromones import BoxWorth, Distance, Exploration, HoleTrail
from colonysim.pheromones.field import Visit
from colonysim.policies.stigmergy import Stigmergy

if TYPE_CHECKING:
    from collections.abc import Mapping
    from random import Random
    from typing import Any

    from colonysim.backends.protocol import Backend
    from colonysim.pheromones.field import Field, Moment
    from colonysim.policies.policy import Policy
    from colonysim.policies.settings import StigmergySettings
    from colonysim.policies.view import LocalView
    from colonysim.trace.rows import Rows
    from colonysim.world.state import World

__all__ = ["Strides", "strides_of"]

UNKNOWN = float("inf")


def strides_of(
    world: World,
    fields: Mapping[str, Field],
    backend: Backend,
    policy: Policy,
    memories: list[Any],
    views: list[LocalView],
    random: list[Random],
    steps: list[int],
    rows: Rows,
) -> Strides | None:
    """The strides of an episode, or None if they would not do what policy, fields or backend say."""
    if not isinstance(policy, Stigmergy) or not isinstance(backend, NodeWorld):
        return None
    if (type(policy), type(backend)) != (Stigmergy, NodeWorld):  # what is derived from them may do as it likes
        return None
    s = policy.settings
    known = {"D": Distance, "B": BoxWorth, "H": HoleTrail, "E": Exploration}
    if {name: type(field) for name, field in fields.items()} != known:
        return None
    if s.collision != "reservation" or s.epsilon_per != "episode" or s.updates != "occupied":
        return None
    return Strides(world, fields, backend, s, memories, views, random, steps, rows)


class Strides:
    """Begins and ends the steps of agents that only travel.

    Args:
        world: As it is at the start of the episode; its arrays are read and written.
        fields: D, B, H and E.
        backend: How long a travel takes.
        settings: The policy's.
        memories: What each agent remembers; the list is shared with the episode, as are the following.
        views: What each agent sees.
        random: Each agent's stream.
        steps: Steps each agent has begun.
        rows: The trace.
    """

    def __init__(
        self,
        world: World,
        fields: Mapping[str, Field],
        backend: NodeWorld,
        settings: StigmergySettings,
        memories: list[Any],
        views: list[LocalView],
        random: list[Random],
        steps: list[int],
        rows: Rows,
    ) -> None:
        scenario, topology = world.scenario, world.topology
        self.goal, self.max_steps, self.reach = scenario.goal, scenario.max_steps, scenario.reach
        self.first, self.ends, self.lengths, self.rises = topology.edges
        self.surface, self.occupant, self.node_holder = world.surface, world.occupant, world.node_holder
        self.reserved, self.agent_node, self.agent_from = world.reserved, world.agent_node, world.agent_from
        self.agent_box, self.box_base, self.clear_requests = world.agent_box, world.box_base, world.clear_requests
        distance, exploration = fields["D"], fields["E"]
        assert isinstance(distance, Distance) and isinstance(exploration, Exploration)
        self.d, self.official, self.known = distance.d, distance.official, distance.visited
        self.straight, self.d_max = distance.straight, distance.d_max
        self.lrta, self.blank = distance.lrta, distance.blank
        self.stored, self.visited = exploration.stored, exploration.visited
        self.scale, self.shift = exploration.scale, exploration.shift
        self.marks_waits = settings.exploration_on_wait
        # Without boxes B, and without holes H, have nothing to say.
        self.worth = fields["B"] if scenario.boxes else None
        self.sight = world.sight() if scenario.boxes else None
        self.trail = fields["H"] if scenario.holes else None
        self.beta = settings.beta
        timing = scenario.timing
        self.measured = timing.travels
        self.fixed, self.pace, self.jitter, self.jitters = (
            timing.travel_fixed, timing.travel, timing.jitter, backend.jitters
        )  # fmt: skip
        self.memories, self.views, self.steps, self.rows = memories, views, steps, rows
        self.draw = [stream.random for stream in random]
        self.epsilon = array("d", [memory.epsilon for memory in memories])  # it changes between episodes only
        self.visit = Visit()
        self.target = array("i", [-1]) * len(memories)
        self.began = array("d", [0.0]) * len(memories)
        self.moved = bytearray(len(memories))
        # What a choice is between: the ways' places in `ends`, the nodes, and their chances.
        most = max(map(len, topology.neighbours), default=0)
        self.ways, self.options, self.chances = (
            array("i", [0]) * most, array("i", [0]) * most, array("d", [0.0]) * most
        )  # fmt: skip

    def depart(self, agent: int, now: float) -> float:
        """Lets an agent choose and begin a travel (Algorithm 9 without boxes); returns how long it takes.

        Returns -1 and changes nothing if the agent is done, or if there may be more to decide than where to travel.
        """
        node, steps = self.agent_node[agent], self.steps[agent]
        if node == self.goal or steps >= self.max_steps or self.agent_box[agent] >= 0 or self.reserved[agent]:
            return self.hand_back(agent)
        if self.clear_requests:  # asked to make way, or to keep off a node
            return self.hand_back(agent)
        if self.sight is not None:
            memory = self.memories[agent]
            if memory.box >= 0 or memory.shunned >= 0 or self.sight.sees_box(node):
                return self.hand_back(agent)
        surface, occupant, holder, ends = self.surface, self.occupant, self.node_holder, self.ends
        options, level, reach, count = self.options, surface[node], self.reach, 0
        for way in range(self.first[node], self.first[node + 1]):
            j = ends[way]
            if -reach < surface[j] - level - self.rises[way] < reach and occupant[j] == -1 and holder[j] == -1:
                self.ways[count], options[count] = way, j
                count += 1
        if count == 0:
            return self.hand_back(agent)
        draw = self.draw[agent]
        explored = draw() < self.epsilon[agent]
        chosen = self.choose(count, explored, draw())
        target, way = options[chosen], self.ways[chosen]
        self.rows.chose(agent, node, explored, target, options, self.chances, count)
        holder[target] = agent
        self.reserved[agent] = (target,)
        self.target[agent], self.began[agent] = target, now
        self.steps[agent] = steps + 1
        return self.seconds(agent, node, target, self.lengths[way])

    def hand_back(self, agent: int) -> float:
        """Leaves what comes next to the policy, which sees an agent that has just arrived if it has."""
        if self.moved[agent]:
            self.moved[agent] = 0
            view = self.views[agent]
            view.waited, view.refused, view.failures = 0.0, None, 0
        return -1.0

    def choose(self, count: int, explored: bool, rest: float) -> int:
        """Which of the first `count` options it is to be, `rest` being drawn; `softmax` and `sample` in one."""
        chances, options, beta = self.chances, self.options, self.beta
        for i in range(count):
            chances[i] = -self.crowding(options[i]) if explored else self.nearness(options[i])
        top = chances[0]
        for i in range(1, count):
            if chances[i] > top:
                top = chances[i]
        total = 0.0
        for i in range(count):
            chances[i] = 1.0 if chances[i] == top else exp(beta * (chances[i] - top))
            total += chances[i]
        chosen, last = -1, 0
        for i in range(count):
            chances[i] = chances[i] / total
            if chosen < 0 and chances[i] > 0.0:
                rest -= chances[i]
                last = i
                if rest < 0.0:
                    chosen = i
        return chosen if chosen >= 0 else last

    def crowding(self, node: int) -> float:
        """E of a node."""
        return self.stored[node] * self.scale - self.shift

    def nearness(self, node: int) -> float:
        """D of a node."""
        value = self.d_max - self.d[node]
        if value <= 0.0 or (self.blank and not self.known[node]):
            return 0.0
        return value

    def seconds(self, agent: int, i: int, j: int, length: float) -> float:
        """How long the travel takes, as the node world has it."""
        took = self.fixed + self.pace * length
        if self.measured:
            took = self.measured.get((i, j), took)
        if self.jitter:
            took *= 1.0 + self.jitter * (2.0 * self.jitters[agent]() - 1.0)
        return took

    def arrive(self, agent: int) -> tuple[int, int]:
        """Ends the step: the agent is there and deposits; returns the nodes that changed."""
        origin, node, before = self.agent_node[agent], self.target[agent], self.agent_from[agent]
        self.node_holder[node] = -1
        self.reserved[agent] = ()
        if self.occupant[origin] == agent:
            self.occupant[origin] = -1
        self.occupant[node] = agent
        self.agent_node[agent] = node
        self.agent_from[agent] = origin
        self.moved[agent] = 1
        self.rows.travelled(agent, origin, node, self.steps[agent], self.began[agent])
        self.mark("arrive", agent, -1, -1, origin, before)
        return origin, node

    def mark(self, moment: Moment, agent: int, box: int, hole: int, left: int, before: int) -> None:
        """Deposits of an agent where it stands, see `Visit`; at any moment but the start of an episode."""
        node, held = self.agent_node[agent], self.agent_box[agent]
        level = self.box_base[held] if held >= 0 else self.surface[node]
        rows, worth, trail, stays = self.rows, self.worth, self.trail, moment != "claim"
        if stays:
            self.update_distance(node, level)
            rows.deposit("D", agent, node, self.nearness(node))
        if worth is not None or trail is not None:
            visit = self.visit
            visit.moment, visit.agent, visit.node, visit.level = moment, agent, node, level
            visit.box, visit.hole, visit.left, visit.before = box, hole, left, before
            if worth is not None and (writes := worth.deposit(visit)):
                rows.deposits(worth, agent, writes)
            if trail is not None and (writes := trail.deposit(visit)):
                rows.deposits(trail, agent, writes)
        if stays and (self.marks_waits or moment != "wait"):
            self.stored[node] += 1.0 / self.scale
            self.visited[node] = 1
            rows.deposit("E", agent, node, self.crowding(node))

    def update_distance(self, node: int, level: float) -> None:
        """Algorithm 2, as `Distance` does it."""
        self.known[node] = 1
        d, official, surface, reach = self.d, self.official, self.surface, self.reach
        best = best_official = UNKNOWN
        for way in range(self.first[node], self.first[node + 1]):
            j = self.ends[way]
            if -reach < surface[j] - level - self.rises[way] < reach:
                through = d[j] + self.lengths[way]
                if through < best:
                    best = through
                if through < best_official and official[j]:
                    best_official = through
        if node == self.goal:
            best = best_official = 0.0
        if best_official < UNKNOWN:
            official[node] = 1
        value = best if self.lrta else best_official
        d[node] = value if value < UNKNOWN else self.straight[node]
