"""Random scenes in which a box is pushed from node to node (its way) through cramped surroundings.

Pushes fail there often enough to learn when they do.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from colonysim.physics import STANDARD, BoxSpec, Ground, Pit, Ramp, RobotSpec, Scene, Terrain
from colonysim.push.paths import FreeSpace, Point, Surroundings
from colonysim.push.task import Kind, PushTask

__all__ = ["CrampedWay", "draw_way"]

_PUSHES = (1, 2, 3, 4)
_TURNS = (0.0, 0.0, 0.0, math.pi / 4, -math.pi / 4, math.pi / 2, -math.pi / 2, math.pi / 2, -math.pi / 2)
_LENGTH = (1.9, 2.8)
_MARGIN = (1.2, 2.6)
_HEIGHT = 0.25
_APART = 1.45
"""Least distance of two boxes' centres, and of a box from a pit's: their corners do not meet, metres."""
_DRAWS = 60


@dataclass(frozen=True, slots=True)
class CrampedWay:
    """A scene and the pushes of one box in it, from node to node.

    Attributes:
        terrain: Ground that ends near the way, pits, perhaps a ramp.
        boxes: The box of the way first; then one that half fills the way's pit, if any does, and others.
        robot: Where the robot begins.
        tasks: The pushes.
    """

    terrain: Terrain
    boxes: tuple[BoxSpec, ...]
    robot: RobotSpec
    tasks: tuple[PushTask, ...]

    def scene(self, engine: str | None = None) -> Scene:
        """A fresh scene."""
        return Scene(self.terrain, self.boxes, [self.robot], engine=engine)


def draw_way(rng: np.random.Generator) -> CrampedWay:
    """A way of one to four pushes, and its surroundings; drawn again until it can be built.

    Half of the ways end in a pit, one or two boxes deep and then half filled or not. One in four begins on a ramp,
    up or down, with steps or cliffs at its sides. Up to four boxes and two pits stand about, half of them a node's
    distance from the way.

    Args:
        rng: Source of randomness, advanced.
    """
    while True:
        drawn = _draw(rng)
        if drawn is not None:
            return drawn


def _draw(rng: np.random.Generator) -> CrampedWay | None:
    ramped = bool(rng.random() < 0.25)
    places, headings = _places(rng, ramped)
    ends_in_pit = bool(rng.random() < 0.5) and not (ramped and len(places) < 3)
    kinds: list[Kind] = ["slope" if ramped and i == 0 else "flat" for i in range(len(headings))]
    if ends_in_pit:
        kinds[-1] = "hole"
    grounds, ramps, heights = _ground(rng, places, ramped)
    deep = 1 if rng.random() < 0.5 else 2
    pits, taken = [], list(places)
    if ends_in_pit:
        pits.append(Pit(*places[-1], headings[-1], rim=heights[-1], depth=deep * _HEIGHT))
    for _ in range(int(rng.integers(0, 3))):
        x, y = _place(rng, places, grounds)
        level = _level(grounds, ramps, x, y)
        if level is not None and _clear(x, y, taken, _APART):
            pits.append(Pit(x, y, headings[0], rim=level, depth=_HEIGHT))
            taken.append((x, y))
    try:
        terrain = Terrain(tuple(grounds), tuple(pits), tuple(ramps))
    except ValueError:
        return None
    askew = float(rng.uniform(-math.pi, math.pi)) if rng.random() < 0.15 else float(rng.uniform(-0.1, 0.1))
    boxes = [BoxSpec(*places[0], heights[0], headings[0] + askew)]
    if ends_in_pit and deep == 2 and rng.random() < 0.5:
        boxes.append(BoxSpec(*places[-1], heights[-1] - 2 * _HEIGHT, headings[-1]))
    for _ in range(int(rng.integers(0, 5))):
        x, y = _place(rng, places, grounds)
        level = _level(grounds, ramps, x, y)
        if level is not None and _clear(x, y, [places[0], *taken[len(places) :]], _APART):
            boxes.append(BoxSpec(x, y, level, headings[0]))
            taken.append((x, y))
    tasks = tuple(
        PushTask(0, places[i], places[i + 1], kind, heights[i + 1], 0 if kind == "hole" else None)
        for i, kind in enumerate(kinds)
    )
    robot = _robot(rng, terrain, boxes)
    return None if robot is None else CrampedWay(terrain, tuple(boxes), robot, tasks)


def _places(rng: np.random.Generator, ramped: bool) -> tuple[list[Point], list[float]]:
    """Nodes that never come back near an earlier one, and the headings between them."""
    while True:
        heading = float(rng.choice([0.0, math.pi])) if ramped else float(rng.uniform(-math.pi, math.pi))
        places: list[Point] = [(0.0, 0.0)]
        headings: list[float] = []
        for i in range(int(rng.choice(_PUSHES))):
            if i:
                heading += float(rng.choice(_TURNS))
            length = float(rng.uniform(*_LENGTH))
            x, y = places[-1]
            places.append((x + length * math.cos(heading), y + length * math.sin(heading)))
            headings.append(heading)
        if all(math.dist(a, b) > 1.7 for i, a in enumerate(places) for b in places[:i]):
            return places, headings


def _ground(
    rng: np.random.Generator, places: Sequence[Point], ramped: bool
) -> tuple[list[Ground], list[Ramp], list[float]]:
    """The ground round a way, the ramp under its first push, and the heights of its nodes."""
    west, south, east, north = (float(v) for v in rng.uniform(*_MARGIN, size=4))
    a, b = min(x for x, _ in places) - west, min(y for _, y in places) - south
    c, d = max(x for x, _ in places) + east, max(y for _, y in places) + north
    if not ramped:
        return [Ground(a, b, c, d, 0.0)], [], [0.0] * len(places)
    rise, (x1, _) = float(rng.uniform(0.2, 0.4)), places[1]
    up = bool(rng.random() < 0.7)
    half = 2.2
    foot, crest = (0.0, x1) if up else (x1, 0.0)
    ramp = Ramp(foot, 0.0, 0.0, crest, 0.0, rise, half)
    lower, higher = (0.0, rise) if up else (rise, 0.0)
    near = Ground(-2.0, -half, 0.0, half, lower) if x1 > 0 else Ground(0.0, -half, 2.0, half, lower)
    rest = places[1:]
    low, high = min(y for _, y in rest) - south, max(y for _, y in rest) + north
    far_end = max(c, x1 + 0.8) if x1 > 0 else min(a, x1 - 0.8)
    beyond = Ground(min(x1, far_end), low, max(x1, far_end), high, higher)
    grounds = [near, beyond]
    if rng.random() < 0.5:
        # Platforms on the upper level beside the ramp: steps at its sides.
        sides = (min(0.0, x1), max(0.0, x1))
        grounds += [
            Ground(sides[0], half, sides[1], half + 2.0, rise),
            Ground(sides[0], -half - 2.0, sides[1], -half, rise),
        ]
    return grounds, [ramp], [lower, *[higher] * (len(places) - 1)]


def _place(rng: np.random.Generator, places: Sequence[Point], grounds: Sequence[Ground]) -> Point:
    """Somewhere on the ground, or a node's distance from the way."""
    if rng.random() < 0.5:
        x, y = places[int(rng.integers(len(places)))]
        angle, far = float(rng.uniform(-math.pi, math.pi)), float(rng.uniform(*_LENGTH))
        return x + far * math.cos(angle), y + far * math.sin(angle)
    ground = grounds[int(rng.integers(len(grounds)))]
    return float(rng.uniform(ground.xmin, ground.xmax)), float(rng.uniform(ground.ymin, ground.ymax))


def _level(grounds: Sequence[Ground], ramps: Sequence[Ramp], x: float, y: float) -> float | None:
    """Height of level ground with room for a box, else None."""
    if any(ramp.height(x + dx, y + dy) is not None for ramp in ramps for dx in (-1, 0, 1) for dy in (-1, 0, 1)):
        return None
    return next((ground.z for ground in grounds if ground.contains(x, y, 0.5)), None)


def _clear(x: float, y: float, taken: Sequence[Point], gap: float) -> bool:
    return all(math.dist((x, y), other) >= gap for other in taken)


def _robot(rng: np.random.Generator, terrain: Terrain, boxes: Sequence[BoxSpec]) -> RobotSpec | None:
    """A robot that has come up to the box from any side."""
    box = boxes[0]
    with Scene(terrain, boxes, []) as scene:
        space = FreeSpace(scene, Surroundings((), scene.standing_boxes(), scene.open_pits()))
        for _ in range(_DRAWS):
            bearing, away = float(rng.uniform(-math.pi, math.pi)), float(rng.uniform(1.3, 1.7))
            x, y = box.x + away * math.cos(bearing), box.y + away * math.sin(bearing)
            if space.slack(x, y) >= 0.0 and away > box.length / 2 + STANDARD.bumper:
                return RobotSpec(x, y, terrain.height(x, y), float(rng.uniform(-math.pi, math.pi)))
    return None
