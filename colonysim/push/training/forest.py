"""Grows the paper's classifier on the states of pushes whose end is known, and says how far it can be trusted."""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from colonysim import __version__
from colonysim.arguments import as_seed, whole
from colonysim.errors import MissingExtraError
from colonysim.installing import install_command
from colonysim.learning.cards import check_place, load_model, save_model
from colonysim.learning.seeds import Purpose, episode_rng
from colonysim.physics import default_engine, engine_version
from colonysim.push.choosing import network_chooser
from colonysim.push.feasibility import Feasibility
from colonysim.push.judging import Rules
from colonysim.push.network import load_network, network_ticks
from colonysim.push.state import State
from colonysim.push.training.episode import Episode
from colonysim.push.training.starts import KINDS, distribution, draw

__all__ = ["flatten_forest", "gather_states", "train_feasibility"]

TREES, DEPTH = 100, 10
_FOLDS = 5
Array = npt.NDArray[Any]


def flatten_forest(forest: Any) -> Feasibility:
    """A fitted `sklearn.ensemble.RandomForestClassifier` of the classes 0 and 1 as flat arrays."""
    parts: dict[str, list[Array]] = {key: [] for key in ("feature", "threshold", "left", "right", "value")}
    roots: list[int] = []
    offset, depth = 0, 0
    classes = list(forest.classes_)
    for grown in forest.estimators_:
        tree = grown.tree_
        own = np.arange(tree.node_count)
        leaf = tree.children_left < 0
        roots.append(offset)
        depth = max(depth, tree.max_depth)
        parts["feature"].append(np.where(leaf, 0, tree.feature).astype(np.uint8))
        parts["threshold"].append(_round_down(np.where(leaf, 0.0, tree.threshold)))
        parts["left"].append((np.where(leaf, own, tree.children_left) + offset).astype(np.int32))
        parts["right"].append((np.where(leaf, own, tree.children_right) + offset).astype(np.int32))
        weights = tree.value[:, 0, :]
        wins = weights[:, classes.index(1)] if 1 in classes else np.zeros(tree.node_count)
        parts["value"].append((wins / weights.sum(axis=1)).astype(np.float32))
        offset += tree.node_count
    joined = {key: np.concatenate(arrays) for key, arrays in parts.items()}
    return Feasibility(np.array(roots, dtype=np.int32), **joined, depth=depth)


def _round_down(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """To single precision, never upwards: a single-precision number then compares as with the exact one."""
    near = values.astype(np.float32)
    return np.where(near > values, np.nextafter(near, np.float32(-np.inf)), near)


@dataclass(frozen=True, slots=True)
class Gathered:
    """States of whole trajectories.

    Attributes:
        states: Shape (n, 9).
        labels: 1 where the trajectory succeeded, shape (n,).
        episodes: Number of the trajectory, shape (n,).
    """

    states: npt.NDArray[np.float32]
    labels: npt.NDArray[np.int64]
    episodes: npt.NDArray[np.int64]

    @property
    def weights(self) -> npt.NDArray[np.float64]:
        """One for each trajectory, shared by its states: long failures would dominate otherwise."""
        weights: npt.NDArray[np.float64] = 1.0 / np.bincount(self.episodes)[self.episodes]
        return weights


def gather_states(
    seed: int,
    *,
    model: str | Path = "push",
    states: int = 10_000,
    starts: Sequence[str] = ("push", "anywhere"),
    engine: str | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> Gathered:
    """Run the trained network without guards and label whole trajectories by how they ended.

    Args:
        seed: Makes the episodes, apart from those of training, tuning and judging.
        model: The network.
        states: Gathered until there are this many.
        starts: Start distributions, taken in turn; terrains take turns too.
        engine: The rigid-body engine; by default the first that is installed.
        on_progress: Called after each episode with the states so far and their wanted number.
    """
    network = load_network(model)
    rules = dataclasses.replace(Rules(), ticks=network_ticks(model), guards=False, leash=None, at_node=False)
    chosen = [distribution(name) for name in starts]
    seen: list[State] = []
    labels: list[int] = []
    episodes: list[int] = []
    number = 0
    while len(seen) < states:
        rng = episode_rng(Purpose.CLASSIFIER, seed, number)
        start = draw(KINDS[number % len(KINDS)], chosen[number // len(KINDS) % len(chosen)], rng)
        choose = network_chooser(network, rng)
        episode = Episode(start, rules, engine=engine)
        first, steps = episode.state, list(episode.play(choose))
        episode.close()
        # What was chosen from: the state after the last action is none.
        seen += [first, *(step.state for step in steps[:-1])]
        labels += [int(steps[-1].verdict == "success")] * len(steps)
        episodes += [number] * len(steps)
        number += 1
        if on_progress is not None:
            on_progress(min(len(seen), states), states)
    return Gathered(np.array(seen, dtype=np.float32), np.array(labels), np.array(episodes))


def train_feasibility(
    out_dir: Path,
    seed: int,
    *,
    model: str | Path = "push",
    states: int = 10_000,
    starts: Sequence[str] = ("push", "anywhere"),
    trees: int = TREES,
    depth: int = DEPTH,
    name: str = "feasibility",
    engine: str | None = None,
    on_progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Train the classifier on states of the trained network and write it with its card.

    Figures on the card come from five folds that never split an episode; the classifier written is grown
    on all states.

    Args:
        out_dir: Where to write; created.
        seed: Makes the episodes and the forest.
        model: The network whose pushes are judged.
        states: Least number of states.
        starts: Start distributions of the episodes.
        trees: Trees of the forest.
        depth: Their largest depth.
        name: Name of the model.
        engine: The rigid-body engine; by default the first that is installed.
        on_progress: Called after each episode with the states so far and their wanted number.

    Returns:
        Path of the card.

    Raises:
        MissingExtraError: scikit-learn is not installed.
        ModelError: The model cannot be written there; found before anything is pushed.
        ValueError: All states come from one episode.
    """
    try:
        from sklearn.ensemble import RandomForestClassifier
        from sklearn.metrics import roc_auc_score
        from sklearn.model_selection import GroupKFold
    except ImportError as error:
        raise MissingExtraError(
            f"training the classifier needs scikit-learn ({error}): {install_command('train')}"
        ) from error
    seed, states = as_seed(seed), whole("states", states)
    trees, depth = whole("trees", trees), whole("depth", depth)
    path = Path(out_dir) / f"{name}.npz"
    check_place(path)
    engine = engine or default_engine()
    data = gather_states(seed, model=model, states=states, starts=starts, engine=engine, on_progress=on_progress)
    weights = data.weights

    def grow(rows: Array) -> Any:
        forest = RandomForestClassifier(trees, max_depth=depth, min_samples_leaf=3, random_state=seed)
        return forest.fit(data.states[rows], data.labels[rows], sample_weight=weights[rows])

    def auc(rows: Array, weighted: bool = False) -> float | None:
        # Undefined when every trajectory ended alike.
        labels = data.labels[rows]
        if labels.min() == labels.max():
            return None
        return float(roc_auc_score(labels, chances[rows], sample_weight=weights[rows] if weighted else None))

    count = int(data.episodes[-1]) + 1
    if count < 2:
        raise ValueError(f"{states} states came from one episode, expected enough for two at least")
    folds = min(_FOLDS, count)
    chances = np.zeros(len(data.labels))
    for train, test in GroupKFold(folds).split(data.states, data.labels, data.episodes):
        chances[test] = flatten_forest(grow(train)).many(data.states[test])
    right = (chances >= 0.5) == (data.labels == 1)
    first = np.r_[True, np.diff(data.episodes) > 0]
    accepted = first & (chances >= 0.5)
    everything = np.arange(len(data.labels))
    flat = flatten_forest(grow(everything))
    results = {
        "states": len(data.labels),
        "episodes": count,
        "episodes_won": float(data.labels[first].mean()),
        "accuracy": float(right.mean()),
        "accuracy_by_episode": float(np.average(right, weights=weights)),
        "accuracy_at_start": float(right[first].mean()),
        "false_accept_at_start": float(np.mean(data.labels[accepted] == 0)) if accepted.any() else None,
        "auc": auc(everything),
        "auc_by_episode": auc(everything, weighted=True),
        "auc_at_start": auc(np.flatnonzero(first)),
        "split": f"{folds} folds by episode",
    }
    card = {
        "about": "Random forest: the chance that the executor `rl` succeeds from a state (paper Eq. 4)",
        "depth": flat.depth,
        "how": {
            "version": __version__,
            "seed": seed,
            "engine": engine_version(engine),
            "network": str(load_model(model, "q-network").card["sha256"]),
            "starts": list(starts),
            "trees": trees,
            "max_depth": depth,
            "min_samples_leaf": 3,
            "weights": "each episode counts once",
        },
        "results": results,
    }
    arrays = {f.name: getattr(flat, f.name) for f in dataclasses.fields(flat) if f.name != "depth"}
    save_model(path, "forest", arrays, card)
    return path.with_suffix(".json")
