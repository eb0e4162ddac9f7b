"""Single pushes from the frozen start distribution: success and reward by terrain, with what ablates learning.

Every row is 200 episodes a terrain by default; intervals are Wilson's, 95 %.

    python benchmarks/push_single.py --episodes 200 --seed 0 --out push_single.json
"""

import argparse
import json
from pathlib import Path
from typing import Any

from colonysim.physics import ENGINES, default_engine, engine_version
from colonysim.push.executors import ChooserName, ExecutorName
from colonysim.push.training.evaluation import evaluate_push
from colonysim.push.training.starts import KINDS

ROWS: dict[str, tuple[ExecutorName, ChooserName, int]] = {
    "rl": ("rl", "network", 1),
    "staged": ("staged", "network", 8),
    "scripted": ("scripted", "network", 8),
    "staged, one try": ("staged", "network", 1),
    "staged, one try, random weights": ("staged", "random-weights", 1),
    "staged, one try, Push In": ("staged", "push-in", 1),
    "staged, random weights": ("staged", "random-weights", 8),
    "staged, Push In": ("staged", "push-in", 8),
    "rl, random weights": ("rl", "random-weights", 1),
    "rl, Push In": ("rl", "push-in", 1),
}
"""Executor, what chooses in the network's place, tries within the step limit."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rows", nargs="*", default=list(ROWS), choices=list(ROWS))
    parser.add_argument("--terrains", nargs="+", default=list(KINDS), choices=list(KINDS))
    parser.add_argument("--model", default=None, help="a shipped network's name or the path of a card")
    parser.add_argument("--engine", default=None, choices=ENGINES, help="by default the first that is installed")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    engine = given.engine or default_engine()
    found: dict[str, Any] = {
        "engine": engine_version(engine), "episodes": given.episodes, "seed": given.seed, "rows": {},
    }  # fmt: skip
    for name in given.rows:
        push, chooser, tries = ROWS[name]
        row = evaluate_push(
            push, episodes=given.episodes, seed=given.seed, terrains=given.terrains, chooser=chooser, tries=tries,
            model=given.model, engine=engine,
        )  # fmt: skip
        found["rows"][name] = row
        shares = [
            f"{kind} {r['success']:.3f} [{r['success_low']:.3f}, {r['success_high']:.3f}] "
            f"reward {r['reward_mean']:.2f} ± {r['reward_sd']:.2f}"
            for kind, r in row.items()
        ]
        print(f"{name}: " + "; ".join(shares), flush=True)
        if given.out is not None:
            given.out.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
