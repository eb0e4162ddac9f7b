"""Chains of nodes and a hole, with turns of 0, 45 and 90 degrees: does one push prepare the next?

python benchmarks/push_chains.py --chains 300 --tries 8 --rows staged --seed 0
python benchmarks/push_chains.py --chains 100 --nodes 5 --rows staged rl --seed 0 --out push_chains.json
"""

import argparse
import json
from pathlib import Path
from typing import Any

from colonysim.physics import ENGINES, default_engine, engine_version
from colonysim.push.executors import ChooserName, ExecutorName, make_executor
from colonysim.push.feasibility import load_feasibility
from colonysim.push.training.chains import evaluate_chains

ROWS: dict[str, tuple[ExecutorName, ChooserName, bool]] = {
    "staged": ("staged", "network", False),
    "staged, Push In": ("staged", "push-in", False),
    "staged, random weights": ("staged", "random-weights", False),
    "scripted": ("scripted", "network", False),
    "rl": ("rl", "network", True),
    "rl, no gate": ("rl", "network", False),
}
"""Executor, what chooses, and whether the feasibility classifier says where a push begins."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--chains", type=int, default=100)
    parser.add_argument("--nodes", type=int, default=2, help="nodes before the hole")
    parser.add_argument("--tries", type=int, default=3, help="tries of each target")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--rows", nargs="*", default=list(ROWS), choices=list(ROWS))
    parser.add_argument("--model", default=None, help="a shipped network's name or the path of a card")
    parser.add_argument("--engine", default=None, choices=ENGINES, help="by default the first that is installed")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    engine = given.engine or default_engine()
    found: dict[str, Any] = {
        "engine": engine_version(engine), "nodes": given.nodes, "tries": given.tries, "seed": given.seed, "rows": {},
    }  # fmt: skip
    for name in given.rows:
        push, chooser, gated = ROWS[name]
        gate = load_feasibility() if gated else None
        executor = make_executor(push, model=given.model, chooser=chooser, tries=given.tries, gate=gate)
        row = evaluate_chains(executor, chains=given.chains, nodes=given.nodes, seed=given.seed, engine=engine)
        found["rows"][name] = row
        print(
            f"{name}: {row['success']:.3f} [{row['success_low']:.3f}, {row['success_high']:.3f}] of {row['chains']}, "
            f"nodes {row['nodes']:.3f}, error {row['error_median']:.3f} (p95 {row['error_p95']:.3f}) m, "
            f"{row['pushes_mean']:.1f} pushes, {row['seconds_mean']:.0f} s; {row['reasons']}",
            flush=True,
        )
        if given.out is not None:
            given.out.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
