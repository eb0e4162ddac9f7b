"""New worlds by kind, size and seed, as documents that can be written to a file. Each can be solved by construction."""

from __future__ import annotations

import json
from collections import deque
from typing import TYPE_CHECKING, Any, Literal

from colonysim.errors import ColonysimError
from colonysim.world.generate import doors, draw_some, rooms

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Kind", "invent", "to_yaml"]

Kind = Literal["grid", "rooms", "platforms", "geometric"]

CELL = 4
"""Side of the squares that level ground is divided into; what stands on the inner four nodes leaves a way round."""
HEIGHT = 1.0
"""Height of every box, graph units."""

Stands = tuple[list[int], list[int]]
"""The nodes of the holes and those of the boxes."""


def invent(
    kind: Kind,
    *,
    columns: int = 3,
    rows: int = 3,
    size: int = 6,
    holes: int = 0,
    spare: int = 0,
    depth: int = 1,
    agents: int = 4,
    crowded: bool = False,
    seed: int = 0,
) -> dict[str, Any]:
    """A scenario document.

    Each door between two platforms is a hole, and has its boxes on the platform that is reached first: one after the
    other can be opened, in any order where holes are one box deep. Holes and boxes of the other kinds are in
    nobody's way, as the nodes around them stay free.

    Args:
        kind: "grid": level ground. "rooms": rooms behind walls with doors. "platforms": rooms whose doors are holes.
            "geometric": nodes strewn at random, without holes.
        columns: Nodes along x; of rooms and platforms, how many along x.
        rows: Nodes along y; of rooms and platforms, how many along y.
        size: Nodes along each side of a room or platform.
        holes: How many; platforms have one at each door instead.
        spare: Boxes besides those that the holes need.
        depth: Boxes that fill a hole.
        agents: How many; on platforms they start on the first.
        crowded: Whether they start in one corner, as close together as there is room.
        seed: Makes the world.

    Raises:
        ColonysimError: It does not fit.

    Example:
        >>> invent("platforms", columns=2, rows=1, size=5)["holes"]
        [{'node': 27, 'depth': 1.0}]
    """
    if min(columns, rows, size, depth, agents) < 1 or min(holes, spare) < 0:
        raise ColonysimError("columns, rows, size, depth and agents are at least 1, holes and spare boxes at least 0")
    if kind == "geometric" and (holes or spare):
        raise ColonysimError("a geometric world is made without holes and boxes; expected grid, rooms or platforms")
    if kind == "platforms" and holes:
        raise ColonysimError("the holes of platforms are their doors, one between each two; leave their number out")
    walled = kind in ("rooms", "platforms")
    width, height = (columns * (size + 1) - 1, rows * (size + 1) - 1) if walled else (columns, rows)
    topology: dict[str, Any] = {"kind": "rooms" if walled else kind, "columns": columns, "rows": rows}
    stands: Stands = ([], [])
    if walled:
        topology |= {"size": size, "seed": seed}
    if kind == "geometric":
        topology = {"kind": kind, "nodes": columns * rows, "radius": 1.6, "apart": 0.5, "seed": seed}
        topology |= {"width": float(columns), "height": float(rows)}
    elif kind == "platforms":
        stands = _bridged(columns, rows, size, depth, spare, seed)
    else:
        cells = _cells(size, size, width, columns, rows) if walled else _cells(width, height, width, 1, 1)
        stands = _strewn(cells, width, holes, spare, depth, seed)
    goal = width * height - 1
    crowd: dict[str, Any] = {"count": agents, "seed": seed}
    if kind == "platforms":
        crowd["within"] = [0, 0, size - 1, size - 1]
    elif crowded:
        walls = rooms(columns, rows, size, 1.0, seed)[1] if walled else ()
        side = _corner(agents, width, height, {*stands[0], *stands[1], *walls, goal})
        crowd["within"] = [0, 0, side, side]
    return {
        "name": f"{kind}-{columns}x{rows}-s{seed}",
        "topology": topology,
        "holes": [{"node": node, "depth": depth * HEIGHT} for node in stands[0]],
        "boxes": [[node, HEIGHT] for node in stands[1]],
        "agents": crowd,
        "goal": goal,
        "max_steps": 50 + 6 * (width + height),
    }


def _cells(width: int, height: int, row_length: int, columns: int, rows: int) -> list[int]:
    """The first node of each square of `CELL` x `CELL` nodes in rooms of width x height."""
    return [
        (row * (height + 1) + y) * row_length + column * (width + 1) + x
        for row in range(rows)
        for column in range(columns)
        for y in range(0, height - CELL + 1, CELL)
        for x in range(0, width - CELL + 1, CELL)
    ]


def _strewn(cells: Sequence[int], row_length: int, holes: int, spare: int, depth: int, seed: int) -> Stands:
    """Holes with their boxes beside them, and spare boxes, each group on the inner nodes of a square of its own."""
    inner = [row_length + 1, row_length + 2, 2 * row_length + 1, 2 * row_length + 2]
    if depth >= len(inner):
        raise ColonysimError(f"a hole here is at most {len(inner) - 1} boxes deep, not {depth}")
    needed = holes + -(-spare // len(inner))
    if needed > len(cells):
        raise ColonysimError(
            f"{holes} holes and {spare} spare boxes need {needed} squares of {CELL} x {CELL} nodes,"
            f" there are {len(cells)}"
        )
    pits: list[int] = []
    boxes: list[int] = []
    for n, cell in enumerate(draw_some(cells, needed, seed)):
        nodes = [cell + step for step in draw_some(inner, len(inner), seed + n)]
        if n < holes:
            pits.append(nodes[0])
            boxes += nodes[1 : 1 + depth]
        else:
            boxes += nodes[: min(len(inner), spare)]
            spare -= min(len(inner), spare)
    return pits, boxes


def _bridged(columns: int, rows: int, size: int, depth: int, spare: int, seed: int) -> Stands:
    """All doors as holes, each with its boxes on the platform that lies nearer to the first.

    One stands right before the door, further ones in the middle of the platform; no two touch, so that none of them
    cuts a platform in two.
    """
    if size < 5:
        raise ColonysimError(f"a platform needs a size of at least 5, not {size}")
    width = columns * (size + 1) - 1
    gates = doors(columns, rows, size, seed)
    around: dict[int, list[tuple[int, int]]] = {}
    for (a, b), door in gates.items():
        around.setdefault(a, []).append((b, door))
        around.setdefault(b, []).append((a, door))
    middles = {room: _middle(room, columns, size, seed) for room in range(columns * rows)}
    order, waiting = {0: 0}, deque([0])
    while waiting:
        room = waiting.popleft()
        near = around.get(room, [])
        for other, _ in draw_some(near, len(near), seed + room):
            if other not in order:
                order[other] = len(order)
                waiting.append(other)
    boxes: list[int] = []
    for (a, b), door in gates.items():
        inwards = 1 if b == a + 1 else width
        first = a if order[a] < order[b] else b
        boxes.append(door - inwards if first == a else door + inwards)
        boxes += [_taken(middles[first], size) for _ in range(depth - 1)]
    left = [node for room in sorted(middles) for node in middles[room]]
    if spare > len(left):
        raise ColonysimError(f"there is room for {len(left)} spare boxes on these platforms, not for {spare}")
    return list(gates.values()), boxes + draw_some(left, spare, seed)


def _middle(room: int, columns: int, size: int, seed: int) -> list[int]:
    """Every second node of a platform, two away from its border, in an order drawn at random."""
    width = columns * (size + 1) - 1
    row, column = divmod(room, columns)
    first = row * (size + 1) * width + column * (size + 1)
    nodes = [first + y * width + x for y in range(2, size - 2, 2) for x in range(2, size - 2, 2)]
    return draw_some(nodes, len(nodes), seed + room)


def _taken(nodes: list[int], size: int) -> int:
    if not nodes:
        raise ColonysimError(f"platforms of size {size} have no room for so many boxes; expected larger ones")
    return nodes.pop()


def _corner(agents: int, width: int, height: int, taken: set[int]) -> int:
    """The largest x and y of the smallest square in the corner at (0, 0) that has room for all agents."""
    free = 0
    for side in range(max(width, height)):
        border = {(side, y) for y in range(side + 1)} | {(x, side) for x in range(side)}
        free += sum(x < width and y < height and y * width + x not in taken for x, y in border)
        if free >= agents:
            return side
    raise ColonysimError(f"there is room for {free} agents, not for {agents}")


def to_yaml(document: dict[str, Any]) -> str:
    """A document as the text of a scenario file: a line for each field, hole and box."""
    lines = []
    for name, value in document.items():
        if isinstance(value, list):
            lines += [f"{name}:", *(f"  - {json.dumps(item)}" for item in value)] if value else []
        else:
            lines.append(f"{name}: {json.dumps(value)}")
    return "\n".join([*lines, ""])
