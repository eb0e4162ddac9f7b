# cython: initializedcheck=False, auto_pickle=False
"""Episodes, one after another: the SimPy environment, the agents' processes and the bookkeeping around them."""

from __future__ import annotations

import time
from array import array
from math import inf
from typing import TYPE_CHECKING, Any

import simpy

from colonysim.backends.motion import ByProtocol, Motion, move
from colonysim.errors import PluginError
from colonysim.pheromones.field import Visit
from colonysim.policies.decision import Stream
from colonysim.simulation.alarms import Alarm, Timers
from colonysim.simulation.clock import Clock
from colonysim.simulation.faults import FAILED, Breakdowns
from colonysim.simulation.order import ENDS, MOVED, WOKEN
from colonysim.simulation.ticks import Ticks
from colonysim.simulation.timeline import Timeline
from colonysim.simulation.waiting import Waiting
from colonysim.states import MOST
from colonysim.trace.schema import EpisodeResult
from colonysim.world.intents import Outcome, Wait
from colonysim.world.state import AgentStatus, nodes_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from colonysim.backends.protocol import Backend
    from colonysim.pheromones.field import Moment
    from colonysim.pheromones.marks import Marks
    from colonysim.policies.decision import Decider, Decision
    from colonysim.policies.view import LocalView
    from colonysim.randomness import Streams
    from colonysim.scenario.scenario import Scenario
    from colonysim.trace.rows import Rows
    from colonysim.world.state import World

__all__ = ["DOING", "Episode"]

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


STOPPED, NO_PUSHER = "stopped", "does not push"
"""The reasons of an agent's wait while it stands still, and of a push that is not for an agent of its group."""
ABSENT, LOST = AgentStatus.ABSENT, AgentStatus.LOST
RESTING, ACTING, STANDING = DOING = 0, 1, 2
"""What an agent is doing: nothing, a move, or standing still until a certain time."""


class Process(Alarm):
    """The process of an agent: it goes on whenever its event comes.

    Args:
        first_env: See `Alarm`.
        episode: The episode.
        agent: Which agent.
    """

    def __init__(self, first_env: simpy.Environment, episode: Episode, agent: int) -> None:
        super().__init__(first_env)
        self._episode, self._agent = episode, agent

    def come(self, event: simpy.Event) -> None:
        """Its action has ended, or it is to choose again."""
        episode = self._episode
        if episode.goes_on(self._due):
            episode.resume(self._agent)
            if episode.awaited and episode.asked < 0:
                episode.timeline.notice()


class Episode:
    """One episode after another: the SimPy environment, the agents' processes and the bookkeeping around them.

    The process of an agent is an event that is scheduled for when its action ends or somebody wakes it, and what
    happens then (`resume`): the action's end is settled, and the agent looks, decides, reserves, and acts or waits.

    If the policy's decisions come from outside (`Decider.outside`), everything stops where an agent has to decide:
    `asked` says which one, and `answer` goes on with its decision.

    Args:
        world: The world, put back to its start before each episode.
        fields: The pheromones.
        backend: What moves the agents.
        policy: What decides for them.
        views: What each agent sees.
        rows: The trace.
        unmarked: Fields in which nobody leaves marks, which agents read that ignore the others.
    """

    def __init__(
        self,
        world: World,
        fields: Mapping[str, Marks],
        backend: Backend,
        policy: Decider,
        views: list[LocalView],
        rows: Rows,
        unmarked: Sequence[Marks] = (),
    ) -> None:
        self.world, self.fields, self.backend, self.policy = world, fields, backend, policy
        self.marks, self.motion = list(fields.values()), backend if isinstance(backend, Motion) else ByProtocol(backend)
        self.views, self.rows, self.unmarked = views, rows, list(unmarked)
        scenario, agents = world.scenario, len(views)
        self.max_steps, self.stall = scenario.max_steps, scenario.stall_seconds
        self.limit = inf if scenario.time_limit is None else scenario.time_limit
        self.waiting = Waiting(agents, len(world.topology), self._rouse)
        first_env = simpy.Environment()
        self.processes = [Process(first_env, self, agent) for agent in range(agents)]
        self.timers, self.ticks = Timers(self._expired), Ticks(first_env, self)
        self.clock = Clock(first_env, backend, self._latest, self.goes_on, self._ended)
        first_env.run()
        # What each agent is doing: where it goes, with which box for which hole, since when, and what will come of it.
        self.doing = bytearray(agents)
        self.target, self.box, self.hole, self.ends_at = (array("i", [-1]) * agents for _ in range(4))
        self.began, self.outcomes = array("d", [0.0]) * agents, _none(agents)
        # Steps begun; since when it waits, and how often it has decided to wait for short or no time at all.
        self.steps, self.since = array("q", [0]) * agents, array("d", [0.0]) * agents
        self.short_waits, self.spins = array("i", [0]) * agents, array("i", [0]) * agents
        self.expires = bytearray(agents)
        self.asks = array("i", [-1]) * agents  # the node that each asks to be cleared
        self.leaves = array("d", [0.0]) * agents  # what each has decided to leave
        self.still_until = array("d", [0.0]) * agents  # until when each stands still once its move has ended
        self.random: list[Stream] = []
        self.visit, self.slice = Visit(), MOST
        self._differ(scenario, agents)
        self.outside, self.asked = policy.outside, -1  # the agent that is asked for its decision, or -1
        # The changes of the scenario, and whether some of them wait for what agents do.
        self.timeline, self.awaited = Timeline(self, backend), False

    def _differ(self, scenario: Scenario, agents: int) -> None:
        """What the agents do not have in common, and what may go wrong."""
        self.pushes, self.speeds = bytearray([1]) * agents, array("d", [1.0]) * agents
        for group in scenario.groups:
            for agent in group.agents:
                self.pushes[agent], self.speeds[agent] = group.pushes, group.speed
        self.faults: Breakdowns | None = None
        if scenario.faults is not None:
            self.faults = Breakdowns(scenario.faults, scenario.topology, agents, self.fields)
            senses = self.faults.senses
            for view in self.views:
                if senses is not None:
                    view._sense_with(senses)
        faults = self.faults
        self.stops, self.loses = faults is not None and faults.stops, faults is not None and faults.loses
        self.breaks = faults is not None and faults.moves
        self.alike = not self.breaks and set(self.speeds) <= {1.0}

    # -- the episode -----------------------------------------------------------------------------------------------

    def prepare(self, number: int, memories: list[Any], streams: Streams, synchronous: bool) -> None:
        """Makes all ready for an episode in which nothing has happened yet; the arguments are those of `begin`."""
        views = self.views
        self.number, self.memories, self.synchronous = number, memories, synchronous
        self.env = simpy.Environment()
        self.waiting.clear()
        self.timers.clear()
        self.ticks.clear()
        for process in self.processes:
            process.reset()
        self.clock.begin(self.env, self.backend.tick)
        self.ties = streams.draws("ties", len(views))
        self._seed(streams)
        if self.faults is not None:
            self.faults.begin(streams)
        for agent in range(len(views)):
            self.steps[agent] = self.short_waits[agent] = self.spins[agent] = 0
            self.since[agent], self.doing[agent], self.outcomes[agent] = -1.0, RESTING, None
            self.expires[agent], self.asks[agent], self.still_until[agent], self.leaves[agent] = 0, -1, 0.0, 0.0
        self.now = self.due = self.last_outcome = 0.0
        # Agents that act, and that stand still; alarms that will come; waits under way that end at a time of their own.
        self.stuck, self.over, self.acting, self.standing, self.armed, self.timed = False, False, 0, 0, 0, 0
        self.short: set[int] = set()
        self.finished = {agent for agent in range(len(views)) if not self.timeline.takes_part(agent)}
        self.stepped, self.paused, self.pause_at, self.asked = 0, False, self.slice, -1
        self.edge_seconds, self.clocked = self.backend.edge_seconds, self.backend.tick is not None
        for view in views:
            view.edge_seconds, view.waited, view.refused, view.failures = self.edge_seconds, 0.0, None, 0
            view.outcome, view.steps = "", 0

    def _seed(self, streams: Streams) -> None:
        """Starts the agents' own random streams; to seed a generator again takes half as long as to make one."""
        if not self.random:
            self.random = [Stream(streams.generator(f"agent/{agent}")) for agent in range(len(self.views))]
            return
        for agent, stream in enumerate(self.random):
            stream.generator.seed(streams.derive(f"agent/{agent}"))

    def reseed(self, streams: Streams) -> None:
        """Draws from now on from other streams of the episode."""
        self.ties = streams.draws("ties", len(self.views))
        self._seed(streams)
        if self.faults is not None:
            self.faults.reseed(streams)

    def close(self) -> None:
        """Lets go of what calls back, for it knows the episode."""
        self.env = self.clock = self.waiting = self.timers = self.ticks = None  # type: ignore[assignment]
        self.timeline = None  # type: ignore[assignment]
        self.processes = []

    def begin(self, number: int, memories: list[Any], streams: Streams, *, synchronous: bool) -> None:
        """Puts the agents at their starts; the events of that are `rows.events`.

        Args:
            number: The episode's number.
            memories: What each agent remembers.
            streams: The episode's random streams.
            synchronous: Whether all agents decide on the same state, and then all move.
        """
        world, rows = self.world, self.rows
        self.wall = time.perf_counter()
        rows.begin(number)
        self.prepare(number, memories, streams, synchronous)
        self.timeline.begin()
        for agent in self.drawn(self.present()):
            rows.event("start", agent, node=world.agent_node[agent])
            self._deposit("start", agent)
        if synchronous:
            self.ticks.arm(self.env, 0.0, 0.0, ENDS)
        else:
            for agent in self.present():
                self._expect(agent, 0.0, ENDS)

    def _participants(self) -> list[int]:
        """The agents that are there from the start or join later in this episode."""
        return [agent for agent in range(len(self.views)) if self.timeline.takes_part(agent)]

    def present(self) -> list[int]:
        """The agents that are there, wherever they have got to."""
        return [agent for agent, status in enumerate(self.world.agent_status) if status is not ABSENT]

    def join(self, agent: int) -> None:
        """An agent that was absent stands on its start node now."""
        self.rows.event("start", agent, node=self.world.agent_node[agent])
        self._deposit("start", agent)
        if not self.synchronous:  # else the next tick finds it
            self._expect(agent, 0.0, ENDS)

    def lose(self, agent: int) -> None:
        """An agent fails for the rest of the episode, once the move that it has begun is over."""
        absent = self.world.agent_status[agent] is ABSENT
        self.world.lose(agent)
        self.waiting.wake((self.world.agent_node[agent],))  # who waits for its box
        if absent:
            self.done(agent)
        else:
            self.waiting.call(agent)

    def go_on(self, until: float = inf) -> bool:
        """Lets happen what is due until there are events in `rows.events`.

        Args:
            until: Nothing that is due later than this happens, simulated seconds.

        Returns:
            Whether there are events. If not, either nothing more is due by `until`, or an agent is `asked`, or the
            episode is `over`, or it is `paused` after so many of SimPy's steps as a `slice` is to have.
        """
        step, rows, agents, self.paused = self.env.step, self.rows, len(self.views), False
        while not self.stuck and len(self.finished) < agents:
            if self.asked >= 0:
                return False
            if not self._anything_due():
                self.due = inf
                break
            if until < inf:  # to look at the queue before each event would cost as much as a tenth of a timeout
                due = self.env.peek()
                if due > until and self.limit > until and not self._stalls(due):
                    return False
            step()
            self.stepped += 1
            if self.over:
                return False
            if rows.events:
                return True
            if self.stepped >= self.pause_at:
                self.pause_at, self.paused = self.stepped + self.slice, True
                return False
        self.over = True
        return False

    def go_through(self, steps: int) -> bool:
        """Goes on to a number of SimPy's steps of this episode, or until its timeline has other parameters of policies.

        Returns:
            False if it ends, or an agent is asked, before.
        """
        while self.stepped < steps and not self.timeline.tunings:
            if self.over or self.asked >= 0 or self.env.peek() == inf:
                return False
            self.env.step()
            self.stepped += 1
        return True

    def goes_on(self, due: float) -> bool:
        """Whether the episode has not ended by the time of an event that has just come; if so, that is the time now."""
        rows = self.rows
        self.due = due
        if due > self.limit or self._stalls(due):
            self.over = True
            return False
        self.now = self.world.now = rows.now = due
        return True

    def finish(self) -> None:
        """Ends the episode, by now if it is not over: its result and its last event."""
        due, now = self.due, self.now
        if not self.over:
            ended = "interrupted"
        elif len(self.finished) == len(self.views):
            ended = self._how_it_ended()
        elif self.stuck or self._stalls(due):
            ended = "deadlock"
        else:
            ended, now = "timeout", self.limit
        self.clock.cancel()
        self.rows.foreign(self.backend.rows())
        self._close(ended, now, time.perf_counter() - self.wall)

    def _anything_due(self) -> bool:
        """Whether anything can still happen: SimPy's queue also holds the timers of waits that have ended before."""
        return self.synchronous or self.armed > 0 or self.timed > 0 or self.clock.pending or self.timeline.armed > 0

    def _stalls(self, due: float) -> bool:
        """Whether nothing comes out any more, if nothing happens before `due`.

        That is, no action is under way that will end, nobody stands still who will go on, and no change of the place
        will come.
        """
        if due <= self.last_outcome + self.stall:
            return False
        return due == inf or not (self.acting or self.standing or self.timeline.armed or due <= self.clock.until())

    def _latest(self) -> float:
        """When the episode ends if nothing happens before."""
        if self.acting or self.standing or self.timeline.armed:
            return self.limit
        return min(self.limit, max(self.last_outcome + self.stall, self.clock.until()))

    def _enough(self, agent: int, node: int) -> float:
        """The time until which an action may be under way that begins now, on a backend that does not say how long."""
        topology = self.world.topology
        length = topology.length(self.world.agent_node[agent], node) / (topology.mean_length or 1.0)
        return self.now + ENOUGH * self.edge_seconds * max(1.0, length)

    def _how_it_ended(self) -> str:
        states = {self.world.agent_status[agent] for agent in self._participants()}
        if states == {AgentStatus.GOAL}:
            return "goal"
        return "max_steps" if AgentStatus.SPENT in states else "lost"

    def _close(self, ended: str, now: float, wall: float) -> None:
        world = self.world
        arrived = sum(status is AgentStatus.GOAL for status in world.agent_status)
        agents = len(self._participants())
        steps = max(self.steps, default=0) if ended == "goal" else world.scenario.max_steps
        result = EpisodeResult(
            self.number, steps, arrived / agents if agents else 1.0, ended, now, world.seated(), wall
        )
        self.rows.now = world.now = now
        self.rows.event("episode", status=ended, step=steps)
        self.rows.close(self.fields, result)

    # -- the process of an agent -----------------------------------------------------------------------------------

    def resume(self, agent: int) -> None:
        """The alarm of an agent has come: its action has ended, or it is to choose again."""
        self.armed -= 1
        rested = False
        if self.doing[agent] == ACTING:
            self.doing[agent] = RESTING
            self.acting -= 1
            self.last_outcome = self.now
            if self.synchronous:
                if self.acting == 0 and not self.clock.pending:
                    self.ticks.tick()
                return
            waits = self.settle(agent)  # who waited for the place chooses before who comes from it
            if self.awaited and self.timeline.notice():
                waits = True  # what the timeline made wait for this happens before it chooses
            if waits:
                self._expect(agent, 0.0, MOVED)
                return
        elif self.doing[agent] == STANDING:
            self.doing[agent] = RESTING
            self.standing -= 1
        elif self.waiting.waits(agent):
            self._rested(agent)
            rested = True
        if self.stops:
            self.stop_by_chance(agent, rested)
        self._choose(agent)

    def _choose(self, agent: int) -> None:
        """Look, decide, reserve, and act or wait, unless the agent is done or stands still."""
        if self.done(agent):
            return
        if self.still_until[agent] > self.now:
            self._stand(agent)
            return
        if self.outside:
            self.ask(agent)
        else:
            self._follow(agent, self.decide(agent))

    def ask(self, agent: int) -> None:
        """Has everything stop until the decision of an agent comes from outside."""
        self.views[agent].look()
        self.asked = agent

    def asking(self) -> list[int]:
        """The agent that is asked, and in synchronous mode those that will be asked after it in the same tick."""
        if not self.synchronous:
            return [self.asked]
        return self.ticks.to_decide()

    def answer(self, decision: Decision) -> None:
        """Goes on with the decision of the agent that is asked; then the next one may be."""
        agent, self.asked = self.asked, -1
        self._note(agent, decision)
        if self.synchronous:
            self.ticks.answer(decision)
        else:
            self._follow(agent, decision)
        if self.awaited and self.asked < 0:
            self.timeline.notice()

    def _follow(self, agent: int, decision: Decision) -> None:
        """Reserve, and act or wait."""
        if decision.idle:
            self._rest(agent, None)
        elif decision.wait is not None:
            self._rest(agent, decision.wait)
        elif blockers := self.reserve(agent, decision):
            self._rest(agent, self.refused(agent, decision, blockers))
        else:
            self.act(agent, decision)

    def drawn(self, agents: Iterable[int]) -> list[int]:
        """Agents in an order drawn anew, for whatever they do at one time."""
        lots = {agent: self.ties.draw(agent) for agent in agents}
        return sorted(lots, key=lots.__getitem__)

    def _expect(self, agent: int, seconds: float, order: float) -> None:
        """Sets an agent's alarm, and before or after what else happens then."""
        process = self.processes[agent]
        process.arm(self.env, self.now, seconds, order + self.ties.draw(agent))
        self.armed += 1

    def _ended(self, agent: int, outcome: Outcome) -> None:
        """The clock says that an action has ended, at this time."""
        self.outcomes[agent] = outcome
        self.acting += 1
        self._expect(agent, 0.0, ENDS)

    def done(self, agent: int) -> bool:
        """Whether the agent is finished for this episode; lets it leave at the goal."""
        world = self.world
        if world.agent_status[agent] is LOST:
            self.finished.add(agent)
            if self.asks[agent] >= 0:
                self._withdraw_request(agent)
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

    def decide(self, agent: int) -> Decision:
        """What the policy has an agent do, which looks now."""
        view = self.views[agent]
        view.look()
        decision = self.policy.think(view, self.memories[agent], self.random[agent])
        self._note(agent, decision)
        return decision

    def _note(self, agent: int, decision: Decision) -> None:
        """Keeps what an agent remembers, and for the trace what it could choose from."""
        view, rows = self.views[agent], self.rows
        self.memories[agent], self.leaves[agent] = decision.memory, decision.mark
        if view._overlooked and decision.node < 0:
            self._look_again(view, decision)
        if view._senses is not None:
            view._senses.decided(agent)
        if rows.kept:
            choice, options = decision.choice, decision.options
            if options is not None and decision.count:
                rows.chose(
                    agent, view.node, decision.explored, decision.node, options.nodes, options.boxes, options.chances,
                    decision.count,
                )  # fmt: skip
            elif choice is not None and choice.targets:
                rows.decision(
                    agent, view.node, choice.explored, decision.node, choice.targets, choice.boxes, choice.probabilities
                )

    def _look_again(self, view: LocalView, decision: Decision) -> None:
        """Has an agent that waits, and has overlooked a box, look again after a while: nothing need change for that."""
        wait = decision.waits(view)
        if wait.seconds is None:
            decision.idle, decision.wait = False, Wait(wait.nodes, self.edge_seconds, wait.clear)

    def reserve(self, agent: int, decision: Decision) -> Sequence[int]:
        """Reserves what the move needs, all or none; returns the nodes that stand in the way."""
        world, kept, node = self.world, self.world.reserved[agent], decision.node
        places = self.motion.needs(agent, node, decision.box, decision.hole)
        if not (world.reserve_node(agent, node) if places is None else world.reserve(agent, places)):
            return (node,) if places is None else world.blockers(agent, places)
        if kept:  # what its body still needed after its last action is free now
            self.waiting.wake(nodes_of(kept))
        return ()

    def refused(self, agent: int, decision: Decision, blockers: Sequence[int]) -> Wait:
        """The wait until what stands in the way of a move may have gone."""
        view = self.views[agent]
        view.refused = decision.intent(view)
        # A carrier asks whoever stands in the way to go; others choose again after a while.
        clear = blockers[0] if decision.box >= 0 else -1
        return Wait(tuple(blockers), self.edge_seconds, clear)

    def count_step(self, agent: int) -> None:
        """An agent begins a step, or spends one waiting where all act at once."""
        view = self.views[agent]
        self.steps[agent] += 1
        view.steps = self.steps[agent]

    def act(self, agent: int, decision: Decision) -> None:
        """Begins a move for which everything is reserved."""
        node, box, hole = decision.node, decision.box, decision.hole
        self.count_step(agent)
        self.short_waits[agent] = 0
        if self.asks[agent] >= 0:
            self._withdraw_request(agent)
        self.target[agent], self.box[agent], self.hole[agent], self.began[agent] = node, box, hole, self.now
        if self.world.claim(agent, box if self.pushes[agent] else -1):
            self._deposit("claim", agent, box, hole)
        if self.alike and (box < 0 or self.pushes[agent]):
            seconds = self.motion.undertake(agent, node, box, hole, self.now)
        else:
            seconds = self._undertake(agent, node, box, hole)
        self.doing[agent] = ACTING
        if seconds < 0.0:
            self.clock.expect(agent, self._enough(agent, node), self.now)
            return
        self.outcomes[agent], self.ends_at[agent] = self.motion.outcome, self.motion.ends_at
        self.acting += 1
        self._expect(agent, seconds, ENDS)

    def _undertake(self, agent: int, node: int, box: int, hole: int) -> float:
        """Begins a move of an agent that differs, or that may fail; returns as `Motion.undertake`.

        What fails is never begun on a backend with a clock, which could not take it back: the agent stays where it is
        for the time that is typical of the edge. On any other it takes as long as if it had succeeded.
        """
        motion, at = self.motion, self.world.agent_node[agent]
        if box >= 0 and not self.pushes[agent]:
            motion.outcome = Outcome("blocked", at, reason=NO_PUSHER)
            return 0.0
        fails = self.breaks and self.faults is not None and self.faults.fails(agent)
        if fails and self.clocked:
            topology = self.world.topology
            motion.outcome = Outcome("failed", at, reason=FAILED)
            return self.edge_seconds * topology.length(at, node) / (topology.mean_length or 1.0)
        seconds = motion.undertake(agent, node, box, hole, self.now)
        if seconds < 0.0:
            return seconds
        if fails and (motion.outcome is None or motion.outcome.status == "arrived"):
            motion.outcome = Outcome("failed", at, reason=FAILED)
        return seconds / self.speeds[agent]

    def settle(self, agent: int) -> bool:
        """Applies what came of a move, deposits, and wakes who waited for what it changed; returns whether any did."""
        world, view, rows, node = self.world, self.views[agent], self.rows, self.target[agent]
        box, hole, outcome = self.box[agent], self.hole[agent], self.outcomes[agent]
        origin, before = world.agent_node[agent], world.agent_from[agent]
        action, status, reason, lost, changed = "travel", "arrived", "", False, None
        if box >= 0:
            action = "take" if world.box_node[box] == node else "push"
        if outcome is None:
            now_at = self.ends_at[agent]
            world.arrive(agent, now_at, box, node)
        else:
            now_at, status, reason, lost = outcome.node, outcome.status, outcome.reason, outcome.lost
            changed = world.apply(agent, move(node, box, hole), outcome)
        if now_at == world.goal and (box >= 0 or status != "arrived"):
            self.short.add(agent)  # the goal is its nearest node, but its body has not got there
        elif self.short:
            self.short.discard(agent)
        view.waited, view.refused = 0.0, None
        view.outcome, view.failures = status, 0 if status == "arrived" else view.failures + 1
        rows.ended(agent, action, origin, node, box, hole, status, reason, self.steps[agent], self.began[agent], now_at)
        if now_at != origin:
            self._deposit("arrive", agent, -1, -1, origin, before)
        elif not lost:
            self._deposit("wait", agent)
        if self.clocked:
            self.rows.foreign(self.backend.rows())
        return self.waiting.wake_two(origin, node) if changed is None else self.waiting.wake(changed)

    # -- standing still --------------------------------------------------------------------------------------------

    def stand_still(self, agent: int, until: float) -> None:
        """Lets an agent stand still for a while: it ends the move under way, then does nothing until that time.

        It keeps its box and what its body needs, is woken if it waits, and is no agent that waits meanwhile: it asks
        for no node, leaves no marks, and loses no patience. In synchronous mode it lasts for whole ticks.

        Args:
            agent: Which agent.
            until: Simulated seconds of this episode. One that is sooner than what it was told before changes nothing.
        """
        if until > self.still_until[agent]:
            self.still_until[agent] = until
            self.waiting.call(agent)

    def _stand(self, agent: int) -> None:
        """Begins to stand still, or goes on with it."""
        seconds = self.still_until[agent] - self.now
        self.still_until[agent] = self.now + seconds  # exactly when its alarm comes
        if self.asks[agent] >= 0:
            self._withdraw_request(agent)
        self.note_stop(agent)
        self.doing[agent] = STANDING
        self.standing += 1
        self._expect(agent, seconds, ENDS)

    def stop_by_chance(self, agent: int, rested: bool) -> None:
        """Lets an agent that is about to choose stand still if it has broken down, see `Breakdowns.still_until`."""
        assert self.faults is not None
        until = self.faults.still_until(agent, self.now, rested)
        if until > self.still_until[agent]:
            self.still_until[agent] = until

    def note_stop(self, agent: int) -> None:
        """Writes down that an agent stands still."""
        rows = self.rows
        if rows.kept or rows.hears_waits:
            node = self.world.agent_node[agent]
            rows.event("wait", agent, "wait", node, -1, -1, -1, "", STOPPED, self.steps[agent])

    # -- waiting ---------------------------------------------------------------------------------------------------

    def _rest(self, agent: int, wait: Wait | None) -> None:
        """Waits for a change on one of the nodes, or for the time to pass; nothing is polled.

        Without a wait it is for anything around that could give the agent something to do.
        """
        world, rows = self.world, self.rows
        nodes: Sequence[int] = ()
        self.spins[agent] = self.spins[agent] + 1 if self.since[agent] == self.now else 0
        if self.spins[agent] > DECISIONS:
            why = f"it has decided {DECISIONS} times to wait, and no time has passed: {wait}"
            raise PluginError(f"policy {self.policy.name!r}, agent {agent} at {self.now:g} s: {why}")
        if wait is None:
            visibility = world.visibility_of(agent)
            count = visibility.around(world.agent_node[agent])
            self.waiting.begin_at(agent, visibility.found, count)
            if rows.kept or rows.hears_waits:
                nodes = (min(visibility.found[:count], default=-1),)
            self.note_wait(agent, nodes)
        else:
            self.note_wait(agent, wait.nodes)
            number = self.waiting.begin(agent, wait.nodes)
            if wait.seconds is not None:
                seconds = self._length(agent, wait.seconds)
                self.timers.start(self.env, self.now, seconds, ENDS + self.ties.draw(agent), number)
                self.expires[agent] = 1
                self.timed += 1
        clear = -1 if wait is None else wait.clear
        if self.asks[agent] >= 0 and world.clear_requests.get(clear) != agent:
            self._withdraw_request(agent)
        # Who asks first is served first. Only a new request wakes its addressee: two carriers that ask each other
        # would not stop otherwise.
        if 0 <= clear < len(world.topology) and clear not in world.clear_requests:
            world.ask(agent, clear)
            self.asks[agent] = clear
            self.waiting.call(world.occupant[clear])
        self.since[agent] = self.now

    def _length(self, agent: int, asked: float) -> float:
        """How many seconds a wait lasts that asks for so many.

        Not fewer than some, or a policy that asks for no time at all would hold the clock for ever.
        """
        short = asked < SHORT_WAIT * self.edge_seconds
        self.short_waits[agent] = self.short_waits[agent] + 1 if short else 0
        more = min(max(0, self.short_waits[agent] - TOLERATED), DOUBLINGS)
        seconds = max(asked, SHORTEST_WAIT * 2.0**more * self.edge_seconds)
        if self.now > self.last_outcome + self.stall:
            seconds = max(seconds, SELDOM * (self.now - self.last_outcome))
        return seconds

    def _expired(self, wait: int, due: float) -> None:
        """The time of a wait has come."""
        if self.goes_on(due):
            self.waiting.expire(wait)

    def _rouse(self, agent: int) -> None:
        """Lets an agent that waits go on, after all that ends at this time."""
        self._expect(agent, 0.0, WOKEN)

    def _rested(self, agent: int) -> None:
        view = self.views[agent]
        self.waiting.end(agent)
        self.timed -= self.expires[agent]
        self.expires[agent] = 0
        view.waited += (self.now - self.since[agent]) / self.edge_seconds

    def _withdraw_request(self, agent: int) -> None:
        """Asks for no node any more; who kept off it may go there now."""
        node, self.asks[agent] = self.asks[agent], -1
        if self.world.clear_requests.get(node) == agent:
            self.world.unask(node)
            self.waiting.wake((node,))

    def note_wait(self, agent: int, nodes: Sequence[int]) -> None:
        """Writes down that an agent waits for a change on one of the nodes; it leaves its marks of that."""
        rows = self.rows
        if rows.kept or rows.hears_waits:
            target = nodes[0] if nodes else -1
            self.rows.event("wait", agent, "wait", self.world.agent_node[agent], target, step=self.steps[agent])
        self._deposit("wait", agent)

    # -- marks -----------------------------------------------------------------------------------------------------

    def _deposit(
        self, moment: Moment, agent: int, box: int = -1, hole: int = -1, left: int = -1, before: int = -1
    ) -> None:
        """Lets an agent leave marks of every field where it stands, see `Visit`."""
        world, visit, rows = self.world, self.visit, self.rows
        visit.moment, visit.agent, visit.node = moment, agent, world.agent_node[agent]
        visit.level = world.level(agent)
        visit.box, visit.hole, visit.left, visit.before, visit.mark = box, hole, left, before, self.leaves[agent]
        some = self._left(agent) if self.loses else self.marks
        for marks in some:
            count = marks.mark(visit)
            if count and rows.kept:
                rows.marked(marks, agent, count)

    def _left(self, agent: int) -> list[Marks]:
        """The fields in which an agent leaves marks now; in the others they are lost."""
        faults = self.faults
        assert faults is not None
        return [marks for field, marks in enumerate(self.marks) if not faults.mark_lost(agent, field)]


def _none(count: int) -> list[Outcome | None]:
    return [None] * count
