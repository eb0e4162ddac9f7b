"""Random maps of two levels with ramps and holes, and what their ground really is, measured on its slabs."""

from __future__ import annotations

import math
import random
from typing import Any

from colonysim.errors import ScenarioError
from colonysim.physics.shapes import Slab
from colonysim.scenario.loading import scenario_from_document
from colonysim.scenario.scenario import Scenario

Cell = tuple[int, int]
_AROUND = ((1, 0), (0, 1), (-1, 0), (0, -1))

FOOT: dict[str, Any] = {
    "name": "foot",
    "nodes": [
        *([{14: 8, 8: 14}.get(7 * row + column, 7 * row + column), 1.5 * column, 1.5 * row, 1.5]
          for row in range(5) for column in range(7)),
        [40, -1.5, 3, 1], [41, -1.5, 1.5, 1], [42, -1.5, 4.5, 1], [43, -3, 3, 1],
    ],
    "edges": {"radius": 1.51},
    "slopes": [[40, 8]],
    "holes": [{"node": 4, "depth": 0.35}, {"node": 5, "depth": 0.35}, {"node": 31, "depth": 0.7}],
    "boxes": [[16, 0.35], [17, 0.35], [10, 0.35], [41, 0.35]],
    "agents": [43, 42],
    "goal": 6,
}  # fmt: skip
"""39 nodes, two levels: the lower one lies along the foot of its ramp, and two pits are 2.4 m apart."""


def level_map(seed: int) -> Scenario:
    """A map that the node world accepts: blobs of nodes on two levels, side by side, joined by one to three ramps.

    Any node may lie beside a ramp, level with its foot or its top; outlines are ragged, most maps are turned.
    """
    draw = random.Random(seed)
    while True:
        try:
            return scenario_from_document(_document(draw, seed))
        except ScenarioError:  # an agent is cut off, or there is no room for what stands there
            continue


def _document(draw: random.Random, seed: int) -> dict[str, Any]:
    spacing = draw.uniform(1.0, 1.9)
    low = _blob(draw, {(0, 0)}, set(), draw.randint(3, 14))
    beside = [(cell, ahead) for cell in sorted(low) for ahead in _next_to(cell) if ahead not in low]
    foot, top = draw.choice(beside)
    high = _blob(draw, {top}, low, draw.randint(3, 16))
    ramps = {(foot, top)}
    meeting = [(a, b) for a in sorted(low) for b in _next_to(a) if b in high]
    for _ in range(draw.choice((0, 0, 1, 2))):
        pair = draw.choice(meeting)
        ends = {end for ramp in ramps for end in ramp}
        if not ends & set(pair):
            ramps.add(pair)
    cells = sorted(low | high)
    ids = dict(zip(cells, draw.sample(range(100), len(cells)), strict=True))
    turn = draw.choice((0.0, 0.0, math.pi / 2, draw.uniform(-math.pi, math.pi), draw.uniform(-math.pi, math.pi)))
    c, s, shake = math.cos(turn), math.sin(turn), draw.choice((0.0, 0.0, 0.08)) * spacing
    rise = draw.uniform(0.35, 0.6)
    nodes = []
    for x, y in cells:
        u, v = spacing * x + draw.uniform(-shake, shake), spacing * y + draw.uniform(-shake, shake)
        nodes.append([ids[x, y], round(c * u - s * v, 3), round(s * u + c * v, 3), 1.0 + rise * ((x, y) in high)])
    edges = [
        [ids[a], ids[b]]
        for a in cells
        for b in _next_to(a)
        if a < b and b in ids and ((a in low) == (b in low) or (a, b) in ramps or (b, a) in ramps)
    ]
    if draw.random() < 0.2:
        corners = [(a, (a[0] + 1, a[1] + d)) for a in cells for d in (-1, 1)]
        edges += [[ids[a], ids[b]] for a, b in corners if b in ids and (a in low) == (b in low)]
    ends = {end for ramp in ramps for end in ramp}
    others = [cell for cell in cells if cell not in ends]
    draw.shuffle(others)
    places = [ids[cell] for cell in others]
    holes, places = places[: draw.randint(0, 3)], places[3:]
    boxes, places = places[: draw.randint(len(holes), 4)], places[4:]
    places += [ids[cell] for cell in sorted(ends)]
    return {
        "name": f"levels-{seed}",
        "nodes": nodes,
        "edges": edges,
        "slopes": [[ids[a], ids[b]] for a, b in sorted(ramps)],
        "holes": [{"node": node, "depth": draw.choice((0.35, 0.35, 0.7))} for node in holes],
        "boxes": [[node, 0.35] for node in boxes],
        "agents": places[1 : 1 + draw.randint(1, 3)],
        "goal": places[0],
    }


def _next_to(cell: Cell) -> list[Cell]:
    return [(cell[0] + dx, cell[1] + dy) for dx, dy in _AROUND]


def _blob(draw: random.Random, start: set[Cell], taken: set[Cell], size: int) -> set[Cell]:
    """Cells that hang together, `taken` ones left out."""
    cells = set(start)
    while len(cells) < size:
        border = sorted({n for cell in cells for n in _next_to(cell)} - cells - taken)
        if not border:
            break
        cells.add(draw.choice(border))
    return cells


def face(slab: Slab, x: float, y: float) -> float:
    """Height of a slab's upper face at a place, minus infinity beside it."""
    c, s, slope = math.cos(slab.yaw), math.sin(slab.yaw), slab.slope
    cp, sp = math.cos(slope), math.sin(slope)
    # The middle of the upper face, and from there along the face.
    u = c * (x - slab.centre[0]) + s * (y - slab.centre[1]) + sp * slab.half[2]
    v = -s * (x - slab.centre[0]) + c * (y - slab.centre[1])
    if abs(u) > cp * slab.half[0] + 1e-9 or abs(v) > slab.half[1] + 1e-9:
        return -math.inf
    return float(slab.centre[2] + cp * slab.half[2] + u * sp / cp)
