"""Episodes, one after another: the SimPy environment, the agents' processes and the bookkeeping around them."""

from __future__ import annotations

import time
from array import array
from collections.abc import Generator, Iterable, Iterator, Mapping
from math import inf
from typing import TYPE_CHECKING, Any

import simpy

from colonysim.errors import PluginError
from colonysim.pheromones.field import Visit
from colonysim.simulation.clock import Clock
from colonysim.simulation.moments import Moments
from colonysim.simulation.strides import strides_of
from colonysim.simulation.waiting import Waiting
from colonysim.trace.schema import EpisodeResult
from colonysim.world.intents import Push, Wait
from colonysim.world.state import AgentStatus

if TYPE_CHECKING:
    from colonysim.backends.protocol import Backend, Done
    from colonysim.pheromones.field import Field, Moment
    from colonysim.policies.policy import Choice, Policy
    from colonysim.policies.view import LocalView
    from colonysim.randomness import Streams
    from colonysim.simulation.strides import Strides
    from colonysim.trace.rows import Rows
    from colonysim.trace.schema import Event
    from colonysim.world.intents import Intent, Move, Outcome
    from colonysim.world.state import World

__all__ = ["Episode"]

ENDS, WOKEN, MOVED = 0.0, 1.0, 2.0
"""What happens at one time: first what ends then, next who was called by it, last who has just made others choose.

Within each the order is drawn, so a place is one of these numbers and a lot below 1.
"""
SHORTEST_WAIT = 1e-3
"""In units of a travelled edge's time."""
ENOUGH = 100.0
"""So many times as long as its edge should take may an action of a backend with a clock be under way, and no stall."""
SHORT_WAIT, TOLERATED, DOUBLINGS = 0.1, 8, 10
"""After so many waits in a row that were shorter than a tenth of that time, the shortest doubles with each more."""
DECISIONS = 10_000
"""So often may an agent make up its mind to wait without any time passing."""
SELDOM = 0.01
"""While nothing but long actions goes on, who waits looks up after this share of the time that it has lasted."""


class _Environment(simpy.Environment):
    """SimPy's, beside which the next moments of agents may stand as bare numbers.

    There are more of these than of anything else, and an event and a callback for each would cost more than the step
    that it is for. SimPy's own events at the same time come before them.
    """

    def __init__(self) -> None:
        super().__init__(0.0)
        self.moments = Moments()
        self.queue: list[Any] = self._queue  # (time, priority, number, event)

    def restart(self) -> None:
        """It is 0 o'clock, and nothing is due."""
        self._now = 0.0
        self.queue.clear()
        self.moments.clear()

    def at(self, now: float) -> None:
        """It is so late now, though no event has come."""
        self._now = now

    def peek(self) -> float:
        """When something is due next."""
        return min(super().peek(), self.moments.time)


def _raise_as_it_was(process: Any) -> None:
    if not process.ok:
        raise process.value


class Episode:
    """One episode after another: the SimPy environment, the agents' processes and the bookkeeping around them.

    Args:
        world: The world, put back to its start before each episode.
        fields: The pheromones.
        backend: What moves the agents.
        policy: What decides for them.
        views: What each agent sees.
        rows: The trace.
    """

    def __init__(
        self,
        world: World,
        fields: Mapping[str, Field],
        backend: Backend,
        policy: Policy,
        views: list[LocalView],
        rows: Rows,
    ) -> None:
        self.world, self.fields, self.backend, self.policy = world, fields, backend, policy
        self.views, self.rows = views, rows
        scenario = world.scenario
        self.goal, self.max_steps, self.stall = scenario.goal, scenario.max_steps, scenario.stall_seconds
        self.limit = inf if scenario.time_limit is None else scenario.time_limit
        self.steps, self.since = array("i", [0]) * len(views), array("d", [0.0]) * len(views)
        self.env = _Environment()
        self.queue, self.moments = self.env.queue, self.env.moments
        self.waiting = Waiting(len(views), len(world.topology), self._rouse)
        self.short_waits, self.spins = array("i", [0]) * len(views), array("i", [0]) * len(views)
        self.asks: dict[int, int] = {}
        self.told: dict[int, simpy.Event] = {}
        self.outcomes: dict[int, Outcome] = {}
        self.visit = Visit()
        self.strides: Strides | None = None
        self.asked_for_strides = False

    # -- the episode -----------------------------------------------------------------------------------------------

    def _prepare(self, number: int, memories: list[Any], streams: Streams, synchronous: bool) -> None:
        views = self.views
        self.number, self.memories = number, memories
        self.env.restart()
        self.waiting.clear()
        self.clock = Clock(self.env, self.backend, self._latest, self._ended)
        self.ties = streams.draws("ties", len(views))
        self.random = [streams.generator(f"agent/{agent}") for agent in range(len(views))]
        for agent in range(len(views)):
            self.steps[agent] = self.short_waits[agent] = self.spins[agent] = 0
            self.since[agent] = -1.0
        self.now = self.due = self.last_outcome = 0.0
        self.stuck, self.striding = False, 0
        self.short: set[int] = set()
        self.finished: set[int] = set()
        for kept in (self.asks, self.told, self.outcomes):
            kept.clear()
        edge_seconds = self.backend.edge_seconds
        for view in views:
            view.edge_seconds, view.waited, view.refused, view.failures = edge_seconds, 0.0, None, 0
        if not synchronous and not self.asked_for_strides:
            self.asked_for_strides = True
            self.strides = strides_of(
                self.world, self.fields, self.backend, self.policy, views, self.steps, self.rows, self.asks,
                self._withdraw_request,
            )  # fmt: skip
        if self.strides is not None:
            self.strides.prepare(memories, self.random)

    def close(self) -> None:
        """Lets go of what calls back and of who still waits, for they know the episode."""
        self.env.restart()
        self.told = {}
        self.strides = self.waiting = self.clock = None  # type: ignore[assignment]

    def run(self, number: int, memories: list[Any], streams: Streams, *, synchronous: bool) -> Iterator[Event]:
        """Runs to the episode's end; yields events as they come out.

        Args:
            number: The episode's number.
            memories: What each agent remembers.
            streams: The episode's random streams.
            synchronous: Whether all agents decide on the same state, and then all move.
        """
        world, rows = self.world, self.rows
        began = time.perf_counter()
        rows.begin(number)
        self._prepare(number, memories, streams, synchronous)
        for agent in self._drawn(range(len(self.views))):
            rows.event("start", agent, node=world.agent_node[agent])
            self._deposit("start", agent)
        if synchronous:
            self._begin(self._ticks())
        else:
            for agent in range(len(self.views)):
                self._expect(agent, 0.0, ENDS)
        if self.backend.tick is not None:
            self._begin(self.clock.run(self.backend.tick))
        events = rows.events
        while self._go_on():
            yield from events
            events.clear()
        due, now = self.due, self.now
        if len(self.finished) == len(self.views):
            ended = self._how_it_ended()
        elif self.stuck or self._stalls(due):
            ended = "deadlock"
        else:
            ended, now = "timeout", self.limit
        self.clock.cancel()
        self.rows.foreign(self.backend.rows())
        yield from self._close(ended, now, time.perf_counter() - began)

    def _go_on(self) -> bool:
        """Lets happen what is due until there are events to hand out; returns False once the episode is over."""
        queue, moments, rows, events, agents = self.queue, self.moments, self.rows, self.rows.events, len(self.views)
        while True:
            due, told = moments.time, True
            if queue:
                time = queue[0][0]
                if time <= due:
                    due, told = time, False
            self.due = due
            if due > self.limit or self._stalls(due):
                return False
            if self.stuck or len(self.finished) == agents:
                return False
            # All that a step runs happens at this time; asking the environment each time is slow.
            self.now = rows.now = due
            if told:
                self._moment()
            else:
                self.env.step()
            if events:
                return True

    def _begin(self, steps: Generator[simpy.Event, Any, None]) -> None:
        """Starts a process; what it raises reaches the caller itself, where SimPy would build another one like it."""
        self.env.at(self.now)
        self.env.process(steps).callbacks.append(_raise_as_it_was)

    def _stalls(self, due: float) -> bool:
        """Whether nothing comes out any more, if nothing happens before `due`: no action is under way that will end."""
        if due <= self.last_outcome + self.stall:
            return False
        return due == inf or not (self.striding or self.outcomes or due <= self.clock.until())

    def _latest(self) -> float:
        """When the episode ends if nothing happens before."""
        if self.striding or self.outcomes:
            return self.limit
        return min(self.limit, max(self.last_outcome + self.stall, self.clock.until()))

    def _enough(self, agent: int, intent: Move) -> float:
        """The time until which an action may be under way that begins now, on a backend that does not say how long."""
        topology, node = self.world.topology, self.world.agent_node[agent]
        length = topology.length(node, intent.node) / (topology.mean_length or 1.0)
        return self.now + ENOUGH * self.backend.edge_seconds * max(1.0, length)

    def _how_it_ended(self) -> str:
        states = set(self.world.agent_status)
        if states == {AgentStatus.GOAL}:
            return "goal"
        return "max_steps" if AgentStatus.SPENT in states else "lost"

    def _close(self, ended: str, now: float, wall: float) -> Iterator[Event]:
        world = self.world
        arrived = sum(status is AgentStatus.GOAL for status in world.agent_status)
        agents = len(world.agent_status)
        steps = max(self.steps, default=0) if ended == "goal" else world.scenario.max_steps
        result = EpisodeResult(
            self.number, steps, arrived / agents if agents else 1.0, ended, now, world.seated(), wall
        )
        self.rows.event("episode", status=ended, step=steps)
        self.rows.close(self.fields, result)
        yield from self.rows.events
        self.rows.events.clear()

    # -- asynchronous: each agent in its own time --------------------------------------------------------------------

    def _agent(self, agent: int) -> Generator[simpy.Event, Any, None]:
        """Look, decide, reserve, act, deposit, until the agent is done."""
        while not self._done(agent):
            intent = self._attempt(agent, self._decide(agent).intent)
            if isinstance(intent, Wait):
                self._rest(agent, intent)
                yield self._telling(agent)
                self._rested(agent)
            else:
                yield from self._carry_out(agent, intent)

    def _attempt(self, agent: int, intent: Intent) -> Intent:
        """The intent, with what it needs reserved; or the wait until it may be tried again."""
        if isinstance(intent, Wait):
            return intent
        blockers = self._reserve(agent, intent)
        if not blockers:
            return intent
        view = self.views[agent]
        view.refused = intent
        # A carrier asks whoever stands in the way to go; others choose again after a while.
        clear = blockers[0] if isinstance(intent, Push) else -1
        return Wait(tuple(blockers), view.edge_seconds, clear)

    def _carry_out(self, agent: int, intent: Move) -> Generator[simpy.Event, Any, None]:
        """Acts on an intent for which everything is reserved."""
        began = self.now
        outcome: Outcome = yield self._act(agent, intent)
        if self._settle(agent, intent, outcome, began):
            self._expect(agent, 0.0, MOVED)  # who waited for the place chooses before who comes from it
            yield self._telling(agent)

    def _drawn(self, agents: Iterable[int]) -> list[int]:
        """Agents in an order drawn anew, for whatever they do at one time."""
        return sorted(agents, key=self.ties.draw)

    def _expect(self, agent: int, seconds: float, order: float) -> None:
        """Notes an agent's next moment, and before or after what else happens then."""
        self.moments.put(self.now + seconds, order + self.ties.draw(agent), agent)

    def _telling(self, agent: int) -> simpy.Event:
        """The event of an agent's next moment, for a process to wait for; its value is the outcome, if there is one."""
        event = self.told[agent] = self.env.event()
        return event

    def _moment(self) -> None:
        """What happens now is told by a bare number; a process is woken for it only if one waits."""
        number = self.moments.take()
        if number < 0:
            self.waiting.expire(-1 - number)
            return
        if number in self.told:
            outcome = self.outcomes.pop(number, None)
            if outcome is not None:
                self.last_outcome = self.now
            self.env.at(self.now)
            self.told.pop(number).succeed(outcome)
            return
        strides = self.strides
        if strides is None:
            self._begin(self._agent(number))
            return
        target = strides.heading(number)
        if target >= 0:
            self.last_outcome = self.now
            self.striding -= 1
            origin = strides.arrive(number)
            if self.waiting.wake_two(origin, target):
                self._expect(number, 0.0, MOVED)
                return
        elif self.waiting.waits(number):
            self._rested(number)
        self._stride(number)

    def _stride(self, agent: int) -> None:
        """What `_agent` does, for an agent whose steps are told in one breath."""
        strides = self.strides
        assert strides is not None
        seconds = strides.depart(agent, self.now)
        if seconds >= 0.0:
            self.striding += 1
            self._expect(agent, seconds, ENDS)
            return
        thought = strides.handed_back(agent)
        if thought is None:
            if self._done(agent):
                return
            intent = self._decide(agent).intent
        elif thought.idle:
            self._idle(agent)
            return
        else:
            intent = thought.intent(self.views[agent])
        intent = self._attempt(agent, intent)
        if isinstance(intent, Wait):
            self._rest(agent, intent)
        else:
            self._begin(self._detour(agent, intent))

    def _detour(self, agent: int, intent: Move) -> Generator[simpy.Event, Any, None]:
        """A step that cannot be told in one breath."""
        yield from self._carry_out(agent, intent)
        self._stride(agent)

    def _act(self, agent: int, intent: Move) -> simpy.Event:
        """Begins an action; the event's value will be its outcome."""
        done = self._start(agent, intent)
        if done is None:
            self.clock.expect(agent, self._enough(agent, intent))
        else:
            self.outcomes[agent] = done.outcome
            self._expect(agent, done.seconds, ENDS)
        return self._telling(agent)

    def _ended(self, agent: int, outcome: Outcome) -> None:
        """The clock says that an action has ended, at this time."""
        self.outcomes[agent] = outcome
        self._expect(agent, 0.0, ENDS)

    def _rest(self, agent: int, wait: Wait) -> None:
        """Waits for a change on one of the nodes, or for the time to pass; nothing is polled."""
        world, view = self.world, self.views[agent]
        self.spins[agent] = self.spins[agent] + 1 if self.since[agent] == self.now else 0
        if self.spins[agent] > DECISIONS:
            why = f"it has decided {DECISIONS} times to wait, and no time has passed: {wait}"
            raise PluginError(f"policy {self.policy.name!r}, agent {agent} at {self.now:g} s: {why}")
        self._note_wait(agent, wait)
        number = self.waiting.begin(agent, wait.nodes)
        if wait.seconds is not None:
            # Not shorter, or a policy that asks for no time at all would hold the clock for ever.
            short = wait.seconds < SHORT_WAIT * view.edge_seconds
            self.short_waits[agent] = self.short_waits[agent] + 1 if short else 0
            more = min(max(0, self.short_waits[agent] - TOLERATED), DOUBLINGS)
            seconds = max(wait.seconds, SHORTEST_WAIT * 2.0**more * view.edge_seconds)
            if self.now > self.last_outcome + self.stall:
                seconds = max(seconds, SELDOM * (self.now - self.last_outcome))
            self.moments.put(self.now + seconds, self.ties.draw(agent), -1 - number)
        if world.clear_requests.get(wait.clear) != agent:
            self._withdraw_request(agent)
            # Who asks first is served first. Only a new request wakes its addressee: two carriers that ask each other
            # would not stop otherwise.
            if 0 <= wait.clear < len(world.topology) and wait.clear not in world.clear_requests:
                world.ask(agent, wait.clear)
                self.asks[agent] = wait.clear
                self.waiting.call(world.occupant[wait.clear])
        self.since[agent] = self.now

    def _idle(self, agent: int) -> None:
        """`_rest` until anything around changes that could give the agent something to do."""
        sight, node = self.world.sight(), self.world._agent_nodes[agent]
        count, rows = sight.around(node), self.rows
        self.waiting.begin_at(agent, sight.found, count)
        if rows.kept or rows.hears_waits:
            target = min(sight.found[:count], default=-1)
            self.rows.event("wait", agent, "wait", node, target, step=self.steps[agent])
        self._deposit("wait", agent)
        if self.asks:
            self._withdraw_request(agent)
        self.since[agent] = self.now

    def _rouse(self, agent: int) -> None:
        """Lets an agent that waits go on, after all that ends at this time."""
        self._expect(agent, 0.0, WOKEN)

    def _rested(self, agent: int) -> None:
        view = self.views[agent]
        self.waiting.end(agent)
        view.waited += (self.now - self.since[agent]) / view.edge_seconds

    def _withdraw_request(self, agent: int) -> None:
        """Asks for no node any more; who kept off it may go there now."""
        requests, node = self.world.clear_requests, self.asks.pop(agent, -1)
        if requests.get(node) == agent:
            self.world.unask(node)
            self.waiting.wake((node,))

    # -- synchronous: all agents decide on the same state, then all move --------------------------------------------

    def _ticks(self) -> Generator[simpy.Event, Any, None]:
        while True:
            going = [agent for agent in range(len(self.views)) if agent not in self.finished]
            active = [agent for agent in self._drawn(going) if not self._done(agent)]
            if not active:
                return
            choices = {agent: self._decide(agent) for agent in active}
            began = self.now
            moving: dict[int, Move] = {}
            timed = False
            for agent, choice in choices.items():
                intent = choice.intent
                if isinstance(intent, Wait):
                    timed = timed or intent.seconds is not None
                    self._tick_waits(agent, intent)
                elif blockers := self._reserve(agent, intent):
                    timed = True
                    self.views[agent].refused = intent
                    self._tick_waits(agent, Wait(tuple(blockers)))
                else:
                    moving[agent] = intent
            if not moving and not timed:
                self.stuck = True
                return
            actions = {agent: self._act(agent, intent) for agent, intent in moving.items()}
            if actions:
                yield self.env.all_of(list(actions.values()))
            else:
                yield self.env.timeout(self.backend.edge_seconds)
            for node in list(self.world.clear_requests):
                self.world.unask(node)
            for agent, choice in choices.items():
                if agent in moving:
                    outcome: Outcome = actions[agent].value  # type: ignore[assignment]
                    self._settle(agent, moving[agent], outcome, began)
                else:
                    self.steps[agent] += 1
                    clear = choice.intent.clear if isinstance(choice.intent, Wait) else -1
                    if clear >= 0 and clear not in self.world.clear_requests:
                        self.world.ask(agent, clear)
                        self.asks[agent] = clear

    def _tick_waits(self, agent: int, wait: Wait) -> None:
        self._note_wait(agent, wait)
        self.views[agent].waited += 1.0

    # -- what both modes share -------------------------------------------------------------------------------------

    def _done(self, agent: int) -> bool:
        """Whether the agent is finished for this episode; lets it leave at the goal."""
        world = self.world
        if world.agent_status[agent] is AgentStatus.LOST:
            self.finished.add(agent)
            self.rows.event("lost", agent, node=world.agent_node[agent], step=self.steps[agent])
            return True
        if world.arrived(agent) and agent not in self.short:
            freed = world.release(agent)
            node = world.leave(agent)
            self.backend.leave(agent)
            self.finished.add(agent)
            self.rows.event("goal", agent, node=node, step=self.steps[agent])
            self.waiting.wake({node, *freed})
            return True
        if self.steps[agent] >= self.max_steps:
            world.spend(agent)
            self.finished.add(agent)
            self.rows.event("spent", agent, node=world.agent_node[agent], step=self.steps[agent])
            return True
        return False

    def _decide(self, agent: int) -> Choice:
        view = self.views[agent]
        view.look()
        choice = self.policy.decide(view, self.memories[agent], self.random[agent])
        self.memories[agent] = choice.memory
        if choice.targets:
            intent = choice.intent
            chosen = -1 if isinstance(intent, Wait) else intent.node
            self.rows.decision(
                agent, view.node, choice.explored, chosen, choice.targets, choice.boxes, choice.probabilities
            )
        return choice

    def _reserve(self, agent: int, intent: Move) -> list[int]:
        """Reserves what the manoeuvre needs, all or none; returns the nodes that stand in the way."""
        world = self.world
        places, kept = self.backend.footprint(agent, intent), world.held(agent)
        if world.reserve(agent, places):
            if kept:  # what its body still needed after its last action is free now
                nodes = {node for place in kept for node in (place if isinstance(place, tuple) else (place,))}
                self.waiting.wake(nodes)
            return []
        return world.blockers(agent, places)

    def _start(self, agent: int, intent: Move) -> Done | None:
        self.steps[agent] += 1
        self.short_waits[agent] = 0
        if self.world.clear_requests:
            self._withdraw_request(agent)
        if self.world.begin(agent, intent) and isinstance(intent, Push):
            self._deposit("claim", agent, intent.box, intent.hole)
        return self.backend.start(agent, intent, self.now)

    def _settle(self, agent: int, intent: Move, outcome: Outcome, began: float) -> bool:
        """Applies an outcome, deposits, and wakes whoever waited for what it changed; returns whether anybody did."""
        world, view, target = self.world, self.views[agent], intent.node
        origin, before = world.agent_node[agent], world.agent_from[agent]
        box, hole, action = -1, -1, "travel"
        if isinstance(intent, Push):
            box, hole = intent.box, intent.hole
            action = "take" if world.box_node[box] == target else "push"
        changed = world.apply(agent, intent, outcome)
        self.short.discard(agent)
        if outcome.node == self.goal and (outcome.status != "arrived" or isinstance(intent, Push)):
            self.short.add(agent)  # the goal is its nearest node, but its body has not got there
        view.waited, view.refused = 0.0, None
        view.failures = 0 if outcome.status == "arrived" else view.failures + 1
        self.last_outcome = self.now
        self.rows.event(
            "end", agent, action, origin, target, box, hole, outcome.status, outcome.reason, self.steps[agent], began,
            outcome.node,
        )  # fmt: skip
        if outcome.node != origin:
            self._deposit("arrive", agent, left=origin, before=before)
        elif not outcome.lost:
            self._deposit("wait", agent)
        if self.backend.tick is not None:
            self.rows.foreign(self.backend.rows())
        return self.waiting.wake(changed)

    def _note_wait(self, agent: int, wait: Wait) -> None:
        target = wait.nodes[0] if wait.nodes else -1
        self.rows.event("wait", agent, "wait", self.world.agent_node[agent], target, step=self.steps[agent])
        self._deposit("wait", agent)

    def _deposit(
        self, moment: Moment, agent: int, box: int = -1, hole: int = -1, left: int = -1, before: int = -1
    ) -> None:
        if self.strides is not None:
            self.strides.mark(moment, agent, box, hole, left, before)
            return
        world, visit = self.world, self.visit
        visit.moment, visit.agent, visit.node = moment, agent, world.agent_node[agent]
        visit.level = world.level(agent)
        visit.box, visit.hole, visit.left, visit.before = box, hole, left, before
        for field in self.fields.values():
            writes = field.deposit(visit)
            if writes:
                self.rows.deposits(field, agent, writes)
