"""When a push has succeeded or failed, and what a control step is worth."""

from dataclasses import dataclass
from typing import Literal

from colonysim.physics import Pose
from colonysim.push.state import HOLD, PIT_DEPTH, State
from colonysim.push.task import Kind, PushTask

__all__ = ["OFF_NODE", "PAPER_RULES", "STEP_LIMIT", "Rules", "Verdict", "guard", "judge", "reward", "short_of_node"]

Verdict = Literal["success", "failure", "abort"]

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
_ARRIVED = 0.03
OFF_NODE = 0.10
"""With guards a push that ends further beside its node than this has failed, metres."""


@dataclass(frozen=True, slots=True)
class Rules:
    """How an episode of the training environment is run and rewarded.

    Attributes:
        ticks: T, control ticks of one action.
        check_every: Success and failure are tested after this many ticks (an action moves the robot by up to
            .39 m and would jump over the goal's .2 m); the last tick of an action is always tested.
        hold_heading: Leave the heading term out of the reward when D < .3 before or after the action, where
            the direction to the goal flips by half a turn.
        cross_track_gain: Reward for each metre that the box comes closer to the push line.
        success_bonus: Added to the reward of the action that succeeds.
        failure_penalty: Taken from the reward of the action that fails or is aborted.
        guards: Whether the aborts of the staged executor end an episode too.
        at_node: On level ground an episode that fulfils the paper's success goes on until the box has come
            along its line to the node itself, so that the learner does not stop .2 m before it.
        leash: A robot further than this from the box ends the episode, metres; None for no limit.
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
    return state.remaining > _ARRIVED and state.distance > _ARRIVED


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
