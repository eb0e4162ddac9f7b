"""What fading and spreading marks cost a step on 100,000 nodes, beside the same colony without them.

Both colonies run in turn, in one process; printed are the median over rounds of the CPU time of a step with them over
that without, and the smallest and largest. In the first rows nobody looks at E: with `epsilon: 0` agents follow D.

Run with: python benchmarks/spreading.py [rounds] [agents] [steps] [--json]
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from typing import TYPE_CHECKING, Any

import colonysim
from colonysim.scenario.invent import invent

if TYPE_CHECKING:
    from colonysim.scenario.scenario import Scenario

FADES = {f"{name}_half_life": 30.0 for name in ("distance", "box", "hole", "exploration")}
UNSEEN: dict[str, Any] = {"epsilon": 0.0, "epsilon_floor": 0.0, "restless": None}
CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "E fades and spreads, nobody looks": (UNSEEN, {"exploration_half_life": 30.0, "exploration_diffusion": 0.5}),
    "E spreads, nobody looks": (UNSEEN, {"exploration_diffusion": 0.5}),
    "E fades, nobody looks": (UNSEEN, {"exploration_half_life": 30.0}),
    "all fade, D is looked at": (UNSEEN, FADES),
    "E fades and spreads, explorers look": ({}, {"exploration_half_life": 30.0, "exploration_diffusion": 0.5}),
    "D spreads and is looked at": (UNSEEN, {"distance_diffusion": 0.5}),
}


def seconds(scenario: Scenario) -> tuple[float, int]:
    """CPU seconds and steps of an episode, without the time that it takes to begin."""
    colony = colonysim.Colony(scenario, seed=1, episodes=1)
    colony.run_until(time=0.0)
    begin, before = time.process_time(), int(colony.agents.steps.sum())
    colony.run_until(episode=1)
    return time.process_time() - begin, int(colony.agents.steps.sum()) - before


def main() -> None:
    numbers = [int(word) for word in sys.argv[1:] if word.isdigit()]
    rounds, agents, steps = (*numbers, *(5, 1000, 100)[len(numbers) :])
    document = invent("grid", columns=400, rows=250, agents=agents, seed=1)
    document["max_steps"] = steps
    found = {}
    for name, (both, more) in CASES.items():
        scenarios = [
            colonysim.scenario_from_document({**document, "policy": policy}) for policy in (both, {**both, **more})
        ]
        ratios, costs = [], []
        for _ in range(rounds):
            (plain, count), (marked, other) = (seconds(scenario) for scenario in scenarios)
            ratios.append(marked / other / (plain / count))
            costs.append(plain / count * 1e6)
        found[name] = {"ratio": statistics.median(ratios), "least": min(ratios), "most": max(ratios)}
        cost = statistics.median(costs)
        print(f"{name:38s} {statistics.median(ratios):6.3f} ({min(ratios):.3f} to {max(ratios):.3f}) of {cost:.1f} us")
    if "--json" in sys.argv:
        print(json.dumps({"agents": agents, "steps": steps, "rounds": rounds, "cases": found}))


if __name__ == "__main__":
    main()
