"""Backends that each break one promise; `check_backend` must name it."""

from __future__ import annotations

import random
import secrets
import threading
from dataclasses import replace
from itertools import count
from typing import Any, ClassVar

from colonysim.backends.mock import Mock
from colonysim.backends.nodeworld import NodeWorld
from colonysim.backends.protocol import Done, TraceRow
from colonysim.world.intents import BoxPlace, Outcome, Travel


class Nameless(Mock):
    name = ""


class Timeless(Mock):
    def reset(self, world, streams):
        super().reset(world, streams)
        self.edge_seconds = 0.0


class Counting:
    """Beside a backend: how often it has been reset."""

    resets = 0

    def reset(self, world, streams):
        super().reset(world, streams)
        self.resets += 1


class Unsteady(Counting, NodeWorld):
    """As it should be in the first episode; then it takes its time from nowhere."""

    def start(self, agent, intent, now):
        done = super().start(agent, intent, now)
        return done._replace(seconds=done.seconds + secrets.randbelow(1000) / 1e6) if self.resets > 1 else done


class Shared(Mock):
    """One count for all instances, used only while another instance is running."""

    running: ClassVar[set[int]] = set()

    def reset(self, world, streams):
        super().reset(world, streams)
        self.running.add(id(self))

    def start(self, agent, intent, now):
        done = super().start(agent, intent, now)
        return done._replace(seconds=done.seconds + len(self.running) / 8)

    def close(self):
        super().close()
        self.running.discard(id(self))


class Worn(Mock):
    """Gets slower from one run to the next."""

    used = 0

    def start(self, agent, intent, now):
        done = super().start(agent, intent, now)
        return done._replace(seconds=done.seconds + self.used / 8)

    def close(self):
        super().close()
        self.used += 1


class OnceOnly(Mock):
    """Cannot be reset after it was closed."""

    finished = False

    def reset(self, world, streams):
        if self.finished:
            raise RuntimeError("gone")
        super().reset(world, streams)

    def close(self):
        super().close()
        self.finished = self.calls[-2:-1] != []


class Meddler(Mock):
    """Moves the agent in the world itself."""

    def start(self, agent, intent, now):
        done = super().start(agent, intent, now)
        self._world.agent_from[agent] = done.outcome.node
        return done


class Grabber(Mock):
    """Claims a box as soon as it is asked about it."""

    def feasible(self, agent, box, targets):
        self._world.box_claim[box] = agent
        return super().feasible(agent, box, targets)


class Reuser(Mock):
    """Hands out a list that it goes on using."""

    def __init__(self):
        super().__init__(tick=0.25)
        self.out = []

    def advance(self, now):
        self.out[:] = super().advance(now)
        return self.out


class Trusting(Mock):
    """Gives away the very list from which it will answer again."""

    def reset(self, world, streams):
        super().reset(world, streams)
        self.known = {}

    def feasible(self, agent, box, targets):
        place = (self._world.box_node[box], self._world.box_base[box], *self._world.surface, *targets)
        return self.known.setdefault(place, list(super().feasible(agent, box, targets)))


class Jumper(Mock):
    """Lands somewhere else altogether."""

    def start(self, agent, intent, now):
        done = super().start(agent, intent, now)
        far = (done.outcome.node + len(self._world.topology) // 2) % len(self._world.topology)
        return done._replace(outcome=replace(done.outcome, node=far, status="failed", reason="slipped"))


class Silent(Mock):
    """Fails without saying why."""

    def __init__(self):
        super().__init__(script=lambda agent, intent, world: Outcome("failed", world.agent_node[agent]))


class Boaster(Mock):
    """Says that a push has arrived, and leaves the box behind."""

    def start(self, agent, intent, now):
        done = super().start(agent, intent, now)
        return done._replace(outcome=replace(done.outcome, boxes=()))


class BoxThrower(Mock):
    """Moves boxes over half the place."""

    def start(self, agent, intent, now):
        done = super().start(agent, intent, now)
        world = self._world
        if not world.box_node:
            return done
        near = (world.box_node[0], *world.topology.neighbours[world.box_node[0]])
        places = [node for node in range(len(world.topology)) if node not in near]
        boxes = (BoxPlace(0, places[0]),) if places else (BoxPlace(99, 0),)
        return done._replace(outcome=Outcome("failed", world.agent_node[agent], boxes, "storm"))


class Bumper(Mock):
    """Drives into whoever stands in the way."""

    def start(self, agent, intent, now):
        world = self._world
        for node in world.topology.neighbours[world.agent_node[agent]]:
            if world.occupant[node] >= 0:
                return Done(1.0, Outcome("failed", node, reason="bump"))
        return super().start(agent, intent, now)


class Haughty(Mock):
    """Raises at what it does not like."""

    def start(self, agent, intent, now):
        done = super().start(agent, intent, now)
        if done.outcome.status == "blocked":
            raise ValueError(done.outcome.reason)
        return done


class Obliging(Mock):
    """Goes wherever it is asked to, over any step."""

    def start(self, agent, intent, now):
        if isinstance(intent, Travel) and intent.node in self._world.topology.neighbours[self._world.agent_node[agent]]:
            return Done(1.0, Outcome("arrived", intent.node))
        return super().start(agent, intent, now)


class Footless(Mock):
    """Reserves only where it comes from."""

    def footprint(self, agent, intent):
        return frozenset((self._world.agent_node[agent],))


class Backwards(Mock):
    """Names an edge the wrong way round."""

    def footprint(self, agent, intent):
        at = self._world.agent_node[agent]
        return frozenset((intent.node, (max(at, intent.node), min(at, intent.node))))


class Counter(Mock):
    """One chance too many."""

    def feasible(self, agent, box, targets):
        return [1.0] * (len(targets) + 1)


class Confident(Mock):
    """More than certain."""

    def feasible(self, agent, box, targets):
        return [1.5] * len(targets)


class Shortsighted(Mock):
    """Promises to tell about a whole way, and stops after the first push."""

    def feasible_way(self, agent, box, way):
        return self.feasible(agent, box, way[1:2])


class Guesser(NodeWorld):
    """Draws from the stream of durations whenever it is asked what could be done."""

    def footprint(self, agent, intent):
        if self.draws is not None:
            self.draws.draw(agent)
        return super().footprint(agent, intent)


class Gambler(Mock):
    """Uses the generator that belongs to everybody."""

    def start(self, agent, intent, now):
        done = super().start(agent, intent, now)
        return done._replace(seconds=1.0 + random.random() / 10)


class Stubborn(Mock):
    """Goes on after it was cancelled."""

    def __init__(self):
        super().__init__(tick=0.25)

    def cancel(self, agent):
        pass


class Ghost(Mock):
    """Goes on after it has left."""

    def __init__(self):
        super().__init__(tick=0.25)

    def leave(self, agent):
        pass


class Panicker(Mock):
    """When one leaves, all stop."""

    def __init__(self):
        super().__init__(tick=0.25)

    def leave(self, agent):
        raise KeyError(agent)


class Stutterer(Mock):
    """Says everything twice."""

    def __init__(self):
        super().__init__(tick=0.25)

    def advance(self, now):
        return [f for finished in super().advance(now) for f in (finished, finished)]


class Forgetful(Mock):
    """Loses every seventh action."""

    def __init__(self):
        super().__init__(tick=0.25)
        self.number = count(1)

    def start(self, agent, intent, now):
        super().start(agent, intent, now)
        if next(self.number) % 7 == 0:
            self._pending.pop(agent)


class Mute(Mock):
    """Never answers, and has no clock."""

    def start(self, agent, intent, now):
        super().start(agent, intent, now)


class Scribbler(Mock):
    """Writes to a table of its own."""

    def rows(self):
        return [TraceRow("weather", (0.0, "rain"))]


class Sloppy(Mock):
    """Forgets the angles of a pose."""

    def rows(self):
        return [TraceRow("poses", (0.0, "agent", 0, 1.0, 2.0, 0.0))]


class Repeater(Mock):
    """Hands the same rows over again and again."""

    def rows(self):
        return [TraceRow("controls", (0.0, 0, "script", "travel", 3))]


class Slammer(Mock):
    """Can be closed once."""

    shut = False

    def reset(self, world, streams):
        super().reset(world, streams)
        self.shut = False

    def close(self):
        if self.shut:
            raise RuntimeError("closed already")
        super().close()
        self.shut = True


class Hoarder(Mock):
    """Starts a thread and never ends it."""

    def reset(self, world, streams):
        super().reset(world, streams)
        threading.Thread(target=threading.Event().wait, daemon=True).start()


class Reticent(Mock):
    """Gets slower within an episode, and says nothing of it when its state is asked for."""

    def start(self, agent, intent, now):
        done = super().start(agent, intent, now)
        return done._replace(seconds=done.seconds + self._started / 8)

    def state(self):
        return {**super().state(), "started": 0}

    def restore(self, state):
        super().restore(state)


class HalfSavable(Mock):
    restore = None

    def state(self):
        return super().state()


class NotReplayable(Counting, Mock):
    """Says that it is, but an episode after another one is not as one without it."""

    state = restore = None
    replayable = True

    def start(self, agent, intent, now):
        done = super().start(agent, intent, now)
        return done._replace(seconds=done.seconds + self.resets / 8)

    def close(self):
        super().close()
        self.resets = 0


FAULTS: list[tuple[Any, str]] = [
    (Reticent, "saving"),
    (HalfSavable, "saving"),
    (NotReplayable, "saving"),
    (Nameless, "attributes"),
    (Timeless, "attributes"),
    (Unsteady, "determinism"),
    (Shared, "isolation"),
    (Worn, "reset"),
    (OnceOnly, "reset"),
    (Meddler, "reads only"),
    (Grabber, "reads only"),
    (Reuser, "hands over"),
    (Trusting, "hands over"),
    (Jumper, "legal outcomes"),
    (Silent, "legal outcomes"),
    (Boaster, "legal outcomes"),
    (BoxThrower, "legal outcomes"),
    (Bumper, "legal outcomes"),
    (Haughty, "failures are outcomes"),
    (Obliging, "failures are outcomes"),
    (Footless, "footprint"),
    (Backwards, "footprint"),
    (Counter, "feasible"),
    (Confident, "feasible"),
    (Shortsighted, "feasible"),
    (Guesser, "feasible"),
    (Gambler, "randomness"),
    (Stubborn, "cancel"),
    (Ghost, "leave"),
    (Panicker, "leave"),
    (Stutterer, "delivers once"),
    (Forgetful, "delivers once"),
    (Mute, "delivers once"),
    (Scribbler, "rows"),
    (Sloppy, "rows"),
    (Repeater, "rows"),
    (Slammer, "close"),
    (Hoarder, "close"),
]
