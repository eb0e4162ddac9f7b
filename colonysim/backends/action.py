"""What a robot is doing, tick by tick, and how it looks out for others meanwhile."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.backends.traffic import LOOK_TICKS, closing_in, ticks_until_close

if TYPE_CHECKING:
    from colonysim.physics import Scene
    from colonysim.push.task import Manoeuvre
    from colonysim.world.intents import Push, Travel

__all__ = ["Action"]


class Action:
    """What a robot is doing.

    Args:
        intent: What it was asked for.
        manoeuvre: Its controls, tick by tick.
        origin: The node where it began.

    Attributes:
        held: Whether its wheels are stopped because another robot is in front of it.
        look_at: The tick at which it looks out for other robots again.
    """

    __slots__ = ("held", "intent", "look_at", "manoeuvre", "origin")

    def __init__(self, intent: Travel | Push, manoeuvre: Manoeuvre, origin: int) -> None:
        self.intent = intent
        self.manoeuvre = manoeuvre
        self.origin = origin
        self.held = False
        self.look_at = 0

    def go_on(self, scene: Scene, agent: int, ticks: int) -> None:
        """Drives for one more tick, unless another robot is in the way.

        Raises:
            StopIteration: The manoeuvre is over; its value is the result.
        """
        left, right = speeds = next(self.manoeuvre)
        if ticks >= self.look_at and (ticks + agent) % LOOK_TICKS == 0:
            others = [scene.course(i) for i in scene.present_robots() if i != agent]
            here = scene.course(agent)
            self.held = closing_in(here, speeds, others)
            self.look_at = ticks + ticks_until_close(here, others)
        if self.held:
            scene.drive(agent, 0.0, 0.0)
        else:
            scene.drive(agent, left, right)
