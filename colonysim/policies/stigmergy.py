"""The paper's policy: choose by softmax over D, B or E, and push boxes where H leads (Section 3.4, Algorithm 9)."""

from __future__ import annotations

import sys
from array import array
from typing import TYPE_CHECKING, Any

from colonysim.characters import printable
from colonysim.pheromones import BoxWorth, Distance, Exploration, HoleTrail, extent
from colonysim.pheromones.distance import farthest
from colonysim.plugins import make_field
from colonysim.policies.choice import pick, weigh
from colonysim.policies.decision import Decider, Decision, Memory, Options, Stream, new_decision, new_memory
from colonysim.policies.paths import likely_way
from colonysim.policies.settings import OF_A_RUN, settings_for
from colonysim.states import Stored
from colonysim.suggest import nearest
from colonysim.world.intents import Wait

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from colonysim.pheromones.field import Field
    from colonysim.policies.paths import Way
    from colonysim.policies.settings import StigmergySettings
    from colonysim.policies.view import LocalView
    from colonysim.scenario.scenario import Scenario
    from colonysim.states import State
    from colonysim.world.state import World

__all__ = ["Memory", "Stigmergy"]

NEVER = 1 << 30
"""More decisions than any agent makes."""

_REMEMBERED = ("box", "hole", "sought", "shunned", "shunned_at")
"""What a memory holds of boxes, holes and nodes: their indices, or -1."""
HOLE_OPEN = 3
"""Weight in `Memory.vain` of a decision with an open hole visible; one without has weight 1."""


class Stigmergy(Decider):
    """The stigmergic policy in either of its presets, or with parameters of your own.

    Args:
        scenario: Its `policy:` section is read, see `StigmergySettings`.
        settings: Takes the place of the scenario's section if given.

    Attributes:
        fixed: Names of parameters that cannot change under way.
    """

    fixed = OF_A_RUN

    def __init__(self, scenario: Scenario, settings: StigmergySettings | None = None) -> None:
        self.settings = settings or settings_for(scenario)
        preset = scenario.parameters.get("preset", "colony")
        self.name = str(preset) if settings is None else "stigmergy"
        # Copies of settings, which cannot change, as C numbers for every decision.
        s = self.settings
        self._beta, self._patience = s.beta, float("inf") if s.patience is None else s.patience
        self._two_node, self._ask_to_clear = s.collision == "two_node", s.ask_to_clear
        self._least, self._overfill, self._from_box = s.feasibility, s.overfill, s.candidates_centre == "box"
        self._look_on, self._restless, self._per_choice = s.look_on, NEVER, s.epsilon_per == "choice"
        self._errands, self._step_past, self._reach = s.errands, s.step_past, scenario.reach
        self._weighs = bool(s.weights)
        self._tries = -1 if s.tries is None else min(s.tries, sys.maxsize)
        self._scenario = self._place = scenario
        self._room, self._most_holes, self._marking = -1, -1, False
        self._make_room(scenario)

    def __reduce__(self) -> tuple[Any, ...]:
        return _made_anew, (type(self), self._scenario, self.settings, self.name), getattr(self, "__dict__", None)

    def _make_room(self, scenario: Scenario) -> None:
        """Makes the scratch arrays large enough for a scenario's map, and computes its threshold of restlessness."""
        restless, topology = self.settings.restless, scenario.topology
        if restless is not None:
            choices = restless * farthest(topology, scenario.goal) / topology.mean_length
            self._restless = max(1, int(min(choices, float(NEVER))))
        room, holes = 2 * scenario.topology.most_neighbours + 1, len(scenario.holes)
        if room > self._room:
            # Options of a decision: at most all neighbours and the boxes on them.
            self._room, self._options = room, Options(room)
            self._nodes, self._boxes, self._values = self._options.nodes, self._options.boxes, self._options.chances
            # The nodes that a box could be pushed to, and the neighbours that have a box.
            self._pushes, self._beside = array("i", [0]) * room, array("i", [0]) * room
        if holes > self._most_holes:
            # Candidate holes of a box, whether each hole is among them, and B of each.
            self._most_holes = holes
            self._holes, self._worths = array("i", [0]) * holes, array("d", [0.0]) * holes
            self._marked = bytearray(holes)

    def fields(self, world: World) -> Mapping[str, Field]:
        """D, B, H and E with this policy's parameters, and the extra fields it was asked to carry.

        Raises:
            PluginError: There is no such extra field.
            ScenarioError: It has the name of another field, or a weight is that of none.
        """
        self._place = world.scenario  # it may be another than the policy was made for
        self._make_room(world.scenario)
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
                half_life=s.distance_half_life,
                diffusion=s.distance_diffusion,
                period=s.diffusion_period,
            ),
            BoxWorth(
                world,
                start=s.box_start * d_max,
                decay=s.box_decay,
                cap=s.box_cap * d_max if s.box_cap is not None else float("inf"),
                credit=s.box_credit,
                stack=s.stack_credit,
                half_life=s.box_half_life,
            ),
            HoleTrail(
                world,
                evaporation=s.hole_evaporation,
                rule=s.hole_rule,
                everywhere=everywhere,
                half_life=s.hole_half_life,
                diffusion=s.hole_diffusion,
                period=s.diffusion_period,
            ),
            Exploration(
                world,
                evaporation=s.exploration_evaporation,
                on_wait=s.exploration_on_wait,
                at_start=at_start,
                half_life=s.exploration_half_life,
                diffusion=s.exploration_diffusion,
                period=s.diffusion_period,
            ),
        ]
        found = {field.name: field for field in own}
        extras: dict[str, Field] = {}
        for name in s.extra_fields:
            extra = make_field(name, world)
            if extra.name in found:
                message = f"there is a field {extra.name!r} already; {name!r} must give its own another name"
                raise self._scenario.fault("policy.extra_fields", message)
            found[extra.name] = extras[extra.name] = extra
        for name in s.weights:
            message = ""
            if name not in extras:
                message = f"no extra field {printable(repr(name))}; {nearest(name, extras)}"
                if name in found:
                    message += "; to leave a field unread, a group of agents `ignores` it"
            elif extras[name].by_box:
                message = f"the values of {name!r} belong to boxes: only values at nodes can be weighed"
            if message:
                raise self._scenario.fault(f"policy.weights.{name}", message)
        return found

    def begin(self, agent: int, memory: Memory | None) -> Memory:
        """An agent's memory at the start of an episode: only the chance to explore is kept from the episode before."""
        s = self.settings
        if memory is None:
            return Memory(s.epsilon)
        decay = s.epsilon_decay if s.epsilon_per == "episode" else 1.0
        return Memory(max(s.epsilon_floor, memory.epsilon * decay))

    def state(self, agent: int, memory: Memory) -> State:
        """The memory of an agent as plain data."""
        numbers = {name: getattr(memory, name) for name in _REMEMBERED}
        return {"epsilon": memory.epsilon, "way": list(memory.way), "vain": memory.vain, **numbers}

    def restore(self, agent: int, state: Any) -> Memory:
        """The memory of an agent from plain data.

        Raises:
            ColonysimError: It is none.
        """
        told, place = Stored(state, f"memory of agent {agent}"), self._place
        most = {"box": len(place.boxes), "sought": len(place.boxes), "shunned": len(place.boxes)}
        most |= {"hole": len(place.holes), "shunned_at": len(place.topology)}
        numbers = {name: told.whole(name, -1, most[name] - 1) for name in _REMEMBERED}
        way = tuple(told.wholes("way", None, 0, len(place.topology) - 1))
        return Memory(told.real("epsilon", 0.0, 1.0), way=way, vain=told.whole("vain", 0, 2**31 - 1), **numbers)

    def take_over(self, memory: Memory, before: Decider) -> Memory:
        """The same, but for the chance to explore where another one was set: that is the chance from now on."""
        epsilon = self.settings.epsilon
        if not isinstance(before, Stigmergy) or before.settings.epsilon == epsilon:
            return memory
        return new_memory(
            epsilon, memory.box, memory.hole, memory.way, memory.sought, memory.shunned, memory.shunned_at, memory.vain
        )

    def think(self, view: LocalView, memory: Memory, stream: Stream) -> Decision:
        """Algorithm 9 for one agent.

        Raises:
            TypeError: There is no view or stream, or the memory is none of `begin`.
        """
        if view is None or stream is None or type(memory) is not Memory:  # compiled code would end the interpreter
            raise TypeError("a view, a memory and a stream are needed to decide")
        return self._think(view, memory, stream.draw)

    def _think(self, view: LocalView, memory: Memory, draw: Callable[[], float]) -> Decision:
        """Algorithm 9; `draw` returns the next number of the agent's stream, 0 <= draw() < 1."""
        if memory.shunned >= 0 and view.node != memory.shunned_at:
            memory = new_memory(memory.epsilon, memory.box, memory.hole, memory.way, memory.sought, -1, -1, memory.vain)
        if memory.box >= 0:
            carried = self._carry(view, memory)
            if carried is not None:
                return carried
            dropped = memory.box if view.held_box == memory.box else -1
            memory = new_memory(memory.epsilon, -1, -1, (), -1, dropped, view.node, memory.vain)
        return self._choose(view, memory, draw)

    # -- with a box ------------------------------------------------------------------------------------------------

    def _carry(self, view: LocalView, memory: Memory) -> Decision | None:
        """The next push of the box that the agent is committed to, a wait for it, or None to give the box up."""
        box, hole = memory.box, memory.hole
        if view.held_box != box or 0 <= self._tries <= view.failures:
            return None
        way = self._way(view, box, hole, memory.way)
        if way and view.foresees:
            way = self._likely_way(view, box, hole, way, memory.way)
        if not way:
            return None
        if view.sees_hole(hole):
            # With its last push something is achieved.
            vain = memory.vain if len(way) > 2 else 0
            memory = new_memory(memory.epsilon, box, hole, way, -1, -1, -1, vain)
        node = way[1]
        if not view.foresees and view.feasible(box, (node,))[0] < self._least:
            return None
        decision = new_decision(memory)
        if self._allowed(view, node) and not (view.refused is not None and self._impatient(view)):
            decision.box, decision.node, decision.hole = box, node, hole
            return decision
        if self._impatient(view):
            return None
        s = self.settings
        seconds = None if s.patience is None else (s.patience - view.waited) * view.edge_seconds
        decision.wait = Wait(self._causes(view, (node,)), seconds, node if self._ask_to_clear else -1)
        return decision

    def _impatient(self, view: LocalView) -> bool:
        """Whether the agent has waited as long as `patience` allows."""
        return view.waited >= self._patience - 1e-9

    def _way(self, view: LocalView, box: int, hole: int, planned: Way = (), count: int = -1) -> Way:
        """The way on which a visible box comes nearer to a hole; empty if there is none.

        With the hole visible it is the shortest way. Where the planned way leads to nodes from which the hole is not
        visible, the box still follows it: H is 1 wherever the hole is visible, and would lead straight back. Elsewhere
        the box, which is then next to the agent or on its node, climbs H; the way ends with its next node.

        Args:
            view: What the agent sees.
            box: The box.
            hole: The hole's key.
            planned: The way as planned before.
            count: The number of nodes in `_pushes` that the box could be pushed to; -1 to look them up.
        """
        at = view.box_node(box)
        if view.sees_hole(hole):
            if view.hole_node(hole) == at or not self._has_room(view, box, hole):
                return ()
            way = view.way_to_hole(box, hole, view.goal)
            if way:
                return way
        elif at in planned[:-1]:
            rest = planned[planned.index(at) :]
            slides = view.sees(rest[1]) and view.can_slide(box, at, rest[1])
            if slides and (len(rest) == 2 or view.can_follow(box, at, rest[1])):
                return rest
        if count < 0:
            count = view.pushes_into(box, view.goal, self._pushes)
        trail = view.h
        best, best_scent = -1, trail.read(at, hole)
        for i in range(count):
            scent = trail.read(self._pushes[i], hole)
            if scent > best_scent:
                best, best_scent = self._pushes[i], scent
        return (at, best) if best >= 0 else ()

    def _likely_way(self, view: LocalView, box: int, hole: int, way: Way, planned: Way = ()) -> Way:
        """`likely_way` for the setting `feasibility`; other ways are tried to a visible hole only."""
        others = hole if view.sees_hole(hole) and self._has_room(view, box, hole) else -1
        return likely_way(view, box, way, planned, self._least, others, view.goal)

    def _has_room(self, view: LocalView, box: int, hole: int) -> bool:
        """Whether a box may go to a visible hole: with `overfill` always, else if it will not stand above the rim."""
        return self._overfill or view.box_height(box) < view.headroom(hole) + self._reach

    def _targets(self, view: LocalView, memory: Memory, box: int, from_node: int) -> list[tuple[int, Way]]:
        """The holes that a visible box could be pushed to (Algorithm 6), each with the box's way there.

        Args:
            view: What the agent sees.
            memory: What it remembers.
            box: The box.
            from_node: The first node on the agent's way to the box.
        """
        at = view.box_node(box)
        beside, pushable = view.beside(at), 0
        if beside:
            pushable = view.pushes_into(box, view.goal, self._pushes)
        asked, own = at == view.node or at == from_node, memory.sought == box
        found: list[tuple[int, Way]] = []
        for i in range(self._candidates(view, memory, box, at, pushable)):
            hole = self._holes[i]
            planned = memory.way if own and memory.hole == hole else ()
            if beside:
                way = self._way(view, box, hole, planned, pushable)
            elif not view.sees_hole(hole):
                way = planned if at in planned[:1] else ()
            else:
                way = view.way_to_hole(box, hole, view.goal) if self._has_room(view, box, hole) else ()
            if way and asked and view.foresees:
                way = self._likely_way(view, box, hole, way)
            if way:
                found.append((hole, way))
        if found and asked and not view.foresees:
            found = self._feasible(view, box, found)
        return found

    def _feasible(self, view: LocalView, box: int, found: list[tuple[int, Way]]) -> list[tuple[int, Way]]:
        """Those of the targets whose first push has at least the chance `feasibility`."""
        chances = view.feasible(box, [way[1] for _, way in found])
        return [pair for pair, chance in zip(found, chances, strict=True) if chance >= self._least]

    def _candidates(self, view: LocalView, memory: Memory, box: int, at: int, pushable: int) -> int:
        """Writes the candidate holes of Algorithm 6 into `_holes`, ascending.

        Args:
            view: What the agent sees.
            memory: What it remembers.
            box: The box.
            at: The node of the box.
            pushable: The number of nodes in `_pushes`; holes that have a trail H on one of them are candidates.

        Returns:
            How many holes there are.
        """
        if self._marking:  # the last call ended with an error
            for hole in range(self._most_holes):
                self._marked[hole] = 0
        self._marking = True
        count = view.holes_into(self._holes, at if self._from_box else view.node)
        for i in range(count):
            self._marked[self._holes[i]] = 1
        trail = view.h
        for i in range(pushable):
            count = trail.gather(self._pushes[i], self._holes, count, self._marked)
        if memory.sought == box and not self._marked[memory.hole]:
            self._holes[count], self._marked[memory.hole] = memory.hole, 1
            count += 1
        for i in range(count):
            hole, place = self._holes[i], i
            self._marked[hole] = 0
            while place > 0 and self._holes[place - 1] > hole:
                self._holes[place] = self._holes[place - 1]
                place -= 1
            self._holes[place] = hole
        self._marking = False
        return count

    # -- without a box ---------------------------------------------------------------------------------------------

    def _choose(self, view: LocalView, memory: Memory, draw: Callable[[], float]) -> Decision:
        """The decision of an agent without a box: makes way for a carrier, explores (E) or exploits (D and B)."""
        count, requested = view.exits_into(self._nodes), view.requested()
        if self._two_node or (self._ask_to_clear and requested):
            every, count = count, 0
            for i in range(every):
                j = self._nodes[i]
                if not (self._two_node and view.crowded(j)) and not (self._ask_to_clear and view.wanted(j)):
                    self._nodes[count] = j
                    count += 1
        if count and requested and view.wanted(view.node):
            return self._follow_distance(view, memory, draw, count)
        if draw() < memory.epsilon:
            return self._explore(view, memory, draw, count)
        return self._exploit(view, memory, draw, count)

    def _explore(self, view: LocalView, memory: Memory, draw: Callable[[], float], count: int) -> Decision:
        """Chooses by E among the `count` neighbours in `_nodes` and the adjacent boxes that could go to a hole."""
        for i in range(count):
            self._boxes[i] = -1
        targets: dict[int, list[tuple[int, Way]]] = {}
        for i in range(view.boxes_beside(self._beside)):
            j, box = self._beside[i], view.top_box(self._beside[i])
            if box != memory.shunned and view.graspable_from(view.node, box) and self._allowed(view, j):
                found = self._targets(view, memory, box, j)
                if found:
                    targets[j] = found
                    count = self._insert(count, j, box)
        if self._per_choice:
            s = self.settings
            epsilon = max(s.epsilon_floor, memory.epsilon * s.epsilon_decay)
            memory = new_memory(
                epsilon, memory.box, memory.hole, memory.way, memory.sought, memory.shunned, memory.shunned_at,
                memory.vain,
            )  # fmt: skip
        if count == 0:
            return self._follow_distance(view, memory, draw, count)
        crowding = view.e
        for i in range(count):
            self._values[i] = -crowding.read(self._nodes[i])
        self._weigh_extra(view, count)
        weigh(self._values, count, self._beta)
        chosen = pick(self._values, count, draw())
        decision = new_decision(memory)
        decision.node = self._nodes[chosen]
        if self._boxes[chosen] >= 0:
            holes = targets[self._nodes[chosen]]
            hole, way = holes[int(draw() * len(holes))]
            decision = self._claim(view, memory, self._boxes[chosen], hole, way)
        decision.explored = True
        return self._weighed(decision, count)

    def _look_about(self, view: LocalView, memory: Memory, draw: Callable[[], float], count: int) -> Decision:
        """With no box of use: follows D, or roams for a while when `Memory.vain` has passed the threshold."""
        if self._restless == NEVER or not view.pushes_boxes or not view.box_in_sight():
            return self._follow_distance(view, memory, draw, count)
        # With no open hole visible a box is hardly of use and D may well lead on: the threshold is reached later.
        passed = HOLE_OPEN if view.open_hole_in_sight() else 1
        vain = memory.vain + passed if memory.vain < 2 * HOLE_OPEN * self._restless else 0
        memory = new_memory(
            memory.epsilon, -1, memory.hole, memory.way, memory.sought, memory.shunned, memory.shunned_at, vain
        )
        if vain > HOLE_OPEN * self._restless:
            return self._roam(view, memory, draw, count)
        return self._follow_distance(view, memory, draw, count)

    def _roam(self, view: LocalView, memory: Memory, draw: Callable[[], float], count: int) -> Decision:
        """Chooses by E among all moves that the place allows, whether of use or not.

        These are the `count` neighbours in `_nodes`, adjacent boxes that the agent could take hold of, and pushes of
        the box on its node with which it stays level.
        """
        for i in range(count):
            self._boxes[i] = -1
        for i in range(view.boxes_beside(self._beside)):
            j, box = self._beside[i], view.top_box(self._beside[i])
            if box != memory.shunned and view.graspable_from(view.node, box) and self._allowed(view, j):
                self._nodes[count], self._boxes[count] = j, box
                count += 1
        box = view.top_box(view.node)
        if box >= 0 and box != memory.shunned and view.graspable_from(view.node, box):
            for i in range(view.pushes_into(box, view.goal, self._pushes)):
                j = self._pushes[i]
                if self._allowed(view, j) and view.feasible(box, (j,))[0] >= self._least:
                    self._nodes[count], self._boxes[count] = j, box
                    count += 1
        decision = new_decision(memory)
        if count == 0:
            decision.idle = True
            return decision
        crowding = view.e
        for i in range(count):
            self._values[i] = -crowding.read(self._nodes[i])
        self._weigh_extra(view, count)
        weigh(self._values, count, self._beta)
        i = pick(self._values, count, draw())
        decision.node, decision.box, decision.explored = self._nodes[i], self._boxes[i], True
        return self._weighed(decision, count)

    def _weigh_extra(self, view: LocalView, count: int) -> None:
        """Adds the weighed extra fields at the first `count` nodes to what speaks for them."""
        if self._weighs:
            for name, weight in self.settings.weights.items():
                field = view.fields[name]
                for i in range(count):
                    self._values[i] += weight * field.at(self._nodes[i])

    def _insert(self, count: int, node: int, box: int) -> int:
        """Inserts the node of a box into the first `count` options, which are ascending; returns their number."""
        place = 0
        while place < count and self._nodes[place] < node:
            place += 1
        if place == count or self._nodes[place] != node:
            for i in range(count, place, -1):
                self._nodes[i], self._boxes[i] = self._nodes[i - 1], self._boxes[i - 1]
            count += 1
        self._nodes[place], self._boxes[place] = node, box
        return count

    def _weighed(self, decision: Decision, count: int) -> Decision:
        """The decision, with the first `count` options that it was chosen from."""
        decision.count, decision.options = count, self._options
        return decision

    def _exploit(self, view: LocalView, memory: Memory, draw: Callable[[], float], count: int) -> Decision:
        """Chooses by B of the nearest box of use against D of the `count` neighbours in `_nodes`.

        With `look_on` and an open hole visible, a box that can go to no hole is passed over for the next nearest; with
        `step_past`, boxes that can be reached only over the nodes of other boxes come last.
        """
        # With no hole visible only a box nearby, where H can be read, or one that is sought can have any targets.
        some = view.box_at_hand() or memory.sought >= 0 or view.hole_in_sight()
        if not some:
            return self._look_about(view, memory, draw, count)
        box, first = view.find_box(memory.shunned, view.goal)
        useless: list[int] = []
        found: list[tuple[int, Way]] = []
        past = False
        while True:
            if box >= 0:
                if first != view.node and not self._allowed(view, first):
                    break
                found = self._targets(view, memory, box, first)
                if found:
                    break
                useless.append(box)
            elif past or not self._step_past:
                break
            else:
                past = True
            if not self._look_on or not view.open_hole_in_sight():
                break
            box, first = view.find_box(memory.shunned, view.goal, useless, past)
        if not found:
            return self._look_about(view, memory, draw, count)
        worth, chosen = view.b, 0
        if len(found) > 1:
            for i, (hole, _) in enumerate(found):
                self._worths[i] = worth.at(box, hole)
            weigh(self._worths, len(found), self._beta)
            chosen = pick(self._worths, len(found), draw())
        hole, way = found[chosen]
        return self._follow_distance(view, memory, draw, count, box, first, worth.at(box, hole), hole, way)

    def _follow_distance(
        self,
        view: LocalView,
        memory: Memory,
        draw: Callable[[], float],
        count: int,
        box: int = -1,
        towards: int = -1,
        worth: float = 0.0,
        hole: int = -1,
        way: Way = (),
    ) -> Decision:
        """One softmax over D of the neighbours and, if there is a box to go for, its B.

        Args:
            view: What the agent sees.
            memory: What it remembers.
            draw: Its stream.
            count: How many neighbours it could travel to; they are in `_nodes`.
            box: The box to go for, or -1.
            towards: The first node on the way to it.
            worth: B of that box.
            hole: The hole that box is meant for.
            way: The box's way there.
        """
        options, nearness = count, view.d
        for i in range(options):
            self._boxes[i], self._values[i] = -1, nearness.read(self._nodes[i])
        if box >= 0:
            self._nodes[count], self._boxes[count], self._values[count] = towards, box, worth
            count += 1
        elif self._step_past and self._shut_in(view, options):
            for node, beside in self._boxes_to_pass(view, memory).items():
                self._nodes[count], self._boxes[count], self._values[count] = node, beside, nearness.read(node)
                count += 1
        if count == 0:
            decision = new_decision(memory)
            if self._step_past and self.settings.patience is not None and self._boxes_to_pass(view, memory):
                # Those on its ways out may be shut in by itself: it will not wait for them for ever.
                decision.wait = Wait(view.around(), (self._patience - view.waited) * view.edge_seconds)
            else:
                decision.idle = True
            return decision
        self._weigh_extra(view, count)
        weigh(self._values, count, self._beta)
        i = pick(self._values, count, draw())
        if i < options:
            decision = new_decision(memory)
            decision.node = self._nodes[i]
        elif box < 0:
            decision = new_decision(memory)
            decision.box, decision.node = self._boxes[i], self._nodes[i]
        elif view.graspable_from(view.node, box) and view.box_node(box) == towards:
            decision = self._claim(view, memory, box, hole, way)
        else:
            if self._errands:
                memory = new_memory(memory.epsilon, -1, hole, way, box, memory.shunned, memory.shunned_at, memory.vain)
            decision = new_decision(memory)
            # On the way there may be another box, to whose node it steps to leave that on the other side.
            decision.box, decision.node = -1 if view.passable(towards) else view.top_box(towards), towards
        return self._weighed(decision, count)

    def _shut_in(self, view: LocalView, options: int) -> bool:
        """Whether the agent has no exit, or D is 0 on all of them; `_values` holds D of the first `options` exits.

        An agent whose only exits are occupied counts as shut in once it is impatient.
        """
        for i in range(options):
            if self._values[i] > 0.0:
                return False
        shut = True
        if options == 0 and not self._impatient(view):
            for j in view.neighbours:  # not with all(): it would take a generator each time
                shut = shut and not view.passable(j)
        return shut

    def _boxes_to_pass(self, view: LocalView, memory: Memory) -> dict[int, int]:
        """The adjacent nodes whose box the agent could step to, in order to leave it on another side; node to box."""
        if view.boxes_beside(self._beside) == 0:
            return {}
        beside = {view.box_node(box): box for box in view.boxes() if box != memory.shunned}
        return {
            node: box
            for node, box in beside.items()
            if node in view.neighbours and view.graspable_from(view.node, box) and self._allowed(view, node)
        }

    def _claim(self, view: LocalView, memory: Memory, box: int, hole: int, way: Way) -> Decision:
        """Commits to a box: steps to its node, or pushes it along `way` at once if the agent is there already."""
        planned = way if self._errands else ()
        decision = new_decision(new_memory(memory.epsilon, box, hole, planned, -1, -1, -1, memory.vain))
        decision.box, decision.hole, at = box, hole, view.box_node(box)
        if at != view.node:
            decision.node = at
        elif self._allowed(view, way[1]):
            decision.node = way[1]
        else:
            seconds, decision = self.settings.patience, new_decision(memory)
            if self._impatient(view):
                # It has waited for that node before: whoever is there may be shut in by this very box.
                memory = new_memory(memory.epsilon, -1, -1, (), -1, box, view.node, memory.vain)
                seconds, decision = 1.0, new_decision(memory)
            limit = None if seconds is None else seconds * view.edge_seconds
            decision.wait = Wait(self._causes(view, (way[1],)), limit)
        return decision

    def _allowed(self, view: LocalView, node: int) -> bool:
        """Whether the collision rule allows a move to a neighbour (`collision`: reservations, or Algorithm 8)."""
        if not view.free(node) or (self._ask_to_clear and view.wanted(node)):
            return False
        return not (self._two_node and view.crowded(node))

    def _causes(self, view: LocalView, nodes: Way) -> tuple[int, ...]:
        """The nodes whose change could allow a move to `nodes`: these, and under Algorithm 8 their neighbours."""
        if not self._two_node:
            return tuple(nodes)
        return tuple(sorted({*nodes, *(j for node in nodes for j, _ in view.ways(node))}))


def _made_anew(kind: type[Stigmergy], scenario: Scenario, settings: StigmergySettings, name: str) -> Stigmergy:
    """A copy of a policy, made without calling the constructor of a derived class, whose arguments may differ."""
    policy = kind.__new__(kind)
    Stigmergy.__init__(policy, scenario, settings)
    policy.name = name
    return policy
