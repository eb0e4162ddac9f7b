"""The colonies that are timed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from colonysim.bench.brought import OwnBackend, OwnRule, OwnWalk, Subclass
from colonysim.scenario.invent import invent
from colonysim.scenario.loading import load_scenario, scenario_from_document

if TYPE_CHECKING:
    from colonysim.policies.policy import Policy
    from colonysim.scenario.scenario import Scenario

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
        policy: The policy; None for the scenario's own.
        backend: Makes the backend anew for each run; None for the node world as it comes.
        mode: The mode; None for the scenario's own.
        beside: The case on the same world that runs only what is built in, or "".
    """

    name: str
    about: str
    make: Callable[[], Scenario]
    episodes: int = 1
    traced: bool = False
    common: bool = True
    policy: Callable[[Scenario], Policy] | str | None = None
    backend: Callable[[], object] | None = None
    mode: str | None = None
    beside: str = ""

    @property
    def settings(self) -> dict[str, Any]:
        """What `simulate` and `run` are to be given beside the scenario."""
        backend = "nodeworld" if self.backend is None else self.backend()
        return {
            "policy": self.policy, "backend": backend, "mode": self.mode, "episodes": self.episodes, "seed": SEED,
        }  # fmt: skip


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


def _travel_1000() -> Scenario:
    return _empty(100, 100, 1000, 200)


def _with_a_field(scenario: Scenario) -> Scenario:
    """The same scenario with a field more, which writes nothing."""
    document = dict(scenario.document)
    return scenario_from_document({**document, "policy": {"extra_fields": ["colonysim.bench.brought:ExtraField"]}})


def _made(document: dict[str, Any], steps: int) -> Scenario:
    return scenario_from_document({**document, "max_steps": steps})


CASES: dict[str, Case] = {
    case.name: case
    for case in (
        Case("travel-10", "10 agents travel, 100 nodes", lambda: _empty(10, 10, 10, 1000), 300),
        Case("travel-1000", "1,000 agents travel, 10,000 nodes", _travel_1000),
        Case("travel-10000", "10,000 agents travel, 100,000 nodes", lambda: _empty(400, 250, 10_000, 60)),
        Case("boxes-50", "50 agents among 5 % boxes, 2,500 nodes", lambda: _boxes(50, 50, 100)),
        Case("boxes-1000", "1,000 agents among 5 % boxes, 10,000 nodes", lambda: _boxes(100, 1000, 20)),
        Case("crowd-10000", "10,000 agents start in one corner of 40,000 nodes, 5 % boxes",
             lambda: _boxes(200, 10_000, 3, crowded=True)),
        Case("hard", "the scenario hard", lambda: load_scenario("hard"), 30),
        Case("own-walk", "a ten-line random walk on travel-1000", _travel_1000, policy=OwnWalk, beside="travel-1000"),
        Case("own-rule", "a Python policy that follows D and E on travel-1000", _travel_1000, policy=OwnRule,
             beside="travel-1000"),
        Case("subclass", "a class derived from Colony, unchanged, on travel-1000", _travel_1000, policy=Subclass,
             beside="travel-1000"),
        Case("extra-field", "travel-1000 with a field more that writes nothing", lambda: _with_a_field(_travel_1000()),
             beside="travel-1000"),
        Case("extra-field-hard", "hard with a field more that writes nothing",
             lambda: _with_a_field(load_scenario("hard")), 30, beside="hard"),
        Case("own-backend", "a class derived from the node world, unchanged, on travel-1000", _travel_1000,
             backend=OwnBackend, beside="travel-1000"),
        Case("paper", "the preset paper on travel-1000", _travel_1000, policy="paper", beside="travel-1000"),
        Case("synchronous", "travel-1000, all deciding at once", _travel_1000, mode="synchronous",
             beside="travel-1000"),
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
