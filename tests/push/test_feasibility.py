"""The feasibility classifier as flat arrays."""

import time
from pathlib import Path

import numpy as np
import pytest

from colonysim.push.feasibility import load_feasibility
from colonysim.push.training.forest import flatten_forest, train_feasibility


def test_flat_arrays_equal_scikit_learn() -> None:
    ensemble = pytest.importorskip("sklearn.ensemble")
    rng = np.random.default_rng(0)
    states = rng.normal(size=(600, 9)).astype(np.float32)
    labels = (states[:, 0] + states[:, 3] ** 2 > 0.5).astype(int)
    forest = ensemble.RandomForestClassifier(30, max_depth=10, random_state=0)
    forest.fit(states, labels, sample_weight=rng.uniform(0.1, 1.0, 600))
    flat = flatten_forest(forest)
    # Thresholds lie between the states seen; numbers on them are the hard case.
    unseen = np.concatenate([rng.normal(size=(300, 9)), np.tile(flat.threshold[:200, None], 9)])
    wanted = forest.predict_proba(unseen)[:, 1]
    assert flat.many(unseen) == pytest.approx(wanted, abs=1e-6)
    assert [flat(x) for x in unseen[:20]] == pytest.approx(wanted[:20], abs=1e-6)


def test_the_shipped_classifier_tells_easy_from_hopeless_and_is_quick() -> None:
    feasible = load_feasibility()
    behind = [1.2, 0.0, 0.125, 0.0, 0.0, 2.7, 0.0, 0.0, 0.0]
    in_front = [1.2, 0.0, 0.125, 0.0, 0.0, -0.3, 0.0, 0.0, 3.1]
    assert feasible(behind) > 0.8
    assert feasible(in_front) < feasible(behind)
    began = time.process_time()
    for _ in range(100):
        feasible(behind)
    assert (time.process_time() - began) / 100 < 0.002


def test_a_small_training(tmp_path: Path) -> None:
    pytest.importorskip("sklearn")
    seen: list[tuple[int, int]] = []
    card = train_feasibility(
        tmp_path, 1, states=150, trees=5, depth=4, on_progress=lambda done, all_: seen.append((done, all_))
    )
    assert 0.0 <= load_feasibility(card)(np.zeros(9)) <= 1.0
    assert seen[-1] == (150, 150)
