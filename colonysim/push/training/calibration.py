"""Fits `WayChance`, the chance of each push along a box's way, to logged pushes, and tests its calibration."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from colonysim import __version__
from colonysim.arguments import as_seed, whole
from colonysim.errors import MissingExtraError
from colonysim.installing import install_command
from colonysim.intervals import wilson
from colonysim.learning.cards import check_place, load_model, save_model
from colonysim.physics import default_engine, engine_version
from colonysim.push.foresight import Features
from colonysim.push.training.waylogs import LoggedWay, gather_ways
from colonysim.push.way import WayChance

__all__ = ["calibration_curve", "false_accepts", "fit_way_chance", "train_way_chance"]

ACCEPTED = 0.5
"""The policy's default: a push below this chance is not tried."""
_EDGES = (0.0, 0.05, 0.2, 0.5, 0.8, 0.9, 0.95, 1.0)
"""Most pushes are all but safe or hopeless: the bins are finer there."""
_FOLDS = 5
_STRENGTH = 10.0
Floats = npt.NDArray[np.float64]
Truths = npt.NDArray[np.bool_]


def fit_way_chance(ways: Sequence[LoggedWay]) -> WayChance:
    """Fits the regression to every push that was begun, as it was foreseen and as it was seen right before it.

    What was foreseen counts because the chance of a way is to be told before its first push: each factor of the
    product is the chance of a push given that those before it succeeded, which is what these rows hold.

    Raises:
        MissingExtraError: scikit-learn is not installed.
        ValueError: All pushes ended alike.
    """
    try:
        from sklearn.linear_model import LogisticRegression
    except ImportError as error:
        raise MissingExtraError(
            f"fitting the chance of a way needs scikit-learn ({error}): {install_command('train')}"
        ) from error
    rows: list[Features] = []
    outcomes: list[bool] = []
    for way in ways:
        for number, (foreseen, push) in enumerate(zip(way.foreseen, way.pushes, strict=False)):
            # The first push is foreseen as it is seen.
            for features in (push.seen, foreseen) if number else (push.seen,):
                rows.append(features)
                outcomes.append(push.success)
    if len(set(outcomes)) < 2:
        raise ValueError(f"all {len(outcomes)} pushes ended alike, so there is nothing to fit")
    inputs = np.array(rows, dtype=np.float64)
    spread = inputs.std(axis=0)
    spread[spread == 0.0] = 1.0
    fitted = LogisticRegression(C=_STRENGTH, max_iter=1000).fit(inputs / spread, outcomes)
    return WayChance(tuple(float(w) for w in fitted.coef_[0] / spread), float(fitted.intercept_[0]))


def calibration_curve(chances: Floats, outcomes: Truths) -> list[dict[str, float]]:
    """What was foretold against what came: for each bin its mean chance, the share of successes and their interval.

    Args:
        chances: Shape (n,).
        outcomes: Shape (n,).

    Returns:
        Bins that are not empty: `low`, `high`, `n`, `chance`, `success`, `success_low`, `success_high` (Wilson, 95 %).
    """
    bins = np.clip(np.searchsorted(_EDGES, chances, side="right") - 1, 0, len(_EDGES) - 2)
    curve = []
    for i in range(len(_EDGES) - 1):
        inside = bins == i
        n, wins = int(inside.sum()), int(outcomes[inside].sum())
        if n:
            low, high = wilson(wins, n)
            curve.append({
                "low": _EDGES[i], "high": _EDGES[i + 1], "n": n, "chance": round(float(chances[inside].mean()), 4),
                "success": round(wins / n, 4), "success_low": round(low, 4), "success_high": round(high, 4),
            })  # fmt: skip
    return curve


def false_accepts(accepted: Truths, outcomes: Truths) -> dict[str, Any]:
    """How often what would fail is accepted, and what would succeed refused.

    Args:
        accepted: Shape (n,).
        outcomes: Shape (n,).

    Returns:
        `failed` and `succeeded` (counts), `false_accept` (share of the failed that were accepted) and `false_refuse`
        (share of the succeeded that were not), each with its Wilson interval as `..._interval`, and `accepted`, how
        many were, with `accepted_success`, the share of them that succeeded.
    """
    failed, succeeded = int((~outcomes).sum()), int(outcomes.sum())
    let, kept = int((accepted & ~outcomes).sum()), int((~accepted & outcomes).sum())
    taken = int(accepted.sum())
    return {
        "failed": failed,
        "succeeded": succeeded,
        "false_accept": round(let / failed, 4) if failed else None,
        "false_accept_interval": [round(end, 4) for end in wilson(let, failed)],
        "false_refuse": round(kept / succeeded, 4) if succeeded else None,
        "false_refuse_interval": [round(end, 4) for end in wilson(kept, succeeded)],
        "accepted": taken,
        "accepted_success": round((taken - let) / taken, 4) if taken else None,
    }


def train_way_chance(
    out_dir: Path,
    seed: int,
    *,
    model: str | Path = "push",
    ways: int = 600,
    name: str = "way",
    engine: str | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Push boxes along random ways, fit the chance of a way to the log, and write it with its card.

    Figures on the card come from five folds that never split a way; what is written is fitted to all ways. The log,
    `ways.jsonl` in `out_dir`, goes on where it ends.

    Args:
        out_dir: Where to write; created.
        seed: Makes the ways.
        model: The network that pushes.
        ways: How many ways.
        name: Name of the model.
        engine: The rigid-body engine; by default the first that is installed.
        on_progress: Called after each way with the ways so far and their wanted number.

    Returns:
        Path of the card.

    Raises:
        MissingExtraError: scikit-learn is not installed.
        ColonysimError: The log was made with another seed or network, or the model cannot be written there; found
            before anything is pushed.
        ValueError: Too few ways: all pushes of a fold ended alike.
    """
    seed, ways = as_seed(seed), whole("ways", ways)
    path = Path(out_dir) / f"{name}.npz"
    check_place(path)
    engine = engine or default_engine()
    log = Path(out_dir) / "ways.jsonl"
    logged = gather_ways(log, seed, model=model, ways=ways, engine=engine, on_progress=on_progress)
    fitted = fit_way_chance(logged)
    card = {
        "about": "Logistic regression: the chance that `staged` succeeds with a push, those before it having succeeded",
        "features": list(Features._fields),
        "how": {
            "version": __version__,
            "seed": seed,
            "engine": engine_version(engine),
            "network": str(load_model(model, "q-network").card["sha256"]),
            "ways": len(logged),
            "C": _STRENGTH,
        },
        "results": {"split": f"{_FOLDS} folds by way", **judge_folds(logged)},
    }
    save_model(path, "logistic", {"weights": np.array(fitted.weights), "bias": np.array([fitted.bias])}, card)
    return path.with_suffix(".json")


def judge_folds(ways: Sequence[LoggedWay]) -> dict[str, Any]:
    """Single pushes and whole ways, each judged by a regression that was fitted without them.

    Returns:
        `pushes` and `ways`, each with `n`, `success`, `brier`, `curve` (`calibration_curve`) and `accepts`: what is
        accepted (`false_accepts`) by the regression at .5, by the planner's geometry and by the paper's forest. Of
        whole ways, geometry and forest look at the first push, as the colony does with them; `geometry of all
        pushes` looks at each with the box imagined there.
    """
    folds = min(_FOLDS, len(ways))
    models = [fit_way_chance([way for i, way in enumerate(ways) if i % folds != fold]) for fold in range(folds)]
    told: list[tuple[float, float, float, bool]] = []
    whole: list[tuple[float, float, float, float, bool]] = []
    for i, way in enumerate(ways):
        model, first = models[i % folds], way.pushes[0]
        told += [(model(push.seen), push.seen.room, push.forest, push.success) for push in way.pushes]
        product = float(np.prod([model(seen) for seen in way.foreseen]))
        whole.append((product, first.seen.room, first.forest, min(f.room for f in way.foreseen), way.success))
    chances, rooms, forests, won = (np.array(column) for column in zip(*told, strict=True))
    products, first_rooms, first_forests, all_rooms, arrived = (np.array(column) for column in zip(*whole, strict=True))
    return {
        "pushes": _judged(chances, won, {"geometry": rooms >= 0.0, "forest": forests >= ACCEPTED}),
        "ways": _judged(
            products,
            arrived,
            {
                "geometry": first_rooms >= 0.0,
                "forest": first_forests >= ACCEPTED,
                "geometry of all pushes": all_rooms >= 0.0,
            },
        ),
    }


def _judged(chances: Floats, outcomes: Truths, others: dict[str, Truths]) -> dict[str, Any]:
    accepts = {"way": chances >= ACCEPTED, **others}
    return {
        "n": len(outcomes),
        "success": round(float(outcomes.mean()), 4),
        "brier": round(float(np.mean((chances - outcomes) ** 2)), 4),
        "curve": calibration_curve(chances, outcomes),
        "accepts": {name: false_accepts(accepted, outcomes) for name, accepted in accepts.items()},
    }
