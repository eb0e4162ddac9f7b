"""What an episode costs beyond its physics: episode against bare replays of the same motor commands.

    python benchmarks/bullet_speed.py hard:r20-4 hard:r5-6 --push staged --repeats 5 --seed 100

An episode is run once with a recording scene. Then three things are timed in turn, again and again, because
other work on the machine slows all three alike: the episode; the same wheel speeds, tick by tick, through the
same scene (`Scene.drive` and `Scene.tick`); and the same forces, step by step, through the engine alone.
Both replays have to end with all bodies where the episode ended, bit for bit.
"""

import argparse
import contextlib
import io
import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any
from unittest import mock

import colonysim.backends.bullet as backend
from colonysim.physics import BoxSpec, RobotSpec, Scene, Terrain
from colonysim.physics.bullet import BulletEngine
from colonysim.simulation import simulate
from colonysim.world.loading import load_scenario
from colonysim.world.scenario import Scenario

ITERATIONS, STEP = 50, 1 / 120

Command = tuple[str, tuple[Any, ...]]


@dataclass(slots=True)
class Tape:
    """One episode as what was asked of the scene, and of the engine."""

    terrain: Terrain
    boxes: Sequence[BoxSpec]
    robots: Sequence[RobotSpec]
    scene: list[Command] = field(default_factory=list)
    engine: list[Command] = field(default_factory=list)
    end: list[object] = field(default_factory=list)
    ticks: int = 0


class RecordingEngine(BulletEngine):
    """Keeps what changes the world."""

    tape: list[Command]

    def push(self, body: int, force: Any, at: Any, torque: Any) -> None:
        self.tape.append(("push", (body, force, at, torque)))
        super().push(body, force, at, torque)

    def wake(self, body: int) -> None:
        self.tape.append(("wake", (body,)))
        super().wake(body)

    def remove(self, body: int) -> None:
        self.tape.append(("remove", (body,)))
        super().remove(body)

    def step(self) -> None:
        self.tape.append(("step", ()))
        super().step()


class RecordingScene(Scene):
    """Keeps what is asked of it; a copy of the tape outlives it."""

    tapes: list[Tape] = []

    def __init__(
        self, terrain: Terrain, boxes: Sequence[BoxSpec], robots: Sequence[RobotSpec], *, gui: bool = False
    ) -> None:
        self.tape = Tape(terrain, boxes, robots)
        self.tapes.append(self.tape)
        engine = RecordingEngine(dt=STEP, iterations=ITERATIONS)
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


def run_episode(scenario: Scenario, push: str, seed: int) -> None:
    for _ in simulate(scenario, backend="bullet", episodes=1, seed=seed, backend_options={"push": push}):
        pass


def record(scenario: Scenario, push: str, seed: int) -> Tape:
    """Runs the episode once and keeps its commands."""
    RecordingScene.tapes.clear()
    with mock.patch.object(backend, "Scene", RecordingScene):
        run_episode(scenario, push, seed)
    return RecordingScene.tapes.pop()


def replay_scene(tape: Tape) -> Scene:
    """The same wheel speeds through the scene, traction included."""
    scene = Scene(tape.terrain, tape.boxes, tape.robots)
    calls: dict[str, Callable[..., None]] = {
        "drive": scene.drive, "tick": scene.tick, "remove_robot": scene.remove_robot,
    }  # fmt: skip
    for name, arguments in tape.scene:
        calls[name](*arguments)
    return scene


def replay_engine(tape: Tape) -> Scene:
    """The same forces through the engine alone, nothing computed."""
    engine = BulletEngine(dt=STEP, iterations=ITERATIONS)
    scene = Scene(tape.terrain, tape.boxes, tape.robots, engine=engine)
    calls: dict[str, Callable[..., None]] = {
        "push": engine.push, "wake": engine.wake, "remove": engine.remove, "step": engine.step,
    }  # fmt: skip
    for name, arguments in tape.engine:
        calls[name](*arguments)
    return scene


def clock(what: Callable[[], object]) -> tuple[float, float, object]:
    """Wall and CPU seconds, and what came of it."""
    wall, cpu = time.perf_counter(), time.process_time()
    made = what()
    return time.perf_counter() - wall, time.process_time() - cpu, made


def check(tape: Tape, scene: Scene, removed: bool) -> None:
    """A replay that went elsewhere compares nothing."""
    boxes = [scene.box(i) for i in range(len(scene.boxes))]
    if boxes != tape.end[len(tape.end) - len(boxes) :] or (removed and poses(scene) != tape.end):
        raise SystemExit("the replay did not end where the episode ended")
    scene.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("maps", nargs="*", default=["hard:r20-4", "hard:r5-6"], help="scenario:variant")
    parser.add_argument("--push", default="staged")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--seed", type=int, default=100)
    options = parser.parse_args()
    for name in options.maps:
        map_name, _, variant = name.partition(":")
        scenario = load_scenario(map_name, variant or None)
        with contextlib.redirect_stdout(io.StringIO()):
            tape = record(scenario, options.push, options.seed)
        times: list[tuple[float, ...]] = []
        for _ in range(options.repeats):
            wall, cpu, _ = clock(lambda: run_episode(scenario, options.push, options.seed))
            scene_wall, scene_cpu, scene = clock(lambda: replay_scene(tape))
            check(tape, scene, True)  # type: ignore[arg-type]
            engine_wall, engine_cpu, scene = clock(lambda: replay_engine(tape))
            check(tape, scene, False)  # type: ignore[arg-type]
            times.append((wall, scene_wall, engine_wall, cpu, scene_cpu, engine_cpu))
        simulated = tape.ticks / 60
        wall, scene_wall, engine_wall, cpu, scene_cpu, engine_cpu = map(statistics.median, zip(*times, strict=True))
        by_scene = statistics.median(t[0] / t[1] for t in times), statistics.median(t[3] / t[4] for t in times)
        by_engine = statistics.median(t[0] / t[2] for t in times), statistics.median(t[3] / t[5] for t in times)
        print(
            f"{name}, {options.push}, seed {options.seed}, {simulated:.0f} s simulated, medians of {len(times)}:\n"
            f"  wall s: episode {wall:.1f}, wheel speeds replayed {scene_wall:.1f}, forces replayed {engine_wall:.1f}\n"
            f"  CPU s:  episode {cpu:.1f}, wheel speeds replayed {scene_cpu:.1f}, forces replayed {engine_cpu:.1f}\n"
            f"  episode / wheel speeds: wall {by_scene[0]:.2f}, CPU {by_scene[1]:.2f}; "
            f"episode / forces: wall {by_engine[0]:.2f}, CPU {by_engine[1]:.2f}\n"
            f"  {simulated / wall:.0f} simulated seconds a wall second, {simulated / cpu:.0f} a CPU second",
            flush=True,
        )


if __name__ == "__main__":
    main()
