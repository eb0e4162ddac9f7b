"""Physics steps a second on both engines, by turns in one process: through the scene, and of the engine alone.

    python benchmarks/engine_speed.py --robots 4 12 --rounds 9

Robots drive in circles, every third one pushes a box ahead of it. "Alone" is the same world stepped without traction.
Figures are medians over rounds, of CPU time; ratios are of figures of the same round.
"""

import argparse
import statistics
import time

from colonysim.physics import ENGINES, BoxSpec, Ground, RobotSpec, Scene, Terrain, engine_trouble, wheel_speeds
from colonysim.physics.engine import STEP_SECONDS, make_engine

TICKS = 240
"""Four simulated seconds."""


def place(robots: int) -> tuple[Terrain, list[BoxSpec], list[RobotSpec]]:
    """A lane for each robot, six metres from the next."""
    ground = Ground(-10.0, -10.0, 20.0, 6.0 * robots + 10.0, 0.0)
    specs = [RobotSpec(0.0, 6.0 * i, 0.0, 0.0) for i in range(robots)]
    boxes = [BoxSpec(1.0, 6.0 * i, 0.0, 0.0) for i in range(0, robots, 3)]
    return Terrain((ground,)), [*boxes, BoxSpec(10.0, 0.0, 0.0, 0.3)], specs


def through_scene(engine: str, robots: int) -> float:
    """Steps a CPU second with traction."""
    with Scene(*place(robots), engine=engine) as scene:
        for i in range(robots):
            scene.drive(i, *wheel_speeds(0.36, 0.0 if i % 3 == 0 else 0.4))
        scene.tick()
        began = time.process_time()
        for _ in range(TICKS):
            scene.tick()
            for i in range(robots):
                scene.course(i)
        return 2 * TICKS / (time.process_time() - began)


def alone(engine: str, robots: int) -> float:
    """Steps a CPU second of the same bodies without traction."""
    made = make_engine(engine)
    with Scene(*place(robots), engine=made) as scene:
        for i in range(robots):
            scene.drive(i, *wheel_speeds(0.36, 0.0))
        scene.tick()
        began = time.process_time()
        for _ in range(2 * TICKS):
            made.step()
        return 2 * TICKS / (time.process_time() - began)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", type=int, nargs="+", default=[4, 12])
    parser.add_argument("--rounds", type=int, default=9)
    given = parser.parse_args()
    engines = [name for name in ENGINES if not engine_trouble(name)]
    print(f"steps of 1/{1 / STEP_SECONDS:.0f} s a CPU second, medians of {given.rounds} rounds")
    for robots in given.robots:
        rounds = [
            {(name, how): measure(name, robots) for name in engines for how, measure in MEASURES.items()}
            for _ in range(given.rounds)
        ]
        for how in MEASURES:
            rates = {name: statistics.median(each[name, how] for each in rounds) for name in engines}
            line = ", ".join(f"{name} {rate:,.0f}" for name, rate in rates.items())
            if len(engines) == 2:
                one, other = engines
                ratios = sorted(each[other, how] / each[one, how] for each in rounds)
                line += f"; {other} / {one} {statistics.median(ratios):.2f} ({ratios[0]:.2f} to {ratios[-1]:.2f})"
            print(f"{robots} robots, {how}: {line}", flush=True)


MEASURES = {"through the scene": through_scene, "engine alone": alone}


if __name__ == "__main__":
    main()
