# cython: boundscheck=False, auto_pickle=False
"""Room for a robot among pits, boxes, robots and the ground's border, and ways through it.

The robot is a disc that may turn on the spot. Slack is how far its centre could still move towards the
nearest obstacle; negative slack is a place where it must not be.
"""

import math
from array import array
from collections.abc import Callable
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
_DIAGONAL = math.sqrt(2.0)
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
        found = _Grid(self, start, goal).search()
        return None if found is None else self._straighten([start, *found, goal])

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


class _Queue:
    """Cells by the cost of a way through them: a binary heap whose entries may become cheaper (`heapq`'s cannot).

    Args:
        size: How many cells there are.
    """

    def __init__(self, size: int) -> None:
        self._count = 0
        self._cells, self._costs = array("i", bytes(4 * size)), array("d", bytes(8 * size))
        self._places = array("i", [-1]) * size

    def put(self, cell: int, cost: float) -> None:
        """Puts a cell in, or lowers its cost."""
        cells, places, costs = self._cells, self._places, self._costs
        costs[cell] = cost
        place = places[cell]
        if place < 0:
            place = self._count
            self._count += 1
        while place > 0:
            above = (place - 1) // 2
            other = cells[above]
            if not self._before(cell, other):
                break
            cells[place], places[other] = other, place
            place = above
        cells[place], places[cell] = cell, place

    def pop(self) -> int:
        """Takes out the cheapest cell, of equally cheap ones the first; -1 when there is none."""
        if self._count == 0:
            return -1
        cells, places = self._cells, self._places
        found, cell = cells[0], cells[self._count - 1]
        self._count -= 1
        places[found] = -1
        place, count = 0, self._count
        while 2 * place + 1 < count:
            below = 2 * place + 1
            if below + 1 < count and self._before(cells[below + 1], cells[below]):
                below += 1
            other = cells[below]
            if not self._before(other, cell):
                break
            cells[place], places[other] = other, place
            place = below
        if count > 0:
            cells[place], places[cell] = cell, place
        return found

    def _before(self, one: int, other: int) -> bool:
        a, b = self._costs[one], self._costs[other]
        return a < b or (a == b and one < other)


class _Grid:
    """The cells around a start and a goal, and what it costs to be there, worked out where the search comes by.

    Cells are counted column by column. Every search makes one; compiled, it is plain numbers (`paths.pxd`).

    Args:
        space: The room there is.
        start: Where the way begins.
        goal: Where it ends.
    """

    def __init__(self, space: FreeSpace, start: Point, goal: Point) -> None:
        self._space = space
        self._start_x, self._start_y = start
        self._xmin = min(start[0], goal[0]) - _WINDOW
        self._ymin = min(start[1], goal[1]) - _WINDOW
        self._columns = int((max(start[0], goal[0]) + _WINDOW - self._xmin) / _CELL) + 1
        self._rows = int((max(start[1], goal[1]) + _WINDOW - self._ymin) / _CELL) + 1
        self._first, self._last = self._cell(start), self._cell(goal)
        self._at_start = space.slack(*start)
        # By cell: what it costs (0: not known yet), the least cost of a way there, from which cell, and whether that is
        # settled; and how far the goal is (below 0: not known yet).
        size = self._columns * self._rows
        self._prices, self._costs = array("d", bytes(8 * size)), array("d", [math.inf]) * size
        self._came, self._done, self._left = array("i", [-1]) * size, bytearray(size), array("d", [-1.0]) * size
        self._prices[self._first] = self._prices[self._last] = 1.0

    def _cell(self, point: Point) -> int:
        column, row = round((point[0] - self._xmin) / _CELL), round((point[1] - self._ymin) / _CELL)
        return column * self._rows + row

    def _place(self, cell: int) -> Point:
        """The middle of a cell."""
        return self._xmin + _CELL * (cell // self._rows), self._ymin + _CELL * (cell % self._rows)

    def _price(self, cell: int) -> float:
        """Cost of a cell's width: more where there is little slack, infinite where a robot must not be."""
        price = self._prices[cell]
        if price == 0.0:
            column, row = cell // self._rows, cell % self._rows
            price = self._prices[cell] = self._worked_out(self._xmin + _CELL * column, self._ymin + _CELL * row)
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

    def _ahead(self, cell: int) -> float:
        """How far the goal's cell is, in cells."""
        left = self._left[cell]
        if left < 0.0:
            rows, last = self._rows, self._last
            dx, dy = cell // rows - last // rows, cell % rows - last % rows
            left = self._left[cell] = sqrt(dx * dx + dy * dy)
        return left

    def search(self) -> list[Point] | None:
        """A*: the places between start and goal on the cheapest way, or None; of equally good cells the lower first."""
        rows, columns, first, last = self._rows, self._columns, self._first, self._last
        costs, came, done = self._costs, self._came, self._done
        costs[first] = 0.0
        queue = _Queue(rows * columns)
        queue.put(first, self._ahead(first))
        while True:
            here = queue.pop()
            if here < 0 or here == last:
                break
            done[here] = 1
            spent, column, row = costs[here], here // rows, here % rows
            for dx in range(-1, 2):
                for dy in range(-1, 2):
                    if (dx == 0 and dy == 0) or not (0 <= column + dx < columns and 0 <= row + dy < rows):
                        continue
                    there = here + dx * rows + dy
                    reached = spent + (_DIAGONAL if dx != 0 and dy != 0 else 1.0) * self._price(there)
                    if reached < costs[there]:
                        costs[there], came[there] = reached, here
                        if not done[there]:
                            queue.put(there, reached + self._ahead(there))
        if came[last] < 0:
            return None
        points: list[Point] = []
        here = came[last]
        while here != first:
            points.append(self._place(here))
            here = came[here]
        return points[::-1]
