"""Does a push executor keep the promises of the protocol? A check for those who write one."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from colonysim.arguments import as_seed, real
from colonysim.backends.executors import CheckedExecutor
from colonysim.errors import PluginError
from colonysim.learning.seeds import Purpose, episode_rng
from colonysim.physics import TICK_SECONDS, BoxSpec, RobotSpec, Scene
from colonysim.push.judging import box_ending
from colonysim.push.paths import everything_else
from colonysim.push.training.starts import KINDS, distribution, draw
from colonysim.testing.promises import ConformanceError, global_randomness

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from colonysim.physics import Pose
    from colonysim.push.executors import Executor
    from colonysim.push.task import Manoeuvre, ManoeuvreResult, WheelSpeeds
    from colonysim.push.training.starts import Start

__all__ = ["check_executor"]

AWAY = 6.5
"""A second robot and a second box stand this far from the push, metres: whoever does as promised leaves them alone."""
MOVED = 0.02
"""A body that nobody touches does not move further than this, metres."""
ARRIVED = 0.5
"""A box that is said to have arrived is no further from its node than this, metres."""
CANCELLED_AFTER = 40
"""Ticks."""


@dataclass(frozen=True)
class _Played:
    """What came of a push, all of which the same seed has to give again."""

    speeds: tuple[WheelSpeeds, ...]
    told: tuple[tuple[Any, ...], ...]
    result: ManoeuvreResult
    box: Pose


def check_executor(
    factory: Callable[[], Executor], *, seed: int = 1, limit: float = 300.0, engine: str | None = None
) -> None:
    """Has an executor push single boxes: on level ground, up a slope, into a pit, and against another box.

    Args:
        factory: Makes a new executor; called several times.
        seed: Makes the starts, and all that the executor draws.
        limit: Simulated seconds within which each push has to end, whether it succeeds or not.
        engine: The rigid-body engine; by default the first that is installed.

    Raises:
        ConformanceError: The first broken promise: "protocol" (what it makes is no manoeuvre, or something is raised),
            "begins later", "reads only", "own robot", "ends", "honesty", "log", "determinism", "randomness",
            "isolation" or "cancel"; the message says what happened.

    Example:
        ```python
        from colonysim.testing import check_executor

        def test_my_executor_keeps_its_promises():
            check_executor(MyExecutor)
        ```
    """
    seed, limit = as_seed(seed), real("limit", limit, 1.0, 1e6)
    for name, start, others in _worlds(seed):
        world = _World(name, start, others, seed, round(limit / TICK_SECONDS), engine)
        _check_cancel(factory, world)
        _check_pushes(factory, world)
        _check_side_by_side(factory, world)


def _worlds(seed: int) -> list[tuple[str, Start, list[BoxSpec]]]:
    """Names, starts and further boxes."""
    found: list[tuple[str, Start, list[BoxSpec]]] = []
    for number, kind in enumerate(KINDS):
        start = draw(kind, distribution("push"), episode_rng(Purpose.TEST, seed, number))
        found.append((kind, start, []))
    flat = found[0][1]
    x, y = flat.task.goal
    return [*found, ("another box in the way", flat, [BoxSpec(x, y, 0.0, flat.task.line)])]


class _World:
    """Scenes in which the same push can be tried again and again.

    Args:
        name: For messages.
        start: Where it begins.
        others: Boxes that stand about.
        seed: For the executor.
        ticks: After so many it has to be over.
        engine: The engine.
    """

    def __init__(
        self, name: str, start: Start, others: Sequence[BoxSpec], seed: int, ticks: int, engine: str | None
    ) -> None:
        self.name, self.task, self.seed, self.ticks, self._engine = name, start.task, seed, ticks, engine
        line = start.task.line + math.pi / 2
        east, north = AWAY * math.cos(line), AWAY * math.sin(line)
        self._robots = [start.robot, RobotSpec(east, north, 0.0, 0.0)]
        self._boxes, self._terrain = [start.box, BoxSpec(-east, -north, 0.0, 0.0), *others], start.terrain

    def scene(self) -> Scene:
        """A new scene: the robot and the box of the push come first, those that are to be left alone next."""
        return Scene(self._terrain, self._boxes, self._robots, engine=self._engine)

    def fault(self, promise: str, what: str) -> ConformanceError:
        """A broken promise, and on which push."""
        return ConformanceError(promise, f"push ({self.name}): {what}")


class _Push:
    """One push under way in a scene of its own.

    Args:
        world: The push.
        executor: What carries it out.
    """

    def __init__(self, world: _World, executor: CheckedExecutor) -> None:
        self.world, self.scene = world, world.scene()
        self._told: list[tuple[Any, ...]] = []
        self._speeds: list[WheelSpeeds] = []
        self._before = self.poses()
        self.over: _Played | None = None
        try:
            self.manoeuvre = self._begin(executor)
        except BaseException:
            self.scene.close()
            raise

    def _begin(self, executor: CheckedExecutor) -> Manoeuvre:
        scene, world = self.scene, self.world
        try:
            made = executor(scene, 0, world.task, everything_else(scene, 0), self._log, world.seed)
        except PluginError as error:
            raise world.fault("protocol", str(error)) from error
        self._untouched("begins later", "to make the manoeuvre of a push")
        if self._told:
            raise world.fault("begins later", f"to make the manoeuvre of a push already logs {self._told[0]}")
        return made

    def poses(self) -> tuple[int, tuple[Pose, ...]]:
        """How many ticks the scene has had, and where everything in it is."""
        scene = self.scene
        return scene.ticks, (*map(scene.robot, range(2)), *map(scene.box, range(len(scene.boxes))))

    def _untouched(self, promise: str, what: str) -> None:
        if self.poses() != self._before:
            why = "ticks the scene" if self.scene.ticks != self._before[0] else "moves a body"
            raise self.world.fault(promise, f"{what} {why}")

    def _log(self, *told: Any) -> None:
        who, control, ticks = told if len(told) == 3 else (None, None, None)
        if who not in ("script", "network") or not isinstance(control, str) or type(ticks) is not int or ticks < 0:
            raise self.world.fault("log", f"it logs {told!r:.80}, expected 'script' or 'network', a control, and ticks")
        self._told.append(told)

    def go_on(self) -> bool:
        """One tick more; False once the push is over."""
        scene, world = self.scene, self.world
        self._before = self.poses()
        try:
            speeds = next(self.manoeuvre)
        except PluginError as error:
            raise world.fault("protocol", str(error)) from error
        except StopIteration as end:
            self._untouched("reads only", "the end of its manoeuvre")
            self._end(end.value)
            return False
        self._untouched("reads only", f"tick {scene.ticks} of its manoeuvre")
        if len(self._speeds) == world.ticks:
            raise world.fault("ends", f"it is not over after {world.ticks * TICK_SECONDS:g} s")
        self._speeds.append(speeds)
        scene.drive(0, *speeds)
        scene.tick()
        return True

    def _end(self, result: ManoeuvreResult) -> None:
        scene, world = self.scene, self.world
        for what, found, wanted in (
            ("robot", scene.robot(1), world._robots[1]), ("box", scene.box(1), world._boxes[1]),
        ):  # fmt: skip
            if math.dist(found[:2], (wanted.x, wanted.y)) > MOVED:
                raise world.fault("own robot", f"another {what}, {AWAY:g} m away, has moved")
        if result.success != (result.reason == "done"):
            raise world.fault("honesty", f"success is {result.success} and the reason {result.reason!r:.80}; 'done' is"
                              " the reason of a success alone")  # fmt: skip
        if result.success and box_ending(scene, world.task, ARRIVED) != "done":
            raise world.fault("honesty", f"it says that it is done, and the box is {self._away()}")
        logged = sum(ticks for _, _, ticks in self._told)
        if abs(logged - len(self._speeds)) > 1:
            raise world.fault("log", f"it has driven for {len(self._speeds)} ticks, and logged controls of {logged}")
        self.over = _Played(tuple(self._speeds), tuple(self._told), result, scene.box(0))

    def _away(self) -> str:
        off = math.dist(self.scene.box(0)[:2], self.world.task.goal)
        return f"{off:.2f} m from its node" if self.world.task.pit is None else "not in its pit"

    def to_the_end(self) -> _Played:
        """All the rest of it."""
        while self.go_on():
            pass
        assert self.over is not None
        return self.over

    def close(self) -> None:
        """Ends it, wherever it is."""
        try:
            self.manoeuvre.close()
        except Exception as error:
            raise self.world.fault("cancel", f"a manoeuvre that is closed raises {error!r}") from error
        finally:
            self.scene.close()


def _made(factory: Callable[[], Executor], world: _World) -> CheckedExecutor:
    try:
        return CheckedExecutor("it", factory())
    except PluginError as error:
        raise world.fault("protocol", str(error)) from error


def _play(executor: CheckedExecutor, world: _World) -> _Played:
    push = _Push(world, executor)
    try:
        return push.to_the_end()
    finally:
        push.close()


def _check_cancel(factory: Callable[[], Executor], world: _World) -> None:
    """A robot may be stopped at any time: before its manoeuvre has begun, and in the middle."""
    for ticks in (0, CANCELLED_AFTER):
        push = _Push(world, _made(factory, world))
        for _ in range(ticks):
            if not push.go_on():
                break
        push.close()


def _check_pushes(factory: Callable[[], Executor], world: _World) -> None:
    """The same seed gives the same push, whatever else has happened."""
    used = _made(factory, world)
    with global_randomness(1):
        first = _play(_made(factory, world), world)
    with global_randomness(1):
        _same(world, "determinism", "two pushes of one seed differ", first, _play(used, world))
    with global_randomness(2):
        _same(world, "randomness", "the seed of the `random` module makes a difference", first,
              _play(_made(factory, world), world))  # fmt: skip
    _same(world, "isolation", "it pushes otherwise the second time", first, _play(used, world))


def _check_side_by_side(factory: Callable[[], Executor], world: _World) -> None:
    """One executor has two robots push at a time, as in a colony; each does what it does alone."""
    alone = _play(_made(factory, world), world)
    both = _made(factory, world)
    pushes = [_Push(world, both), _Push(world, both)]
    try:
        under_way = pushes[1:]  # which is ahead of the other
        for tick in itertools.count():
            if tick == CANCELLED_AFTER:
                under_way = [*under_way, pushes[0]]
            under_way = [push for push in under_way if push.go_on()]
            if tick >= CANCELLED_AFTER and not under_way:
                break
        for push in pushes:
            assert push.over is not None
            _same(world, "isolation", "another push beside it makes a difference", alone, push.over)
    finally:
        for push in pushes:
            push.close()


def _same(world: _World, promise: str, what: str, one: _Played, other: _Played) -> None:
    if one != other:
        parted = next((n for n, (a, b) in enumerate(zip(one.speeds, other.speeds, strict=False)) if a != b), None)
        where = f"at tick {parted}" if parted is not None else f"{one.result} or {other.result}"
        raise world.fault(promise, f"{what}: {where}")
