"""Room for a robot among pits, boxes, robots and the ground's border, and ways through it.

The robot is a disc that may turn on the spot. Slack is how far its centre could still move towards the
nearest obstacle; negative slack is a place where it must not be.
"""

import heapq
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from colonysim.physics.scene import Scene
from colonysim.physics.terrain import Terrain

Point = tuple[float, float]
Array = NDArray[np.float64]

ROBOT_RADIUS = 0.47
"""A robot that turns on the spot sweeps this disc, metres."""
BOX_CLEARANCE = ROBOT_RADIUS + 0.03
"""Least distance of a robot's centre from a box's sides, metres."""
PIT_CLEARANCE = 0.40
"""Least distance of a robot's centre from a pit's edges: its wheels stay on the ground, metres."""
ROBOT_CLEARANCE = 2 * ROBOT_RADIUS
BORDER_CLEARANCE = 0.40
"""Least distance of a robot's centre from the ground's border, metres."""

_CELL = 0.12
_WINDOW = 3.0
_COMFORT = 0.15
_AMPLE = 1.0
_ESCAPE = 0.8
_STEEPEST = 0.3
_STEP = 0.005
"""Together with the steepest slope over .1 m: a step of .035 m is passed over, one of .04 m stops the wheels."""
# At the ground's border and at cliffs: eight looks at each of several distances, the last of them further than needed.
_REACHES = np.array([0.1, 0.2, 0.3, BORDER_CLEARANCE, BORDER_CLEARANCE + _COMFORT]).reshape(-1, 1, 1)
_ANGLES = np.arange(8).reshape(-1, 1) * (math.pi / 4)
_LOOKS_X, _LOOKS_Y = _REACHES * np.cos(_ANGLES), _REACHES * np.sin(_ANGLES)
_LOOKS_RISE = _STEEPEST * _REACHES + 0.02
_LOOKS_STEP = _STEEPEST * np.diff(_REACHES, axis=0, prepend=0.0) + _STEP


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What a robot has to stay away from.

    Attributes:
        robots: Indices of the other robots.
        boxes: Indices of boxes that stand on the ground (those seated in pits are ground).
        open_pits: Indices of pits that are empty or half filled: to a robot they are walls.
        discs: Further places to keep out of: x, y and the distance to keep, metres.
    """

    robots: tuple[int, ...] = ()
    boxes: tuple[int, ...] = ()
    open_pits: tuple[int, ...] = ()
    discs: tuple[tuple[float, float, float], ...] = ()


Obstacles = Callable[[], Surroundings]
"""Asked whenever a way is planned; it answers for that moment."""


def everything_else(scene: Scene, robot: int) -> Obstacles:
    """The obstacles of a robot alone with its knowledge of the scene: all other bodies, all unfilled pits."""

    def look() -> Surroundings:
        robots = tuple(i for i in scene.present_robots() if i != robot)
        return Surroundings(robots, scene.standing_boxes(), scene.open_pits())

    return look


class FreeSpace:
    """The room there is at one moment.

    Args:
        scene: The scene; poses are read once.
        around: What to stay away from.
    """

    def __init__(self, scene: Scene, around: Surroundings) -> None:
        self._terrain = scene.terrain
        squares: list[tuple[float, ...]] = []
        for i in around.boxes:
            box = scene.box(i)
            c, s = math.cos(box.yaw), math.sin(box.yaw)
            squares.append((box.x, box.y, c, s, scene.boxes[i].length / 2, BOX_CLEARANCE))
        for i in around.open_pits:
            pit = scene.terrain.pits[i]
            squares.append((pit.x, pit.y, math.cos(pit.yaw), math.sin(pit.yaw), pit.side / 2, PIT_CLEARANCE))
        others = [scene.robot(i) for i in around.robots]
        discs = [(other.x, other.y, ROBOT_CLEARANCE) for other in others]
        # One row for each obstacle, so that all are looked at in one go: most questions are about few places.
        self._squares = np.array(squares).reshape(-1, 6, 1).transpose(1, 0, 2)
        self._discs = np.array([*discs, *around.discs]).reshape(-1, 3, 1).transpose(1, 0, 2)

    def slack(self, x: Array, y: Array) -> Array:
        """Slack at many places, metres; arrays of one shape in and out."""
        shape, x, y = x.shape, x.ravel(), y.ravel()
        least = _border_slack(self._terrain, x, y)
        if self._squares.shape[1]:
            cx, cy, c, s, half, clearance = self._squares
            u = np.maximum(np.abs(c * (x - cx) + s * (y - cy)) - half, 0.0)
            v = np.maximum(np.abs(-s * (x - cx) + c * (y - cy)) - half, 0.0)
            least = np.minimum(least, (np.sqrt(u * u + v * v) - clearance).min(axis=0))
        if self._discs.shape[1]:
            cx, cy, clearance = self._discs
            least = np.minimum(least, (np.sqrt((x - cx) ** 2 + (y - cy) ** 2) - clearance).min(axis=0))
        return least.reshape(shape)

    def at(self, *places: Point) -> list[float]:
        """Slack at single places, metres."""
        x, y = np.array(places).T
        return [float(slack) for slack in self.slack(x, y)]

    def along(self, start: Point, end: Point) -> float:
        """Least slack on a straight way, metres."""
        return float(self.slack(*_samples(start, end)).min())

    def path(self, start: Point, goal: Point) -> list[Point] | None:
        """Waypoints of a way from start to goal, the goal last; None when there is none.

        A robot that starts where it must not be may leave, as long as it gets no closer to what it is too
        close to.
        """
        slack = self.slack(*_samples(start, goal))
        at_start, at_goal = float(slack[0]), float(slack[-1])
        if at_goal < 0.0:
            return None
        if slack.min() >= min(_COMFORT / 2, at_start, at_goal):
            return [goal]
        grid = _search(self, start, goal)
        return None if grid is None else self._straighten([start, *grid, goal])

    def _straighten(self, points: list[Point]) -> list[Point]:
        """Leave out the waypoints that a straight line can do without."""
        points = _bends(points)
        slack = self.slack(np.array([p[0] for p in points]), np.array([p[1] for p in points]))
        kept: list[Point] = []
        here = 0
        while here < len(points) - 1:
            ahead = len(points) - 1
            while ahead > here + 1:
                worst = float(slack[here : ahead + 1].min())
                if self.along(points[here], points[ahead]) >= min(worst, _COMFORT / 2) - 0.01:
                    break
                ahead -= 1
            kept.append(points[ahead])
            here = ahead
        return kept


def _samples(start: Point, end: Point) -> tuple[Array, Array]:
    """Places on a straight way, both ends included."""
    count = max(2, math.ceil(math.dist(start, end) / (_CELL / 2)) + 1)
    share = np.linspace(0.0, 1.0, count)
    x, y = start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])
    x[-1], y[-1] = end
    return x, y


def _bends(points: list[Point]) -> list[Point]:
    """The points without those inside straight runs of a grid."""
    kept = points[:1]
    for before, here, after in zip(points, points[1:], points[2:], strict=False):
        bend = (here[0] - before[0]) * (after[1] - here[1]) - (here[1] - before[1]) * (after[0] - here[0])
        if abs(bend) > 1e-6:
            kept.append(here)
    return [*kept, points[-1]]


def surface(terrain: Terrain, x: Array, y: Array) -> Array:
    """Height of the ground at many places as if all pits were filled; minus infinity off the ground."""
    top = np.full(x.shape, -np.inf)
    for g in terrain.grounds:
        inside = (x >= g.xmin) & (x <= g.xmax) & (y >= g.ymin) & (y <= g.ymax)
        np.maximum(top, g.z, out=top, where=inside)
    for ramp in terrain.ramps:
        yaw = ramp.yaw
        c, s = math.cos(yaw), math.sin(yaw)
        along = c * (x - ramp.x0) + s * (y - ramp.y0)
        across = -s * (x - ramp.x0) + c * (y - ramp.y0)
        inside = (np.abs(across) <= ramp.half_width) & (along >= -ramp.landing)
        inside &= along <= ramp.length + ramp.landing
        height = ramp.z0 + np.clip(along / ramp.length, 0.0, 1.0) * (ramp.z1 - ramp.z0)
        np.maximum(top, height, out=top, where=inside)
    return top


def _border_slack(terrain: Terrain, x: Array, y: Array) -> Array:
    """Slack towards the ground's border and towards cliffs, in coarse grades."""
    slack = np.full(x.shape, _AMPLE)
    edgy = ~_amid(terrain, x, y)
    if edgy.any():
        slack[edgy] = _edge_slack(terrain, x[edgy], y[edgy])
    return slack


def _amid(terrain: Terrain, x: Array, y: Array) -> NDArray[np.bool_]:
    """Where the ground is the same level rectangle as far as `_edge_slack` would look: there is ample room."""
    reach = BORDER_CLEARANCE + _COMFORT + 0.01
    amid = np.zeros(x.shape, dtype=bool)
    for g in terrain.grounds:
        inside = (x >= g.xmin + reach) & (x <= g.xmax - reach) & (y >= g.ymin + reach) & (y <= g.ymax - reach)
        for other in terrain.grounds:
            if other.z > g.z:
                inside &= ~_within(x, y, other.xmin, other.ymin, other.xmax, other.ymax, reach)
        amid |= inside
    for ramp in terrain.ramps:
        # The square around the strip and its landings, whichever way it points.
        half = math.hypot(ramp.length / 2 + ramp.landing, ramp.half_width)
        cx, cy = (ramp.x0 + ramp.x1) / 2, (ramp.y0 + ramp.y1) / 2
        amid &= ~_within(x, y, cx - half, cy - half, cx + half, cy + half, reach)
    return amid


def _within(x: Array, y: Array, xmin: float, ymin: float, xmax: float, ymax: float, margin: float) -> NDArray[np.bool_]:
    return (x >= xmin - margin) & (x <= xmax + margin) & (y >= ymin - margin) & (y <= ymax + margin)


def _edge_slack(terrain: Terrain, x: Array, y: Array) -> Array:
    here = surface(terrain, x, y)
    ground = np.isfinite(here)
    slack = np.where(ground, _AMPLE, -BORDER_CLEARANCE)
    if not ground.all():
        if ground.any():
            slack[ground] = _edge_slack(terrain, x[ground], y[ground])
        return slack
    # All looks in one go: most calls are about few places.
    there = surface(terrain, x + _LOOKS_X, y + _LOOKS_Y)
    # Neither a cliff nor, on the way there, a step that stops the wheels.
    with np.errstate(invalid="ignore"):
        steps = np.abs(np.diff(there, axis=0, prepend=np.broadcast_to(here, (1, *there.shape[1:]))))
    sound = (np.abs(there - here) <= _LOOKS_RISE) & (steps <= _LOOKS_STEP)
    slack[~sound.all(axis=(0, 1))] = 0.0
    slack[~sound[:-1].all(axis=(0, 1))] = -_COMFORT
    return slack


def _search(space: FreeSpace, start: Point, goal: Point) -> Sequence[Point] | None:
    """A* over a grid that is laid around start and goal; places with little slack cost more."""
    xmin = min(start[0], goal[0]) - _WINDOW
    ymin = min(start[1], goal[1]) - _WINDOW
    columns = int((max(start[0], goal[0]) + _WINDOW - xmin) / _CELL) + 1
    rows = int((max(start[1], goal[1]) + _WINDOW - ymin) / _CELL) + 1
    x, y = np.meshgrid(xmin + _CELL * np.arange(columns), ymin + _CELL * np.arange(rows), indexing="ij")
    slack = space.slack(x, y)
    [at_start] = space.at(start)
    if at_start < 0.0:
        near = (x - start[0]) ** 2 + (y - start[1]) ** 2 < _ESCAPE**2
        slack = np.where(near & (slack >= at_start - 0.02), np.maximum(slack, 0.0), slack)
    price = np.where(slack >= 0.0, 1.0 + 3.0 * np.clip(1.0 - slack / _COMFORT, 0.0, 1.0), np.inf)

    def cell(point: Point) -> tuple[int, int]:
        return round((point[0] - xmin) / _CELL), round((point[1] - ymin) / _CELL)

    first, last = cell(start), cell(goal)
    price[first] = price[last] = 1.0
    prices = price.tolist()
    steps = [(dx, dy, math.hypot(dx, dy)) for dx, dy in itertools.product((-1, 0, 1), repeat=2) if (dx, dy) != (0, 0)]
    cost = {first: 0.0}
    came: dict[tuple[int, int], tuple[int, int]] = {}
    queue = [(math.dist(first, last), first)]
    done: set[tuple[int, int]] = set()
    while queue:
        _, here = heapq.heappop(queue)
        if here == last:
            break
        if here in done:
            continue
        done.add(here)
        i, j = here
        spent = cost[here]
        for dx, dy, length in steps:
            x_there, y_there = i + dx, j + dy
            if not (0 <= x_there < columns and 0 <= y_there < rows):
                continue
            reached = spent + length * prices[x_there][y_there]
            there = (x_there, y_there)
            if reached < cost.get(there, math.inf):
                cost[there] = reached
                came[there] = here
                heapq.heappush(queue, (reached + math.dist(there, last), there))
    if last not in came:
        return None
    points: list[Point] = []
    here = came[last]
    while here != first:
        points.append((xmin + _CELL * here[0], ymin + _CELL * here[1]))
        here = came[here]
    return points[::-1]
