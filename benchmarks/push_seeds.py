"""Training the push from nothing with several seeds, and which of the networks is best.

A chain is as strong as its weakest push: the seed whose network has the largest least success on tuning pushes wins,
over `rl` and one try of `staged` on each terrain, and `staged` into pits two boxes deep; of equals the one with the
larger mean. One try with boxes at any angle before their pit is measured besides. `--ship` writes the network, its card
telling of all seeds. Trainings that are there already are not repeated, those that were stopped go on.

    python benchmarks/push_seeds.py --seeds 0 1 2 --workers 2 --work runs/push-seeds --ship colonysim/push/models
"""

import argparse
import json
import os
import sys
from functools import partial
from pathlib import Path
from statistics import fmean
from typing import Any

from push_pits import into_pits

from colonysim.files import replace_file
from colonysim.learning.cards import load_model, save_model
from colonysim.learning.seeds import Purpose
from colonysim.processes import results
from colonysim.push.executors import ExecutorName
from colonysim.push.training.evaluation import evaluate_push
from colonysim.push.training.trainer import train_push

TUNING_SEED = 20
PUSHES: tuple[ExecutorName, ...] = ("rl", "staged")


def measure(task: tuple[int, int, Path]) -> dict[str, Any]:
    """Train one seed and push with it so often; the row is kept beside the network."""
    seed, pushes, work = task
    folder = work / f"s{seed}"
    if (folder / "tuning.json").exists():
        kept: dict[str, Any] = json.loads((folder / "tuning.json").read_text(encoding="utf-8"))
        if kept["pushes"] == pushes:
            return kept
    if not (folder / "push.json").exists():
        train_push("improved", folder, seed, resume=True)
    card = load_model(folder / "push.json", "q-network").card
    row: dict[str, Any] = {
        "seed": seed, "sha256": card["sha256"], "cpu_seconds": card["how"]["cpu_seconds"], "pushes": pushes,
    }  # fmt: skip
    tune = partial(
        evaluate_push, episodes=pushes, seed=TUNING_SEED, tries=1, model=folder / "push.json", purpose=Purpose.TUNE
    )
    for push in PUSHES:
        row[push] = {kind: found["success"] for kind, found in tune(push).items()}
    pits = partial(into_pits, pushes, TUNING_SEED, model=folder / "push.json")
    row["askew"] = pits(starts="askew", tries=1)["done"] / pushes
    row["deep_pits"] = pits(boxes=2)["done"] / pushes
    shares = [*(share for push in PUSHES for share in row[push].values()), row["deep_pits"]]
    row["least"], row["mean"] = min(shares), round(fmean(shares), 4)
    replace_file(folder / "tuning.json", (json.dumps(row, indent=1) + "\n").encode())
    return row


def best_of(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """The row of the network that ships."""
    return max(rows, key=lambda row: (float(row["least"]), float(row["mean"])))


def ship(rows: list[dict[str, Any]], work: Path, out: Path) -> None:
    """Write the best seed's network to `out`, with how all of them did."""
    best = best_of(rows)
    model = load_model(work / f"s{best['seed']}" / "push.json", "q-network")
    card = {key: part for key, part in model.card.items() if key not in ("format", "kind", "arrays", "sha256")}
    card["how"]["command"] = f"python {' '.join(sys.argv)}"
    card["how"]["rule"] = "of these trainings the one with the largest least success on tuning pushes"
    card["results"]["trainings"] = {"tuning_seed": TUNING_SEED, "rows": rows}
    save_model(out / "push.npz", "q-network", model.arrays, card)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    parser.add_argument("--pushes", type=int, default=300, help="tuning pushes a terrain and executor")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--work", type=Path, default=Path("runs/push-seeds"))
    parser.add_argument("--ship", type=Path, help="folder that the best network is written to")
    given = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    rows = []
    tasks = [(seed, given.pushes, given.work) for seed in given.seeds]
    for _, row in results(measure, tasks, given.workers, fresh=True):
        rows.append(row)
        print(row, flush=True)
    rows.sort(key=lambda row: given.seeds.index(row["seed"]))
    print(f"best: seed {best_of(rows)['seed']}")
    if given.ship is not None:
        ship(rows, given.work, given.ship)


if __name__ == "__main__":
    main()
