"""The verdict on a push, the same when it runs and when it is trained, and what a control step is worth.

From the inside out: `judge` is the paper's table of success and failure; `guard` gives up a push that is going wrong;
`ending` says from both when the network's part of a push is over, and why; `box_ending` says of a box alone whether its
push is over, whoever pushed it.
"""

import math
from dataclasses import dataclass
from typing import Literal

from colonysim.physics import Pose, Scene
from colonysim.push.controls import CONTROL_TICKS
from colonysim.push.seating import is_deep, lies, pressed
from colonysim.push.state import HOLD, PIT_DEPTH, State
from colonysim.push.task import Kind, PushTask

__all__ = [
    "ARRIVED", "DONE", "PAPER_RULES", "STEP_LIMIT", "STEP_TICKS", "Rules", "Verdict", "box_ending", "ending", "guard",
    "judge", "must_lie", "reward", "short_of_node",
]  # fmt: skip

Verdict = Literal["success", "failure"]

STEP_LIMIT: dict[Kind, int] = {"flat": 50, "slope": 100, "hole": 50}
"""Most control steps of an episode (paper, table of maximum steps), for steps of 50 ticks."""
STEP_TICKS = 50
"""T of the paper: control ticks of one step."""
DONE = 0.2
"""Success needs the box this close to the goal, metres."""
_FAR = 5.0
_STRAIGHT, _TURNED = 0.2, 0.3
_LOW = 0.2
_CORRIDOR, _DRIFT = 0.15, 0.08
_WIDER, _WIDENING, _NEAR = 0.15, 0.1, 0.5
"""Up a slope, which is long, the corridor widens by a share of what remains beyond the last half metre."""
_TIPPING = (0.62, 0.80)
_TIPPING_OFFSET = 0.08
_PAST = 0.012
_AT_NODE = 0.03
"""A box this close to its node, or to passing beside it, cannot be pushed any closer, metres."""
ARRIVED = 0.12
"""A box that the network has pushed as far as its node has arrived if it is this close to it, metres."""


@dataclass(frozen=True, slots=True)
class Rules:
    """How a network pushes, when its push is over, and, in training, how it is rewarded.

    The defaults are those of the executors `staged` and, behind its classifier, `rl`.

    Attributes:
        ticks: T, control ticks (of 1/60 s) of one action.
        check_every: Control ticks between two tests of whether the push is over: a multiple of 3, or at least `ticks`.
            An action moves the robot by up to .39 m and would jump over the goal's .2 m. The last tick of an action is
            always tested.
        hold_heading: Leave the heading term out of the reward when D < .3 before or after the action, where
            the direction to the goal flips by half a turn.
        cross_track_gain: Reward for each metre that the box comes closer to the push line.
        success_bonus: Added to the reward of the action that succeeds.
        failure_penalty: Taken from the reward of the action that fails.
        guards: Whether the guards decide that a push has failed, and not the paper's table.
        at_node: Whether a push that fulfils the paper's success goes on until the box has come along its line to the
            node itself, or lies in its pit, so that it does not stop .2 m before the node.
        leash: A robot further than this from the box has lost it, metres; None for no limit.
        tolerance: With guards, a box that has come along its line has failed further from its node than this, metres.

    Raises:
        ValueError: `check_every` is no multiple of 3 and less than `ticks`.
    """

    ticks: int = 25
    check_every: int = 3
    hold_heading: bool = True
    cross_track_gain: float = 4.0
    success_bonus: float = 5.0
    failure_penalty: float = 2.0
    guards: bool = True
    leash: float | None = 2.2
    at_node: bool = True
    tolerance: float = ARRIVED

    def __post_init__(self) -> None:
        if self.check_every % CONTROL_TICKS and self.check_every < self.ticks:
            raise ValueError(
                f"check_every: {self.check_every}, expected a multiple of {CONTROL_TICKS}, or at least {self.ticks}"
            )

    def step_limit(self, kind: Kind) -> int:
        """Most actions of an episode: the paper's simulated time, whatever the length of an action."""
        return STEP_LIMIT[kind] * STEP_TICKS // self.ticks


PAPER_RULES = Rules(
    ticks=STEP_TICKS,
    check_every=STEP_TICKS,
    hold_heading=False,
    cross_track_gain=0.0,
    success_bonus=0.0,
    failure_penalty=0.0,
    guards=False,
    leash=None,
    at_node=False,
)
"""The paper's text verbatim."""


def judge(task: PushTask, state: State, robot: Pose, box: Pose) -> Verdict | None:
    """The paper's table of success and failure conditions.

    Heights count from the floor of a pit one box deep, .25 m below the rim: a box's centre stands at .375
    before and .125 in the pit, a robot at .25.
    """
    distance = state.distance
    if task.kind == "hole":
        floor = task.rim - PIT_DEPTH
        low = box.z - floor < _LOW
        sunk = robot.z - floor < _LOW
        if distance <= DONE and low and not sunk:
            return "success"
        return "failure" if (distance > DONE and low) or sunk else None
    turn = abs(state.box_turn)
    if distance <= DONE and turn < _STRAIGHT:
        return "success"
    return "failure" if distance > _FAR or turn > _TURNED else None


def short_of_node(state: State) -> bool:
    """Whether a box that counts as arrived (D <= .2) could still be pushed on towards its node."""
    return state.remaining > _AT_NODE and state.distance > _AT_NODE


def guard(task: PushTask, state: State, started_at: float, corridor: float = _CORRIDOR) -> str | None:
    """Why a push should be given up before it spoils anything; None while it may go on.

    Args:
        task: The push.
        state: The state now.
        started_at: The box's cross-track distance when the push began, metres.
        corridor: Least width that the box may leave the push line by, metres.
    """
    offset = abs(state.cross_track)
    remaining = state.remaining
    if task.kind == "slope":
        corridor += min(_WIDER, _WIDENING * max(0.0, remaining - _NEAR))
    if offset > max(corridor, abs(started_at) + _DRIFT):
        return "off_line"
    if task.kind == "hole":
        # The last moment before the box tips: it no longer straightens itself once inside.
        if _TIPPING[0] <= remaining <= _TIPPING[1] and offset > _TIPPING_OFFSET:
            return "off_line_at_edge"
    elif remaining <= _PAST and state.distance > DONE:
        return "past_goal"
    return None


def must_lie(scene: Scene, task: PushTask, rules: Rules) -> bool:
    """Whether the goal is a pit in which the box has to lie flat: always `at_node`, else in a deep pit only.

    The paper's pits are one box deep; in a deeper one its conditions hold while the box still leans over the edge.
    """
    return task.kind == "hole" and (rules.at_node or is_deep(scene, task))


def ending(scene: Scene, robot: int, task: PushTask, state: State, started_at: float, rules: Rules) -> str:
    """Why the network's part of a push is over; empty while it goes on.

    A push is over, too, after a fault of the robot and after too many actions; both are told elsewhere. Where the box
    must lie in its pit (`must_lie`), `"done"` means that nothing is left but to let it come to rest.

    Args:
        scene: The scene.
        robot: Index of the robot.
        task: The push.
        state: The state now.
        started_at: The box's cross-track distance when the network took over, metres.
        rules: Whether guards or the paper's table give a push up, and how close to its node a box must come.

    Returns:
        `"done"`; `"failure"` (by the paper's table); `"off_node"` (the box went past its node, too far beside it),
        `"robot_far"`, `"off_line"`, `"off_line_at_edge"`, `"past_goal"`; `"box fallen"`; or nothing.
    """
    if scene.box_fault(task.box):
        return "box fallen"
    verdict = judge(task, state, scene.robot(robot), scene.box(task.box))
    if must_lie(scene, task, rules):
        # It first leans over the edge: it must be pressed on until it lies, but no further than the robot may go
        # without falling in.
        if pressed(scene, robot, task):
            return "done"
        if verdict == "success":
            return "done" if lies(scene, task) else ""
        if is_deep(scene, task):
            verdict = None
    elif verdict == "success" and rules.at_node:
        if short_of_node(state):
            verdict = None
        elif rules.guards and state.distance > rules.tolerance:
            return "off_node"
    if verdict == "success":
        return "done"
    if verdict == "failure" and not rules.guards:
        return "failure"
    if rules.leash is not None and math.hypot(state.x_box, state.y_box) > rules.leash:
        return "robot_far"
    return (guard(task, state, started_at) or "") if rules.guards else ""


def box_ending(scene: Scene, task: PushTask, tolerance: float) -> str:
    """Why a push is over whatever the robot does, from where the box is; empty while it is not.

    Args:
        scene: The scene.
        task: The push.
        tolerance: A box this close to its node has arrived, metres.

    Returns:
        `"done"` (the box is at its node, or lies in its pit), `"box stray"` (it fell into another pit or off the
        ground), `"nan"`; or nothing.
    """
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


def reward(rules: Rules, before: State, after: State, verdict: Verdict | None) -> float:
    """What an action was worth: paper Eq. 8, and what the rules add to it.

    The paper's constant cost of .1 is for an action of 50 ticks and scales with its length.
    """
    d_before, d_after = before.distance, after.distance
    value = 5.0 * (d_before - d_after) - 0.1 * rules.ticks / STEP_TICKS
    if not (rules.hold_heading and min(d_before, d_after) < HOLD):
        value += 2.0 * (abs(before.heading_error) - abs(after.heading_error))
    value += rules.cross_track_gain * (abs(before.cross_track) - abs(after.cross_track))
    if verdict == "success":
        value += rules.success_bonus
    elif verdict is not None:
        value -= rules.failure_penalty
    return value
