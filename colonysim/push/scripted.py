"""The scripted push: stage, touch, follow the line, press the box into its pit, back off, try again."""

import math
from dataclasses import dataclass

from colonysim.physics.scene import Scene
from colonysim.physics.shapes import wrap
from colonysim.physics.terrain import Pit
from colonysim.physics.traction import wheel_speeds
from colonysim.push.driving import BACK_OFF, BACK_SPEED, Part, Pilot, in_frame
from colonysim.push.judging import box_ending
from colonysim.push.paths import Obstacles
from colonysim.push.seating import OVERRUN, settle
from colonysim.push.staging import Leg, first_legs, in_place, stage_part
from colonysim.push.task import Log, Manoeuvre, ManoeuvreResult, PushTask, ignore

PUSH_SPEED = 0.45
"""Metres per second while the box moves."""
NODE_TOLERANCE = 0.15
"""A box this close to its node has arrived, metres."""

_CONTACT_SLACK = 0.03
_BRAKING = 3.9
_TRACK_GAIN, _TRACK_MOST = 1.5, 0.4
_TURN_GAIN, _TURN_SHARE = 4.0, 0.5
"""A flush box is lost when the robot turns faster than this share of its speed (rad/m)."""
_LOST_AHEAD, _LOST_ASIDE = 0.25, 0.45
_STRAY = 0.25
_STALL_SECONDS = 2.5
_RETRY = frozenset({"lost contact", "off the line", "stalled", "stuck", "not seated"})
"""Reasons after which another try makes sense."""


@dataclass(frozen=True, slots=True)
class PushSettings:
    """What may be chosen about a scripted push.

    Attributes:
        speed: Metres per second while the box moves.
        tries: Pushes begun before it gives up, retries included.
        limit: Simulated seconds before it gives up.
    """

    speed: float = PUSH_SPEED
    tries: int = 8
    limit: float = 120.0


def scripted_push(
    scene: Scene,
    robot: int,
    task: PushTask,
    obstacles: Obstacles,
    log: Log = ignore,
    settings: PushSettings | None = None,
) -> Manoeuvre:
    """Push a box to the end of its line.

    After a push to a node the robot stays at the box, ready to push on in the same direction without
    staging again; after a push into a pit it backs off.

    Args:
        scene: The scene.
        robot: Index of the robot.
        task: The push.
        obstacles: What to stay away from, besides the box itself.
        log: Told about the controls.
        settings: Speed and limits.

    Returns:
        A manoeuvre. Its reason is `"done"`; or `"box stray"` (the box fell where it should not),
        `"no staging pose"`, `"blocked"` (by a robot), `"timeout"`; or why the last
        try failed: `"lost contact"`, `"off the line"`, `"stalled"`, `"stuck"`, `"not seated"`; or a fault of
        the robot: `"in_pit"`, `"flipped"`, `"fallen"`, `"nan"`.
    """
    settings = settings or PushSettings()
    pilot = Pilot(scene, robot, log, settings.limit)
    reason, tries = "timeout", 0
    try:
        while True:
            if end := box_ending(scene, task, NODE_TOLERANCE):
                reason = end
                break
            if tries >= settings.tries:
                break
            leg = first_legs(scene, task, obstacles())[0]
            tries += 1
            reason = yield from _push_leg(pilot, task, leg, obstacles, settings.speed)
            if reason not in _RETRY and reason != "done":
                break
            if reason in _RETRY:
                # Seen from further back the same place may be reachable again.
                fault = yield from pilot.straight(-BACK_OFF, BACK_SPEED, "back")
                if fault != "done":
                    reason = fault
                    break
        if task.pit is not None and reason == "done":
            fault = yield from pilot.straight(-BACK_OFF, BACK_SPEED, "back")
            reason = fault
    finally:
        pilot.flush()
    return ManoeuvreResult(reason == "done", reason, pilot.seconds, tries)


def _push_leg(pilot: Pilot, task: PushTask, leg: Leg, obstacles: Obstacles, speed: float) -> Part:
    """One straight push: stage if need be, touch, follow the line, and settle the box in a pit."""
    scene = pilot.scene
    if not in_place(pilot, task.box, leg.heading):
        if (reason := (yield from stage_part(pilot, task.box, leg.heading, obstacles))) != "done":
            return reason
        if (reason := (yield from _touch(pilot, task.box, leg.heading))) != "done":
            return reason
    pit = None if task.pit is None or not leg.hole else scene.terrain.pits[task.pit]
    reason = yield from _track(pilot, task.box, leg, pit, speed)
    if reason != "done" or pit is None:
        return reason
    return (yield from settle(pilot, task))


def _touch(pilot: Pilot, box: int, heading: float) -> Part:
    """Drive straight ahead until the bumper is at the box."""
    scene = pilot.scene
    contact = scene.boxes[box].length / 2 + scene.models[pilot.robot].bumper + _CONTACT_SLACK
    until = scene.time + 4.0
    while True:
        pose, at = pilot.pose, scene.box(box)
        ahead, aside = in_frame(pose, at.x, at.y)
        if ahead <= contact:
            return "done"
        if abs(aside) > _LOST_ASIDE or scene.time >= until:
            return "lost contact"
        forward = min(0.35, 0.15 + ahead - contact)
        turn = 2.0 * wrap(heading - pose.yaw)
        if fault := (yield from pilot.hold("push", wheel_speeds(forward, turn))):
            return fault


def _track(pilot: Pilot, box: int, leg: Leg, pit: Pit | None, speed: float) -> Part:
    """Push the box along the leg's line until it is there, or until the bumper is past the pit's edge."""
    scene = pilot.scene
    line, c, s = leg.heading, math.cos(leg.heading), math.sin(leg.heading)
    bumper = scene.models[pilot.robot].bumper
    contact = scene.boxes[box].length / 2 + bumper
    coast = speed * speed / (2 * _BRAKING)
    best, since = math.inf, scene.time
    while True:
        pose, at = pilot.pose, scene.box(box)
        remaining = c * (leg.goal[0] - at.x) + s * (leg.goal[1] - at.y)
        across = -s * (at.x - leg.goal[0]) + c * (at.y - leg.goal[1])
        to_go = remaining - coast
        if pit is not None:
            nose = c * (leg.goal[0] - pose.x) + s * (leg.goal[1] - pose.y) - bumper
            to_go = nose - _edge(pit, line) + OVERRUN
        if to_go <= 0.0:
            return "done"
        if to_go < best - 0.01:
            best, since = to_go, scene.time
        elif scene.time - since > _STALL_SECONDS:
            return "stalled"
        ahead, aside = in_frame(pose, at.x, at.y)
        # A box that tips into the pit leaves the bumper; from there on the robot only follows straight.
        tipping = pit is not None and remaining < _edge(pit, line) + 0.05
        if tipping:
            across = 0.0
        elif ahead > contact + _LOST_AHEAD or abs(aside) > _LOST_ASIDE:
            return "lost contact"
        elif abs(across) > _STRAY:
            return "off the line"
        wanted = line - max(-_TRACK_MOST, min(_TRACK_MOST, _TRACK_GAIN * across))
        most = _TURN_SHARE * speed
        turn = max(-most, min(most, _TURN_GAIN * wrap(wanted - pose.yaw)))
        if fault := (yield from pilot.hold("push", wheel_speeds(speed, turn))):
            return fault


def _edge(pit: Pit, line: float) -> float:
    """Distance of a pit's edge from its centre along a line that crosses it nearly squarely."""
    off = (line - pit.yaw + math.pi / 4) % (math.pi / 2) - math.pi / 4
    return pit.side / 2 / math.cos(off)
