"""New worlds by kind, size and seed, as documents that can be written to a file. Each can be solved by construction."""

from __future__ import annotations

import json
from collections import deque
from typing import TYPE_CHECKING, Any, Literal, get_args

from colonysim.arguments import as_seed, whole
from colonysim.errors import ColonysimError
from colonysim.scenario.generate import MAX_NODES, doors, draw_some
from colonysim.scenario.loading import scenario_from_document
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.scenario.scenario import Scenario

__all__ = ["KINDS", "Kind", "invent", "to_yaml"]

Kind = Literal["grid", "rooms", "platforms", "geometric"]
KINDS: tuple[Kind, ...] = get_args(Kind)
_SIZE = 6
_SMALLEST = {"rooms": 2, "platforms": 5}
"""Least nodes along each side of a room or platform; of a platform less would leave no way round its boxes."""

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
    size: int | None = None,
    holes: int = 0,
    spare: int = 0,
    depth: int | None = None,
    agents: int = 4,
    crowded: bool = False,
    seed: int = 0,
) -> dict[str, Any]:
    """A scenario document that was checked as a file would be.

    Each door between two platforms is a hole, and has its boxes on the platform that is reached first: one after the
    other can be opened, in any order where holes are one box deep. Holes and boxes of the other kinds are in
    nobody's way, as the nodes around them stay free.

    Args:
        kind: "grid": level ground. "rooms": rooms behind walls with doors. "platforms": rooms whose doors are holes.
            "geometric": nodes strewn at random, without holes.
        columns: Nodes along x; of rooms and platforms, how many along x.
        rows: Nodes along y; of rooms and platforms, how many along y.
        size: Nodes along each side of a room or platform, at least 2 or 5; 6 by default. Of the other kinds none.
        holes: How many; platforms have one at each door instead.
        spare: Boxes besides those that the holes need.
        depth: Boxes that fill a hole; 1 by default. Not where there are no holes.
        agents: How many; on platforms they start on the first.
        crowded: Whether they start in one corner, as close together as there is room.
        seed: Makes the world.

    Raises:
        ColonysimError: It does not fit, or something is asked for that this kind of world does not have.

    Examples:
        >>> invent("platforms", columns=2, rows=1, size=5)["holes"]
        [{'node': 27, 'depth': 1.0}]
    """
    if kind not in KINDS:
        raise ColonysimError(f"no kind {kind!r} of world; {nearest(str(kind), KINDS)}")
    columns, rows, agents, seed = whole("columns", columns), whole("rows", rows), whole("agents", agents), as_seed(seed)
    holes, spare = whole("holes", holes, 0), whole("spare", spare, 0)
    if kind == "geometric" and (holes or spare):
        raise ColonysimError("a geometric world is made without holes and boxes; expected grid, rooms or platforms")
    if kind == "platforms" and holes:
        raise ColonysimError("the holes of platforms are their doors, one between each two; leave their number out")
    walled = kind in _SMALLEST
    if size is not None and not walled:
        raise ColonysimError(f"size: rooms and platforms have one, a {kind} world is as large as its columns and rows")
    side = whole("size", _SIZE if size is None else size, _SMALLEST.get(kind, 1))
    width, height = (columns * (side + 1) - 1, rows * (side + 1) - 1) if walled else (columns, rows)
    if width * height > MAX_NODES:
        raise ColonysimError(f"{width} x {height} nodes are {width * height}, expected at most {MAX_NODES}")
    pitted = columns * rows > 1 if kind == "platforms" else holes > 0
    if depth is not None and not pitted:
        raise ColonysimError(f"depth {depth}: there are no holes in this world")
    filling = whole("depth", 1 if depth is None else depth)
    topology: dict[str, Any] = {"kind": "rooms" if walled else kind, "columns": columns, "rows": rows}
    stands: Stands = ([], [])
    if walled:
        topology |= {"size": side, "seed": seed}
    if kind == "geometric":
        topology = {"kind": kind, "nodes": columns * rows, "radius": 1.6, "apart": 0.5, "seed": seed}
        topology |= {"width": float(columns), "height": float(rows)}
    elif kind == "platforms":
        stands = _bridged(columns, rows, side, filling, spare, seed)
    else:
        cells = _cells(side, side, width, columns, rows) if walled else _cells(width, height, width, 1, 1)
        stands = _strewn(cells, width, holes, spare, filling, seed)
    crowd: dict[str, Any] = {"count": agents, "seed": seed}
    if kind == "platforms":
        crowd["within"] = [0, 0, side - 1, side - 1]
    document: dict[str, Any] = {
        "name": f"{kind}-{columns}x{rows}-s{seed}",
        "topology": topology,
        "holes": [{"node": node, "depth": filling * HEIGHT} for node in stands[0]],
        "boxes": [[node, HEIGHT] for node in stands[1]],
        "agents": crowd,
        "goal": width * height - 1,
        "max_steps": 50 + 6 * (width + height),
    }
    scenario = scenario_from_document(document, source=str(document["name"]))
    if crowded:
        corner = _corner(scenario)
        crowd["within"] = [0, 0, corner, corner]
        scenario_from_document(document, source=str(document["name"]))
    return document


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
        inwards = 1 if a // columns == b // columns else width
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


def _corner(scenario: Scenario) -> float:
    """The side of the smallest square in the corner at (0, 0) that has room for all agents, graph units."""
    x, y = scenario.topology.x, scenario.topology.y
    taken = {scenario.goal, *(hole.node for hole in scenario.holes), *(box.node for box in scenario.boxes)}
    free = sorted(max(x[node], y[node]) for node in range(len(x)) if node not in taken)
    return free[len(scenario.agents) - 1]


def to_yaml(document: dict[str, Any]) -> str:
    """A document as the text of a scenario file: a line for each field, hole and box."""
    lines = []
    for name, value in document.items():
        if isinstance(value, list):
            lines += [f"{name}:", *(f"  - {json.dumps(item)}" for item in value)] if value else []
        else:
            lines.append(f"{name}: {json.dumps(value)}")
    return "\n".join([*lines, ""])
