"""One episode of a single push: a scene stepped by controls. No learning library is needed."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from colonysim.physics import WheelSpeeds
from colonysim.push.choosing import Choose
from colonysim.push.controls import Control
from colonysim.push.driving import Pilot
from colonysim.push.judging import Rules, Verdict, must_lie, reward
from colonysim.push.learned import ControlLoop
from colonysim.push.seating import settle
from colonysim.push.state import State
from colonysim.push.task import run_alone
from colonysim.push.training.starts import Start

__all__ = ["Episode", "Step"]


@dataclass(frozen=True, slots=True)
class Step:
    """What one action led to.

    Attributes:
        control: Number of the control that was held, -1 for wheel speeds.
        state: The state after it; of a box in a pit, before it has come to rest.
        reward: What it was worth.
        verdict: `"success"` or `"failure"`, which end the episode, or None.
        reason: Why the episode ended: `"success"`, `"timeout"` (the step limit), a reason of `judging.ending`, `"not
            seated"`, or a fault of the robot; empty while it goes on.
        truncated: Whether the step limit ended the episode.
        ticks: Control ticks that the action took; fewer than T when the episode ended within it.
    """

    control: int
    state: State
    reward: float
    verdict: Verdict | None
    reason: str
    truncated: bool
    ticks: int

    @property
    def over(self) -> bool:
        """Whether the episode has ended."""
        return self.verdict is not None or self.truncated


class Episode:
    """A push from its start to success, failure or the step limit.

    Controls are held and the push is judged by the same loop as in a colony, `push.learned.ControlLoop`.

    Args:
        start: Where it begins.
        rules: How it is run and rewarded.
        engine: The rigid-body engine; by default the first that is installed.
    """

    def __init__(self, start: Start, rules: Rules, *, engine: str | None = None) -> None:
        self.start = start
        self.rules = rules
        self.steps = 0
        self.scene = start.scene(engine)
        self._pilot = Pilot(self.scene, 0, limit=math.inf)
        self._loop = ControlLoop(self._pilot, start.task, rules)

    @property
    def state(self) -> State:
        """The state that the next control is chosen from."""
        state: State = self._loop.state
        return state

    def play(self, choose: Choose) -> Iterator[Step]:
        """The steps to the episode's end, each with the control chosen from the state before it."""
        over = False
        while not over:
            step = self.step(choose(self.state))
            over = step.over
            yield step

    def step(self, control: Control | WheelSpeeds) -> Step:
        """Hold one control, or wheel speeds (rad/s), for T ticks, or until the episode ends."""
        scene, rules, task = self.scene, self.rules, self.start.task
        before, begun = self.state, scene.ticks
        reason = run_alone(scene, 0, self._loop.act(control))
        ticks = scene.ticks - begun
        if reason == "done" and must_lie(scene, task, rules):
            reason = run_alone(scene, 0, settle(self._pilot, task))
        self.steps += 1
        verdict: Verdict | None = None
        if reason:
            verdict = "success" if reason == "done" else "failure"
        truncated = verdict is None and self.steps >= rules.step_limit(task.kind)
        return Step(
            -1 if isinstance(control, WheelSpeeds) else control,
            self.state,
            reward(rules, before, self.state, verdict),
            verdict,
            "success" if verdict == "success" else "timeout" if truncated else reason,
            truncated,
            ticks,
        )

    def close(self) -> None:
        """Free the scene."""
        self.scene.close()
