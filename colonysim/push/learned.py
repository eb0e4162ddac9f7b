"""Pushes whose controls a network chooses: the paper's `rl`, and the network's part of `staged`."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from colonysim.physics.scene import Scene
from colonysim.physics.shapes import wrap
from colonysim.push.choosing import Choose
from colonysim.push.controls import CONTROL_TICKS, NAMES, control_speeds
from colonysim.push.driving import BACK_OFF, BACK_SPEED, Part, Pilot
from colonysim.push.judging import DONE, STEP_LIMIT, STEP_TICKS, guard, judge, short_of_node
from colonysim.push.paths import Obstacles
from colonysim.push.seating import SETTLE_SECONDS, is_deep, lies, pressed
from colonysim.push.staging import Leg, face_for, first_legs, in_place, stage_part
from colonysim.push.state import State, fold, observe
from colonysim.push.task import Kind, Log, Manoeuvre, ManoeuvreResult, PushTask, ignore

__all__ = ["Approach", "StagedSettings", "push_in_legs", "rl_push", "staged_push"]

Approach = Callable[[Pilot, Leg], Part]
"""Brings a robot to where the network takes over a leg; returns `"done"`, at once where nothing needs doing."""

_ON_AXIS, _ON_PIT_AXIS = 0.10, 0.05
"""A leg runs along the box's (or the pit's) own axis if that passes this close by the box, metres. Before a
pit the bound is below the guard's: a push given up at the edge begins anew on a line of its own."""
_LEASH = 2.2
_SLOW = 1.5


@dataclass(frozen=True, slots=True)
class StagedSettings:
    """What may be chosen about a staged push.

    Attributes:
        ticks: T, control ticks of one action of the network.
        tries: Failed pushes before it gives up, all straight legs of the way together.
        limit: Simulated seconds before it gives up.
        tolerance: A box this close to its node has arrived, metres.
        accepted: A box this close counts as arrived when no try is left, metres.
    """

    ticks: int = 25
    tries: int = 8
    limit: float = 180.0
    tolerance: float = 0.12
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
    pilot = Pilot(scene, robot, log, limit * scene.tick_seconds * _SLOW)
    state = _look(scene, robot, task)
    reason, spent = "", 0
    try:
        while not reason:
            control = choose(state)
            name, held = NAMES[control], 0
            while held < ticks and not reason:
                speeds = control_speeds(control, state)
                for _ in range(min(CONTROL_TICKS, ticks - held)):
                    pilot.note(name, "network")
                    yield speeds
                    held += 1
                    spent += 1
                state = _look(scene, robot, task)
                reason = pilot.fault() or _table(scene, robot, task, state) or ("timeout" if spent >= limit else "")
            pilot.flush()
    finally:
        pilot.flush()
    return ManoeuvreResult(reason == "done", reason, pilot.seconds, 1)


def _table(scene: Scene, robot: int, task: PushTask, state: State) -> str:
    verdict = judge(task, state, scene.robot(robot), scene.box(task.box))
    if verdict is None:
        return scene.box_fault(task.box) or ""
    # The paper's pits are one box deep; in a deeper one its conditions hold while the box still leans.
    if is_deep(scene, task) and not lies(scene, task) and not pressed(scene, robot, task):
        return ""
    return "done" if verdict == "success" else "failure"


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
    scene = pilot.scene
    reason, tries, failed = "timeout", 0, 0
    try:
        while True:
            end = _ended(scene, task, settings.accepted if failed >= settings.tries else settings.tolerance)
            if end or failed >= settings.tries:
                reason = end or reason
                break
            pit = None if task.pit is None else scene.terrain.pits[task.pit]
            tries += 1
            for leg in first_legs(scene, task, obstacles()):
                reason = yield from approach(pilot, leg)
                if reason not in _UNREACHED:
                    break
            if reason in _NO_WAY and _ended(scene, task, settings.accepted) == "done":
                reason = "done"
                break
            if reason != "done":
                break
            reason = yield from _NetworkPart(pilot, leg_task(scene, task, leg), choose, settings).run()
            if reason == "done" and not leg.hole:
                continue
            if reason in _FAULTS:
                break
            if (fault := (yield from pilot.straight(-BACK_OFF, BACK_SPEED, "back"))) != "done":
                reason = fault
                break
            if reason == "done" and pit is not None:
                # Only now: the network chooses everything until the robot has backed off.
                if (fault := (yield from pilot.wait(SETTLE_SECONDS))) != "done":
                    reason = fault
                    break
                reason = "done" if scene.box_seated(task.box, pit) else "not seated"
            failed += reason != "done"
    finally:
        pilot.flush()
    return ManoeuvreResult(reason == "done", reason, pilot.seconds, tries)


_UNREACHED = frozenset({"no staging pose", "infeasible"})
_NO_WAY = _UNREACHED | {"stuck"}
_FAULTS = frozenset({"timeout", "in_pit", "flipped", "fallen", "nan", "box fallen"})


class _NetworkPart:
    """The network's part of a leg: it chooses controls until the leg is done or a guard gives it up.

    Most ticks of a push are spent here; compiled, it calls without detours (`learned.pxd`).

    Args:
        pilot: The robot.
        task: The leg, as a push of its own.
        choose: Chooses the controls.
        settings: Limits.
    """

    def __init__(self, pilot: Pilot, task: PushTask, choose: Choose, settings: StagedSettings) -> None:
        self._pilot, self._task, self._choose = pilot, task, choose
        self._ticks, self._tolerance = settings.ticks, settings.tolerance
        self._state = self._look()
        self._started_at = self._state.cross_track

    def run(self) -> Part:
        """The controls, tick by tick."""
        for _ in range(STEP_LIMIT[self._task.kind] * STEP_TICKS // self._ticks):
            control = self._choose(self._state)
            name, reason, held = NAMES[control], "", 0
            while held < self._ticks and not reason:
                speeds = control_speeds(control, self._state)
                for _ in range(min(CONTROL_TICKS, self._ticks - held)):
                    self._pilot.note(name, "network")
                    yield speeds
                    held += 1
                if fault := self._pilot.fault():
                    return fault
                self._state = self._look()
                reason = self._verdict()
            self._pilot.flush()
            if reason:
                return reason
        return "slow"

    def _look(self) -> State:
        return _look(self._pilot.scene, self._pilot.robot, self._task)

    def _verdict(self) -> str:
        """Why the network's part is over; empty while it is not."""
        scene, robot, task, state = self._pilot.scene, self._pilot.robot, self._task, self._state
        if scene.box_fault(task.box):
            return "box fallen"
        verdict = judge(task, state, scene.robot(robot), scene.box(task.box))
        if task.kind == "hole" and (verdict == "success" or pressed(scene, robot, task)):
            # In a pit deeper than the box it first leans over the edge: it must be pressed on until it lies, but no
            # further than the robot may go without falling in.
            return "done" if pressed(scene, robot, task) or lies(scene, task) else ""
        if verdict == "success" and not short_of_node(state):
            return "done" if state.distance <= self._tolerance else "off_node"
        if math.hypot(state.x_box, state.y_box) > _LEASH:
            return "robot_far"
        return guard(task, state, self._started_at) or ""


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


def _look(scene: Scene, robot: int, task: PushTask) -> State:
    return observe(scene.robot(robot), scene.box(task.box), task)


def _ended(scene: Scene, task: PushTask, tolerance: float) -> str:
    """Why a push is over whatever the robot does; empty while it is not."""
    if fault := scene.box_fault(task.box):
        return "box stray" if fault == "fallen" else fault
    pit = None if task.pit is None else scene.terrain.pits[task.pit]
    box = scene.box(task.box)
    if pit is not None and scene.box_seated(task.box, pit):
        return "done"
    half = scene.boxes[task.box].height / 2
    for other in scene.terrain.pits:
        if other is not pit and other.contains(box.x, box.y) and box.z < other.rim + half - 0.05:
            return "box stray"
    if pit is None and math.dist((box.x, box.y), task.goal) <= tolerance:
        return "done"
    return ""
