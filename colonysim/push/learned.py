# cython: auto_pickle=False
"""Pushes whose controls a network chooses: the paper's `rl`, and the network's part of `staged`."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from colonysim.physics.scene import Scene
from colonysim.physics.shapes import wrap
from colonysim.physics.traction import WheelSpeeds
from colonysim.push.choosing import Choose
from colonysim.push.controls import CONTROL_TICKS, NAMES, Control, control_speeds
from colonysim.push.driving import BACK_OFF, BACK_SPEED, Part, Pilot
from colonysim.push.judging import DONE, PAPER_RULES, STEP_LIMIT, STEP_TICKS, Rules, box_ending, ending
from colonysim.push.paths import Obstacles
from colonysim.push.seating import settle
from colonysim.push.staging import Leg, face_for, first_legs, in_place, stage_part
from colonysim.push.state import State, fold, observe
from colonysim.push.task import Kind, Log, Manoeuvre, ManoeuvreResult, PushTask, ignore

__all__ = ["Approach", "ControlLoop", "StagedSettings", "leg_task", "push_in_legs", "rl_push", "staged_push"]

Approach = Callable[[Pilot, Leg], Part]
"""Brings a robot to where the network takes over a leg; returns `"done"`, at once where nothing needs doing."""

_ON_AXIS, _ON_PIT_AXIS = 0.10, 0.05
"""A leg runs along the box's (or the pit's) own axis if that passes this close by the box, metres. Before a
pit the bound is below the guard's: a push given up at the edge begins anew on a line of its own."""


@dataclass(frozen=True, slots=True)
class StagedSettings:
    """What may be chosen about a staged push.

    Attributes:
        rules: How the network pushes, and what ends its part. A box within `rules.tolerance` of its node has arrived.
        tries: Failed pushes before it gives up, all straight legs of the push together.
        limit: Simulated seconds before it gives up.
        accepted: A box this close to its node counts as arrived when no try is left, metres.
    """

    rules: Rules = field(default_factory=Rules)
    tries: int = 8
    limit: float = 180.0
    accepted: float = DONE


def rl_push(
    scene: Scene,
    robot: int,
    task: PushTask,
    log: Log = ignore,
    *,
    choose: Choose,
    ticks: int = STEP_TICKS,
) -> Manoeuvre:
    """The paper's push: the network chooses every control, from wherever the robot is, and has one try.

    Args:
        scene: The scene.
        robot: Index of the robot.
        task: The push.
        log: Told about every control.
        choose: Chooses the controls.
        ticks: T, control ticks of one action.

    Returns:
        A manoeuvre that ends with `"done"`, `"failure"` (paper's table), `"timeout"` (the step limit), or a fault
        of the robot or the box.
    """
    limit = STEP_LIMIT[task.kind] * STEP_TICKS
    pilot = Pilot(scene, robot, log, limit * scene.tick_seconds)
    rules = replace(PAPER_RULES, ticks=ticks, check_every=CONTROL_TICKS)
    try:
        # The last action, which begins before the limit, is cut short by it.
        reason = yield from ControlLoop(pilot, task, rules).run(choose, limit // ticks + 1)
    finally:
        pilot.flush()
    return ManoeuvreResult(reason == "done", reason, pilot.seconds, 1)


def staged_push(
    scene: Scene,
    robot: int,
    task: PushTask,
    obstacles: Obstacles,
    log: Log = ignore,
    *,
    choose: Choose,
    settings: StagedSettings | None = None,
) -> Manoeuvre:
    """A script drives the robot to a coarse pose behind the right face; from there the network decides.

    The network aligns, approaches and pushes until the robot backs off. Guards give up a push that is going
    wrong before it spoils anything: the robot backs off and is staged again. A robot that still stands at
    the box from the push before is not staged at all.

    Args:
        scene: The scene.
        robot: Index of the robot.
        task: The push.
        obstacles: What to stay away from, besides the box itself.
        log: Told about every control, and whether the script or the network chose it.
        choose: Chooses the controls of the network's part.
        settings: Limits.

    Returns:
        A manoeuvre. Its reason is `"done"`; `"box stray"`, `"no staging pose"`,
        `"blocked"`, `"timeout"`; why the last try was given up: `"off_line"`, `"off_line_at_edge"`,
        `"past_goal"`, `"off_node"`, `"robot_far"`, `"slow"`, `"not seated"`; or a fault of the robot.
    """
    settings = settings or StagedSettings()

    def approach(pilot: Pilot, leg: Leg) -> Part:
        if in_place(pilot, task.box, leg.heading):
            return "done"
        return (yield from stage_part(pilot, task.box, leg.heading, obstacles, coarse=True))

    return push_in_legs(Pilot(scene, robot, log, settings.limit), task, obstacles, approach, choose, settings)


def push_in_legs(
    pilot: Pilot,
    task: PushTask,
    obstacles: Obstacles,
    approach: Approach,
    choose: Choose,
    settings: StagedSettings,
) -> Manoeuvre:
    """Push a box leg by leg, each approached and then left to the network, until it is there or tries run out.

    Args:
        pilot: The robot.
        task: The push.
        obstacles: What to stay away from, besides the box itself.
        approach: Brings the robot to where the network takes over.
        choose: Chooses the controls of the network's part.
        settings: Limits.

    Returns:
        A manoeuvre; its reasons are those of `staged_push`, and the approach's.
    """
    scene, rules = pilot.scene, settings.rules
    reason, tries, failed = "timeout", 0, 0
    try:
        while True:
            end = box_ending(scene, task, settings.accepted if failed >= settings.tries else rules.tolerance)
            if end or failed >= settings.tries:
                reason = end or reason
                break
            tries += 1
            for leg in first_legs(scene, task, obstacles()):
                reason = yield from approach(pilot, leg)
                if reason not in _UNREACHED:
                    break
            if reason in _NO_WAY and box_ending(scene, task, settings.accepted) == "done":
                reason = "done"
                break
            if reason != "done":
                break
            part = leg_task(scene, task, leg)
            reason = yield from ControlLoop(pilot, part, rules).run(choose, rules.step_limit(part.kind))
            if reason == "done" and not leg.hole:
                continue
            if reason in _FAULTS:
                break
            if (fault := (yield from pilot.straight(-BACK_OFF, BACK_SPEED, "back"))) != "done":
                reason = fault
                break
            if reason == "done" and task.pit is not None:
                # Only now: the network chooses everything until the robot has backed off.
                reason = yield from settle(pilot, task)
                if reason in _FAULTS:
                    break
            failed += reason != "done"
    finally:
        pilot.flush()
    return ManoeuvreResult(reason == "done", reason, pilot.seconds, tries)


_UNREACHED = frozenset({"no staging pose", "infeasible"})
_NO_WAY = _UNREACHED | {"stuck"}
_FAULTS = frozenset({"timeout", "in_pit", "flipped", "fallen", "nan", "box fallen"})


class ControlLoop:
    """The loop in which a network chooses controls, in colonies, in evaluations and in training.

    Observe the state, choose a control, drive by it for T control ticks (the control looks at the state anew every
    third), and judge whether the push is over (`judging.ending`).

    Most ticks of a push are spent here; compiled, it calls without detours (`learned.pxd`).

    Args:
        pilot: The robot.
        task: The push along one straight line.
        rules: How long an action lasts, and what ends the push.

    Attributes:
        state: The state that the next control is chosen from.
    """

    def __init__(self, pilot: Pilot, task: PushTask, rules: Rules) -> None:
        self._pilot, self._task, self._rules = pilot, task, rules
        self._bumper = pilot.scene.models[pilot.robot].bumper
        self._ticks, self._check_every = rules.ticks, rules.check_every
        self.state = self._look()
        self._started_at = self.state.cross_track

    def run(self, choose: Choose, actions: int) -> Part:
        """Choose control after control, until the push is over or there have been that many.

        Returns:
            Why it ended: as of `act`, or `"slow"`.
        """
        for _ in range(actions):
            if reason := (yield from self.act(choose(self.state))):
                return reason
        return "slow"

    def act(self, control: Control | WheelSpeeds) -> Part:
        """One action: hold a control for T ticks, or until the push is over.

        Args:
            control: One of the eight, or the wheel speeds themselves, rad/s.

        Returns:
            Why the push is over: a fault of the robot or the pilot's `"timeout"`, or a reason of `judging.ending`;
            empty while it goes on.
        """
        name, reason, held = "wheels" if isinstance(control, WheelSpeeds) else NAMES[control], "", 0
        while held < self._ticks and not reason:
            speeds = control if isinstance(control, WheelSpeeds) else control_speeds(control, self.state)
            for _ in range(min(CONTROL_TICKS, self._ticks - held)):
                self._pilot.note(name, "network")
                yield speeds
                held += 1
            self.state = self._look()
            if held % self._check_every == 0 or held == self._ticks:
                reason = self._pilot.fault() or self._over()
        self._pilot.flush()
        return reason

    def _look(self) -> State:
        return observe(self._pilot.pose, self._pilot.scene.box(self._task.box), self._task, self._bumper)

    def _over(self) -> str:
        pilot = self._pilot
        return ending(pilot.scene, pilot.robot, self._task, self.state, self._started_at, self._rules)


def leg_task(scene: Scene, task: PushTask, leg: Leg) -> PushTask:
    """The leg as a push of its own, along the box's (or the pit's) own axis where that passes close by."""
    kind: Kind = "hole" if leg.hole else ("slope" if task.kind == "slope" else "flat")
    pit = None if not leg.hole or task.pit is None else scene.terrain.pits[task.pit]
    if pit is not None:
        axis = wrap(leg.heading - fold(leg.heading - pit.yaw))
    else:
        axis = face_for(scene.box(task.box), leg.heading).heading
    offset = leg.length * math.sin(wrap(leg.heading - axis))
    start = leg.start
    if abs(offset) <= (_ON_AXIS if pit is None else _ON_PIT_AXIS):
        along = max(leg.length, 1.0)
        start = (leg.goal[0] - along * math.cos(axis), leg.goal[1] - along * math.sin(axis))
    return PushTask(task.box, start, leg.goal, kind, task.rim, task.pit if leg.hole else None)
