"""Policies, backends and fields with faults drawn from a seed: whatever they do, a run ends, well or with one error.

As a program (`python faulty_parts.py policies 0 200`) it tries those of the seeds and prints a line for each, so that
whoever calls it sees which one took the interpreter with it.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import random
import sys
import time
from typing import Any

import numpy as np

from colonysim.backends.mock import Mock
from colonysim.backends.nodeworld import NodeWorld
from colonysim.backends.protocol import Done, Finished
from colonysim.errors import ColonysimError
from colonysim.pheromones import Distance, Exploration, HoleTrail, Write
from colonysim.policies import Choice
from colonysim.policies.presets import Colony
from colonysim.policies.uniform import Uniform
from colonysim.simulation import simulate
from colonysim.testing.worlds import random_scenario
from colonysim.world.intents import BoxPlace, Outcome, Push, Travel, Wait

NAN, INF = math.nan, math.inf
NODES: tuple[Any, ...] = (
    -1, -2, 10**6, 2**31, 2**63, -(2**31), 2**100, None, "3", 1.5, NAN, True, (), np.int64(0), np.int32(-7), [0]
)  # fmt: skip
TIMES: tuple[Any, ...] = (
    NAN, INF, -INF, 0, -1.0, 1e-300, 1e-9, 10**400, None, "1", True, np.float32(0.5), np.float64(NAN), 1e308, [1.0]
)  # fmt: skip
THINGS: tuple[Any, ...] = (None, 0, "x", NAN, (), [], {}, object(), Travel, 10**400)


class CrossError(Exception):
    """Cannot even say what it is."""

    def __str__(self) -> str:
        return "cross"


def one_of(draw: random.Random, values: Any) -> Any:
    return values[draw.randrange(len(values))]


def an_intent(draw: random.Random, view: Any) -> Any:
    node = one_of(draw, (*NODES, *view.neighbours, view.node))
    nodes = one_of(draw, ((), (node,), node, tuple(view.neighbours), NODES[:3], iter((node,))))
    return one_of(
        draw,
        (
            Travel(node), Push(one_of(draw, NODES), node, one_of(draw, NODES)), Push(0, node, -1),
            Wait(nodes, one_of(draw, TIMES), one_of(draw, NODES)), Wait(), Wait(tuple(view.neighbours), one_of(draw, TIMES)),  # noqa: E501
            Wait((), one_of(draw, TIMES)), Wait((), 1e-9, one_of(draw, view.neighbours)), *THINGS,
        ),
    )  # fmt: skip


def a_policy(seed: int, scenario: Any) -> Any:
    """A policy that fails in one or two of many ways, at once or now and then."""
    draw = random.Random(f"policy/{seed}")
    base, often = one_of(draw, (Uniform, Colony)), one_of(draw, (1.0, 0.3, 0.05))
    where, fault = (
        one_of(draw, ("intent", "intent", "intent", "choice", "raise", "begin", "fields", "patient", "numpy")),
        draw,
    )

    class Faulty(base):  # type: ignore[misc,valid-type]
        name = one_of(draw, ("faulty", "mistaken"))

        def fields(self, world):
            if where == "fields":
                return one_of(fault, (None, {"D": None}, [1], {1: Distance(world, d_max=9.0)}, {"E": object()}, 3))
            return super().fields(world)

        def begin(self, agent, memory):
            if where == "begin":
                if fault.random() < 0.3:
                    raise CrossError
                return one_of(fault, THINGS)
            return super().begin(agent, memory)

        def decide(self, view, memory, random):
            if where == "patient":  # waits as briefly as it may, for ever
                return Choice(Wait((), 1e-12, one_of(fault, (-1, view.node))), memory)
            if fault.random() >= often or where in ("fields", "begin"):
                return super().decide(view, memory, random)
            if where == "raise":
                raise one_of(fault, (CrossError(), RecursionError(), KeyError(3), StopIteration(), ValueError("a\nb")))
            if where == "choice":
                return one_of(fault, (
                    *THINGS, Choice(Wait((), 1.0), memory, False, (10**9,), (-1,), (1.0,)),
                    Choice(Wait((), 1.0), memory, False, (0,), (), (1.0,)), Choice(Wait((), 1.0), memory, False, (0,), (-1,), (NAN,)),  # noqa: E501
                    Choice(Wait((), 1.0), memory, False, None, 3, "x"), Choice(Wait((), 1.0), memory, "no", (0,), (99,), (1.0,)),  # noqa: E501
                ))  # fmt: skip
            if where == "numpy":
                return Choice(Travel(np.int64(one_of(fault, view.neighbours))), memory)
            return Choice(an_intent(fault, view), memory)

    return Faulty(scenario)


def an_outcome(draw: random.Random, node: int) -> Any:
    status = one_of(draw, ("arrived", "blocked", "failed", "lost", None, 3))
    boxes = one_of(
        draw, ((), (BoxPlace(one_of(draw, NODES), one_of(draw, NODES)),), (BoxPlace(0, 0),), None, (1,), ((0, 0),))
    )
    keeps = one_of(draw, ((), (one_of(draw, NODES),), None, "ab", (node,)))
    outcome = Outcome(one_of(draw, ("arrived", "blocked", "failed")), one_of(draw, NODES))
    return one_of(
        draw,
        (
            outcome, Outcome(status, node, boxes, one_of(draw, ("why", "", None, 3)), one_of(draw, (True, False, None)), keeps),  # noqa: E501
            Outcome("failed", -1, reason="fell off"), Outcome("blocked", -2, reason="x"), Outcome("failed", node, keeps=keeps),  # noqa: E501
            Outcome("failed", node, boxes), Outcome("failed", node, lost=True), *THINGS,
        ),
    )  # fmt: skip


def a_backend(seed: int) -> Any:
    """A backend that fails in one of many ways, at once or now and then; some have a clock."""
    draw = random.Random(f"backend/{seed}")
    base, often = one_of(draw, (NodeWorld, Mock, lambda: Mock(tick=0.25))), one_of(draw, (1.0, 0.3, 0.05))
    where = one_of(
        draw,
        (
            "outcome",
            "outcome",
            "time",
            "start",
            "advance",
            "footprint",
            "feasible",
            "attributes",
            "raise",
            "rows",
            "mute",
        ),
    )
    body = base()

    class Faulty(type(body)):  # type: ignore[misc]
        name = "faulty"

        def reset(self, world, streams):
            super().reset(world, streams)
            self.here = world
            if where == "attributes":
                setattr(self, one_of(draw, ("tick", "edge_seconds")), one_of(draw, TIMES))

        def _fails(self, method):
            return where == method and draw.random() < often

        def start(self, agent, intent, now):
            done = super().start(agent, intent, now)
            if self._fails("raise"):
                raise one_of(draw, (CrossError(), KeyError(3), StopIteration()))
            if self._fails("outcome"):
                return Done(1.0, an_outcome(draw, self.here.agent_node[agent]))
            if self._fails("time"):
                return Done(one_of(draw, TIMES), Outcome("blocked", self.here.agent_node[agent], reason="x"))
            if where == "mute":
                return None
            return one_of(draw, THINGS) if self._fails("start") else done

        def advance(self, now):
            finished = super().advance(now)
            if self._fails("advance"):
                return one_of(
                    draw,
                    (*THINGS, [None], [Finished(one_of(draw, NODES), an_outcome(draw, 0))], [(1, 2, 3)], [(0, None)]),
                )
            if self._fails("outcome"):
                return [Finished(agent, an_outcome(draw, 0)) for agent, _ in finished]
            return finished

        def footprint(self, agent, intent):
            if self._fails("footprint"):
                places = one_of(
                    draw, ({one_of(draw, NODES[:12])}, {(0, one_of(draw, NODES[:12]))}, {(1, 2, 3)}, {()}, "ab")
                )
                return one_of(draw, (*THINGS, places))
            return super().footprint(agent, intent)

        def feasible(self, agent, box, targets):
            if self._fails("feasible"):
                return one_of(
                    draw,
                    (*THINGS, [NAN] * len(targets), [INF] * len(targets), [1.0], ["x"] * len(targets), [-1.0, 2.0]),
                )
            return super().feasible(agent, box, targets)

        def rows(self):
            if self._fails("rows"):
                return one_of(
                    draw, (*THINGS, [1], [("weather", (1,))], [("poses", (1, 2))], [(None, None)], [("poses", None)])
                )
            return super().rows()

    made = Faulty(tick=body.tick) if isinstance(body, Mock) else Faulty()
    if where == "feasible" and draw.random() < 0.5:
        made.feasible_way = made.feasible
    if where == "mute" and draw.random() < 0.5:
        made.tick = 0.5
    return made


def a_field(seed: int, world: Any) -> Any:
    """A field that fails in one of many ways, under a name that a policy reads or under one of its own."""
    draw = random.Random(f"field/{seed}")
    base, often = one_of(draw, (Exploration, HoleTrail, Distance)), one_of(draw, (1.0, 0.1))
    where = one_of(draw, ("at", "at", "keys", "deposit", "deposit", "frame", "end", "raise", "lacks", "attributes"))
    options = {"d_max": 9.0} if base is Distance else {"evaporation": 0.1}

    class Faulty(base):  # type: ignore[misc,valid-type]
        def _fails(self, method):
            return where == method and draw.random() < often

        def at(self, node, key=-1):
            return one_of(draw, (*THINGS, *TIMES)) if self._fails("at") else super().at(node, key)

        def keys(self, node):
            return one_of(draw, (*THINGS, NODES, (10**9,))) if self._fails("keys") else super().keys(node)

        def deposit(self, visit):
            writes = super().deposit(visit)
            if self._fails("raise"):
                raise one_of(draw, (CrossError(), KeyError(3), StopIteration()))
            if self._fails("deposit"):
                if draw.random() < 0.1:
                    return itertools.count()
                each = Write(one_of(draw, NODES), one_of(draw, (-1, *NODES)), one_of(draw, (1.0, *TIMES)))
                return one_of(draw, (*THINGS, [each], [each], (1,), [(0, -1, one_of(draw, TIMES))]))
            return writes

        def frame(self):
            each = Write(one_of(draw, NODES), -1, one_of(draw, TIMES))
            return one_of(draw, (*THINGS, [each])) if self._fails("frame") else super().frame()

        def end_episode(self):
            if self._fails("end"):
                raise CrossError
            super().end_episode()

    field: Any = Faulty(world, **options)
    if where == "lacks":
        field = one_of(draw, (None, object(), Faulty, 3))
    elif where == "attributes":
        field = type(
            "Bare", (), {name: (lambda *_: ()) for name in ("at", "keys", "deposit", "frame", "load", "end_episode")}
        )()
        field.name = one_of(draw, ("E", None, "", 3))
        field.by_box = one_of(draw, (False, True))
    return field


class _Sink:
    def write(self, table: str, row: tuple[object, ...]) -> None:
        pass


def tried(kind: str, seed: int) -> str:
    """Runs a faulty part; "fine", or the message of the one error. Anything else it raises is a failure."""
    scenario = random_scenario(seed, max_nodes=14, max_agents=3)
    scenario = dataclasses.replace(scenario, max_steps=60, stall_seconds=120.0)
    options: dict[str, Any] = {"policy": "colony", "seed": seed, "episodes": 2}
    options["mode"] = ("asynchronous", "synchronous")[seed % 2]
    options["sink"] = _Sink() if seed % 3 else None

    class Carrying(Colony):
        def fields(self, world):
            found, field = dict(super().fields(world)), a_field(seed, world)
            name = getattr(field, "name", None)
            found[name if seed % 5 and isinstance(name, str) else "X"] = field
            return found

    try:
        if kind == "policies":
            options["policy"] = a_policy(seed, scenario)
        elif kind == "backends":
            options["backend"] = a_backend(seed)
        else:
            options["policy"] = Carrying(scenario)
        for _ in simulate(scenario, **options):
            pass
    except ColonysimError as error:
        return str(error).replace("\n", " ")
    return "fine"


if __name__ == "__main__":
    for number in range(int(sys.argv[2]), int(sys.argv[3])):
        began = time.perf_counter()
        print(number, end=" ", flush=True)
        said = tried(sys.argv[1], number)
        print(f"{time.perf_counter() - began:.2f} {said}", flush=True)
