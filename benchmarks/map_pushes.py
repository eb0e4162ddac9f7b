"""The pushes that the paper's maps need, with rigid bodies, one robot at a time.

Each trial draws the box's place (up to 3 cm off) and yaw (up to .05 rad), the robot's place (up to 8 cm off)
and heading (any) from its own seed.

    python benchmarks/map_pushes.py --trials 12 --seed 0
"""

import argparse
import math
import random
import time
from collections.abc import Sequence

from colonysim.physics import BoxSpec, Ground, Pit, Ramp, RobotSpec, Scene, Terrain
from colonysim.push import (
    ManoeuvreResult,
    PushSettings,
    PushTask,
    everything_else,
    plan_push,
    run_alone,
    scripted_push,
)
from colonysim.push.task import Kind

XY_SCALE, Z_SCALE = 1.6, 0.696
TOP, LOW = 5.04 * Z_SCALE, 4.54 * Z_SCALE
"""Heights of the upper ground and of the low ground at the foot of the ramp, metres."""
BORDER = 1.75
"""The ground reaches this far beyond the outermost nodes, metres."""

# Nodes in graph units; the numbers are those of the medium and hard maps, e13 and so on those of easy.
NODES = {
    "2": (2.02, 0.91), "3": (3.72, 0.96), "4": (5.19, 1.09), "12": (7.85, 9.71), "13": (2.39, 6.46),
    "17": (0.74, 9.58), "18": (2.33, 8.06), "20": (7.85, 8.05), "24": (4.17, 9.51), "25": (5.87, 9.71),
    "26": (2.26, 9.64), "29": (2.44, 5.21), "30": (-0.81, 9.52), "31": (-2.31, 9.46), "e13": (2.39, 6.46),
    "e14": (2.67, 7.94), "e30": (2.44, 5.21), "e3": (3.72, 0.96), "e4": (5.19, 1.09), "e2": (2.02, 0.91),
}  # fmt: skip
FILLED_FROM = {"4": "3", "20": "12", "29": "13", "e4": "e3", "e30": "e13"}
LOW_NODES = ("30", "31")
ROUTES = {
    "easy 3-4": ("e2", "e3", "e4"),
    "easy 13-30": ("e14", "e13", "e30"),
    "medium 3-4": ("2", "3", "4"),
    "medium 18-13-29": ("26", "18", "13", "29"),
    "medium 25-12-20": ("24", "25", "12", "20"),
    "hard 30-17-26-18-13-29": ("31", "30", "17", "26", "18", "13", "29"),
}
"""Where the robot begins, then the box's way."""


def at(node: str) -> tuple[float, float]:
    """A node's place in metres."""
    x, y = NODES[node]
    return XY_SCALE * x, XY_SCALE * y


def build_terrain(name: str) -> tuple[Terrain, dict[str, int]]:
    """The ground of one map and the index of each of its pits."""
    easy, hard = name.startswith("easy"), name.startswith("hard")
    holes = [h for h in FILLED_FROM if h.startswith("e") == easy]
    pits = []
    for hole in holes:
        (x, y), (fx, fy) = at(hole), at(FILLED_FROM[hole])
        depth = 0.5 if hard and hole == "29" else 0.25
        pits.append(Pit(x, y, math.atan2(y - fy, x - fx), rim=TOP, depth=depth))
    west, south = 0.64 * XY_SCALE - BORDER, 0.91 * XY_SCALE - BORDER
    east, north = 7.94 * XY_SCALE + BORDER, 9.71 * XY_SCALE + BORDER
    if not hard:
        return Terrain((Ground(west, south, east, north, TOP),), tuple(pits)), {h: i for i, h in enumerate(holes)}
    (x0, y0), (x1, y1) = at("30"), at("17")
    ramp = Ramp(x0, y0, LOW, x1, y1, TOP)
    # The crease is not square to the ground's border: the ramp's landings cover the wedge between the two.
    wedge = abs(math.sin(ramp.yaw)) * ramp.half_width
    side = min(y0, y1) - ramp.half_width
    top = max(north, y1 + ramp.half_width)
    grounds = (
        Ground(west, south, east, side, TOP),
        Ground(x1 + wedge, side, east, top, TOP),
        Ground(at("31")[0] - BORDER, side, x0 - wedge, top, LOW),
    )
    return Terrain(grounds, tuple(pits), (ramp,)), {h: i for i, h in enumerate(holes)}


def run_trial(
    name: str, seed: int, settings: PushSettings, margins: list[float]
) -> tuple[ManoeuvreResult, list[float]]:
    """One way of a box; the last push's result and the seconds of each push."""
    draw = random.Random(f"{name}/{seed}")

    def off(most: float) -> float:
        return draw.uniform(-most, most)

    def height(node: str) -> float:
        return LOW if node in LOW_NODES else TOP

    terrain, holes = build_terrain(name)
    behind, first, *way = ROUTES[name]
    (x, y), (nx, ny), (rx, ry) = at(first), at(way[0]), at(behind)
    box = BoxSpec(x + off(0.03), y + off(0.03), height(first), math.atan2(ny - y, nx - x) + off(0.05))
    robot = RobotSpec(rx + off(0.08), ry + off(0.08), height(behind), off(math.pi))
    seconds: list[float] = []
    with Scene(terrain, [box], [robot]) as scene:
        around = everything_else(scene, 0)
        for here, there in zip((first, *way), way, strict=False):
            kind: Kind = "hole" if there in holes else "slope" if here == "30" else "flat"
            task = PushTask(0, at(here), at(there), kind, height(there), holes.get(there))
            margins.append(plan_push(scene, 0, task, around()).margin)
            result = run_alone(scene, 0, scripted_push(scene, 0, task, around, settings=settings))
            seconds.append(result.seconds)
            if not result.success:
                break
    return result, seconds


def mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--trials", type=int, default=12)
    parser.add_argument("--seed", type=int, default=0, help="seed of the first trial; the others follow")
    parser.add_argument("--speed", type=float, default=PushSettings().speed)
    parser.add_argument("--route", choices=ROUTES, action="append")
    options = parser.parse_args()
    settings = PushSettings(speed=options.speed)
    print(f"seeds {options.seed}-{options.seed + options.trials - 1}, pushing at {options.speed} m/s")
    for name in options.route or ROUTES:
        begun, good, done, margins = time.perf_counter(), 0, [], list[float]()
        for seed in range(options.seed, options.seed + options.trials):
            result, seconds = run_trial(name, seed, settings, margins)
            good += result.success
            if result.success:
                done.append(seconds)
            else:
                print(f"  seed {seed}: push {len(seconds)} failed: {result}")
        parts = " + ".join(f"{mean(part):.1f}" for part in zip(*done, strict=True))
        print(
            f"{name}: {good}/{options.trials}, {parts} s, least margin {min(margins):.2f} m, "
            f"{time.perf_counter() - begun:.1f} s wall",
            flush=True,
        )


if __name__ == "__main__":
    main()
