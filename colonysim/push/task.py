"""What a push is, and the form every manoeuvre of a robot takes."""

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from typing import Literal, TypeVar

from colonysim.physics.scene import Scene
from colonysim.physics.traction import WheelSpeeds as WheelSpeeds

Kind = Literal["flat", "slope", "hole"]
Chooser = Literal["script", "network"]


@dataclass(frozen=True, slots=True)
class PushTask:
    """One box to be pushed along a line.

    Attributes:
        box: Index of the box in the scene.
        start: Where the push line begins, metres: the node that the box stands on.
        goal: Where the box's centre is to go, metres: the next node, or the pit's centre.
        kind: What the goal is: level ground, the end of a slope, or a pit.
        rim: Height of the ground at the goal (of the pit's rim), metres.
        pit: Index of the goal's pit in the terrain; None unless the kind is `"hole"`.
        line: Heading of the push line, radians.
    """

    box: int
    start: tuple[float, float]
    goal: tuple[float, float]
    kind: Kind
    rim: float
    pit: int | None = None
    line: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        line = math.atan2(self.goal[1] - self.start[1], self.goal[0] - self.start[0])
        object.__setattr__(self, "line", line)  # asked for in every tick of a push

    @property
    def length(self) -> float:
        """Length of the push line, metres."""
        return math.hypot(self.goal[0] - self.start[0], self.goal[1] - self.start[1])


@dataclass(frozen=True, slots=True)
class ManoeuvreResult:
    """How a manoeuvre ended.

    Attributes:
        success: Whether it did what it was for.
        reason: `"done"`, or why not.
        seconds: Simulated seconds it took.
        tries: Pushes begun, retries included.
    """

    success: bool
    reason: str
    seconds: float = 0.0
    tries: int = 0


Manoeuvre = Generator[WheelSpeeds, None, ManoeuvreResult]
"""A manoeuvre of one robot: every value it yields holds for one control tick of 1/60 s.

It reads poses from the scene but never ticks it, so that many robots share one clock: whoever runs it
hands each yielded pair to `scene.drive` and ticks the scene once for all robots.
"""

Log = Callable[[Chooser, str, int], None]
"""Told who chose a control, which control it was, and for how many ticks it held."""


def ignore(chooser: Chooser, control: str, ticks: int) -> None:
    """The log that keeps nothing."""


Ended = TypeVar("Ended")


def run_alone(
    scene: Scene,
    robot: int,
    manoeuvre: Generator[WheelSpeeds, None, Ended],
    each_tick: Callable[[], object] | None = None,
) -> Ended:
    """Run one robot's manoeuvre, or a part of one, while every other robot keeps its wheel speeds.

    Args:
        scene: The scene that the manoeuvre reads.
        robot: Index of the robot it belongs to.
        manoeuvre: The manoeuvre.
        each_tick: Called after every tick.

    Returns:
        What the manoeuvre returns: its result, or of a part the reason why it ended.
    """
    while True:
        try:
            speeds = next(manoeuvre)
        except StopIteration as end:
            scene.drive(robot, 0.0, 0.0)
            ended: Ended = end.value
            return ended
        scene.drive(robot, speeds.left, speeds.right)
        scene.tick()
        if each_tick is not None:
            each_tick()
