"""How well robots share a map: what failed, where and why, and whether robots touched each other, doing what.

    python benchmarks/traffic.py hard:r5-6 easy medium --push staged --seeds 10 --first 40

Every seed is a run of its own with one episode, unless --episodes says otherwise.
"""

import argparse
import collections
import itertools
import math
import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass

from colonysim.backends.bullet import Bullet
from colonysim.backends.protocol import Finished
from colonysim.scenario.loading import load_scenario
from colonysim.simulation import simulate
from colonysim.trace.schema import Event
from colonysim.world.intents import Push

NEAR = 1.3
"""Robots whose centres are further apart than this cannot touch, metres."""
AT_BOX = 1.1
"""A robot this near the centre of its box pushes it; further away it is staging, or backing off, metres."""
PAUSE = 0.5
"""Two touches of the same robots closer in time than this count as one, seconds."""


@dataclass(slots=True)
class Touch:
    """One contact between two robots."""

    time: float
    pair: tuple[int, int]
    place: tuple[float, float]
    situation: tuple[str, str]
    doing: tuple[str, str]
    until: float


class Watched(Bullet):
    """The backend, with an eye on contacts between robots."""

    def __init__(self, push: str) -> None:
        super().__init__(push=push)
        self.touches: list[Touch] = []

    def advance(self, now: float) -> Sequence[Finished]:
        done = super().advance(now)
        scene = self._open()
        here = [i for i in range(scene.robot_count) if scene.has_robot(i)]
        for i, j in itertools.combinations(here, 2):
            one, other = scene.robot(i), scene.robot(j)
            if math.dist(one[:2], other[:2]) < NEAR and scene.robots_touch(i, j):
                last = next((t for t in reversed(self.touches) if t.pair == (i, j)), None)
                if last is not None and now - last.until < PAUSE:
                    last.until = now
                else:
                    situation = min(pair := (self._situation(i), self._situation(j)), pair[::-1])
                    self.touches.append(Touch(now, (i, j), one[:2], situation, (self._doing(i), self._doing(j)), now))
        return done

    def _situation(self, agent: int) -> str:
        action, scene = self._actions.get(agent), self._open()
        if action is None:
            return "stand"
        if not isinstance(action.intent, Push):
            return "travel"
        box = action.intent.box
        if self._world.box_node[box] == action.intent.node:
            return "take"
        return "push" if math.dist(scene.robot(agent)[:2], scene.box(box)[:2]) < AT_BOX else "stage"

    def _doing(self, agent: int) -> str:
        action = self._actions.get(agent)
        if action is None:
            return "stands"
        kind = type(action.intent).__name__.lower()
        names = self._world.topology.ids
        return f"{kind} {names[action.origin]}-{names[action.intent.node]}"


def run(name: str, push: str, seed: int, episodes: int, quiet: bool) -> tuple[list[Event], list[Touch], int, float]:
    """One run: events of failed actions and of the episodes' ends, contacts, actions in all, CPU seconds."""
    scenario, _, variant = name.partition(":")
    backend = Watched(push)
    told, actions, begun = [], 0, time.process_time()
    for event in simulate(
        load_scenario(scenario, variant or None), backend=backend, episodes=episodes, seed=seed, decisions=False
    ):
        actions += event.kind == "end"
        if (event.kind == "end" and event.status != "arrived") or event.kind in ("lost", "spent", "episode"):
            told.append(event)
            if not quiet and event.kind != "episode":
                box = f" box {event.box}" if event.box >= 0 else ""
                print(
                    f"  seed {seed} {event.began:6.1f}-{event.time:6.1f} s: agent {event.agent} {event.kind} "
                    f"{event.action} {event.node}-{event.target}{box}: {event.status} {event.reason}"
                )
    if not quiet:
        for t in backend.touches:
            x, y = t.place
            print(
                f"  seed {seed} {t.time:6.1f} s: robots {t.pair[0]} ({t.doing[0]}) and {t.pair[1]} ({t.doing[1]}) "
                f"touch at {x:.2f}, {y:.2f} for {t.until - t.time:.2f} s"
            )
    return told, backend.touches, actions, time.process_time() - begun


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("maps", nargs="+", help="scenario, or scenario:variant")
    parser.add_argument("--push", default="staged")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=40, help="the first seed; the others follow")
    parser.add_argument("--episodes", type=int, default=1)
    parser.add_argument("--quiet", action="store_true", help="only the totals")
    options = parser.parse_args()
    for name in options.maps:
        reasons: collections.Counter[str] = collections.Counter()
        ends: collections.Counter[str] = collections.Counter()
        situations: collections.Counter[str] = collections.Counter()
        steps, seconds, actions, cpu = [], [], 0, 0.0
        for seed in range(options.first, options.first + options.seeds):
            told, touched, begun, spent = run(name, options.push, seed, options.episodes, options.quiet)
            situations.update("/".join(touch.situation) for touch in touched)
            actions += begun
            cpu += spent
            for event in told:
                if event.kind == "end":
                    reasons[f"{event.action}: {event.reason}"] += 1
                elif event.kind == "episode":
                    ends[event.status] += 1
                    steps.append(event.step)
                    seconds.append(event.time)
        count, touches, hours = len(steps), situations.total(), sum(seconds) / 3600
        print(
            f"{name}, {options.push}, seeds {options.first}-{options.first + options.seeds - 1}, {count} episodes: "
            f"{dict(ends)}; steps {statistics.mean(steps):.1f}; {statistics.mean(seconds):.0f} s simulated, "
            f"{cpu / count:.1f} s CPU each; {actions} actions, {sum(reasons.values())} failed; "
            f"robots touched {touches} times, {touches / hours:.1f} an hour"
        )
        for situation, many in situations.most_common():
            print(f"    {many:4d}  {situation}: {many / hours:.1f} an hour")
        for reason, many in reasons.most_common():
            print(f"    {many:4d}  {reason}", flush=True)


if __name__ == "__main__":
    main()
