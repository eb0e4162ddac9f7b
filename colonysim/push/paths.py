"""Room for a robot among pits, boxes, robots and the ground's border, and ways through it.

The robot is a disc that may turn on the spot. Slack is how far its centre could still move towards the
nearest obstacle; negative slack is a place where it must not be.
"""

import heapq
import itertools
import math
from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import sqrt

from colonysim.physics.scene import Scene
from colonysim.push.footing import COMFORT, footing_on

Point = tuple[float, float]

ROBOT_RADIUS = 0.47
"""A robot that turns on the spot sweeps this disc, metres."""
BOX_CLEARANCE = ROBOT_RADIUS + 0.03
"""Least distance of a robot's centre from a box's sides, metres."""
PIT_CLEARANCE = 0.40
"""Least distance of a robot's centre from a pit's edges: its wheels stay on the ground, metres."""
ROBOT_CLEARANCE = 2 * ROBOT_RADIUS

_CELL = 0.12
_WINDOW = 3.0
_ESCAPE = 0.8
# Rows of the arrays below.
_SQUARE, _DISC = 6, 3


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
        self._footing = footing_on(scene.terrain)
        squares: list[float] = []
        for i in around.boxes:
            box, half = scene.box(i), scene.boxes[i].length / 2
            squares += (box.x, box.y, math.cos(box.yaw), math.sin(box.yaw), half, BOX_CLEARANCE)
        for i in around.open_pits:
            pit = scene.terrain.pits[i]
            squares += (pit.x, pit.y, math.cos(pit.yaw), math.sin(pit.yaw), pit.side / 2, PIT_CLEARANCE)
        discs: list[float] = []
        for i in around.robots:
            discs += (*scene.course(i)[:2], ROBOT_CLEARANCE)
        for disc in around.discs:
            discs += disc
        self._squares, self._discs = array("d", squares), array("d", discs)
        self._square_count, self._disc_count = len(squares) // _SQUARE, len(discs) // _DISC

    def slack(self, x: float, y: float) -> float:
        """Slack at one place, metres."""
        squares, discs = self._squares, self._discs
        least = self._footing.slack(x, y)
        for k in range(self._square_count):
            i = _SQUARE * k
            dx, dy, c, s = x - squares[i], y - squares[i + 1], squares[i + 2], squares[i + 3]
            half, clearance = squares[i + 4], squares[i + 5]
            u, v = max(0.0, abs(c * dx + s * dy) - half), max(0.0, abs(-s * dx + c * dy) - half)
            # Most obstacles are too far away to matter, which needs no root to be seen.
            if u - clearance < least and v - clearance < least:
                least = min(least, sqrt(u * u + v * v) - clearance)
        for k in range(self._disc_count):
            i = _DISC * k
            dx, dy, clearance = x - discs[i], y - discs[i + 1], discs[i + 2]
            if abs(dx) - clearance < least and abs(dy) - clearance < least:
                least = min(least, sqrt(dx * dx + dy * dy) - clearance)
        return least

    def clear(self, start: Point, end: Point, least: float) -> bool:
        """Whether the slack is at least `least` all along a straight way, both its ends included."""
        x0, y0 = start
        x1, y1 = end
        parts = max(1, math.ceil(math.dist(start, end) / (_CELL / 2)))
        part = 1.0 / parts
        for k in range(parts):
            share = k * part
            if self.slack(x0 + share * (x1 - x0), y0 + share * (y1 - y0)) < least:
                return False
        return self.slack(x1, y1) >= least

    def path(self, start: Point, goal: Point) -> list[Point] | None:
        """Waypoints of a way from start to goal, the goal last; None when there is none.

        A robot that starts where it must not be may leave, as long as it gets no closer to what it is too
        close to.
        """
        at_goal = self.slack(*goal)
        if at_goal < 0.0:
            return None
        if self.clear(start, goal, min(COMFORT / 2, self.slack(*start), at_goal)):
            return [goal]
        grid = _search(self, start, goal)
        return None if grid is None else self._straighten([start, *grid, goal])

    def _straighten(self, points: list[Point]) -> list[Point]:
        """Leave out the waypoints that a straight line can do without."""
        points = _bends(points)
        slack = [self.slack(*point) for point in points]
        kept: list[Point] = []
        here = 0
        while here < len(points) - 1:
            ahead = len(points) - 1
            while ahead > here + 1:
                worst = min(slack[here : ahead + 1])
                if self.clear(points[here], points[ahead], min(worst, COMFORT / 2) - 0.01):
                    break
                ahead -= 1
            kept.append(points[ahead])
            here = ahead
        return kept


def _bends(points: list[Point]) -> list[Point]:
    """The points without those inside straight runs of a grid."""
    kept = points[:1]
    for before, here, after in zip(points, points[1:], points[2:], strict=False):
        bend = (here[0] - before[0]) * (after[1] - here[1]) - (here[1] - before[1]) * (after[0] - here[0])
        if abs(bend) > 1e-6:
            kept.append(here)
    return [*kept, points[-1]]


class _Grid:
    """What it costs to be in the cells around a start and a goal, worked out where the search comes by.

    Args:
        space: The room there is.
        start: Where the way begins.
        goal: Where it ends.
    """

    def __init__(self, space: FreeSpace, start: Point, goal: Point) -> None:
        self._space = space
        self._start_x, self._start_y = start
        self.xmin = min(start[0], goal[0]) - _WINDOW
        self.ymin = min(start[1], goal[1]) - _WINDOW
        self.columns = int((max(start[0], goal[0]) + _WINDOW - self.xmin) / _CELL) + 1
        self.rows = int((max(start[1], goal[1]) + _WINDOW - self.ymin) / _CELL) + 1
        self.first, self.last = self._cell(start), self._cell(goal)
        self._at_start = space.slack(*start)
        self._prices: dict[tuple[int, int], float] = {self.first: 1.0, self.last: 1.0}

    def _cell(self, point: Point) -> tuple[int, int]:
        return round((point[0] - self.xmin) / _CELL), round((point[1] - self.ymin) / _CELL)

    def place(self, cell: tuple[int, int]) -> Point:
        """The middle of a cell."""
        return self.xmin + _CELL * cell[0], self.ymin + _CELL * cell[1]

    def price(self, cell: tuple[int, int]) -> float:
        """Cost of a cell's width: more where there is little slack, infinite where a robot must not be."""
        price = self._prices.get(cell)
        if price is None:
            x, y = self.place(cell)
            price = self._prices[cell] = self._worked_out(x, y)
        return price

    def _worked_out(self, x: float, y: float) -> float:
        slack = self._space.slack(x, y)
        if slack < 0.0:
            dx, dy = x - self._start_x, y - self._start_y
            leaving = self._at_start < 0.0 and dx * dx + dy * dy < _ESCAPE**2 and slack >= self._at_start - 0.02
            if not leaving:
                return math.inf
            slack = 0.0
        return 1.0 + 3.0 * max(0.0, min(1.0, 1.0 - slack / COMFORT))


def _search(space: FreeSpace, start: Point, goal: Point) -> Sequence[Point] | None:
    """A* over a grid that is laid around start and goal; places with little slack cost more."""
    grid = _Grid(space, start, goal)
    first, last = grid.first, grid.last
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
        spent = cost[here]
        for dx, dy, length in steps:
            there = (here[0] + dx, here[1] + dy)
            if not (0 <= there[0] < grid.columns and 0 <= there[1] < grid.rows):
                continue
            reached = spent + length * grid.price(there)
            if reached < cost.get(there, math.inf):
                cost[there] = reached
                came[there] = here
                heapq.heappush(queue, (reached + math.dist(there, last), there))
    if last not in came:
        return None
    points: list[Point] = []
    here = came[last]
    while here != first:
        points.append(grid.place(here))
        here = came[here]
    return points[::-1]
