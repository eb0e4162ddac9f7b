"""One episode of a single push: a scene stepped by controls. No learning library is needed."""

import math
from dataclasses import dataclass

from colonysim.push.controls import CONTROL_TICKS, Control, control_speeds
from colonysim.push.judging import OFF_NODE, Rules, Verdict, guard, judge, reward, short_of_node
from colonysim.push.seating import SETTLE_SECONDS, is_deep, lies, pressed
from colonysim.push.state import State, observe
from colonysim.push.training.starts import Start

__all__ = ["Episode", "Step"]


@dataclass(frozen=True, slots=True)
class Step:
    """What one action led to.

    Attributes:
        state: The state after it.
        reward: What it was worth.
        verdict: `"success"`, `"failure"` or `"abort"`, which end the episode, or None.
        reason: Why it ended, empty while it goes on.
        truncated: Whether the step limit ended the episode.
        ticks: Control ticks that the action took; fewer than T when the episode ended within it.
    """

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

    Args:
        start: Where it begins.
        rules: How it is run and rewarded.
    """

    def __init__(self, start: Start, rules: Rules) -> None:
        self.start = start
        self.rules = rules
        self.steps = 0
        self.scene = start.scene()
        self.state = self._observe()
        self._first_offset = self.state.cross_track

    def step(self, control: Control) -> Step:
        """Hold one control for T ticks, or until the episode ends."""
        scene, rules = self.scene, self.rules
        before = state = self.state
        verdict: Verdict | None = None
        reason = ""
        ticks = 0
        for ticks in range(1, rules.ticks + 1):
            if ticks % CONTROL_TICKS == 1:
                scene.drive(0, *control_speeds(control, state))
            scene.tick()
            judged = ticks % rules.check_every == 0 or ticks == rules.ticks
            if judged or ticks % CONTROL_TICKS == 0:
                state = self._observe()
            if judged:
                verdict, reason = self._judge(state)
                if verdict is not None:
                    break
        self.state = state
        self.steps += 1
        truncated = verdict is None and self.steps >= rules.step_limit(self.start.task.kind)
        return Step(
            state,
            reward(rules, before, state, verdict),
            verdict,
            reason or ("timeout" if truncated else ""),
            truncated,
            ticks,
        )

    def close(self) -> None:
        """Free the scene."""
        self.scene.close()

    def _observe(self) -> State:
        return observe(self.scene.robot(0), self.scene.box(0), self.start.task)

    def _settled(self) -> Verdict:
        """What has become of the box when the robot has stopped."""
        self.scene.drive(0, 0.0, 0.0)
        for _ in range(round(SETTLE_SECONDS / self.scene.tick_seconds)):
            self.scene.tick()
        return "success" if lies(self.scene, self.start.task) else "failure"

    def _judge(self, state: State) -> tuple[Verdict | None, str]:
        task = self.start.task
        verdict = judge(task, state, self.scene.robot(0), self.scene.box(0))
        if task.kind == "hole" and is_deep(self.scene, task):
            # The paper's conditions hold while the box still leans over the edge, or tumbles.
            over = lies(self.scene, task) or pressed(self.scene, 0, task)
            verdict = self._settled() if over else None
        if verdict == "success" and self.rules.at_node and task.kind != "hole":
            if short_of_node(state):
                verdict = None
            elif self.rules.guards and state.distance > OFF_NODE:
                return "abort", "off_node"
        if verdict is not None:
            return verdict, verdict
        if fault := self.scene.robot_fault(0) or self.scene.box_fault(0):
            return "failure", fault
        if self.rules.leash is not None and math.hypot(state.x_box, state.y_box) > self.rules.leash:
            return "abort", "robot_far"
        if self.rules.guards and (why := guard(task, state, self._first_offset)):
            return "abort", why
        return None, ""
