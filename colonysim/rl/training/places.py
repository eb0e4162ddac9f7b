"""The places that policies are trained, tested and judged on: small invented worlds, none of which serves twice."""

from __future__ import annotations

import random
from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError
from colonysim.learning.seeds import Purpose
from colonysim.scenario.invent import invent
from colonysim.scenario.loading import scenario_from_document

if TYPE_CHECKING:
    from colonysim.scenario.invent import Kind
    from colonysim.scenario.scenario import Scenario

__all__ = ["KINDS", "place"]

KINDS: tuple[Kind, ...] = ("grid", "rooms", "platforms")
"""The kinds of worlds with holes and boxes."""
_APART = 100_000
"""More places than are ever made for one purpose."""


def place(purpose: Purpose, number: int) -> Scenario:
    """A small world with 3 to 6 agents, 1 to 4 holes and 33 to 104 nodes; the kinds take turns.

    Sizes are drawn until `invent` accepts them. An episode ends after as many travelled edges' time as an agent may
    begin steps, so that one which fails takes as long as it could.

    Args:
        purpose: `TRAIN`, `TUNE` (tests while training, and choices) or `JUDGE` (figures that are quoted).
        number: Which one, from 0.
    """
    seed = int(purpose) * _APART + number
    rng = random.Random(f"place/{seed}")
    kind = KINDS[number % len(KINDS)]
    while True:
        try:
            document = invent(kind, **_asked(kind, rng), seed=seed)
        except ColonysimError:
            continue
        return scenario_from_document({**document, "time_limit": float(document["max_steps"])})


def _asked(kind: Kind, rng: random.Random) -> dict[str, Any]:
    """Sizes of a world."""
    asked: dict[str, Any] = {"agents": rng.randint(3, 6), "spare": rng.randint(0, 2), "depth": rng.randint(1, 2)}
    if kind == "grid":
        return asked | {"columns": rng.randint(5, 10), "rows": rng.randint(4, 8), "holes": rng.randint(1, 3)}
    asked |= {"columns": rng.randint(1, 2), "rows": 2, "size": rng.randint(3, 5)}
    return asked | ({"holes": rng.randint(1, 2)} if kind == "rooms" else {})
