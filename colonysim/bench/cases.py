"""The colonies that are timed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from colonysim.world.invent import invent
from colonysim.world.loading import load_scenario, scenario_from_document

if TYPE_CHECKING:
    from colonysim.world.scenario import Scenario

__all__ = ["CASES", "Case"]

SEED = 1
SHARE_OF_BOXES = 0.05


@dataclass(frozen=True, slots=True)
class Case:
    """A colony to be timed.

    Attributes:
        name: What `colonysim bench` calls it.
        about: What it shows.
        make: Builds the scenario, which is not timed.
        episodes: How many.
        traced: Whether the whole trace is written to disk, as `colonysim run` does.
        common: Whether it runs unless other cases are asked for by name.
    """

    name: str
    about: str
    make: Callable[[], Scenario]
    episodes: int = 1
    traced: bool = False
    common: bool = True


def _empty(columns: int, rows: int, agents: int, steps: int) -> Scenario:
    """Level ground, and nothing in anybody's way but each other."""
    return _made(invent("grid", columns=columns, rows=rows, agents=agents, seed=SEED), steps)


def _boxes(side: int, agents: int, steps: int, *, crowded: bool = False) -> Scenario:
    """Level ground with boxes on one node in twenty, one in five of them with a hole to fill."""
    boxes = round(SHARE_OF_BOXES * side * side)
    holes = boxes // 5
    document = invent(
        "grid", columns=side, rows=side, holes=holes, spare=boxes - holes, agents=agents, crowded=crowded, seed=SEED
    )
    return _made(document, steps)


def _made(document: dict[str, Any], steps: int) -> Scenario:
    return scenario_from_document({**document, "max_steps": steps})


CASES: dict[str, Case] = {
    case.name: case
    for case in (
        Case("travel-10", "10 agents travel, 100 nodes", lambda: _empty(10, 10, 10, 1000), 300),
        Case("travel-1000", "1,000 agents travel, 10,000 nodes", lambda: _empty(100, 100, 1000, 200)),
        Case("travel-10000", "10,000 agents travel, 100,000 nodes", lambda: _empty(400, 250, 10_000, 60)),
        Case("boxes-50", "50 agents among 5 % boxes, 2,500 nodes", lambda: _boxes(50, 50, 100)),
        Case("boxes-1000", "1,000 agents among 5 % boxes, 10,000 nodes", lambda: _boxes(100, 1000, 20)),
        Case("crowd-10000", "10,000 agents start in one corner of 40,000 nodes, 5 % boxes",
             lambda: _boxes(200, 10_000, 3, crowded=True)),
        Case("hard", "the scenario hard", lambda: load_scenario("hard"), 30),
        Case("traced", "travel-1000 with the whole trace on disk", lambda: _empty(100, 100, 1000, 50), traced=True),
        Case("million", "100,000 agents travel, 1,000,000 nodes", lambda: _empty(1000, 1000, 100_000, 10),
             common=False),
        Case("steps-1000", "1,000 steps with the trace on disk", lambda: _empty(10, 10, 10, 1000), 8,
             traced=True, common=False),
        Case("steps-100000", "100,000 steps with the trace on disk", lambda: _empty(10, 10, 10, 1000), 800,
             traced=True, common=False),
    )
}  # fmt: skip
"""By name, in the order of the table."""
