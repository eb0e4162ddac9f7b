"""What an episode costs beyond its physics: episode against bare replays of the same motor commands.

    python benchmarks/physics_speed.py hard:r20-4 hard:r5-6 --engine mujoco --push staged --repeats 5 --seed 100

An episode is run once with a recording scene. Then three things are timed in turn, again and again, because
other work on the machine slows all three alike: the episode; the same wheel speeds, tick by tick, through the
same scene (`Scene.drive` and `Scene.tick`); and the same forces, step by step, through the engine alone.
Both replays have to end with all bodies where the episode ended, bit for bit.

Last, the episode and the replay of its wheel speeds take turns in one process, a few simulated seconds each: both
meet the same moments of a busy machine, so that their ratio is far steadier than that of whole runs.
"""

import argparse
import gc
import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any
from unittest import mock

import colonysim.backends.physics as backend
from colonysim.physics import ENGINES, BoxSpec, Engine, RobotSpec, Scene, Terrain, make_engine
from colonysim.physics.engine import STEP_SECONDS
from colonysim.scenario.loading import load_scenario
from colonysim.scenario.scenario import Scenario
from colonysim.simulation import simulate

SLICE = 90
"""Ticks that the episode and its replay advance by in turn."""

Command = tuple[str, tuple[Any, ...]]


@dataclass(slots=True)
class Tape:
    """One episode as what was asked of the scene, and of the engine."""

    terrain: Terrain
    boxes: Sequence[BoxSpec]
    robots: Sequence[RobotSpec]
    engine_name: str
    scene: list[Command] = field(default_factory=list)
    engine: list[Command] = field(default_factory=list)
    end: list[object] = field(default_factory=list)
    ticks: int = 0


class Recording:
    """Put before an engine's class: keeps what changes the world."""

    tape: list[Command]

    def push(self, body: int, force: Any, at: Any, torque: Any) -> None:
        self.tape.append(("push", (body, force, at, torque)))
        super().push(body, force, at, torque)  # type: ignore[misc]

    def wake(self, body: int) -> None:
        self.tape.append(("wake", (body,)))
        super().wake(body)  # type: ignore[misc]

    def remove(self, body: int) -> None:
        self.tape.append(("remove", (body,)))
        super().remove(body)  # type: ignore[misc]

    def step(self) -> None:
        self.tape.append(("step", ()))
        super().step()  # type: ignore[misc]


def engine_with(what: type, name: str) -> Any:
    """An engine whose class has something put before it."""
    plain = make_engine(name)
    plain.close()
    return type(what.__name__, (what, type(plain)), {})(dt=STEP_SECONDS)


class RecordingScene(Scene):
    """Keeps what is asked of it on a tape."""

    def __init__(
        self, tape: list[Tape], terrain: Terrain, boxes: Sequence[BoxSpec], robots: Sequence[RobotSpec], engine: Any
    ) -> None:
        self.tape = Tape(terrain, boxes, robots, engine)
        tape.append(self.tape)
        engine = engine_with(Recording, engine)
        engine.tape = self.tape.engine
        super().__init__(terrain, boxes, robots, engine=engine)

    def drive(self, robot: int, left: float, right: float) -> None:
        self.tape.scene.append(("drive", (robot, left, right)))
        super().drive(robot, left, right)

    def tick(self) -> None:
        self.tape.scene.append(("tick", ()))
        super().tick()
        self.tape.ticks += 1

    def remove_robot(self, i: int) -> None:
        self.tape.scene.append(("remove_robot", (i,)))
        super().remove_robot(i)

    def close(self) -> None:
        if not self.tape.end:
            self.tape.end = poses(self)
        super().close()


def poses(scene: Scene) -> list[object]:
    """Where everything is."""
    robots = [scene.robot(i) for i in range(scene.robot_count) if scene.has_robot(i)]
    return [*robots, *(scene.box(i) for i in range(len(scene.boxes)))]


def run_episode(scenario: Scenario, engine: str, push: str, seed: int) -> None:
    for _ in simulate(scenario, backend=engine, episodes=1, seed=seed, backend_options={"push": push}):
        pass


def record(scenario: Scenario, engine: str, push: str, seed: int) -> Tape:
    """Runs the episode once and keeps its commands."""
    tapes: list[Tape] = []

    def recording(
        terrain: Terrain, boxes: Sequence[BoxSpec], robots: Sequence[RobotSpec], **_: object
    ) -> Scene:
        return RecordingScene(tapes, terrain, boxes, robots, engine)

    with mock.patch.object(backend, "Scene", recording):
        run_episode(scenario, engine, push, seed)
    return tapes[0]


def calls_of(scene: Scene) -> dict[str, Callable[..., None]]:
    """What a tape may ask of a scene."""
    return {"drive": scene.drive, "tick": scene.tick, "remove_robot": scene.remove_robot}


def replay_scene(tape: Tape) -> Scene:
    """The same wheel speeds through the scene, traction included."""
    scene = Scene(tape.terrain, tape.boxes, tape.robots, engine=tape.engine_name)
    calls = calls_of(scene)
    for name, arguments in tape.scene:
        calls[name](*arguments)
    return scene


def replay_engine(tape: Tape) -> Scene:
    """The same forces through the engine alone, nothing computed."""
    engine: Engine = make_engine(tape.engine_name)
    scene = Scene(tape.terrain, tape.boxes, tape.robots, engine=engine)
    calls: dict[str, Callable[..., None]] = {
        "push": engine.push, "wake": engine.wake, "remove": engine.remove, "step": engine.step,
    }  # fmt: skip
    for name, arguments in tape.engine:
        calls[name](*arguments)
    return scene


class Paced:
    """Put before an engine's class: calls somebody after every slice."""

    steps = 0
    after_slice: Callable[[], None] | None = None

    def step(self) -> None:
        super().step()  # type: ignore[misc]
        self.steps += 1
        if self.steps % (2 * SLICE) == 0 and self.after_slice is not None:
            self.after_slice()


def replay_slices(tape: Tape) -> Iterator[None]:
    """The same wheel speeds through the scene, pausing after every slice."""
    scene = Scene(tape.terrain, tape.boxes, tape.robots, engine=engine_with(Paced, tape.engine_name))
    calls, ticks = calls_of(scene), 0
    for name, arguments in tape.scene:
        calls[name](*arguments)
        if name == "tick":
            ticks += 1
            if ticks % SLICE == 0:
                yield
    scene.close()


def in_turn(tape: Tape, scenario: Scenario, push: str, seed: int) -> list[tuple[float, float]]:
    """CPU seconds of each slice of the episode, and of its replay, run in turn."""
    pairs: list[tuple[float, float]] = []
    replay = replay_slices(tape)
    began = time.process_time()

    def change_over() -> None:
        nonlocal began
        paused = time.process_time()
        next(replay, None)
        resumed = time.process_time()
        pairs.append((paused - began, resumed - paused))
        began = resumed

    def paced(terrain: Terrain, boxes: Sequence[BoxSpec], robots: Sequence[RobotSpec], **_: object) -> Scene:
        engine = engine_with(Paced, tape.engine_name)
        engine.after_slice = change_over
        return Scene(terrain, boxes, robots, engine=engine)

    with mock.patch.object(backend, "Scene", paced):
        run_episode(scenario, tape.engine_name, push, seed)
    change_over()
    return pairs


def clock(what: Callable[[], object]) -> tuple[float, float]:
    """Wall and CPU seconds."""
    wall, cpu = time.perf_counter(), time.process_time()
    what()
    return time.perf_counter() - wall, time.process_time() - cpu


def check(tape: Tape) -> None:
    """A replay that went elsewhere would compare nothing."""
    for replay, robots in ((replay_scene, True), (replay_engine, False)):
        scene = replay(tape)
        boxes = [scene.box(i) for i in range(len(scene.boxes))]
        if boxes != tape.end[len(tape.end) - len(boxes) :] or (robots and poses(scene) != tape.end):
            raise SystemExit(f"{replay.__name__} did not end where the episode ended")
        scene.close()


def measure(name: str, engine: str, push: str, seed: int, repeats: int) -> None:
    """Times one map and prints what came out."""
    map_name, _, variant = name.partition(":")
    scenario = load_scenario(map_name, variant or None)
    tape = record(scenario, engine, push, seed)
    check(tape)
    # The tape is far larger than anything an episode keeps: the collector shall not walk through it.
    gc.collect()
    gc.freeze()
    times = [
        (
            *clock(lambda: run_episode(scenario, engine, push, seed)),
            *clock(lambda: replay_scene(tape).close()),
            *clock(lambda: replay_engine(tape).close()),
        )
        for _ in range(repeats)
    ]
    turns = [in_turn(tape, scenario, push, seed) for _ in range(repeats)]
    simulated = tape.ticks / 60
    wall, cpu, scene_wall, scene_cpu, engine_wall, engine_cpu = map(statistics.median, zip(*times, strict=True))

    # On a busy machine the fastest of many is the least disturbed.
    least = [min(column) for column in zip(*times, strict=True)]

    paired = [sum(episode for episode, _ in pairs) / sum(replay for _, replay in pairs) for pairs in turns]
    slices = [[min(column) for column in zip(*pairs, strict=True)] for pairs in zip(*turns, strict=True)]
    least_paired = sum(episode for episode, _ in slices) / sum(replay for _, replay in slices)

    def ratio(one: int, other: int) -> float:
        return statistics.median(t[one] / t[other] for t in times)

    print(
        f"{name} on {engine}, {push}, seed {seed}, {simulated:.0f} s simulated, medians of {repeats}:\n"
        f"  wall s: episode {wall:.1f}, wheel speeds replayed {scene_wall:.1f}, forces replayed {engine_wall:.1f}\n"
        f"  CPU s:  episode {cpu:.1f}, wheel speeds replayed {scene_cpu:.1f}, forces replayed {engine_cpu:.1f}\n"
        f"  episode / wheel speeds: wall {ratio(0, 2):.2f}, CPU {ratio(1, 3):.2f}; "
        f"episode / forces: wall {ratio(0, 4):.2f}, CPU {ratio(1, 5):.2f}\n"
        f"  least CPU s of each: {least[1]:.2f}, {least[3]:.2f}, {least[5]:.2f}: "
        f"ratios {least[1] / least[3]:.2f}, {least[1] / least[5]:.2f}\n"
        f"  episode / wheel speeds, slice by slice in turn: CPU {statistics.median(paired):.3f} "
        f"({min(paired):.3f} to {max(paired):.3f}), least of each slice {least_paired:.3f}\n"
        f"  {simulated / wall:.0f} simulated seconds a wall second, {simulated / cpu:.0f} a CPU second",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("maps", nargs="*", default=["hard:r20-4", "hard:r5-6"], help="scenario:variant")
    parser.add_argument("--engine", default="bullet", choices=ENGINES)
    parser.add_argument("--push", default="staged")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--seed", type=int, default=100)
    options = parser.parse_args()
    for name in options.maps:
        measure(name, options.engine, options.push, options.seed, options.repeats)


if __name__ == "__main__":
    main()
