"""Two boxes into one pit two boxes deep, then across: how often does it work?

Each trial draws the boxes' places (up to 3 cm off), their yaw (up to .05 rad), the robot's place (up to 8 cm
off), its heading (any) and the direction of the pit (any) from its own seed. The robot pushes the first box in,
is put beside the second and pushes it in, then drives across and back.

    python benchmarks/stacking.py --trials 100 --seed 0
"""

import argparse
import math
import random
import time
from dataclasses import dataclass

from colonysim.intervals import wilson
from colonysim.physics import BoxSpec, Ground, Pit, RobotSpec, Scene, Terrain
from colonysim.push import PushTask, drive_to, everything_else, run_alone, scripted_push

LENGTH, HEIGHT = 1.0, 0.25
EDGE = 2.4
"""From the box's node to the pit, metres."""


@dataclass(frozen=True, slots=True)
class Trial:
    """What happened: reasons are `done` where a part worked."""

    seed: int
    first: str
    second: str
    crossing: str
    seconds: float

    @property
    def success(self) -> bool:
        return self.first == self.second == self.crossing == "done"


def run_trial(seed: int) -> Trial:
    """Stack two boxes and cross them four times, there and back."""
    draw = random.Random(f"stacking/{seed}")

    def off(most: float) -> float:
        return draw.uniform(-most, most)

    yaw = off(math.pi)
    c, s = math.cos(yaw), math.sin(yaw)
    pit = Pit(EDGE * c, EDGE * s, yaw, side=LENGTH + 0.2, depth=2 * HEIGHT)
    terrain = Terrain((Ground(-8, -8, 8, 8, 0.0),), (pit,))
    # The second box waits aside, behind the place where the robot works, and is moved to the node later.
    boxes = [
        BoxSpec(off(0.03), off(0.03), 0.0, yaw + off(0.05), LENGTH, HEIGHT),
        BoxSpec(-5 * c, -5 * s, 0.0, yaw, LENGTH, HEIGHT),
    ]
    robot = RobotSpec(-2 * c + off(0.08), -2 * s + off(0.08), 0.0, off(math.pi))
    with Scene(terrain, boxes, [robot]) as scene:
        around = everything_else(scene, 0)

        def push(box: int) -> str:
            task = PushTask(box, (0.0, 0.0), (pit.x, pit.y), "hole", 0.0, 0)
            return run_alone(scene, 0, scripted_push(scene, 0, task, around)).reason

        second = crossing = "not tried"
        first = push(0)
        if first == "done":
            scene.place_robot(0, -2 * c + off(0.08), -2 * s + off(0.08), 0.0, off(math.pi))
            scene.place_box(1, off(0.03), off(0.03), 0.0, yaw + off(0.05))
            second = push(1)
        if second == "done":
            for place in (EDGE + 1.8, EDGE - 1.8, EDGE + 1.8, EDGE - 1.8):
                crossing = run_alone(scene, 0, drive_to(scene, 0, place * c, place * s, around)).reason
                if crossing != "done":
                    break
        return Trial(seed, first, second, crossing, scene.time)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--trials", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0, help="seed of the first trial; the others follow")
    options = parser.parse_args()
    begun = time.perf_counter()
    trials = [run_trial(options.seed + i) for i in range(options.trials)]
    good = sum(t.success for t in trials)
    low, high = wilson(good, len(trials))
    for t in trials:
        if not t.success:
            print(f"seed {t.seed}: first {t.first}, second {t.second}, crossing {t.crossing}")
    simulated = sum(t.seconds for t in trials)
    wall = time.perf_counter() - begun
    print(f"n {len(trials)}, seeds {options.seed}-{options.seed + len(trials) - 1}")
    print(f"stacked both and crossed four times: {good} ({good / len(trials):.3f}, 95 % {low:.3f}-{high:.3f})")
    print(f"{simulated / len(trials):.1f} simulated seconds a trial, {simulated / wall:.0f} times real time")


if __name__ == "__main__":
    main()
