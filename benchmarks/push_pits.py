"""Single pushes of `staged` into pits: whether the box lies flat in the end.

From any start distribution and into pits of any depth; in deep ones boxes lean and tumble, and boxes that stand askew
have to turn before they drop. Wilson's interval, 95 %.

    python benchmarks/push_pits.py --boxes 2 --pushes 150 --seed 20
    python benchmarks/push_pits.py --starts askew --tries 1 --pushes 150 --seed 20
"""

import argparse
import dataclasses
from collections import Counter
from pathlib import Path

from colonysim.intervals import wilson
from colonysim.learning.seeds import Purpose
from colonysim.physics import Terrain
from colonysim.push.executors import make_executor
from colonysim.push.paths import everything_else
from colonysim.push.task import run_alone
from colonysim.push.training.evaluation import judged_start
from colonysim.push.training.starts import Start, start_names


def deepened(start: Start, boxes: int) -> Start:
    """The same push into a pit so many boxes deep."""
    terrain = start.terrain
    pits = [dataclasses.replace(pit, depth=boxes * start.box.height) for pit in terrain.pits]
    return dataclasses.replace(start, terrain=Terrain(terrain.grounds, tuple(pits), terrain.ramps))


def into_pits(
    pushes: int, seed: int, *, starts: str = "push", boxes: int = 0, tries: int = 8, model: str | Path | None = None
) -> Counter[str]:
    """How so many pushes ended: `done` where the box lies flat."""
    executor = make_executor("staged", model=model, tries=tries)
    reasons: Counter[str] = Counter()
    for i in range(pushes):
        start, drawn = judged_start("hole", i, seed=seed, starts=starts, purpose=Purpose.TUNE)
        if boxes:
            start = deepened(start, boxes)
        with start.scene() as scene:
            manoeuvre = executor(scene, 0, start.task, everything_else(scene, 0), seed=drawn)
            reasons[run_alone(scene, 0, manoeuvre).reason] += 1
    return reasons


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pushes", type=int, default=150)
    parser.add_argument("--seed", type=int, default=20)
    parser.add_argument("--starts", default="push", choices=start_names())
    parser.add_argument("--boxes", type=int, default=0, help="boxes that fill a pit; 0: as it is drawn")
    parser.add_argument("--tries", type=int, default=8)
    parser.add_argument("--model", default=None, help="a shipped network's name or the path of a card")
    given = parser.parse_args()
    reasons = into_pits(
        given.pushes, given.seed, starts=given.starts, boxes=given.boxes, tries=given.tries, model=given.model
    )
    low, high = wilson(reasons["done"], given.pushes)
    print(f"{reasons['done']} of {given.pushes} [{low:.3f}, {high:.3f}]; {dict(reasons)}")


if __name__ == "__main__":
    main()
