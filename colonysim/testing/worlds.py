"""Random small scenarios that can be solved as far as a check can tell: for tests of policies and backends."""

from __future__ import annotations

import random
from typing import TYPE_CHECKING, Any

from colonysim.arguments import as_seed, whole
from colonysim.scenario.loading import scenario_from_document

if TYPE_CHECKING:
    from colonysim.scenario.scenario import Scenario

__all__ = ["random_document", "random_scenario"]

_BOX = 0.35
_RISE = 0.5


def random_scenario(seed: int, *, max_nodes: int = 12, max_agents: int = 4, max_holes: int = 3) -> Scenario:
    """A random valid scenario; the same seed gives the same one on any machine.

    Args:
        seed: Seed of everything in it.
        max_nodes: Most nodes, at least 4.
        max_agents: Most agents, at least 1.
        max_holes: Most holes.
    """
    seed = as_seed(seed)
    document = random_document(random.Random(seed), max_nodes=max_nodes, max_agents=max_agents, max_holes=max_holes)
    document["name"] = f"random-{seed}"
    return scenario_from_document(document, source=f"random_scenario({seed})")


def random_document(
    rng: random.Random, *, max_nodes: int = 12, max_agents: int = 4, max_holes: int = 3
) -> dict[str, Any]:
    """A random scenario as plain data, with everything that the format can say of a small place.

    The graph is connected; a slope may part it into two levels; no hole lacks the boxes to fill it,
    though they may have to be shared with other holes, or stand behind it.

    Args:
        rng: Source of every choice.
        max_nodes: Most nodes, at least 4.
        max_agents: Most agents, at least 1.
        max_holes: Most holes.
    """
    max_nodes, max_agents = whole("max_nodes", max_nodes, 4), whole("max_agents", max_agents)
    max_holes = whole("max_holes", max_holes, 0)
    count = rng.randint(4, max_nodes)
    ids = rng.sample(range(3 * count), count) if rng.random() < 0.3 else list(range(count))
    points = _points(rng, count)
    edges, upper, slope = _edges(rng, count, points)
    heights = [1.0 + (_RISE if i in upper else 0.0) for i in range(count)]

    order = list(range(count))
    rng.shuffle(order)
    goal = order.pop()
    agents = [order.pop() for _ in range(rng.randint(1, max(1, min(max_agents, count - 3))))]
    holes: list[tuple[int, int]] = []
    boxes: list[int] = []
    for _ in range(rng.randint(0, max_holes)):
        deep = rng.choice((1, 1, 1, 2))
        lacking = max(0, deep - len(boxes))
        node = next((node for node in order if node not in slope), None)
        if node is None or lacking >= len(order):
            break
        order.remove(node)
        boxes += [order.pop() for _ in range(lacking)]
        holes.append((node, deep))
    boxes += [order.pop() for _ in range(min(rng.randint(0, 2), len(order)))]

    listed: list[Any] = []
    for node, deep in holes:
        depth = round(deep * _BOX, 2)
        others = [b if a == node else a for a, b in edges if node in (a, b)]
        rimmed = any(other not in dict(holes) for other in others)
        if rimmed and rng.random() < 0.5:
            heights[node] = round(heights[node] - depth, 2)
            listed.append(ids[node])
        else:
            listed.append({"node": ids[node], "depth": depth})
    directed = [pair for edge in edges for pair in (edge, edge[::-1])]
    forbidden = rng.sample(directed, rng.randint(0, 2)) if rng.random() < 0.3 else []
    return {
        "name": "random",
        "nodes": [[ids[i], *points[i], heights[i]] for i in range(count)],
        "edges": [[ids[i], ids[j]] for i, j in edges],
        "slopes": [[ids[i] for i in slope]] if slope else [],
        "holes": listed,
        "boxes": [[ids[node], _BOX] for node in boxes],
        "agents": [ids[node] for node in agents],
        "goal": ids[goal],
        "no_push": [[ids[i], ids[j]] for i, j in forbidden],
        "detection_radius": rng.choice((1.5, 3.0, 20.0)),
        "max_steps": rng.randint(10, 40),
        "episodes": 3,
        "timing": {"push": rng.choice((1.0, 3.0)), "jitter": rng.choice((0.0, 0.1))},
    }


def _points(rng: random.Random, count: int) -> list[tuple[float, float]]:
    """Distinct positions, about one graph unit apart."""
    columns = rng.randint(1, count)
    return [
        (round(i % columns + rng.randint(-20, 20) / 100, 2), round(i // columns + rng.randint(-20, 20) / 100, 2))
        for i in range(count)
    ]


def _edges(
    rng: random.Random, count: int, points: list[tuple[float, float]]
) -> tuple[list[tuple[int, int]], set[int], tuple[int, ...]]:
    """Edges of a connected graph, the nodes of its upper level, and the slope between the levels, if any."""
    tree: list[tuple[int, int]] = []
    for j in range(1, count):
        near = sorted(range(j), key=lambda i: (_square(points[i], points[j]), i))
        tree.append((rng.choice(near[:2]), j))
    upper: set[int] = set()
    slope: tuple[int, ...] = ()
    if rng.random() < 0.3:
        slope = rng.choice(tree)
        upper = {slope[1]}
        for i, j in tree:
            if i in upper:
                upper.add(j)
    # Further edges stay on one level: across, they would be cliffs that only look like ways.
    further = [
        (i, j)
        for i in range(count)
        for j in range(i + 1, count)
        if (i, j) not in tree and (i in upper) == (j in upper) and _square(points[i], points[j]) < 3
    ]
    return tree + rng.sample(further, rng.randint(0, len(further) // 2)), upper, slope


def _square(a: tuple[float, float], b: tuple[float, float]) -> float:
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2
