"""Push executors by name: those of this package, and those of others, whose answers are checked."""

from __future__ import annotations

import math
from collections.abc import Generator
from numbers import Real
from typing import TYPE_CHECKING, Any, NoReturn, cast

from colonysim.errors import PASSED_ON, ColonysimError, PluginError, told
from colonysim.physics.traction import WheelSpeeds
from colonysim.plugins import BUILT_IN, load
from colonysim.push.executors import make_executor
from colonysim.push.task import ManoeuvreResult, ignore

if TYPE_CHECKING:
    from pathlib import Path

    from colonysim.physics import Scene
    from colonysim.push.executors import Executor, ExecutorName
    from colonysim.push.gated import Gate
    from colonysim.push.paths import Obstacles
    from colonysim.push.task import Log, Manoeuvre, PushTask

__all__ = ["CheckedExecutor", "executor_called"]


def executor_called(name: str, *, model: str | Path | None = None, gate: Gate | None = None) -> Executor:
    """The push executor of a name.

    Args:
        name: "rl", "staged", "scripted", the name under which one of others is installed, or "package.module:Name".
        model: The network; None for the executor's own.
        gate: Says where "rl" begins a push.

    Raises:
        PluginError: There is no such executor, or it cannot be made.
        ColonysimError: The model cannot be used, or the executor takes none.
    """
    if name in BUILT_IN["executors"]:
        return make_executor(cast("ExecutorName", name), model=model, gate=gate)
    factory = load("executors", name)
    try:
        made = factory() if model is None else factory(model=model)
    except PASSED_ON:
        raise
    except BaseException as error:  # another's code may fail in any way, exit() included; ours still owes a message
        options = "" if model is None else f" with the model {str(model)!r}"
        raise PluginError(f"push executor {name!r} cannot be made{options}: {told(error)}") from error
    return CheckedExecutor(name, made)


class CheckedExecutor:
    """An executor of others; what its manoeuvres answer is checked.

    Args:
        name: As it was asked for.
        execute: The executor.

    Raises:
        PluginError: It cannot be called.
    """

    def __init__(self, name: str, execute: Any) -> None:
        if not callable(execute):
            raise PluginError(f"push executor {name!r}: its factory makes {execute!r:.80}, expected what can be called")
        self._name, self._execute = name, execute

    def __call__(
        self, scene: Scene, robot: int, task: PushTask, obstacles: Obstacles, log: Log = ignore, seed: int = 0
    ) -> Manoeuvre:
        """The manoeuvre of a push, see `Executor`.

        Raises:
            PluginError: It raises something, or makes no manoeuvre.
        """
        try:
            manoeuvre = self._execute(scene, robot, task, obstacles, log, seed)
        except PASSED_ON:
            raise
        except BaseException as error:
            self._raised(robot, error)
        if not isinstance(manoeuvre, Generator):
            raise self._fault(robot, f"makes {manoeuvre!r:.80}, expected a generator of wheel speeds")
        return self._checked(robot, manoeuvre)

    def _checked(self, robot: int, manoeuvre: Generator[Any, None, Any]) -> Manoeuvre:
        try:
            while True:
                try:
                    speeds = next(manoeuvre)
                except StopIteration as end:
                    return self._result(robot, end.value)
                except PASSED_ON:
                    raise
                except BaseException as error:
                    self._raised(robot, error)
                yield self._speeds(robot, speeds)
        finally:
            manoeuvre.close()

    def _speeds(self, robot: int, speeds: Any) -> WheelSpeeds:
        try:
            left, right = speeds
            if isinstance(left, Real) and isinstance(right, Real):
                found = WheelSpeeds(float(left), float(right))
                if math.isfinite(found.left) and math.isfinite(found.right):
                    return found
        except (TypeError, ValueError, OverflowError):
            pass
        raise self._fault(robot, f"yields {speeds!r:.80}, expected two finite numbers, the wheel speeds")

    def _result(self, robot: int, result: Any) -> ManoeuvreResult:
        if not isinstance(result, ManoeuvreResult):
            raise self._fault(robot, f"ends with {result!r:.80}, expected a ManoeuvreResult")
        if type(result.success) is not bool or not isinstance(result.reason, str):
            raise self._fault(robot, f"ends with {result!r:.200}, expected True or False, and a reason as text")
        return result

    def _raised(self, robot: int, error: BaseException) -> NoReturn:
        raise self._fault(robot, f"raises {told(error)}") from error

    def _fault(self, robot: int, what: str) -> ColonysimError:
        return PluginError(f"push executor {self._name!r}, robot {robot}: {what}")
