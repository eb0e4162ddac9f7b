"""Chains of pushes: the paper's unsolved problem, whether one push leaves a state the next can begin from."""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from colonysim.arguments import as_seed, whole
from colonysim.intervals import wilson
from colonysim.learning.seeds import Purpose, episode_rng
from colonysim.physics import BoxSpec, Ground, Pit, RobotSpec, Scene, Terrain
from colonysim.push.executors import Executor
from colonysim.push.paths import everything_else
from colonysim.push.task import Log, PushTask, ignore, run_alone

__all__ = ["TURNS", "Chain", "PlayedChain", "draw_chain", "evaluate_chains", "play_chain"]

TURNS = (0.0, math.pi / 4, -math.pi / 4, math.pi / 2, -math.pi / 2)
_LENGTH = (1.8, 2.2)
_EXTENT, _ROOM = 9.0, 4.0
_BEHIND = 1.5
"""A robot stages this far behind a box at most, metres."""
_PIT_ROOM = 1.5
"""The pit keeps this distance from the earlier parts of the way and from where a robot stages for them, metres."""


@dataclass(frozen=True, slots=True)
class Chain:
    """Nodes and a hole, one after the other.

    Attributes:
        places: The box's start, the nodes and the pit's centre, metres.
        axis: Heading of the box's faces and of the pit's sides, radians.
        robot: Where the robot begins.
    """

    places: tuple[tuple[float, float], ...]
    axis: float
    robot: RobotSpec

    def scene(self, engine: str | None = None) -> Scene:
        """A fresh scene."""
        extent = max(_EXTENT, max(abs(value) for place in self.places for value in place) + _ROOM)
        ground = Ground(-extent, -extent, extent, extent, 0.0)
        terrain = Terrain((ground,), (Pit(*self.places[-1], self.axis),))
        return Scene(terrain, [BoxSpec(*self.places[0], 0.0, self.axis)], [self.robot], engine=engine)

    def tasks(self) -> list[PushTask]:
        """The pushes, in order."""
        *nodes, _ = ways = list(itertools.pairwise(self.places))
        flat = [PushTask(0, start, goal, "flat", 0.0) for start, goal in nodes]
        return [*flat, PushTask(0, *ways[-1], "hole", 0.0, 0)]


@dataclass(frozen=True, slots=True)
class PlayedChain:
    """How a chain went.

    Attributes:
        reached: Targets reached, nodes and hole.
        reason: Why it ended, `"done"` when all were reached.
        pushes: Pushes begun.
        seconds: Simulated seconds.
        errors: How far the box was from each node it was brought to, metres.
    """

    reached: int
    reason: str
    pushes: int
    seconds: float
    errors: tuple[float, ...]

    @property
    def success(self) -> bool:
        """Whether the box lies in the pit."""
        return self.reason == "done"


def draw_chain(rng: np.random.Generator, nodes: int = 2) -> Chain:
    """Nodes and a hole, 1.8-2.2 m apart, each turn one of 0, 45 and 90 degrees to either side.

    Long chains may cross themselves, but their pit lies nowhere that box or robot must go before; ways that lead
    back to it are drawn again.

    Args:
        rng: Source of randomness, advanced.
        nodes: How many nodes there are between the start and the hole.
    """
    while True:
        axis = heading = float(rng.uniform(-math.pi, math.pi))
        places = [(0.0, 0.0)]
        for i in range(nodes + 1):
            if i:
                heading += TURNS[int(rng.integers(len(TURNS)))]
            length = float(rng.uniform(*_LENGTH))
            x, y = places[-1]
            places.append((x + length * math.cos(heading), y + length * math.sin(heading)))
        if _pit_is_out_of_the_way(places):
            break
    bearing = axis + float(rng.uniform(-0.5, 0.5))
    away = float(rng.uniform(1.3, 1.7))
    yaw = float(rng.uniform(-math.pi, math.pi))
    robot = RobotSpec(-away * math.cos(bearing), -away * math.sin(bearing), 0.0, yaw)
    return Chain(tuple(places), axis, robot)


def _pit_is_out_of_the_way(places: Sequence[tuple[float, float]]) -> bool:
    """Whether all pushes but the last, and staging for them, keep away from the last place."""
    (px, py) = places[-1]
    for (x0, y0), (x1, y1) in itertools.pairwise(places[:-1]):
        length = math.dist((x0, y0), (x1, y1))
        c, s = (x1 - x0) / length, (y1 - y0) / length
        along = min(max(c * (px - x0) + s * (py - y0), -_BEHIND), length)
        if math.dist((px, py), (x0 + along * c, y0 + along * s)) < _PIT_ROOM:
            return False
    return True


def play_chain(
    chain: Chain, executor: Executor, *, seed: int = 0, log: Log = ignore, engine: str | None = None
) -> PlayedChain:
    """Push the box from target to target with one executor."""
    errors: list[float] = []
    pushes, reason = 0, "done"
    with chain.scene(engine) as scene:
        for i, task in enumerate(chain.tasks()):
            manoeuvre = executor(scene, 0, task, everything_else(scene, 0), log, seed + i)
            result = run_alone(scene, 0, manoeuvre)
            pushes += result.tries
            if not result.success:
                reason = result.reason
                break
            if task.kind != "hole":
                box = scene.box(0)
                errors.append(math.dist((box.x, box.y), task.goal))
        reached = len(errors) + (reason == "done")
        return PlayedChain(reached, reason, pushes, scene.time, tuple(errors))


def evaluate_chains(
    executor: Executor,
    *,
    chains: int = 100,
    nodes: int = 2,
    seed: int = 0,
    purpose: Purpose = Purpose.JUDGE,
    engine: str | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Success of chains of nodes and a hole.

    Args:
        executor: From `make_executor`, which also says how many tries each leg has.
        chains: How many.
        nodes: How many nodes each has before its hole.
        seed: Makes the chains.
        purpose: What they are for.
        engine: The rigid-body engine; by default the first that is installed.
        on_progress: Called after each chain with chains done and successes so far.

    Returns:
        `chains`, `success`, `success_low`, `success_high` (Wilson, 95 %), `nodes` (share of nodes reached of
        those tried), `pushes_mean`, `seconds_mean`, `error_median` and `error_p95` of the nodes (metres),
        and `reasons`.
    """
    chains, nodes, seed = whole("chains", chains), whole("nodes", nodes), as_seed(seed)
    played: list[PlayedChain] = []
    for i in range(chains):
        rng = episode_rng(purpose, seed, 100, i)
        chain = draw_chain(rng, nodes)
        played.append(play_chain(chain, executor, seed=int(rng.integers(2**31)), engine=engine))
        if on_progress is not None:
            on_progress(i + 1, sum(p.success for p in played))
    wins = sum(p.success for p in played)
    low, high = wilson(wins, chains)
    errors = [e for p in played for e in p.errors]
    reasons: dict[str, int] = {}
    for p in played:
        reasons[p.reason] = reasons.get(p.reason, 0) + 1
    tried = sum(min(nodes, p.reached + 1) for p in played)
    return {
        "chains": chains,
        "success": wins / chains,
        "success_low": low,
        "success_high": high,
        "nodes": len(errors) / tried,
        "pushes_mean": float(np.mean([p.pushes for p in played])),
        "seconds_mean": float(np.mean([p.seconds for p in played])),
        "error_median": float(np.median(errors)) if errors else math.nan,
        "error_p95": float(np.quantile(errors, 0.95)) if errors else math.nan,
        "reasons": reasons,
    }
