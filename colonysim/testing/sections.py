"""Random sections for random scenarios: a timeline, groups, faults and marks that spread, all of them at once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from colonysim.scenario.changes import CHANGES
from colonysim.testing.timelines import random_changes

if TYPE_CHECKING:
    import random
    from collections.abc import Collection

__all__ = ["add_sections"]

_DIFFUSIONS = ("distance_diffusion", "hole_diffusion", "exploration_diffusion")
_HALF_LIVES = ("distance_half_life", "hole_half_life", "box_half_life", "exploration_half_life")


def add_sections(
    rng: random.Random, document: dict[str, Any], *, kinds: Collection[str] = CHANGES, bodies: bool = False
) -> dict[str, Any]:
    """A scenario with `changes`, `groups`, `faults` and a `policy` whose marks fade and spread, all of them random.

    Args:
        rng: Source of every choice.
        document: The scenario as plain data, as `random_document` makes it.
        kinds: What the changes may do.
        bodies: Whether groups differ in `robot`, as they may on rigid bodies, instead of `speed`.
    """
    changed = {name: value for name, value in document.items() if name != "agents"}
    groups = _groups(rng, document["agents"], bodies=bodies)
    named = [group["name"] for group in groups if group.get("policy") != "random"]
    tunings = _tunings(rng, named) if "policy" in kinds else []
    return {
        **changed,
        "changes": [*random_changes(rng, document, kinds=kinds), *tunings],
        "groups": groups,
        "faults": _faults(rng),
        "policy": {"name": rng.choice(["colony", "paper", "oracle"]), **_marks(rng)},
    }


def _tunings(rng: random.Random, groups: list[str]) -> list[dict[str, Any]]:
    """Changes of the policies' parameters, for all agents or a group."""
    found: list[dict[str, Any]] = []
    for _ in range(rng.randint(0, 2)):
        given = rng.choice([{"beta": round(rng.uniform(0.0, 8.0), 2)}, {"epsilon": round(rng.random(), 2), "tries": 1}])
        change: dict[str, Any] = {"time": round(rng.uniform(0.0, 20.0), 2), "policy": given}
        if groups and rng.random() < 0.5:
            change["group"] = rng.choice(groups)
        else:
            change["policy"] = {**given, rng.choice(_HALF_LIVES): rng.choice([None, 15.0])}
        found.append(change)
    return found


def _groups(rng: random.Random, agents: list[int], *, bodies: bool) -> list[dict[str, Any]]:
    """One to three groups that share out the agents, in their order."""
    cuts = sorted(rng.sample(range(1, len(agents)), min(len(agents) - 1, rng.randint(0, 2))))
    found: list[dict[str, Any]] = []
    for n, (first, last) in enumerate(zip([0, *cuts], [*cuts, len(agents)], strict=True)):
        group: dict[str, Any] = {"name": f"group {n}", "agents": agents[first:last]}
        if rng.random() < 0.5:
            speed, robot = rng.choice([0.5, 1.5, 3.0]), rng.choice([{"wheel_speed": 5.0}, {"chassis_mass": 80.0}])
            group |= {"robot": robot} if bodies else {"speed": speed}
        if rng.random() < 0.5:
            group["detection_radius"] = rng.choice([1.5, 3.0, 20.0])
        if rng.random() < 0.3:
            group["pushes"] = False
        if rng.random() < 0.4:
            group["ignores"] = rng.sample(["D", "E", "H", "B"], rng.randint(1, 2))
        if rng.random() < 0.4:
            group["policy"] = rng.choice([{"beta": 1.0}, {"epsilon": 0.5, "patience": None}, "random"])
        found.append(group)
    return found


def _faults(rng: random.Random) -> dict[str, Any]:
    chosen: dict[str, Any] = {
        "move_fails": 0.1, "box_missed": 0.2, "node_misplaced": 0.3, "mark_lost": 0.2, "mark_noise": 0.2,
        "stops": {"every": 20.0, "seconds": 4.0},
    }  # fmt: skip
    kept = rng.sample(sorted(chosen), rng.randint(1, len(chosen)))
    return {"seed": rng.randrange(1000), **{name: chosen[name] for name in kept}}


def _marks(rng: random.Random) -> dict[str, Any]:
    spread = {name: rng.choice([0.1, 0.5, 1.0]) for name in rng.sample(_DIFFUSIONS, rng.randint(1, len(_DIFFUSIONS)))}
    fade = {name: rng.choice([2.0, 9.0, 40.0]) for name in _HALF_LIVES if rng.random() < 0.4}
    return {**spread, **fade, "diffusion_period": rng.choice([0.25, 1.0, 3.0])}
