"""The paper's policy: follow D, B or E by chance, push boxes where H leads (Section 3.4, Algorithm 9)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

from colonysim.pheromones import BoxWorth, Distance, Exploration, HoleTrail, extent
from colonysim.plugins import field_class
from colonysim.policies.choice import sample, softmax
from colonysim.policies.paths import likely_way, nearest_box, way_to_hole
from colonysim.policies.policy import Choice
from colonysim.policies.settings import settings_for
from colonysim.world.intents import Push, Travel, Wait

if TYPE_CHECKING:
    import random
    from collections.abc import Mapping, Sequence

    from colonysim.pheromones.field import Field
    from colonysim.policies.paths import Way
    from colonysim.policies.settings import StigmergySettings
    from colonysim.policies.view import LocalView
    from colonysim.world.scenario import Scenario
    from colonysim.world.state import World

__all__ = ["Memory", "Stigmergy"]


@dataclass(frozen=True, slots=True)
class Memory:
    """What an agent remembers from one decision to the next.

    Attributes:
        epsilon: Its chance to explore.
        box: The box it is committed to, or -1.
        hole: The hole (key) which that box is meant for, or -1.
        way: The box's way as last planned, with the hole in sight.
        sought: A box it is on its way to, or -1; `hole` and `way` are then those meant for it.
        shunned: A box it has just dropped, or -1; it will not take it again before it has moved.
        shunned_at: The node at which it dropped that box.
    """

    epsilon: float
    box: int = -1
    hole: int = -1
    way: Way = ()
    sought: int = -1
    shunned: int = -1
    shunned_at: int = -1


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
        if memory.shunned >= 0 and view.node != memory.shunned_at:
            memory = dataclasses.replace(memory, shunned=-1, shunned_at=-1)
        if memory.box >= 0:
            carried = self._carry(view, memory)
            if carried is not None:
                return carried
            dropped = memory.box if view.held_box == memory.box else -1
            memory = Memory(memory.epsilon, shunned=dropped, shunned_at=view.node)
        return self._choose(view, memory, random)

    # -- with a box ------------------------------------------------------------------------------------------------

    def _carry(self, view: LocalView, memory: Memory) -> Choice | None:
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
        if self._allowed(view, node) and not (view.refused is not None and self._impatient(view)):
            return Choice(Push(box, node, hole), memory)
        if self._impatient(view):
            return None
        seconds = None if s.patience is None else (s.patience - view.waited) * view.edge_seconds
        return Choice(Wait(self._causes(view, (node,)), seconds, node if s.ask_to_clear else -1), memory)

    def _impatient(self, view: LocalView) -> bool:
        patience = self.settings.patience
        return patience is not None and view.waited >= patience - 1e-9

    def _way(self, view: LocalView, box: int, hole: int, planned: Way = ()) -> Way:
        """The way on which a visible box comes nearer to a hole; beyond its next node it may be unknown.

        Within R the shortest way is planned. Where that leads out of sight of the hole the box still follows it: H is
        1 wherever the hole is in sight, and would lead straight back. Elsewhere the box climbs H.
        """
        at = view.box_node(box)
        if hole in view.holes():
            if view.hole_node(hole) == at or not self._has_room(view, box, hole):
                return ()
            way = way_to_hole(view, box, hole, self._goal)
            if way:
                return way
        elif at in planned[:-1]:
            rest = planned[planned.index(at) :]
            slides = view.sees(rest[1]) and view.can_slide(box, at, rest[1])
            if slides and (len(rest) == 2 or view.can_follow(box, at, rest[1])):
                return rest
        trail = view.fields["H"]
        best, best_scent = -1, trail.at(at, hole)
        for j in view.pushes(box, self._goal):
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
        near = [hole for hole in view.holes() if view.hole_near(hole, centre)]
        scented: set[int] = set()
        if at == view.node or at in view.neighbours:
            trail = view.fields["H"]
            for j in view.pushes(box, self._goal):
                scented.update(trail.keys(j))
        if memory.sought == box:
            scented.add(memory.hole)
        found, asked = [], at in (view.node, from_node)
        for hole in sorted({*near, *scented}):
            planned = memory.way if (memory.sought, memory.hole) == (box, hole) else ()
            if at == view.node or at in view.neighbours:
                way = self._way(view, box, hole, planned)
            elif hole not in view.holes():
                way = planned if at in planned[:1] else ()
            else:
                way = way_to_hole(view, box, hole, self._goal) if self._has_room(view, box, hole) else ()
            if way and asked and view.foresees:
                way = self._likely_way(view, box, hole, way)
            if way:
                found.append((hole, way))
        if found and asked and not view.foresees:
            chances = view.feasible(box, [way[1] for _, way in found])
            found = [pair for pair, chance in zip(found, chances, strict=True) if chance >= s.feasibility]
        return found

    # -- without a box ---------------------------------------------------------------------------------------------

    def _choose(self, view: LocalView, memory: Memory, random: random.Random) -> Choice:
        options = view.exits()
        if self.settings.collision == "two_node":
            options = [j for j in options if not view.crowded(j)]
        if self.settings.ask_to_clear:
            options = [j for j in options if not view.wanted(j)]
        if view.asked_to_clear and options:
            return self._follow_distance(view, memory, random, options, -1, -1, None)
        if random.random() < memory.epsilon:
            return self._explore(view, memory, random, options)
        return self._exploit(view, memory, random, options)

    def _explore(self, view: LocalView, memory: Memory, random: random.Random, options: list[int]) -> Choice:
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
        nodes = sorted({*options, *targets})
        if s.epsilon_per == "choice":
            memory = dataclasses.replace(memory, epsilon=max(s.epsilon_floor, memory.epsilon * s.epsilon_decay))
        if not nodes:
            return self._follow_distance(view, memory, random, options, -1, -1, None)
        marks = view.fields["E"]
        chances = softmax([-value for value in marks.values(nodes)], s.beta)
        chosen = nodes[sample(chances, random)]
        boxes = tuple(held.get(node, -1) for node in nodes)
        if chosen in targets:
            holes = targets[chosen]
            hole, way = holes[int(random.random() * len(holes))]
            intent, memory = self._claim(view, memory, held[chosen], hole, way)
            return Choice(intent, memory, True, tuple(nodes), boxes, tuple(chances))
        return Choice(Travel(chosen), memory, True, tuple(nodes), boxes, tuple(chances))

    def _exploit(self, view: LocalView, memory: Memory, random: random.Random, options: list[int]) -> Choice:
        """Weighs B of the nearest box against D of the neighbours."""
        seen = nearest_box(view, (memory.shunned,), self._goal)
        if seen is None:
            return self._follow_distance(view, memory, random, options, -1, -1, None)
        box, first = seen
        if first != view.node and not self._allowed(view, first):
            return self._follow_distance(view, memory, random, options, -1, -1, None)
        found = self._targets(view, memory, box, first)
        if not found:
            return self._follow_distance(view, memory, random, options, -1, -1, None)
        worth = view.fields["B"]
        values = [worth.at(box, hole) for hole, _ in found]
        pick = sample(softmax(values, self.settings.beta), random) if len(found) > 1 else 0
        return self._follow_distance(view, memory, random, options, box, first, (values[pick], *found[pick]))

    def _follow_distance(
        self,
        view: LocalView,
        memory: Memory,
        random: random.Random,
        options: Sequence[int],
        box: int,
        towards: int,
        target: tuple[float, int, Way] | None,
    ) -> Choice:
        """One softmax over D of the neighbours and, if there is a box to go for, its B.

        Args:
            view: What the agent sees.
            memory: What it remembers.
            random: Its stream.
            options: Neighbours it could travel to.
            box: The box to go for, or -1.
            towards: The first node on the way to it.
            target: B of that box, the hole it is meant for, and the box's way there.
        """
        values = view.fields["D"].values(options)
        nodes, boxes = tuple(options), (-1,) * len(options)
        if target is not None:
            values.append(target[0])
            nodes, boxes = (*nodes, towards), (*boxes, box)
        elif self.settings.step_past and self._shut_in(view, values):
            beside = self._boxes_to_pass(view, memory)
            values += view.fields["D"].values(list(beside))
            nodes, boxes = (*nodes, *beside), (*boxes, *beside.values())
        if not values:  # whatever could give an idle agent something to do by changing
            return Choice(Wait(view.around()), memory)
        chances = softmax(values, self.settings.beta)
        i = sample(chances, random)
        if i < len(options):
            return Choice(Travel(nodes[i]), memory, False, nodes, boxes, tuple(chances))
        intent: Travel | Push | Wait
        if target is None:
            intent = Push(boxes[i], nodes[i], -1)
            memory = Memory(memory.epsilon, shunned=boxes[i], shunned_at=nodes[i])
        elif view.graspable_from(view.node, box) and view.box_node(box) == towards:
            intent, memory = self._claim(view, memory, box, target[1], target[2])
        else:
            intent = Travel(towards)
            if self.settings.errands:
                memory = dataclasses.replace(memory, sought=box, hole=target[1], way=target[2])
        return Choice(intent, memory, False, nodes, boxes, tuple(chances))

    def _shut_in(self, view: LocalView, values: Sequence[float]) -> bool:
        """Whether the agent has no way out, or none from which it knows a way to the goal, given D of its exits."""
        return max(values) <= 0.0 if values else not any(view.passable(j) for j in view.neighbours)

    def _boxes_to_pass(self, view: LocalView, memory: Memory) -> dict[int, int]:
        """Nodes beside the agent with the boxes that it could step to there, to leave them on another side."""
        beside = {view.box_node(box): box for box in view.boxes() if box != memory.shunned}
        return {
            node: box
            for node, box in beside.items()
            if node in view.neighbours and view.graspable_from(view.node, box) and self._allowed(view, node)
        }

    def _claim(self, view: LocalView, memory: Memory, box: int, hole: int, way: Way) -> tuple[Push | Wait, Memory]:
        """Commits to a box: steps to its node, or pushes at once if the agent already shares it."""
        committed = Memory(memory.epsilon, box, hole, way if self.settings.errands else ())
        at = view.box_node(box)
        if at != view.node:
            return Push(box, at, hole), committed
        first = way[1]
        if self._allowed(view, first):
            return Push(box, first, hole), committed
        seconds = self.settings.patience
        return Wait(self._causes(view, (first,)), None if seconds is None else seconds * view.edge_seconds), memory

    def _allowed(self, view: LocalView, node: int) -> bool:
        """Whether the collision rule lets the agent go to a neighbour (Algorithm 8, or reservations)."""
        s = self.settings
        if not view.free(node) or (s.ask_to_clear and view.wanted(node)):
            return False
        return not (s.collision == "two_node" and view.crowded(node))

    def _causes(self, view: LocalView, nodes: Sequence[int]) -> tuple[int, ...]:
        """The nodes whose change could allow one of `nodes`: themselves, and under Algorithm 8 their neighbours."""
        if self.settings.collision == "reservation":
            return tuple(nodes)
        return tuple(sorted({*nodes, *(j for node in nodes for j, _ in view.ways(node))}))
