"""Generated places: grid, line, ring, rooms and random geometric graph; and the edges that a radius gives.

Coordinates are rounded to six decimals, so that the same description gives the same place on any machine.
"""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, TypeAlias, TypeVar

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Sequence

__all__ = [
    "MAX_EDGES", "MAX_NODES", "Point", "TooManyEdgesError", "doors", "draw_some", "geometric", "grid", "grid_edges",
    "line", "radius_edges", "ring", "rooms",
]  # fmt: skip

MAX_NODES = 2_000_000
"""Most nodes of a generated place."""
MAX_EDGES = 4_000_000
"""Most edges of a place: as many as a grid of a million nodes has with its diagonals, in some 1.5 GB."""
_COMPARED = 4
"""Pairs of nodes that may be compared for each edge that a place may have: in the plane three are, for each found."""
_MAX_TRIES = 4_000_000
"""Positions that may be drawn for all nodes of a place together."""
_JAMMED = 0.547
"""Share of the plane that discs dropped at random fill when no further one finds room (Feder, J. Theor. Biol. 1980)."""

_TOLERANCE = 1e-9  # decimal coordinates a radius apart count as within it, whatever their binary rounding

T = TypeVar("T")
Point: TypeAlias = tuple[float, float]
Place: TypeAlias = tuple[list[Point], list[tuple[int, int]]]


class TooManyEdgesError(ValueError):
    """A radius that joins more than MAX_EDGES pairs, or within which too many would have to be compared."""


def grid(
    columns: int, rows: int, spacing: float, diagonals: bool, cut_corners: bool = True,
    without: Collection[int] = frozenset(),
) -> Place:  # fmt: skip
    """A rectangular grid; node `row * columns + column` stands at (column, row) times `spacing`.

    Args:
        columns: Nodes along x.
        rows: Nodes along y.
        spacing: Distance of neighbours, graph units.
        diagonals: Whether diagonal neighbours are joined too.
        cut_corners: Whether they are though one of the two nodes beside the diagonal is left out.
        without: Nodes that are left out of the edges.
    """
    points = [(round(c * spacing, 6), round(r * spacing, 6)) for r in range(rows) for c in range(columns)]
    steps = [(1, 0), (0, 1), (1, 1), (-1, 1)] if diagonals else [(1, 0), (0, 1)]
    edges = [
        (i, j)
        for r in range(rows)
        for c in range(columns)
        if (i := r * columns + c) not in without
        for dc, dr in steps
        if 0 <= c + dc < columns and r + dr < rows and (j := i + dr * columns + dc) not in without
        and (cut_corners or not (dc and dr) or not (i + dc in without or j - dc in without))
    ]  # fmt: skip
    return points, edges


def grid_edges(columns: int, rows: int, diagonals: bool, left_out: int = 0) -> int:
    """How many edges such a grid has; where nodes are left out of it, at most."""
    across = 2 * (columns - 1) * (rows - 1) if diagonals else 0
    return min((columns - 1) * rows + columns * (rows - 1) + across,
               (columns * rows - left_out) * (4 if diagonals else 2))  # fmt: skip


def line(nodes: int, spacing: float) -> Place:
    """Nodes in a row along x."""
    return [(round(i * spacing, 6), 0.0) for i in range(nodes)], [(i, i + 1) for i in range(nodes - 1)]


def ring(nodes: int, spacing: float) -> Place:
    """Nodes evenly on a circle, neighbours `spacing` apart; node 0 lies east of the centre, which is (0, 0)."""
    radius = spacing / (2 * math.sin(math.pi / nodes))
    angles = [2 * math.pi * i / nodes for i in range(nodes)]
    points = [(round(radius * math.cos(a), 6), round(radius * math.sin(a), 6)) for a in angles]
    return points, [(i, (i + 1) % nodes) for i in range(nodes)]


def rooms(columns: int, rows: int, size: int, spacing: float, seed: int) -> tuple[Place, list[int]]:
    """Square rooms in columns and rows, parted by walls one node thick; a door joins each two side by side.

    Args:
        columns: Rooms along x.
        rows: Rooms along y.
        size: Nodes along each side of a room.
        spacing: Distance of neighbours, graph units.
        seed: Where the doors are.

    Returns:
        The grid that all of it is cut out of, without diagonals, and the numbers of its nodes that are wall.
    """
    width, height = columns * (size + 1) - 1, rows * (size + 1) - 1
    open_walls = set(doors(columns, rows, size, seed).values())
    walls = [
        r * width + c
        for r in range(height)
        for c in range(width)
        if ((r + 1) % (size + 1) == 0 or (c + 1) % (size + 1) == 0) and r * width + c not in open_walls
    ]
    return grid(width, height, spacing, diagonals=False), walls


def doors(columns: int, rows: int, size: int, seed: int) -> dict[tuple[int, int], int]:
    """The node of each door between two rooms, `row * columns + column` being a room's number.

    Doors keep away from the corners of a room: two nodes where it has five or more along a side, one where it has
    three or four.
    """
    rng = random.Random(seed)
    width = columns * (size + 1) - 1
    margin = min(2, (size - 1) // 2)
    found = {}
    for row in range(rows):
        for column in range(columns):
            room, left, low = row * columns + column, column * (size + 1), row * (size + 1)
            if column + 1 < columns:
                at = margin + int(rng.random() * (size - 2 * margin))
                found[room, room + 1] = (low + at) * width + left + size
            if row + 1 < rows:
                at = margin + int(rng.random() * (size - 2 * margin))
                found[room, room + columns] = (low + size) * width + left + at
    return found


def draw_some(items: Sequence[T], count: int, seed: int) -> list[T]:
    """`count` different ones of `items`, in an order drawn at random: the same on every version of Python.

    Raises:
        ValueError: There are not so many.
    """
    if count > len(items):
        raise ValueError(f"{count} of {len(items)}")
    rng, drawn = random.Random(seed), list(items)
    for i in range(count):
        j = i + int(rng.random() * (len(drawn) - i))
        drawn[i], drawn[j] = drawn[j], drawn[i]
    return drawn[:count]


def geometric(
    nodes: int, radius: float, width: float, height: float, seed: int, apart: float, connected: bool
) -> Place:
    """A random geometric graph: nodes uniform in a rectangle, joined when within `radius`.

    Args:
        nodes: Number of nodes.
        radius: Nodes at most this far apart are joined, graph units.
        width: Extent along x, graph units.
        height: Extent along y, graph units.
        seed: Seed of the positions.
        apart: Least distance of two nodes, graph units.
        connected: Whether separate parts are joined by the shortest edges that do so.

    Raises:
        ValueError: The nodes do not fit into the rectangle that far apart.
        TooManyEdgesError: The radius joins too many pairs.
    """
    # What cannot be is found before there are two million nodes of it.
    _check_work(nodes * nodes / 2 * min(1.0, 3 * radius / width) * min(1.0, 3 * radius / height), radius)
    crowded = ValueError(f"{nodes} nodes {apart:g} apart do not fit into {width:g} x {height:g}")
    if nodes * math.pi * (apart / 2) ** 2 > _JAMMED * (width + 2 * apart) * (height + 2 * apart):
        raise crowded
    rng = random.Random(seed)
    cells: dict[tuple[int, int], list[int]] = {}
    size = max(apart, _TOLERANCE) if apart else 1.0
    points: list[Point] = []
    tries = 0
    for _ in range(nodes):
        for _attempt in range(200):
            point = (round(rng.random() * width, 6), round(rng.random() * height, 6))
            if not apart:
                break
            tries += 1
            cx, cy = int(point[0] / size), int(point[1] / size)
            around = (i for dx in (-1, 0, 1) for dy in (-1, 0, 1) for i in cells.get((cx + dx, cy + dy), ()))
            if all(math.dist(point, points[i]) >= apart for i in around):
                cells.setdefault((cx, cy), []).append(len(points))
                break
        else:
            raise crowded
        if tries > _MAX_TRIES:
            raise crowded
        points.append(point)
    edges = list(radius_edges(points, radius))
    if connected:
        # About as far as neighbours are apart: beginning with a much smaller radius takes many rounds.
        far = 0.2 * max(math.sqrt(width * height / nodes), max(width, height) / nodes)
        edges += _joining(points, edges, max(radius, far))
    return points, edges


def _check_work(compared: float, radius: float) -> None:
    if compared > _COMPARED * MAX_EDGES:
        raise TooManyEdgesError(
            f"about {compared:.2g} pairs of nodes would have to be compared with the radius {radius:g},"
            f" expected at most {_COMPARED * MAX_EDGES:.2g}"
        )


def radius_edges(points: Sequence[Point], radius: float) -> Iterator[tuple[int, int]]:
    """All pairs (i, j), i < j, of points at most `radius` apart in the xy plane.

    Raises:
        TooManyEdgesError: There are more than MAX_EDGES of them.
    """
    for count, (i, j, _) in enumerate(_pairs_within(points, radius, range(len(points)))):
        if count == MAX_EDGES:
            raise TooManyEdgesError(f"radius {radius:g} joins more than {MAX_EDGES} pairs of nodes")
        yield i, j


def _pairs_within(points: Sequence[Point], radius: float, origins: Collection[int]) -> Iterator[tuple[int, int, float]]:
    """Pairs within `radius` with at least one end in `origins`: (smaller, larger, distance)."""
    cells: dict[tuple[int, int], list[int]] = {}
    size = radius + 2 * _TOLERANCE
    keys = [(math.floor(x / size), math.floor(y / size)) for x, y in points]
    for i, key in enumerate(keys):
        cells.setdefault(key, []).append(i)
    compared = sum(
        len(some) * len(cells.get((cx + dx, cy + dy), ()))
        for (cx, cy), some in cells.items()
        for dx, dy in ((0, 0), (0, 1), (1, -1), (1, 0), (1, 1))
    )
    _check_work(compared * len(origins) / max(1, len(points)), radius)
    for i in origins:
        x, y = points[i]
        cx, cy = keys[i]
        for dx in (-1, 0, 1):
            for dy in (-1, 0, 1):
                for j in cells.get((cx + dx, cy + dy), ()):
                    if j > i or (j < i and j not in origins):
                        length = math.sqrt((x - points[j][0]) ** 2 + (y - points[j][1]) ** 2)
                        if length <= radius + _TOLERANCE:
                            yield min(i, j), max(i, j), length


def _joining(points: Sequence[Point], edges: Sequence[tuple[int, int]], radius: float) -> list[tuple[int, int]]:
    """The shortest edges that join the parts of a graph, as Kruskal's algorithm would choose them."""
    parent = list(range(len(points)))

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    parts = len(points)
    for i, j in edges:
        a, b = root(i), root(j)
        parts -= a != b
        parent[a] = b
    added: list[tuple[int, int]] = []
    while parts > 1:
        # Only nodes outside the largest part can be the near end of a missing edge; the others are left out.
        members: dict[int, list[int]] = {}
        for i in range(len(points)):
            members.setdefault(root(i), []).append(i)
        largest = max(members, key=lambda r: len(members[r]))
        outside = {i for r, group in members.items() if r != largest for i in group}
        radius *= 1.5
        for _, i, j in sorted((length, i, j) for i, j, length in _pairs_within(points, radius, outside)):
            a, b = root(i), root(j)
            if a != b:
                parent[a] = b
                parts -= 1
                added.append((i, j))
    return added
