"""Where single pushes begin: distributions frozen in `starts.json`, drawn with a seed."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from colonysim.physics import (
    STANDARD,
    BoxSpec,
    Ground,
    Pit,
    Ramp,
    RobotSpec,
    Scene,
    Terrain,
)
from colonysim.push.state import PIT_DEPTH
from colonysim.push.task import Kind, PushTask

__all__ = ["KINDS", "Distribution", "Range", "Start", "distribution", "draw", "start_names"]

KINDS: tuple[Kind, ...] = ("flat", "slope", "hole")
Range = tuple[float, float]
_HALF_BOX = 0.5
_EXTENT = 9.0
_LANDING = 4.0
_ROOM = 0.5


@dataclass(frozen=True, slots=True)
class Distribution:
    """One entry of `starts.json`; ranges are uniform, metres and radians.

    Attributes:
        goal: Distance from the start to the goal node, by terrain.
        slope_angle: Rise of the slope.
        slope_margin: Level ground before and after the slope, from the nodes.
        box_offset: The box's distance from the push line, to the left.
        box_yaw: The box's yaw against the push line.
        robot_distance: From the box's centre to the robot.
        robot_bearing: Angle of the robot's place around the box, 0 straight behind it.
        robot_heading: The robot's heading, against the direction to the box.
        clearance: Least gap between the robot's outline and the box.
        deep: Share of the pits that are two boxes deep instead of one.
        pit_yaw: `box_yaw` where the goal is a pit, if not the same.
    """

    goal: Mapping[Kind, Range]
    slope_angle: float
    slope_margin: float
    box_offset: Range
    box_yaw: Range
    robot_distance: Range
    robot_bearing: Range
    robot_heading: Range
    clearance: float
    deep: float = 0.0
    pit_yaw: Range | None = None


@dataclass(frozen=True, slots=True)
class Start:
    """A push about to begin: everything a scene is built from, and the task."""

    terrain: Terrain
    box: BoxSpec
    robot: RobotSpec
    task: PushTask

    def scene(self, engine: str | None = None) -> Scene:
        """A fresh scene; rebuilt for every episode, since only that is reproducible bit for bit on every engine."""
        return Scene(self.terrain, [self.box], [self.robot], engine=engine)


@cache
def _entries() -> dict[str, Any]:
    text = files("colonysim.push.training").joinpath("starts.json").read_text(encoding="utf-8")
    return {k: v for k, v in json.loads(text).items() if k != "about"}


def start_names() -> tuple[str, ...]:
    """Names of the distributions."""
    return tuple(_entries())


def distribution(name: str) -> Distribution:
    """A distribution by its name in `starts.json`.

    Raises:
        ValueError: There is no such distribution.
    """
    if name not in _entries():
        raise ValueError(f"no start distribution {name!r}; there are {', '.join(start_names())}")
    entry = _entries()[name]

    goal = entry["goal"]
    return Distribution(
        goal={kind: _range(goal[kind]) for kind in KINDS},
        slope_angle=float(entry["slope_angle"]),
        slope_margin=float(entry["slope_margin"]),
        box_offset=_range(entry["box_offset"]),
        box_yaw=_range(entry["box_yaw"]),
        robot_distance=_range(entry["robot_distance"]),
        robot_bearing=_range(entry["robot_bearing"]),
        robot_heading=_range(entry["robot_heading"]),
        clearance=float(entry["clearance"]),
        deep=float(entry.get("deep", 0.0)),
        pit_yaw=_range(entry["pit_yaw"]) if "pit_yaw" in entry else None,
    )


def _range(pair: list[float]) -> Range:
    low, high = pair
    return float(low), float(high)


def draw(kind: Kind, starts: Distribution, rng: np.random.Generator) -> Start:
    """Draw the start of one episode; the push line points anywhere in the world.

    Args:
        kind: The terrain.
        starts: The distribution.
        rng: Source of randomness, advanced.
    """
    line = float(rng.uniform(-math.pi, math.pi))
    length = float(rng.uniform(*starts.goal[kind]))
    goal = (length * math.cos(line), length * math.sin(line))
    # Nothing is drawn where nothing varies, so that the frozen distributions stay what they are.
    deep = kind == "hole" and starts.deep > 0.0 and bool(rng.random() < starts.deep)
    terrain, rim = _terrain(kind, starts, line, length, 2 if deep else 1)
    offset = float(rng.uniform(*starts.box_offset))
    yaw = line + float(rng.uniform(*(starts.pit_yaw if kind == "hole" and starts.pit_yaw else starts.box_yaw)))
    box = BoxSpec(-offset * math.sin(line), offset * math.cos(line), 0.0, yaw)
    while True:
        distance = float(rng.uniform(*starts.robot_distance))
        toward = line + float(rng.uniform(*starts.robot_bearing))
        x, y = box.x - distance * math.cos(toward), box.y - distance * math.sin(toward)
        robot = RobotSpec(x, y, 0.0, toward + float(rng.uniform(*starts.robot_heading)))
        if _clear(robot, box, starts.clearance) and _level(terrain, robot):
            break
    task = PushTask(0, (0.0, 0.0), goal, kind, rim, 0 if kind == "hole" else None)
    return Start(terrain, box, robot, task)


def _terrain(kind: Kind, starts: Distribution, line: float, length: float, boxes: int) -> tuple[Terrain, float]:
    """The ground of one episode, its pit, if any, so many boxes deep, and the height of the goal."""
    c, s = math.cos(line), math.sin(line)
    ground = Ground(-_EXTENT, -_EXTENT, _EXTENT, _EXTENT, 0.0)
    if kind == "flat":
        return Terrain((ground,)), 0.0
    if kind == "hole":
        return Terrain((ground,), (Pit(length * c, length * s, line, depth=boxes * PIT_DEPTH),)), 0.0
    foot, crest = starts.slope_margin, length - starts.slope_margin
    rise = (crest - foot) * math.tan(starts.slope_angle)
    ramp = Ramp(foot * c, foot * s, 0.0, crest * c, crest * s, rise, landing=_LANDING)
    return Terrain((ground,), ramps=(ramp,)), rise


def _clear(robot: RobotSpec, box: BoxSpec, gap: float) -> bool:
    """Whether two rectangles keep a gap: some side of one of them separates all corners of the other."""
    mine, other = (robot.x, robot.y, robot.yaw), (box.x, box.y, box.yaw)
    robot_half, box_half = (STANDARD.bumper, STANDARD.half_width), (_HALF_BOX, _HALF_BOX)
    return _separates(mine, robot_half, other, box_half, gap) or _separates(other, box_half, mine, robot_half, gap)


def _level(terrain: Terrain, robot: RobotSpec) -> bool:
    """Whether the robot would stand on the ground at height 0 and touch neither pit nor slope."""
    corners = ((a * _ROOM, b * _ROOM) for a in (-1, 0, 1) for b in (-1, 0, 1))
    return all(terrain.height(robot.x + dx, robot.y + dy) == 0.0 for dx, dy in corners)


_Placed = tuple[float, float, float]


def _separates(one: _Placed, half: Range, other: _Placed, other_half: Range, gap: float) -> bool:
    turn = other[2] - one[2]
    c, s = abs(math.cos(turn)), abs(math.sin(turn))
    dx, dy = other[0] - one[0], other[1] - one[1]
    along = math.cos(one[2]) * dx + math.sin(one[2]) * dy
    across = -math.sin(one[2]) * dx + math.cos(one[2]) * dy
    return (
        abs(along) >= half[0] + other_half[0] * c + other_half[1] * s + gap
        or abs(across) >= half[1] + other_half[0] * s + other_half[1] * c + gap
    )
