"""Random timelines for random scenarios: for tests of whatever has to live with a place that changes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.arguments import whole
from colonysim.scenario.changes import CHANGES

if TYPE_CHECKING:
    import random
    from collections.abc import Collection

__all__ = ["random_changes"]


def random_changes(
    rng: random.Random,
    document: dict[str, Any],
    *,
    most: int = 6,
    seconds: float = 40.0,
    kinds: Collection[str] = CHANGES,
) -> list[dict[str, Any]]:
    """Random valid `changes:` for a scenario.

    Args:
        rng: Source of every choice.
        document: The scenario as plain data, with `nodes` listed as [id, x, y, z], as `random_document` makes it.
        most: Most changes.
        seconds: The latest time of a change, simulated seconds.
        kinds: What they may do; one of them at least that is always possible, so not only `add_box` and `remove_box`.
    """
    ids = [node[0] for node in document["nodes"]]
    holes = [hole["node"] if isinstance(hole, dict) else hole for hole in document["holes"]]
    ground = [node for node in ids if node not in holes]
    agents, boxes = len(document["agents"]), len(document["boxes"])
    goals, boxed = {document["goal"]}, set[int]()
    found: list[dict[str, Any]] = []
    for _ in range(rng.randint(1, whole("most", most))):
        options = ["add_edge", "remove_edge", "set_surface", "move_goal", "add_agent", "fail", "wipe"]
        options += [*(["add_box"] if len(goals) < len(ids) else []), *(["remove_box"] * bool(boxes))]
        kind = rng.choice([option for option in options if option in kinds])
        change: dict[str, Any] = {}
        if rng.random() < 0.8:
            change["time"] = round(rng.uniform(0.0, seconds), 2)
        if rng.random() < 0.3:
            change[rng.choice(["episode", "from_episode", "to_episode"])] = rng.randint(1, 3)
        if rng.random() < 0.3:
            conditions = [{"at_goal": rng.randint(1, agents)}, {"seated": rng.randint(1, 2)}]
            change["when"] = rng.choice([*conditions, *({"filled": hole} for hole in holes)])
        if kind == "add_edge":
            change[kind] = rng.sample(ids, 2)
        elif kind == "remove_edge":
            change[kind] = rng.choice(document["edges"])
        elif kind == "set_surface":
            node = rng.choice(document["nodes"])
            change[kind] = {"node": node[0], "z": round(node[3] - rng.choice([0.1, 0.35, 0.7]), 2)}
        elif kind == "move_goal":
            change[kind] = rng.choice([node for node in ground if node not in boxed] or [document["goal"]])
            goals.add(change[kind])
        elif kind == "add_agent":
            change[kind] = rng.choice(ground)
            agents += 1
        elif kind == "fail":
            change[kind] = {"agents": [rng.randrange(agents)]}
            if rng.random() < 0.5:
                change[kind]["seconds"] = round(rng.uniform(1.0, seconds), 2)
        elif kind == "wipe":
            change[kind] = rng.choice([{}, {"nodes": rng.sample(ids, 2)}, {"fields": ["D"]}])
        elif kind == "add_box":
            node = rng.choice([node for node in ids if node not in goals])
            change[kind] = {"node": node, "height": 0.35}
            boxed.add(node)
            boxes += 1
        else:
            change[kind] = rng.randrange(boxes)
        found.append(change)
    return found
