"""What robots are doing, tick by tick, and how they look out for each other meanwhile."""

from __future__ import annotations

from typing import TYPE_CHECKING

from colonysim.backends.traffic import LOOK_TICKS, closing_in, ticks_until_close

if TYPE_CHECKING:
    from colonysim.physics import Scene, WheelSpeeds
    from colonysim.push.task import Manoeuvre, ManoeuvreResult
    from colonysim.world.intents import Push, Travel

__all__ = ["Action", "Actions"]


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

    __slots__ = ("_speeds", "held", "intent", "look_at", "manoeuvre", "origin")

    def __init__(self, intent: Travel | Push, manoeuvre: Manoeuvre, origin: int) -> None:
        self.intent = intent
        self.manoeuvre = manoeuvre
        self.origin = origin
        self.held = False
        self.look_at = 0
        self._speeds: WheelSpeeds | None = None

    def go_on(self, scene: Scene, agent: int) -> None:
        """Drives for one more tick, unless another robot is in the way.

        Raises:
            StopIteration: The manoeuvre is over; its value is the result.
        """
        speeds = next(self.manoeuvre)
        ticks, held = scene.ticks, self.held
        if ticks >= self.look_at and (ticks + agent) % LOOK_TICKS == 0:
            others = [scene.course(i) for i in scene.present_robots() if i != agent]
            here = scene.course(agent)
            self.held = closing_in(here, speeds, others)
            self.look_at = ticks + ticks_until_close(here, others)
        # A scene keeps what it was asked for, and most speeds are those of the tick before. (Who puts a robot elsewhere
        # while it is doing something stops it.)
        if speeds is self._speeds and self.held == held:
            return
        self._speeds = speeds
        if self.held:
            scene.drive(agent, 0.0, 0.0)
        else:
            left, right = speeds
            scene.drive(agent, left, right)


class Actions:
    """What the robots of a scene are doing, each one thing at most.

    Every tick of a colony comes by here; compiled, it is a walk through a plain list (`action.pxd`).

    Args:
        scene: The scene; it is driven in, never ticked.
    """

    __slots__ = ("_of", "_scene")

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._of: list[Action | None] = [None] * scene.robot_count

    def begin(self, agent: int, action: Action) -> None:
        """Takes up an action of a robot that has none."""
        self._of[agent] = action

    def get(self, agent: int) -> Action | None:
        """What a robot is doing."""
        return self._of[agent]

    def under_way(self) -> list[tuple[int, Action]]:
        """Whoever is doing something, and what."""
        return [(agent, action) for agent, action in enumerate(self._of) if action is not None]

    def go_on(self) -> list[tuple[int, Action, ManoeuvreResult]]:
        """Drives every robot for one more tick; returns whose manoeuvre is over: who is still to be ended."""
        scene, over = self._scene, []
        for agent in range(len(self._of)):
            action = self._of[agent]
            if action is not None:
                try:
                    action.go_on(scene, agent)
                except StopIteration as end:
                    over.append((agent, action, end.value))
        return over

    def end(self, agent: int) -> None:
        """Stops a robot, if it is doing something."""
        action = self._of[agent]
        if action is not None:
            self._of[agent] = None
            action.manoeuvre.close()
            self._scene.drive(agent, 0.0, 0.0)
