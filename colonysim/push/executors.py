"""What carries out a push: the protocol of executors, and the three of this package."""

from collections.abc import Callable
from pathlib import Path
from typing import Literal, Protocol

import numpy as np

from colonysim.errors import ColonysimError
from colonysim.physics import Scene
from colonysim.push.choosing import Choose, Testing, constant, network_chooser
from colonysim.push.controls import Control
from colonysim.push.gated import Gate, gated_push
from colonysim.push.judging import Rules
from colonysim.push.learned import StagedSettings, rl_push, staged_push
from colonysim.push.network import load_network, open_network, random_network
from colonysim.push.paths import Obstacles
from colonysim.push.scripted import PushSettings, scripted_push
from colonysim.push.task import Log, Manoeuvre, PushTask, ignore

__all__ = [
    "CHOOSERS", "EXECUTORS", "ChooserName", "Executor", "ExecutorName", "Rl", "Scripted", "Staged", "make_executor",
]  # fmt: skip

ExecutorName = Literal["rl", "staged", "scripted"]
ChooserName = Literal["network", "random-weights", "push-in"]
EXECUTORS: tuple[ExecutorName, ...] = ("rl", "staged", "scripted")
CHOOSERS: tuple[ChooserName, ...] = ("network", "random-weights", "push-in")


class Executor(Protocol):
    """Makes the manoeuvre that pushes a box.

    It keeps nothing between two pushes: the same scene, push and seed give the same manoeuvre.
    """

    def __call__(
        self, scene: Scene, robot: int, task: PushTask, obstacles: Obstacles, log: Log = ignore, seed: int = 0
    ) -> Manoeuvre:
        """The manoeuvre of one push; it has done nothing yet.

        A manoeuvre drives its own robot by the wheel speeds that it yields, each for one control tick, and touches
        nothing else: it reads poses from the scene, and neither ticks it nor moves anything in it. It ends within its
        own limit, with a `ManoeuvreResult` that says whether the box is where it was to go.

        Args:
            scene: The scene.
            robot: Index of the robot.
            task: The push.
            obstacles: What to stay away from, besides the box itself (the network looks at nothing but the box).
            log: Told about every control, who chose it ("script" or "network"), and for how many ticks it held.
            seed: All that is drawn comes from it.
        """
        ...


class Scripted:
    """No learning: a script drives behind the box and pushes.

    Args:
        tries: Pushes begun before it gives up.
        limit: Simulated seconds of a push.
    """

    def __init__(self, *, tries: int = 8, limit: float = 180.0) -> None:
        self._settings = PushSettings(tries=tries, limit=limit)

    def __call__(
        self, scene: Scene, robot: int, task: PushTask, obstacles: Obstacles, log: Log = ignore, seed: int = 0
    ) -> Manoeuvre:
        """See `Executor`."""
        del seed  # nothing is drawn
        return scripted_push(scene, robot, task, obstacles, log, self._settings)


class Staged:
    """A script drives behind the box; from there a network chooses every control.

    Args:
        model: As for `make_executor`, as all others.
        chooser: The same.
        testing: The same.
        ticks: The same.
        tries: The same.
        limit: The same.

    Raises:
        ModelError: The model is missing or damaged.
    """

    def __init__(
        self, *, model: str | Path | None = None, chooser: ChooserName = "network", testing: Testing = "greedy",
        ticks: int | None = None, tries: int = 8, limit: float = 180.0,
    ) -> None:  # fmt: skip
        self._fresh, held = _choices(chooser, "push" if model is None else model, testing)
        self._settings = StagedSettings(Rules(ticks=held if ticks is None else ticks), tries=tries, limit=limit)

    def __call__(
        self, scene: Scene, robot: int, task: PushTask, obstacles: Obstacles, log: Log = ignore, seed: int = 0
    ) -> Manoeuvre:
        """See `Executor`."""
        return staged_push(scene, robot, task, obstacles, log, choose=self._fresh(seed), settings=self._settings)


class Rl(Staged):
    """The paper's: a network from wherever the robot is, or the feasibility classifier expects it to succeed.

    Args:
        gate: As for `make_executor`, as all others.
        model: The same.
        chooser: The same.
        testing: The same.
        ticks: The same.
        tries: The same.
        limit: The same.

    Raises:
        ModelError: The model is missing or damaged.
    """

    def __init__(
        self, *, gate: Gate | None = None, model: str | Path | None = None, chooser: ChooserName = "network",
        testing: Testing = "greedy", ticks: int | None = None, tries: int = 8, limit: float = 180.0,
    ) -> None:  # fmt: skip
        super().__init__(model=model, chooser=chooser, testing=testing, ticks=ticks, tries=tries, limit=limit)
        self._gate = gate

    def __call__(
        self, scene: Scene, robot: int, task: PushTask, obstacles: Obstacles, log: Log = ignore, seed: int = 0
    ) -> Manoeuvre:
        """See `Executor`."""
        choose, settings = self._fresh(seed), self._settings
        if self._gate is None:
            return rl_push(scene, robot, task, log, choose=choose, ticks=settings.rules.ticks)
        return gated_push(scene, robot, task, obstacles, log, choose=choose, gate=self._gate, settings=settings)


def make_executor(
    name: ExecutorName,
    *,
    model: str | Path | None = None,
    chooser: ChooserName = "network",
    testing: Testing = "greedy",
    ticks: int | None = None,
    tries: int = 8,
    limit: float = 180.0,
    gate: Gate | None = None,
) -> Executor:
    """An executor by name.

    Args:
        name: `"rl"`: the paper's, the network from wherever the robot is, or, with a gate, from wherever the
            classifier expects it to succeed. `"staged"`: a script drives to a coarse pose, then the network.
            `"scripted"`: no learning.
        model: The network, see `open_network`; None is the shipped one.
        chooser: Puts untrained weights, or the constant control Push In, in the network's place.
        testing: How the network's values become choices.
        ticks: T, control ticks of one action; None: what the network was trained with.
        tries: Failed pushes (`staged`, `rl` with a gate) or pushes begun (`scripted`) before it gives up; without a
            gate `rl` has one.
        limit: Simulated seconds of a push (not of `rl` without a gate, which has the paper's step limit).
        gate: Feasibility classifier that says where `rl` begins a push, or refuses it.

    Raises:
        ModelError: The model is missing or damaged.
        ColonysimError: Something is given that this executor would not look at: a gate, or what is the network's.
        ValueError: An unknown name.
    """
    if name not in EXECUTORS:
        raise ValueError(f"no executor {name!r}; there are {', '.join(EXECUTORS)}")
    if gate is not None and name != "rl":
        raise ColonysimError(f"the executor {name!r} asks no gate; only 'rl' does")
    if name == "scripted":
        if model is not None or ticks is not None or (chooser, testing) != ("network", "greedy"):
            raise ColonysimError("the executor 'scripted' has no network; leave out model, chooser, testing and ticks")
        return Scripted(tries=tries, limit=limit)
    if name == "staged":
        return Staged(model=model, chooser=chooser, testing=testing, ticks=ticks, tries=tries, limit=limit)
    return Rl(gate=gate, model=model, chooser=chooser, testing=testing, ticks=ticks, tries=tries, limit=limit)


def _choices(chooser: ChooserName, source: str | Path, testing: Testing) -> tuple[Callable[[int], Choose], int]:
    """A maker of choosers, one for each push, from a seed; and T of the network's training."""
    network, ticks = open_network(source)
    if chooser == "push-in":
        return lambda _: constant(Control.PUSH_IN), ticks
    if chooser == "network":
        return lambda seed: network_chooser(network, np.random.default_rng(seed), testing), ticks
    if chooser != "random-weights":
        raise ValueError(f"no chooser {chooser!r}; there are {', '.join(CHOOSERS)}")
    trained = load_network(source)
    hidden = [len(biases) for _, biases in trained.layers[:-1]]

    def untrained(seed: int) -> Choose:
        # New weights for every push: one unlucky or lucky draw would say nothing.
        rng = np.random.default_rng(seed)
        return network_chooser(random_network(trained.inputs, hidden, rng), rng, testing)

    return untrained, ticks
