# cython: boundscheck=False, wraparound=False, initializedcheck=False
"""Steps of stigmergic agents in the node world, told in one breath: look, decision, reservation, step and deposits.

What happens is written out here on the flat arrays, without the objects that carry it elsewhere; what does not come to
pass at once, because the agent waits or a place is taken, is handed back. Most steps on a large map are strolls: an
agent without a box, with none in sight, and that nobody asks to make way, can only choose a neighbour to travel to.
Others are thought about by the policy. The same rows come out, bit for bit: `tests/core/test_strides.py` compares both.

Installation compiles this file where there is a C compiler (`hatch_build.py`); `strides.pxd` says what its variables
are then. It runs uncompiled too.
"""

from __future__ import annotations

from array import array
from typing import TYPE_CHECKING

from colonysim.backends.nodeworld import NodeWorld
from colonysim.pheromones import Distance
from colonysim.pheromones.box import BoxWorth
from colonysim.pheromones.exploration import Exploration
from colonysim.pheromones.field import Visit, Write
from colonysim.pheromones.hole import HoleTrail
from colonysim.policies.choice import pick, weigh
from colonysim.policies.presets import Colony
from colonysim.policies.stigmergy import Stigmergy
from colonysim.simulation.foreign import overrides

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from random import Random
    from typing import Any

    from colonysim.backends.protocol import Backend
    from colonysim.pheromones.field import Field, Moment
    from colonysim.policies.policy import Policy
    from colonysim.policies.thought import Thought
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
    views: list[LocalView],
    steps: array[int],
    rows: Rows,
    asks: dict[int, int],
    withdraw: Callable[[int], None],
) -> Strides | None:
    """The strides of a run's episodes, or None if they would not do what policy, fields or backend say."""
    if not isinstance(policy, Stigmergy) or not isinstance(backend, NodeWorld):
        return None
    if type(policy) not in (Stigmergy, Colony) or type(backend) is not NodeWorld:
        return None  # what else is derived from them may do as it likes
    if overrides(policy) or overrides(backend):
        return None
    s = policy.settings
    known = {"D": Distance, "B": BoxWorth, "H": HoleTrail, "E": Exploration}
    if {name: type(field) for name, field in fields.items()} != known:
        return None
    if s.collision != "reservation" or s.epsilon_per != "episode" or s.updates != "occupied":
        return None
    return Strides(world, fields, backend, policy, views, steps, rows, asks, withdraw)


class Strides:
    """Begins and ends the steps of agents.

    Args:
        world: The world; its arrays are read and written.
        fields: D, B, H and E.
        backend: How long a step takes.
        policy: What decides wherever there is more to it than a stroll.
        views: What each agent sees.
        steps: Steps each agent has begun, shared with the episode.
        rows: The trace.
        asks: The node that an agent asks to be cleared, by agent.
        withdraw: Called when an agent that asks acts.
    """

    def __init__(
        self,
        world: World,
        fields: Mapping[str, Field],
        backend: NodeWorld,
        policy: Stigmergy,
        views: list[LocalView],
        steps: array[int],
        rows: Rows,
        asks: dict[int, int],
        withdraw: Callable[[int], None],
    ) -> None:
        scenario, topology, settings = world.scenario, world.topology, policy.settings
        self.world, self.policy, self.asks, self.withdraw = world, policy, asks, withdraw
        self.goal, self.max_steps, self.reach = scenario.goal, scenario.max_steps, scenario.reach
        self.first, self.ends, self.lengths, self.rises = topology.edges
        self.surface, self.occupant, self.node_holder = world.surface, world.occupant, world.node_holder
        self.reserved, self.agent_node, self.agent_from = world.reserved, world.agent_node, world.agent_from
        self.agent_box, self.box_base, self.clear_requests = world.agent_box, world.box_base, world.clear_requests
        distance, exploration, worth, trail = (fields[name] for name in "DEBH")
        assert isinstance(distance, Distance) and isinstance(exploration, Exploration)
        assert isinstance(worth, BoxWorth) and isinstance(trail, HoleTrail)
        self.d, self.official, self.known = distance.d, distance.official, distance.visited
        self.straight, self.d_max = distance.straight, distance.d_max
        self.lrta, self.blank = distance.lrta, distance.blank
        self.exploration, self.backend = exploration, backend
        self.marks_waits, self.marks_starts = settings.exploration_on_wait, settings.deposit_at_start
        # Without boxes B, and without holes H, have nothing to say.
        self.worth = worth if scenario.boxes else None
        self.sight = world.sight() if scenario.boxes else None
        self.trail = trail if scenario.holes else None
        self.hole_at, self.plain = world.hole_at, settings.hole_rule == "max"
        self.beta = settings.beta
        timing = scenario.timing
        self.travels, self.pushes = timing.travels, timing.pushes
        self.fixed, self.pace, self.push_fixed, self.push_pace, self.jitter = (
            timing.travel_fixed, timing.travel, timing.push_fixed, timing.push, timing.jitter
        )  # fmt: skip
        self.views, self.steps, self.rows = views, steps, rows
        self.visit = Visit()
        # What each agent is doing: where to, with which box for which hole, where that leaves it, and since when.
        agents = len(views)
        self.target, self.box, self.hole, self.ends_at = (array("i", [-1]) * agents for _ in range(4))
        self.epsilon, self.began = array("d", [0.0]) * agents, array("d", [0.0]) * agents
        self.handed: dict[int, Thought] = {}
        self.moved = bytearray(agents)
        # What a choice is between: the ways' places in `ends`, the nodes, and their chances.
        most = topology.most_neighbours
        self.ways, self.options, self.chances = (
            array("i", [0]) * most, array("i", [0]) * most, array("d", [0.0]) * most
        )  # fmt: skip

    def prepare(self, memories: list[Any], random: list[Random]) -> None:
        """Begins an episode.

        Args:
            memories: What each agent remembers; the list is shared with the episode.
            random: Each agent's stream.
        """
        self.memories, self.draw = memories, [stream.random for stream in random]
        for agent in range(len(memories)):
            memory = memories[agent]
            # It changes between episodes only.
            self.epsilon[agent], self.target[agent], self.moved[agent] = memory.epsilon, -1, 0
        self.handed.clear()
        self.draws = self.backend.draws
        # What has evaporated is not the same array any more.
        self.stored, self.visited = self.exploration.stored, self.exploration.visited
        self.scale, self.shift = self.exploration.scale, self.exploration.shift

    def depart(self, agent: int, now: float) -> float:
        """Lets an agent decide and begin a step (Algorithm 9); returns how long it takes.

        Returns -1 if the agent is done, or if its step cannot begin now; what it has decided is then in `handed_back`.
        """
        node = self.agent_node[agent]
        if self.world.arrived(agent) or self.steps[agent] >= self.max_steps or self.reserved[agent]:
            self.tell(agent)
            return -1.0
        if self.agent_box[agent] < 0 and not self.clear_requests:  # asked to make way, or to keep off a node
            memory = self.memories[agent]
            if self.sight is None or (memory.box < 0 and memory.shunned < 0 and not self.sight.sees_box(node)):
                seconds = self.stroll(agent, node, now)
                if seconds >= 0.0:
                    return seconds
        return self.think(agent, node, now)

    def stroll(self, agent: int, node: int, now: float) -> float:
        """Lets an agent choose and begin a travel, there being nothing else to do; returns -1 if it is shut in."""
        surface, occupant, holder, ends = self.surface, self.occupant, self.node_holder, self.ends
        options, level, reach, count = self.options, surface[node], self.reach, 0
        for way in range(self.first[node], self.first[node + 1]):
            j = ends[way]
            if -reach < surface[j] - level - self.rises[way] < reach and occupant[j] == -1 and holder[j] == -1:
                self.ways[count], options[count] = way, j
                count += 1
        if count == 0:
            return -1.0
        draw = self.draw[agent]
        explored = draw() < self.epsilon[agent]
        chosen = self.choose(count, explored, draw())
        target, way = options[chosen], self.ways[chosen]
        self.rows.chose(agent, node, explored, target, options, self.chances, count)
        self.begin(agent, target, now)
        self.box[agent] = -1
        return self.seconds(agent, node, target, self.lengths[way], False)

    def think(self, agent: int, node: int, now: float) -> float:
        """Lets the policy decide, and begins what it has decided on if nothing is in the way."""
        self.tell(agent)
        view, world = self.views[agent], self.world
        view.look()
        thought = self.policy.think(view, self.memories[agent], self.draw[agent])
        self.memories[agent] = thought.memory
        target, box, level, ends_at, pushed = thought.node, thought.box, world.level(agent), thought.node, False
        if thought.count and self.rows.kept:
            choice = thought.choice(view)
            self.rows.decision(agent, node, choice.explored, target, choice.targets, choice.boxes, choice.probabilities)
        possible = target >= 0 and world.free(agent, target)
        if possible and box < 0:
            possible = world.passable(level, node, target)
        elif possible and world.box_node[box] == target:
            possible = world.graspable(agent, box, level, node)
        elif possible:
            base, pushed = world.box_base[box], True
            possible = world.box_node[box] == node and world.top[node] == box and world.can_slide(base, node, target)
            ends_at = node if possible and world.falls(base, node, target) else target
        way = self.way(node, target)
        if not possible or way < 0:
            self.handed[agent] = thought
            return -1.0
        self.begin(agent, target, now)
        self.box[agent], self.hole[agent], self.ends_at[agent] = box, thought.hole, ends_at
        if self.asks and agent in self.asks:
            self.withdraw(agent)
        if world.claim(agent, box):
            self.mark("claim", agent, box, thought.hole, -1, -1)
        return self.seconds(agent, node, target, self.lengths[way], pushed)

    def way(self, node: int, target: int) -> int:
        """The place of an edge in `ends`, or -1."""
        for way in range(self.first[node], self.first[node + 1]):
            if self.ends[way] == target:
                return way
        return -1

    def begin(self, agent: int, target: int, now: float) -> None:
        """Reserves the target and counts the step."""
        self.node_holder[target] = agent
        self.reserved[agent] = (target,)
        self.target[agent], self.began[agent] = target, now
        self.steps[agent] += 1

    def handed_back(self, agent: int) -> Thought | None:
        """What an agent has decided and not begun, if anything; once."""
        return self.handed.pop(agent, None) if self.handed else None

    def tell(self, agent: int) -> None:
        """Lets the view of an agent know if its step has just ended."""
        if self.moved[agent]:
            self.moved[agent] = 0
            view = self.views[agent]
            view.waited, view.refused, view.failures = 0.0, None, 0

    def choose(self, count: int, explored: bool, rest: float) -> int:
        """Which of the first `count` options it is to be, `rest` being drawn."""
        chances, options = self.chances, self.options
        for i in range(count):
            chances[i] = -self.crowding(options[i]) if explored else self.nearness(options[i])
        weigh(chances, count, self.beta)
        return pick(chances, count, rest)

    def crowding(self, node: int) -> float:
        """E of a node."""
        return self.stored[node] * self.scale - self.shift

    def nearness(self, node: int) -> float:
        """D of a node."""
        value = self.d_max - self.d[node]
        if value <= 0.0 or (self.blank and not self.known[node]):
            return 0.0
        return value

    def seconds(self, agent: int, i: int, j: int, length: float, pushed: bool) -> float:
        """How long the step takes, as the node world has it."""
        measured = self.pushes if pushed else self.travels
        took = self.push_fixed + self.push_pace * length if pushed else self.fixed + self.pace * length
        if measured:
            took = measured.get((i, j), took)
        if self.draws is not None:
            took *= 1.0 + self.jitter * (2.0 * self.draws.draw(agent) - 1.0)
        return took

    def heading(self, agent: int) -> int:
        """Where the step leads that an agent has begun and not ended, or -1."""
        return self.target[agent]

    def arrive(self, agent: int) -> int:
        """Ends the step: the agent is where it leads and deposits; returns the node from which it came."""
        origin, target, before = self.agent_node[agent], self.target[agent], self.agent_from[agent]
        self.target[agent] = -1
        self.node_holder[target] = -1
        self.reserved[agent] = ()
        self.moved[agent] = 1
        if self.box[agent] >= 0:
            self.push(agent, self.box[agent], origin, target, before)
            return origin
        if self.occupant[origin] == agent:
            self.occupant[origin] = -1
        self.occupant[target] = agent
        self.agent_node[agent], self.agent_from[agent], self.agent_box[agent] = target, origin, -1
        self.rows.travelled(agent, origin, target, self.steps[agent], self.began[agent])
        self.mark("arrive", agent, -1, -1, origin, before)
        return origin

    def push(self, agent: int, box: int, origin: int, target: int, before: int) -> None:
        """Ends a push, or the step to a box."""
        ends_at, action = self.ends_at[agent], "take" if self.world.box_node[box] == target else "push"
        self.world.pushed(agent, box, target, ends_at)
        self.rows.event(
            "end", agent, action, origin, target, box, self.hole[agent], "arrived", "", self.steps[agent],
            self.began[agent], ends_at,
        )  # fmt: skip
        if ends_at != origin:
            self.mark("arrive", agent, -1, -1, origin, before)
        else:
            self.mark("wait", agent, -1, -1, -1, -1)

    def mark(self, moment: Moment, agent: int, box: int, hole: int, left: int, before: int) -> None:
        """Deposits of an agent where it stands, see `Visit`."""
        node, held = self.agent_node[agent], self.agent_box[agent]
        level = self.box_base[held] if held >= 0 else self.surface[node]
        rows, stays = self.rows, moment != "claim"
        marks = stays and (self.marks_starts or moment != "start")
        if marks:
            self.update_distance(node, level)
            rows.deposit("D", agent, node, self.nearness(node))
        if self.worth is not None:
            self.mark_boxes(self.worth, moment, agent, node, box, hole, left, before)
        if stays and self.trail is not None:
            if self.plain and not rows.kept:
                self.trail.update(node, level)
            else:
                visit = self.visit
                visit.moment, visit.agent, visit.node, visit.level = moment, agent, node, level
                rows.deposits(self.trail, agent, self.trail.deposit(visit))
        if marks and (self.marks_waits or moment != "wait"):
            self.stored[node] += 1.0 / self.scale
            self.visited[node] = 1
            rows.deposit("E", agent, node, self.crowding(node))

    def mark_boxes(
        self, worth: BoxWorth, moment: Moment, agent: int, node: int, box: int, hole: int, left: int, before: int
    ) -> None:
        """Algorithm 3, as `BoxWorth` does it."""
        if moment == "claim" and hole >= 0:
            value = worth.lower(box, hole)
            if self.rows.kept:
                self.rows.deposits(worth, agent, (Write(box, hole, value),))
        elif moment == "arrive" and (self.hole_at[node] >= 0 or self.hole_at[left] >= 0):
            hole = worth.crossed(node, left, before)
            if hole >= 0:
                credited = worth.credit(hole, agent)
                if self.rows.kept:
                    self.rows.deposits(worth, agent, [Write(each, hole, worth.at(each, hole)) for each in credited])

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
