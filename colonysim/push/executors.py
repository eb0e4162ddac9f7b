"""The three executors of a push behind one interface."""

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
from colonysim.push.network import QNetwork, load_network, network_ticks, random_network
from colonysim.push.paths import Obstacles
from colonysim.push.scripted import PushSettings, scripted_push
from colonysim.push.task import Log, Manoeuvre, PushTask, ignore

__all__ = ["CHOOSERS", "EXECUTORS", "ChooserName", "Executor", "ExecutorName", "make_executor"]

ExecutorName = Literal["rl", "staged", "scripted"]
ChooserName = Literal["network", "random-weights", "push-in"]
EXECUTORS: tuple[ExecutorName, ...] = ("rl", "staged", "scripted")
CHOOSERS: tuple[ChooserName, ...] = ("network", "random-weights", "push-in")


class Executor(Protocol):
    """Makes the manoeuvre that pushes a box."""

    def __call__(
        self, scene: Scene, robot: int, task: PushTask, obstacles: Obstacles, log: Log = ignore, seed: int = 0
    ) -> Manoeuvre:
        """The manoeuvre of one push; it has done nothing yet.

        Args:
            scene: The scene.
            robot: Index of the robot.
            task: The push.
            obstacles: What to stay away from, besides the box itself (the network looks at nothing but the box).
            log: Told about every control and who chose it.
            seed: For the network's rare drawn choices.
        """
        ...


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
        model: The network: name of a shipped one or path of a card; None is the shipped one of the executor.
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
        scripted_settings = PushSettings(tries=tries, limit=limit)

        def scripted(
            scene: Scene, robot: int, task: PushTask, obstacles: Obstacles, log: Log = ignore, seed: int = 0
        ) -> Manoeuvre:
            return scripted_push(scene, robot, task, obstacles, log, scripted_settings)

        return scripted
    source: str | Path = "push" if model is None else model
    fresh = _choices(chooser, source, testing)
    held = network_ticks(source) if ticks is None else ticks
    settings = StagedSettings(Rules(ticks=held), tries=tries, limit=limit)
    if name == "rl":

        def rl(
            scene: Scene, robot: int, task: PushTask, obstacles: Obstacles, log: Log = ignore, seed: int = 0
        ) -> Manoeuvre:
            if gate is None:
                return rl_push(scene, robot, task, log, choose=fresh(seed), ticks=held)
            return gated_push(scene, robot, task, obstacles, log, choose=fresh(seed), gate=gate, settings=settings)

        return rl

    def staged(
        scene: Scene, robot: int, task: PushTask, obstacles: Obstacles, log: Log = ignore, seed: int = 0
    ) -> Manoeuvre:
        return staged_push(scene, robot, task, obstacles, log, choose=fresh(seed), settings=settings)

    return staged


def _choices(chooser: ChooserName, source: str | Path, testing: Testing) -> Callable[[int], Choose]:
    """A maker of choosers, one for each push, from a seed."""
    if chooser == "push-in":
        return lambda _: constant(Control.PUSH_IN)
    trained = load_network(source)
    if chooser == "network":
        return lambda seed: network_chooser(trained, np.random.default_rng(seed), testing)
    if chooser != "random-weights":
        raise ValueError(f"no chooser {chooser!r}; there are {', '.join(CHOOSERS)}")

    hidden = [len(biases) for _, biases in trained.layers[:-1]]

    def untrained(seed: int) -> Choose:
        # New weights for every push: one unlucky or lucky draw would say nothing.
        rng = np.random.default_rng(seed)
        network: QNetwork = random_network(trained.inputs, hidden, rng)
        return network_chooser(network, rng, testing)

    return untrained
