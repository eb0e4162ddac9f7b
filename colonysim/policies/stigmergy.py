"""The paper's policy: follow D, B or E by chance, push boxes where H leads (Section 3.4, Algorithm 9)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.pheromones import BoxWorth, Distance, Exploration, HoleTrail, extent
from colonysim.plugins import field_class
from colonysim.policies.choice import sample, softmax
from colonysim.policies.paths import likely_way
from colonysim.policies.settings import settings_for
from colonysim.policies.thought import Memory, Thought
from colonysim.world.intents import Wait

if TYPE_CHECKING:
    import random
    from collections.abc import Mapping, Sequence

    from colonysim.pheromones.field import Field
    from colonysim.policies.paths import Way
    from colonysim.policies.policy import Choice
    from colonysim.policies.settings import StigmergySettings
    from colonysim.policies.view import LocalView
    from colonysim.world.scenario import Scenario
    from colonysim.world.state import World

__all__ = ["Memory", "Stigmergy"]


class Stigmergy:
    """The stigmergic policy in either of its presets, or with parameters of your own.

    Args:
        scenario: Its `policy:` section is read, see `StigmergySettings`.
        settings: Takes the place of the scenario's section if given.
    """

    def __init__(self, scenario: Scenario, settings: StigmergySettings | None = None) -> None:
        self.settings = settings or settings_for(scenario)
        preset = scenario.parameters.get("preset", "colony")
        self.name = str(preset) if settings is None else "stigmergy"
        self._goal = scenario.goal
        # Asked for in every decision; settings cannot change.
        s = self.settings
        self._beta, self._patience = s.beta, float("inf") if s.patience is None else s.patience
        self._two_node, self._ask_to_clear = s.collision == "two_node", s.ask_to_clear

    def fields(self, world: World) -> Mapping[str, Field]:
        """D, B, H and E with this policy's parameters, and the extra fields it was asked to carry.

        Raises:
            PluginError: There is no such extra field.
            ScenarioError: It has the name of another field.
        """
        s = self.settings
        d_max = s.d_max * extent(world) or 1.0
        everywhere, at_start = s.updates == "everywhere", s.deposit_at_start
        own: list[Field] = [
            Distance(
                world,
                d_max=d_max,
                rule=s.distance_rule,
                unvisited=s.unvisited,
                everywhere=everywhere,
                at_start=at_start,
            ),
            BoxWorth(
                world,
                start=s.box_start * d_max,
                decay=s.box_decay,
                cap=s.box_cap * d_max if s.box_cap is not None else float("inf"),
                credit=s.box_credit,
                stack=s.stack_credit,
            ),
            HoleTrail(world, evaporation=s.hole_evaporation, rule=s.hole_rule, everywhere=everywhere),
            Exploration(world, evaporation=s.exploration_evaporation, on_wait=s.exploration_on_wait, at_start=at_start),
        ]
        found = {field.name: field for field in own}
        for name in s.extra_fields:
            extra = field_class(name)(world)
            if extra.name in found:
                message = f"there is a field {extra.name!r} already; {name!r} must give its own another name"
                raise world.scenario.fault("policy.extra_fields", message)
            found[extra.name] = extra
        return found

    def begin(self, agent: int, memory: Memory | None) -> Memory:
        """Nothing is remembered across episodes but the chance to explore."""
        s = self.settings
        if memory is None:
            return Memory(s.epsilon)
        decay = s.epsilon_decay if s.epsilon_per == "episode" else 1.0
        return Memory(max(s.epsilon_floor, memory.epsilon * decay))

    def decide(self, view: LocalView, memory: Memory, random: random.Random) -> Choice:
        """Algorithm 9 for one agent."""
        return self.think(view, memory, random).choice()

    def think(self, view: LocalView, memory: Memory, random: random.Random) -> Thought:
        """`decide`, before it is put into words."""
        if memory.shunned >= 0 and view.node != memory.shunned_at:
            memory = Memory(memory.epsilon, memory.box, memory.hole, memory.way, memory.sought)
        if memory.box >= 0:
            carried = self._carry(view, memory)
            if carried is not None:
                return carried
            dropped = memory.box if view.held_box == memory.box else -1
            memory = Memory(memory.epsilon, shunned=dropped, shunned_at=view.node)
        return self._choose(view, memory, random)

    # -- with a box ------------------------------------------------------------------------------------------------

    def _carry(self, view: LocalView, memory: Memory) -> Thought | None:
        """The next push of the box the agent is committed to, a wait, or None to give it up."""
        box, hole, s = memory.box, memory.hole, self.settings
        if view.held_box != box or (s.tries is not None and view.failures >= s.tries):
            return None
        way = self._way(view, box, hole, memory.way)
        if way and view.foresees:
            way = self._likely_way(view, box, hole, way, memory.way)
        if not way:
            return None
        if hole in view.holes():
            memory = Memory(memory.epsilon, box, hole, way)
        node = way[1]
        if not view.foresees and view.feasible(box, (node,))[0] < s.feasibility:
            return None
        thought = Thought(memory)
        if self._allowed(view, node) and not (view.refused is not None and self._impatient(view)):
            thought.box, thought.node, thought.hole = box, node, hole
            return thought
        if self._impatient(view):
            return None
        seconds = None if s.patience is None else (s.patience - view.waited) * view.edge_seconds
        thought.wait = Wait(self._causes(view, (node,)), seconds, node if s.ask_to_clear else -1)
        return thought

    def _impatient(self, view: LocalView) -> bool:
        return view.waited >= self._patience - 1e-9

    def _way(
        self, view: LocalView, box: int, hole: int, planned: Way = (), pushes: Sequence[int] | None = None
    ) -> Way:
        """The way on which a visible box comes nearer to a hole; beyond its next node it may be unknown.

        Within R the shortest way is planned. Where that leads out of sight of the hole the box still follows it: H is
        1 wherever the hole is in sight, and would lead straight back. Elsewhere the box climbs H.
        """
        at = view.box_node(box)
        if hole in view.holes():
            if view.hole_node(hole) == at or not self._has_room(view, box, hole):
                return ()
            way = view.way_to_hole(box, hole, self._goal)
            if way:
                return way
        elif at in planned[:-1]:
            rest = planned[planned.index(at) :]
            slides = view.sees(rest[1]) and view.can_slide(box, at, rest[1])
            if slides and (len(rest) == 2 or view.can_follow(box, at, rest[1])):
                return rest
        trail = view.fields["H"]
        best, best_scent = -1, trail.at(at, hole)
        for j in view.pushes(box, self._goal) if pushes is None else pushes:
            scent = trail.at(j, hole)
            if scent > best_scent:
                best, best_scent = j, scent
        return (at, best) if best >= 0 else ()

    def _likely_way(self, view: LocalView, box: int, hole: int, way: Way, planned: Way = ()) -> Way:
        """`likely_way` with the least chance asked for; other ways than those given only with the hole in sight."""
        others = hole if hole in view.holes() and self._has_room(view, box, hole) else -1
        return likely_way(view, box, way, planned, self.settings.feasibility, others, self._goal)

    def _has_room(self, view: LocalView, box: int, hole: int) -> bool:
        """Whether the box may go into a visible hole: not if it would stand above the rim, unless allowed."""
        return self.settings.overfill or view.box_height(box) < view.headroom(hole) + view.reach

    def _targets(self, view: LocalView, memory: Memory, box: int, from_node: int) -> list[tuple[int, Way]]:
        """Hole candidates of a box next to the agent or with it (Algorithm 6), each with the box's way there."""
        s, at = self.settings, view.box_node(box)
        centre = at if s.candidates_centre == "box" else view.node
        candidates = {hole for hole in view.holes() if view.hole_near(hole, centre)}
        pushes: list[int] = []
        beside = view.beside(at)
        if beside:
            trail, pushes = view.fields["H"], view.pushes(box, self._goal)
            for j in pushes:
                candidates.update(trail.keys(j))
        if memory.sought == box:
            candidates.add(memory.hole)
        found, asked = [], at in (view.node, from_node)
        for hole in sorted(candidates):
            planned = memory.way if (memory.sought, memory.hole) == (box, hole) else ()
            if beside:
                way = self._way(view, box, hole, planned, pushes)
            elif hole not in view.holes():
                way = planned if at in planned[:1] else ()
            else:
                way = view.way_to_hole(box, hole, self._goal) if self._has_room(view, box, hole) else ()
            if way and asked and view.foresees:
                way = self._likely_way(view, box, hole, way)
            if way:
                found.append((hole, way))
        if found and asked and not view.foresees:
            chances = view.feasible(box, [way[1] for _, way in found])
            found = [pair for pair, chance in zip(found, chances, strict=True) if chance >= s.feasibility]
        return found

    # -- without a box ---------------------------------------------------------------------------------------------

    def _choose(self, view: LocalView, memory: Memory, random: random.Random) -> Thought:
        options = view.exits()
        if self._two_node:
            options = [j for j in options if not view.crowded(j)]
        if self._ask_to_clear:
            options = [j for j in options if not view.wanted(j)]
        if options and view.wanted(view.node):
            return self._follow_distance(view, memory, random, options)
        if random.random() < memory.epsilon:
            return self._explore(view, memory, random, options)
        return self._exploit(view, memory, random, options)

    def _explore(self, view: LocalView, memory: Memory, random: random.Random, options: list[int]) -> Thought:
        """Follows E; the node of a box that could be pushed counts as an option."""
        s = self.settings
        targets: dict[int, list[tuple[int, Way]]] = {}
        held: dict[int, int] = {}
        for box in view.boxes():
            at = view.box_node(box)
            if box != memory.shunned and at in view.neighbours and view.graspable_from(view.node, box):
                found = self._targets(view, memory, box, at) if self._allowed(view, at) else []
                if found:
                    targets[at], held[at] = found, box
        nodes = sorted({*options, *targets}) if targets else options
        if s.epsilon_per == "choice":
            epsilon = max(s.epsilon_floor, memory.epsilon * s.epsilon_decay)
            memory = Memory(
                epsilon, memory.box, memory.hole, memory.way, memory.sought, memory.shunned, memory.shunned_at
            )
        if not nodes:
            return self._follow_distance(view, memory, random, options)
        chances = softmax([-value for value in view.fields["E"].values(nodes)], self._beta)
        chosen = nodes[sample(chances, random)]
        boxes = [held.get(node, -1) for node in nodes]
        thought = Thought(memory)
        thought.node = chosen
        if chosen in targets:
            holes = targets[chosen]
            hole, way = holes[int(random.random() * len(holes))]
            thought = self._claim(view, memory, held[chosen], hole, way)
        thought.explored, thought.nodes, thought.boxes, thought.chances = True, nodes, boxes, chances
        return thought

    def _exploit(self, view: LocalView, memory: Memory, random: random.Random, options: list[int]) -> Thought:
        """Weighs B of the nearest box against D of the neighbours."""
        seen = view.nearest_box((memory.shunned,), self._goal)
        if seen is None:
            return self._follow_distance(view, memory, random, options)
        box, first = seen
        if first != view.node and not self._allowed(view, first):
            return self._follow_distance(view, memory, random, options)
        found = self._targets(view, memory, box, first)
        if not found:
            return self._follow_distance(view, memory, random, options)
        worth = view.fields["B"]
        values = [worth.at(box, hole) for hole, _ in found]
        pick = sample(softmax(values, self._beta), random) if len(found) > 1 else 0
        return self._follow_distance(view, memory, random, options, box, first, values[pick], found[pick])

    def _follow_distance(
        self,
        view: LocalView,
        memory: Memory,
        random: random.Random,
        options: list[int],
        box: int = -1,
        towards: int = -1,
        worth: float = 0.0,
        target: tuple[int, Way] | None = None,
    ) -> Thought:
        """One softmax over D of the neighbours and, if there is a box to go for, its B.

        Args:
            view: What the agent sees.
            memory: What it remembers.
            random: Its stream.
            options: Neighbours it could travel to.
            box: The box to go for, or -1.
            towards: The first node on the way to it.
            worth: B of that box.
            target: The hole that box is meant for, and the box's way there.
        """
        values, nodes, boxes = view.fields["D"].values(options), options, [-1] * len(options)
        if target is not None:
            values.append(worth)
            nodes, boxes = [*nodes, towards], [*boxes, box]
        elif self.settings.step_past and self._shut_in(view, values):
            beside = self._boxes_to_pass(view, memory)
            values += view.fields["D"].values(list(beside))
            nodes, boxes = [*nodes, *beside], [*boxes, *beside.values()]
        thought = Thought(memory)
        if not values:  # whatever could give an idle agent something to do by changing
            thought.wait = Wait(view.around())
            return thought
        chances = softmax(values, self._beta)
        i = sample(chances, random)
        if i < len(options):
            thought.node = nodes[i]
        elif target is None:
            thought = Thought(Memory(memory.epsilon, shunned=boxes[i], shunned_at=nodes[i]))
            thought.box, thought.node = boxes[i], nodes[i]
        elif view.graspable_from(view.node, box) and view.box_node(box) == towards:
            thought = self._claim(view, memory, box, target[0], target[1])
        else:
            if self.settings.errands:
                thought = Thought(Memory(memory.epsilon, memory.box, *target, box, memory.shunned, memory.shunned_at))
            thought.node = towards
        thought.nodes, thought.boxes, thought.chances = nodes, boxes, chances
        return thought

    def _shut_in(self, view: LocalView, values: Sequence[float]) -> bool:
        """Whether the agent has no way out, or none from which it knows a way to the goal, given D of its exits."""
        if values:
            return max(values) <= 0.0
        shut = True
        for j in view.neighbours:  # not with all(): it would take a generator each time
            shut = shut and not view.passable(j)
        return shut

    def _boxes_to_pass(self, view: LocalView, memory: Memory) -> dict[int, int]:
        """Nodes beside the agent with the boxes that it could step to there, to leave them on another side."""
        beside = {view.box_node(box): box for box in view.boxes() if box != memory.shunned}
        return {
            node: box
            for node, box in beside.items()
            if node in view.neighbours and view.graspable_from(view.node, box) and self._allowed(view, node)
        }

    def _claim(self, view: LocalView, memory: Memory, box: int, hole: int, way: Way) -> Thought:
        """Commits to a box: steps to its node, or pushes at once if the agent already shares it."""
        thought = Thought(Memory(memory.epsilon, box, hole, way if self.settings.errands else ()))
        thought.box, thought.hole, at = box, hole, view.box_node(box)
        if at != view.node:
            thought.node = at
        elif self._allowed(view, way[1]):
            thought.node = way[1]
        else:
            seconds, thought = self.settings.patience, Thought(memory)
            if self._impatient(view):
                # It has waited for that node before: whoever is there may be shut in by this very box.
                seconds, thought = 1.0, Thought(Memory(memory.epsilon, shunned=box, shunned_at=view.node))
            limit = None if seconds is None else seconds * view.edge_seconds
            thought.wait = Wait(self._causes(view, (way[1],)), limit)
        return thought

    def _allowed(self, view: LocalView, node: int) -> bool:
        """Whether the collision rule lets the agent go to a neighbour (Algorithm 8, or reservations)."""
        if not view.free(node) or (self._ask_to_clear and view.wanted(node)):
            return False
        return not (self._two_node and view.crowded(node))

    def _causes(self, view: LocalView, nodes: Sequence[int]) -> tuple[int, ...]:
        """The nodes whose change could allow one of `nodes`: themselves, and under Algorithm 8 their neighbours."""
        if self.settings.collision == "reservation":
            return tuple(nodes)
        return tuple(sorted({*nodes, *(j for node in nodes for j, _ in view.ways(node))}))
