"""Synchronous episodes: all agents decide on the same state, then all move."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.policies.decision import decision_of, decision_state, new_decision
from colonysim.simulation.alarms import Alarm
from colonysim.simulation.order import ENDS, LAST, MOVED
from colonysim.states import LARGEST, Stored

if TYPE_CHECKING:
    import simpy

    from colonysim.policies.decision import Decision
    from colonysim.simulation.episode import Episode
    from colonysim.states import State

__all__ = ["Ticks"]


class Ticks(Alarm):
    """The process of a synchronous episode, which takes the place of the agents' own.

    A tick begins when all moves of the last one have ended; if nobody moves it lasts a typical edge's time.

    Args:
        first_env: See `Alarm`.
        episode: The episode.

    Attributes:
        turns: Of the tick under way: each agent, whether it moves, and if not, the node that it asks to be cleared
            or -1.
        active: Of a tick that is not yet decided upon: its agents in order.
        decided: The decisions so far, of the first of these.
    """

    def __init__(self, first_env: simpy.Environment, episode: Episode) -> None:
        super().__init__(first_env)
        self._episode = episode
        self._stopped = new_decision(None)  # of an agent that stands still
        self.turns: list[tuple[int, bool, int]] = []
        self.active: list[int] = []
        self.decided: list[Decision] = []

    def clear(self) -> None:
        """There is a new environment, and no tick in it yet."""
        self.reset()
        self.turns, self.active, self.decided = [], [], []

    def come(self, event: simpy.Event) -> None:
        """The next tick begins."""
        episode = self._episode
        if episode.goes_on(self.due):
            self.tick()
            if episode.awaited and episode.asked < 0:
                episode.timeline.notice()

    def tick(self) -> None:
        """What the last tick came to is applied, and the next one begins: those decide who are there and not done."""
        episode = self._episode
        if self.turns:
            self._apply()
            if episode.awaited and episode.timeline.notice():
                self.arm(episode.env, episode.now, 0.0, MOVED)  # what waited for this happens before anybody decides
                return
        going = [agent for agent in episode.present() if agent not in episode.finished]
        self.active, self.decided = [agent for agent in episode.drawn(going) if not episode.done(agent)], []
        for agent in self.active if episode.stops else ():
            episode.stop_by_chance(agent, False)
        self._decide()

    def to_decide(self) -> list[int]:
        """The agents that have not decided yet in this tick, the next one first."""
        episode = self._episode
        return [agent for agent in self.active[len(self.decided) :] if episode.still_until[agent] <= episode.now]

    def answer(self, decision: Decision) -> None:
        """The agent that was asked has decided."""
        self.decided.append(decision)
        self._decide()

    def _decide(self) -> None:
        """Those who have not decided yet do so, or the next of them is asked; after the last one all move."""
        episode = self._episode
        now, still_until = episode.now, episode.still_until
        while len(self.decided) < len(self.active):
            agent = self.active[len(self.decided)]
            if still_until[agent] > now:
                self.decided.append(self._stopped)
            elif episode.outside:
                episode.ask(agent)
                return
            else:
                self.decided.append(episode.decide(agent))
        self._begin()

    def _begin(self) -> None:
        """All have decided: those begin to move whose places are free."""
        episode, world = self._episode, self._episode.world
        active, decisions, self.active, self.decided = self.active, self.decided, [], []
        timed, moving = False, 0
        for agent, decision in zip(active, decisions, strict=True):
            moves = False
            if decision is self._stopped:
                timed = True
                episode.note_stop(agent)
                self.turns.append((agent, False, -1))
                continue
            if decision.node < 0:
                wait = decision.waits(episode.views[agent])
                # Whoever is asked for the first time to clear a node can hear it at the next tick.
                asks = wait.clear >= 0 and wait.clear not in world.clear_requests
                timed = timed or asks or wait.seconds is not None
            elif blockers := episode.reserve(agent, decision):
                timed, wait = True, episode.refused(agent, decision, blockers)
            else:
                moves, moving = True, moving + 1
            if not moves:
                episode.note_wait(agent, wait.nodes)
                episode.views[agent].waited += 1.0
            clear = -1 if moves or decision.wait is None else decision.wait.clear
            self.turns.append((agent, moves, clear))
        if not moving and not timed and episode.timeline.armed == 0:
            episode.stuck = True  # unless all have finished, nobody will do anything more
            return
        for (agent, moves, _), decision in zip(self.turns, decisions, strict=True):
            if moves:
                episode.act(agent, decision)
        if not moving:
            self.arm(episode.env, episode.now, episode.edge_seconds, ENDS)

    def _apply(self) -> None:
        """All actions of a tick have ended: what came of them is applied in the order in which they began."""
        episode, world, turns, self.turns = self._episode, self._episode.world, self.turns, []
        asks = episode.asks
        for node in list(world.clear_requests):
            world.unask(node)
        for agent, moves, clear in turns:
            if moves:
                episode.settle(agent)
                continue
            episode.count_step(agent)
            if clear >= 0 and clear not in world.clear_requests:
                world.ask(agent, clear)
                asks[agent] = clear

    # -- its state ---------------------------------------------------------------------------------------------------

    def state(self) -> State:
        """When the next tick begins, if that is known, and how far this one has come."""
        return {
            "due": self.due if self.scheduled else 0.0, "order": self.order,
            "turns": [list(turn) for turn in self.turns], "active": list(self.active),
            "decided": [None if each is self._stopped else decision_state(each) for each in self.decided],
        }  # fmt: skip

    def restore(self, told: Stored) -> None:
        """Takes over a state, after `clear` and at time 0 of a new environment."""
        episode = self._episode
        agents, nodes = len(episode.views), len(episode.world.topology)
        due, order = told.real("due", 0.0, LARGEST), told.real("order", -1.0, LAST)
        self.turns = [_turn(told, turn, agents, nodes) for turn in told.listed("turns")]
        self.active = told.wholes("active", None, 0, agents - 1)
        decided = [decision_of(each, episode.world, "a decision") for each in told.listed("decided")]
        self.decided = [self._stopped if each is None else each for each in decided]
        if order >= 0.0:
            if due < episode.now:
                raise told.fault("due", due, "a time that is still to come")
            self.arm(episode.env, 0.0, due, order)


def _turn(told: Stored, given: object, agents: int, nodes: int) -> tuple[int, bool, int]:
    """An agent of a tick, whether it moves, and the node that it asks to be cleared."""
    if isinstance(given, list) and len(given) == 3:
        each = Stored(dict(zip(("agent", "moves", "clear"), given, strict=True)), "turns")
        return each.whole("agent", 0, agents - 1), each.flag("moves"), each.whole("clear", -1, nodes - 1)
    raise told.fault("turns", given, "agent, whether it moves, and a node")
