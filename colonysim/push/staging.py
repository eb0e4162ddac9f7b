"""Where to stand behind a box, how a push is split into straight legs, and getting to the staging pose."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from colonysim.physics.scene import Scene
from colonysim.physics.shapes import Pose, wrap
from colonysim.physics.terrain import Pit
from colonysim.push.driving import STAGING_SPEED, Part, Pilot, in_frame
from colonysim.push.footing import footing_on
from colonysim.push.paths import PIT_CLEARANCE, FreeSpace, Obstacles, Point, Surroundings
from colonysim.push.task import Log, Manoeuvre, ManoeuvreResult, PushTask, ignore

MAX_MISMATCH = 0.4
"""A face this far off the push line straightens itself at the bumper, radians."""
COARSE_NEAR, COARSE_FAR = 1.15, 1.6
"""Distances from the box's centre between which a coarse handover leaves the robot, metres."""
COARSE_BEARING = 0.35
COARSE_HEADING = 0.8

_PIT_MISMATCH = 0.2
_FINE_GAPS = (0.72, 0.62, 0.52)
_COARSE_GAPS = (0.92, 0.80, 0.74)
"""Tried one after the other: distances of the robot's centre from the face, metres."""
_NEGLIGIBLE = 0.06
_RUN_UP = 1.25
"""A box this far from a pit's centre does not overhang its edge yet, metres."""
_STEP = 0.04
"""A box slides over no higher step, metres in a tenth of a metre."""
_PATIENCE = 10.0
_NOWHERE = -math.inf


class Face(NamedTuple):
    """A face of a box seen from behind it.

    Attributes:
        heading: The push direction straight through the face, radians.
        mismatch: The wanted direction minus that one, within a quarter turn: [-pi/4, pi/4].
    """

    heading: float
    mismatch: float


class Leg(NamedTuple):
    """A straight part of a push.

    Attributes:
        start: Where the box's centre is, metres.
        goal: Where it is to go, metres.
        hole: Whether it ends in the task's pit.
    """

    start: Point
    goal: Point
    hole: bool

    @property
    def heading(self) -> float:
        """Direction of the leg, radians."""
        return math.atan2(self.goal[1] - self.start[1], self.goal[0] - self.start[0])

    @property
    def length(self) -> float:
        """Length of the leg, metres."""
        return math.dist(self.start, self.goal)


@dataclass(frozen=True, slots=True)
class PushPlan:
    """A push that has been thought through.

    Attributes:
        legs: Straight parts, in order.
        margin: Least slack of all staging poses and of the legs' corridor, metres; negative: not feasible.
        reason: `"ok"`, or what is in the way.
    """

    legs: tuple[Leg, ...]
    margin: float
    reason: str


def quarter(angle: float) -> float:
    """An angle modulo a quarter turn, in [-pi/4, pi/4)."""
    return (angle + math.pi / 4) % (math.pi / 2) - math.pi / 4


def face_for(box: Pose, direction: float) -> Face:
    """The face to push at in order to move a box in a direction (radians)."""
    mismatch = quarter(direction - box.yaw)
    return Face(wrap(direction - mismatch), mismatch)


Split = Literal["smaller first", "larger first", "none"]
"""Which component of a way goes first, or neither: an askew face turns at the bumper, at the cost of tries."""


def legs_for(box: Pose, task: PushTask, pit: Pit | None, split: Split = "smaller first") -> tuple[Leg, ...]:
    """Split a push into straight legs along which the box need not be turned.

    The box goes straight where its face is square to the way, give or take what straightens itself. Other
    ways are split in two along the box's own sides (before a pit: along the pit's).

    Args:
        box: Where the box is now.
        task: The push.
        pit: The task's pit.
        split: How; before a pit only splits from which a box can drop into it.

    Returns:
        One or two legs.
    """
    here, goal = (box.x, box.y), task.goal
    dx, dy = goal[0] - here[0], goal[1] - here[1]
    direction = math.atan2(dy, dx)
    square = abs(quarter(direction - box.yaw)) <= MAX_MISMATCH
    axes, towards = box.yaw, False
    if pit is not None:
        if pit.contains(*here):
            # It hangs at an edge: its own place says nothing about the direction it came from.
            off = quarter(task.line - pit.yaw)
            line = task.line if abs(off) <= _PIT_MISMATCH else task.line - off
            return (Leg((goal[0] - math.cos(line), goal[1] - math.sin(line)), goal, True),)
        towards = abs(quarter(direction - pit.yaw)) <= _PIT_MISMATCH
        askew = abs(quarter(box.yaw - pit.yaw)) > MAX_MISMATCH
        # An askew box turns at the bumper while it is pushed, straight on or round a corner; that may take more tries.
        if towards and (square or askew):
            return (Leg(here, goal, True),)
        axes = pit.yaw
    elif square:
        return (Leg(here, goal, False),)
    c, s = math.cos(axes), math.sin(axes)
    along, aside = c * dx + s * dy, -s * dx + c * dy
    if split == "none" and (pit is None or towards):
        return (Leg(here, goal, pit is not None),)
    swapped = split == "larger first" and (pit is None or min(abs(along), abs(aside)) >= _RUN_UP)
    if (abs(along) < abs(aside)) != swapped:
        corner = (here[0] + c * along, here[1] + s * along)
    else:
        corner = (here[0] - s * aside, here[1] + c * aside)
    last = Leg(corner, goal, pit is not None)
    if math.dist(here, corner) < _NEGLIGIBLE:
        return (Leg(here, goal, pit is not None),)
    return (Leg(here, corner, False), last)


def staging_points(scene: Scene, box: int, at: Point, heading: float, coarse: bool = False) -> list[Point]:
    """Places behind a box that a push may start from, the best first."""
    half = scene.boxes[box].length / 2
    c, s = math.cos(heading), math.sin(heading)
    return [(at[0] - (half + gap) * c, at[1] - (half + gap) * s) for gap in (_COARSE_GAPS if coarse else _FINE_GAPS)]


def plan_push(scene: Scene, box: int, task: PushTask, around: Surroundings, at: Pose | None = None) -> PushPlan:
    """Whether a push is feasible geometrically, with its margin.

    Looks at the staging pose of every leg and at the corridor that box and robot sweep. Whether the robot
    can reach the staging pose from where it is now is not looked at. A way that has to be split in two is split
    so that both legs can be staged, or not at all where no split allows that.

    Args:
        scene: The scene; the box's pose is read from it.
        box: Index of the box.
        task: The push; its start does not matter, the box's own place does.
        around: What to stay away from; the box itself is left out if it is among it.
        at: Where to imagine the box, instead of where it is.
    """
    here = at or scene.box(box)
    plans = [_with_margin(scene, box, task, legs, around) for legs in _ways_to_split(scene, here, task)]
    return next((plan for plan in plans if plan.margin >= 0.0), max(plans, key=lambda plan: plan.margin))


def first_legs(scene: Scene, task: PushTask, around: Surroundings) -> list[Leg]:
    """How a push may begin from where its box is now, the best first; robots move on and are not looked at."""
    ways = _ways_to_split(scene, scene.box(task.box), task)
    if len(ways) > 1:
        still = replace(around, robots=())
        # Sorting keeps the order of the splits among those that can be staged, and among those that cannot.
        ways.sort(key=lambda legs: _with_margin(scene, task.box, task, legs, still).margin < 0.0)
    return [legs[0] for legs in ways]


def _ways_to_split(scene: Scene, box: Pose, task: PushTask) -> list[tuple[Leg, ...]]:
    """The legs of a push from where a box is or would be, for each way to split it that differs."""
    pit = None if task.pit is None else scene.terrain.pits[task.pit]
    splits: tuple[Split, ...] = ("smaller first", "larger first", "none")
    return list(dict.fromkeys(legs_for(box, task, pit, split) for split in splits))


def _with_margin(scene: Scene, box: int, task: PushTask, legs: tuple[Leg, ...], around: Surroundings) -> PushPlan:
    others = replace(around, boxes=tuple(i for i in around.boxes if i != box))
    pits = tuple(i for i in around.open_pits if i != task.pit)
    space = FreeSpace(scene, others)
    corridor = FreeSpace(scene, Surroundings(others.robots, others.boxes, pits))
    margin, reason = math.inf, "ok"
    for leg in legs:
        staged = max(space.slack(x, y) for x, y in staging_points(scene, box, leg.start, leg.heading))
        if staged < margin:
            margin, reason = staged, "ok" if staged >= 0.0 else "no staging pose"
        swept = _corridor_slack(scene, box, leg, corridor)
        if swept < margin:
            margin, reason = swept, "ok" if swept >= 0.0 else "way of the box blocked"
    return PushPlan(legs, margin, reason)


def _corridor_slack(scene: Scene, box: int, leg: Leg, space: FreeSpace) -> float:
    """Slack of the box's centre line: the robot's own, and no step in the ground under the box."""
    (x0, y0), (x1, y1) = leg.start, leg.goal
    parts = max(1, math.ceil(leg.length / 0.1))
    part = 1.0 / parts
    half, footing = scene.boxes[box].length / 2, footing_on(scene.terrain)
    # Along the middle, and where the corners of the box pass: nor may one of them run against a step up.
    c, s = math.cos(leg.heading), math.sin(leg.heading)
    before = before_left = before_right = math.inf
    for k in range(parts + 1):
        share = k * part if k < parts else 1.0
        x, y = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
        here = footing.height(x, y)
        left, right = footing.height(x - half * s, y + half * c), footing.height(x + half * s, y - half * c)
        if here == _NOWHERE or (k > 0 and abs(here - before) > _STEP):
            return -half
        if left - before_left > _STEP or right - before_right > _STEP:
            return -half
        before, before_left, before_right = here, left, right
    # The box's own half is wider than the robot's disc by little; at its ends it may overhang nodes.
    least = math.inf
    for k in range(parts + 1):
        share = k * part if k < parts else 1.0
        least = min(least, space.slack(x0 + share * (x1 - x0), y0 + share * (y1 - y0)))
    return least - (half - PIT_CLEARANCE)


def stage_part(
    pilot: Pilot,
    box: int,
    heading: float,
    obstacles: Obstacles,
    *,
    coarse: bool = False,
) -> Part:
    """Bring a robot behind a box.

    Fine: right behind the box on the line through its centre, heading along the push. Coarse: anywhere
    between 1.15 and 1.6 m from the box's centre, up to .35 rad off the line, heading within .8 rad of it.

    Args:
        pilot: The robot.
        box: Index of the box.
        heading: Direction of the push, radians.
        obstacles: What to drive round, besides the box itself.
        coarse: Which of the two.
    """
    scene = pilot.scene
    if coarse and coarsely_staged(pilot, box, heading):
        return "done"
    if (reason := (yield from pilot.leave_box())) != "done":
        return reason

    def around() -> Surroundings:
        seen = obstacles()
        return seen if box in seen.boxes else replace(seen, boxes=(*seen.boxes, box))

    arrived: Callable[[], bool] | None = None
    if coarse:

        def arrived() -> bool:
            return coarsely_staged(pilot, box, heading, any_heading=True)

    until = scene.time + _PATIENCE
    while True:
        at = scene.box(box)
        pose = pilot.pose
        space = FreeSpace(scene, pilot.near(around()))
        for point in staging_points(scene, box, (at.x, at.y), heading, coarse):
            path = space.path((pose.x, pose.y), point)
            if path is not None:
                break
        else:
            # Another robot may be about to leave; what stands still will not.
            if scene.time >= until or not around().robots:
                return "no staging pose"
            if (reason := (yield from pilot.wait(1.0))) != "done":
                return reason
            continue
        reason = yield from pilot.go(point, around, STAGING_SPEED, 0.03, arrived, path)
        if reason in ("blocked", "no way", "stuck"):
            return "no staging pose" if reason == "no way" else reason
        if reason != "done":
            return reason
        if not coarse:
            return (yield from pilot.turn_to(heading))
        off = wrap(pilot.pose.yaw - heading)
        if abs(off) > COARSE_HEADING - 0.05:
            wanted = heading + math.copysign(COARSE_HEADING - 0.1, off)
            return (yield from pilot.turn_to(wanted, 0.05))
        return "done"


def coarsely_staged(pilot: Pilot, box: int, heading: float, any_heading: bool = False) -> bool:
    """Whether a robot stands where a coarse handover may happen."""
    x, y, yaw = pilot.scene.course(pilot.robot)
    at = pilot.scene.box(box)
    dx, dy = at.x - x, at.y - y
    if not COARSE_NEAR <= math.hypot(dx, dy) <= COARSE_FAR:
        return False
    if abs(wrap(math.atan2(dy, dx) - heading)) > COARSE_BEARING:
        return False
    return any_heading or abs(wrap(yaw - heading)) <= COARSE_HEADING


def in_place(pilot: Pilot, box: int, heading: float) -> bool:
    """Whether a robot already stands at the box's face and can push on without staging."""
    scene = pilot.scene
    contact = scene.boxes[box].length / 2 + scene.models[pilot.robot].bumper
    return at_face(pilot.pose, scene.box(box), contact, heading)


def at_face(pose: Pose, at: Pose, contact: float, heading: float) -> bool:
    """Whether a robot at `pose` touches the face of a box from which it is pushed along a heading (radians).

    Args:
        pose: The robot.
        at: The box.
        contact: Distance of the two centres when the bumper lies against the face.
        heading: Direction of the push, radians.
    """
    ahead, aside = in_frame(pose, at.x, at.y)
    return (
        abs(wrap(pose.yaw - heading)) < 0.25
        and abs(face_for(at, heading).mismatch) < MAX_MISMATCH
        and -0.05 < ahead - contact < 0.10
        and abs(aside) < 0.12
    )


def stage(
    scene: Scene,
    robot: int,
    box: int,
    heading: float,
    obstacles: Obstacles,
    *,
    coarse: bool = False,
    log: Log = ignore,
    limit: float = 60.0,
) -> Manoeuvre:
    """The manoeuvre that brings a robot behind a box; see `stage_part`.

    Returns:
        A manoeuvre that ends with `"done"`, `"no staging pose"`, `"blocked"` (by another robot),
        `"stuck"`, `"timeout"`, or a fault of the robot.
    """
    pilot = Pilot(scene, robot, log, limit)
    try:
        reason = yield from stage_part(pilot, box, heading, obstacles, coarse=coarse)
    finally:
        pilot.flush()
    return ManoeuvreResult(reason == "done", reason, pilot.seconds)
