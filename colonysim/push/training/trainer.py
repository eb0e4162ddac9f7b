"""Training the push (paper Alg. 1): training and testing episodes in turn, the best network kept."""

import dataclasses
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from pydantic import NonNegativeInt

from colonysim import __version__
from colonysim.arguments import as_seed, whole
from colonysim.errors import MissingExtraError
from colonysim.installing import install_command
from colonysim.learning.cards import MOST_BYTES, save_model
from colonysim.learning.checkpoints import carry_out, fitting, read_checkpoint, write_checkpoint
from colonysim.learning.seeds import Purpose, episode_rng
from colonysim.physics import engine_version
from colonysim.push.choosing import Choose, boltzmann, network_chooser
from colonysim.push.controls import CONTROLS, Control
from colonysim.push.network import INPUTS, QNetwork, encode, network_from_arrays, random_network
from colonysim.push.state import State
from colonysim.push.task import Kind
from colonysim.push.training.demonstrator import demonstrate
from colonysim.push.training.episode import Episode, Step
from colonysim.push.training.mirror import mirror_signs, mirrored
from colonysim.push.training.presets import PRESETS, Ends, StartMix, TrainingConfig
from colonysim.push.training.replay import NStep, Replay
from colonysim.push.training.starts import KINDS, distribution, draw
from colonysim.signals import held

if TYPE_CHECKING:
    from colonysim.push.training.dqn import DoubleDQN

__all__ = ["Progress", "Trained", "train_push"]


@dataclass(frozen=True, slots=True)
class Progress:
    """Where a training stands, after a block of training and one of testing episodes.

    Attributes:
        episodes: Training episodes so far, those of the exploration included.
        actions: Training actions so far.
        share: Share of the training done, 0 to 1.
        reward: Mean reward of the last test.
        success: Share of successes of the last test.
        by_kind: The same by terrain (only those that were drawn).
        epsilon: Chance of a uniform action.
        loss: Mean loss of the block's updates.
    """

    episodes: int
    actions: int
    share: float
    reward: float
    success: float
    by_kind: Mapping[str, float]
    epsilon: float
    loss: float


@dataclass(frozen=True, slots=True)
class Trained:
    """A finished training.

    Attributes:
        network: The best network.
        card: Path of its card.
        last: Path of the card of the network as it was at the end.
        peak_episode: Training episode after which it was best.
        history: Every test.
    """

    network: QNetwork
    card: Path
    last: Path
    peak_episode: int
    history: tuple[Progress, ...]


@dataclass(slots=True)
class _Candidate:
    score: float
    reward: float
    episode: int
    arrays: dict[str, npt.NDArray[Any]]


def train_push(
    config: TrainingConfig | str,
    out_dir: Path,
    seed: int,
    *,
    resume: bool = False,
    name: str = "push",
    on_progress: Callable[[Progress], None] | None = None,
    stop_after_blocks: int | None = None,
) -> Trained | None:
    """Train a push: write the best network and the last one with their cards, `history.json` and a checkpoint.

    The best is `<name>.npz`, the network of the end `<name>-last.npz`.

    Args:
        config: A configuration, or the name of a preset.
        out_dir: Where to write; created.
        seed: Makes the run: the same seed gives the same network on the same machine.
        resume: Go on from the checkpoint in `out_dir`, if there is one; the result is that of an unbroken run.
        name: Name of the model.
        on_progress: Called after each test.
        stop_after_blocks: Leave after this many blocks (training and test), as an interruption would.

    Returns:
        The trained network, or None when it was left early.

    Raises:
        MissingExtraError: torch is not installed.
        ColonysimError: Another process is training in `out_dir`.
        ModelError: The checkpoint belongs to another configuration or seed, or a file cannot be written there; found
            before anything is trained.
        ValueError: There is no such preset.
    """
    if isinstance(config, str):
        if config not in PRESETS:
            raise ValueError(f"no preset {config!r}; there are {', '.join(PRESETS)}")
        config = PRESETS[config]
    if stop_after_blocks is not None:
        stop_after_blocks = whole("stop_after_blocks", stop_after_blocks, 0)
    seed = as_seed(seed)
    folder = Path(out_dir)
    return carry_out(
        lambda: _Run(config, folder, seed), folder, (name, f"{name}-last"), resume=resume, stop_after=stop_after_blocks,
        on_progress=on_progress,
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Note:
    """What a checkpoint holds beside its arrays."""

    config: dict[str, Any]
    seed: int
    rng: dict[str, Any]
    epsilon: float
    cpu_seconds: float
    counts: tuple[NonNegativeInt, NonNegativeInt, NonNegativeInt, NonNegativeInt]
    candidates: tuple[tuple[float, float, int], ...]
    history: tuple[Progress, ...]


class _Run:
    """The state of one training between two blocks."""

    def __init__(self, config: TrainingConfig, folder: Path, seed: int) -> None:
        self.config, self.folder, self.seed = config, folder, seed
        self.rng = episode_rng(Purpose.LEARNER, seed)
        start = random_network(config.inputs, config.hidden, self.rng)
        self.learner = _learner(start, config)
        self.replay = Replay(config.buffer, INPUTS[config.inputs])
        self.signs = mirror_signs(config.inputs)
        self.epsilon = config.epsilon
        self.episodes = self.actions = self.tests = self.counted = 0
        self.history: list[Progress] = []
        self.candidates: list[_Candidate] = []
        self._losses: list[float] = []
        self.spent = 0.0
        self._began = time.process_time()

    @property
    def share(self) -> float:
        config = self.config
        shares = [0.0]
        if config.actions is not None:
            shares.append(self.actions / config.actions)
        if config.episodes is not None:
            shares.append(self.counted / config.episodes)
        return max(shares)

    @property
    def finished(self) -> bool:
        return self.share >= 1.0

    def go_on(self) -> None:
        """Training episodes, then a test; the exploration, where there is nothing to test, is part of the first."""
        config = self.config
        self._losses.clear()
        explore = config.explore if config.actions is None else min(config.explore, config.actions)
        while self.actions < explore:
            self._train_episode()
        for _ in range(config.train_block):
            if self.finished:
                break
            self._train_episode()
        rewards: list[float] = []
        won: dict[str, list[float]] = {kind: [] for kind in KINDS}
        for _ in range(config.test_block):
            rng = episode_rng(Purpose.TEST, self.seed, self.tests)
            self.tests += 1
            kind, mix = self._draw(rng)
            choose = network_chooser(self.learner.tested, rng, config.testing, config.beta)
            gained, success = play(kind, mix, config, choose, rng)
            rewards.append(gained)
            won[kind].append(float(success))
        everything = [w for some in won.values() for w in some]
        self.history.append(
            Progress(
                self.episodes,
                self.actions,
                min(1.0, self.share),
                float(np.mean(rewards)),
                float(np.mean(everything)),
                {kind: float(np.mean(some)) for kind, some in won.items() if some},
                self.epsilon,
                float(np.mean(self._losses)) if self._losses else 0.0,
            )
        )
        self.candidates.append(self._candidate())
        self.candidates.sort(key=lambda c: (-c.score, -c.reward, c.episode))
        del self.candidates[config.candidates :]

    def _candidate(self) -> _Candidate:
        """The network as it is now, with its score."""
        recent = self.history[-self.config.score_blocks :]
        score = float(np.mean([p.success for p in recent]))
        reward = float(np.mean([p.reward for p in recent]))
        arrays = {k: a.copy() for k, a in self.learner.tested.arrays().items()}
        return _Candidate(score, reward, self.episodes, arrays)

    def _draw(self, rng: np.random.Generator) -> tuple[Kind, StartMix]:
        kinds, starts = self.config.kinds, self.config.starts
        kind = kinds[_weighted([w for _, w in kinds], rng)][0]
        return kind, starts[_weighted([s.share for s in starts], rng)]

    def _train_episode(self) -> None:
        config = self.config
        rng = episode_rng(Purpose.TRAIN, self.seed, self.episodes)
        kind, mix = self._draw(rng)
        if self.actions >= config.explore:
            self.counted += 1
        episode = _begin(kind, mix, config, rng)
        steps = NStep(self.replay, config.steps, config.gamma)
        encoded = encode(config.inputs, episode.state)
        for step in episode.play(lambda state: self._explore(state, rng)):
            following = encode(config.inputs, step.state)
            steps.add(
                encoded, step.control, step.reward, following,
                terminal=_nothing_follows(step, config.ends), over=step.over,
            )  # fmt: skip
            encoded = following
            self.actions += 1
            if self.actions % config.update_every == 0 and len(self.replay) >= max(config.update_from, config.batch):
                batch = self.replay.sample(config.batch, self.rng)
                if config.mirror:
                    batch = mirrored(batch, self.signs, self.rng)
                self._losses.append(self.learner.update(batch, self.share))
        episode.close()
        self.episodes += 1

    def _explore(self, state: State, rng: np.random.Generator) -> Control:
        """The training policy of paper Alg. 1, after a first part with a teacher."""
        config = self.config
        if self.actions < config.explore:
            if rng.random() < config.demonstrations:
                return demonstrate(state)
            return Control(int(rng.integers(CONTROLS)))
        if rng.random() < self.epsilon:
            self.epsilon = max(config.epsilon_floor, self.epsilon * config.epsilon_decay)
            return Control(int(rng.integers(CONTROLS)))
        return boltzmann(self.learner.network.values(state), rng, config.beta)

    def save(self) -> None:
        """Write the checkpoint; a run that goes on from it ends as if it had never stopped."""
        arrays = {**self.learner.dump(), **self.replay.dump()}
        for i, candidate in enumerate(self.candidates):
            for key, array in candidate.arrays.items():
                arrays[f"candidate{i}_{key}"] = array
        note = {
            "config": dataclasses.asdict(self.config),
            "seed": self.seed,
            "rng": self.rng.bit_generator.state,
            "epsilon": self.epsilon,
            "cpu_seconds": self.spent + time.process_time() - self._began,
            "counts": [self.episodes, self.actions, self.tests, self.counted],
            "candidates": [[c.score, c.reward, c.episode] for c in self.candidates],
            "history": [dataclasses.asdict(p) for p in self.history],
        }
        write_checkpoint(self.folder, arrays, note)

    def restore(self) -> None:
        """Go on from the checkpoint, if there is one."""
        found = read_checkpoint(self.folder, _Note, self.config, self.seed, self._largest)
        if found is None:
            return
        arrays, note = found
        with fitting(self.folder):
            self.learner.restore(arrays)
            self.replay.restore(arrays)
            self.rng.bit_generator.state = note.rng
            for i, (score, reward, episode) in enumerate(note.candidates):
                prefix = f"candidate{i}_"
                kept = {key.removeprefix(prefix): a for key, a in arrays.items() if key.startswith(prefix)}
                network_from_arrays(self.config.inputs, kept)
                self.candidates.append(_Candidate(score, reward, episode, kept))
        self.epsilon, self.spent = note.epsilon, note.cpu_seconds
        self.episodes, self.actions, self.tests, self.counted = note.counts
        self.history = list(note.history)

    @property
    def _largest(self) -> int:
        """Bytes that a checkpoint of this training may take: the replay, networks, Adam's moments, the note."""
        network = sum(array.nbytes for array in self.learner.network.arrays().values())
        return MOST_BYTES + self.replay.nbytes + (5 + self.config.candidates) * network

    def finish(self, name: str) -> Trained:
        """Let the best candidates play off, write the winner and the network as it is now."""
        winner, scores, each = self._playoff()
        last = self._write(f"{name}-last", self._candidate(), {})
        card = self._write(name, winner, {"tuning": scores, "tuning_episodes_each": each})
        network = network_from_arrays(self.config.inputs, winner.arrays)
        return Trained(network, card, last, winner.episode, tuple(self.history))

    def _write(self, name: str, chosen: _Candidate, more: Mapping[str, Any]) -> Path:
        """Write a network with its card; the card's path."""
        network = network_from_arrays(self.config.inputs, chosen.arrays)
        card = {
            "about": "Q network of the push: the value of each of the eight controls in a state (paper Eq. 4)",
            "inputs": self.config.inputs,
            "ticks": self.config.rules.ticks,
            "how": {
                "version": __version__,
                "seed": self.seed,
                "training_episodes": self.episodes,
                "training_actions": self.actions,
                "peak_episode": chosen.episode,
                "engine": engine_version(self.config.engine),
                "cpu_seconds": round(self.spent + time.process_time() - self._began),
                "config": dataclasses.asdict(self.config),
            },
            "results": {
                "test_success": chosen.score,
                "test_reward": chosen.reward,
                "test_episodes": self.config.test_block * self.config.score_blocks,
                **more,
            },
        }
        path = self.folder / f"{name}.npz"
        save_model(path, "q-network", network.arrays(), card)
        return path.with_suffix(".json")

    def _playoff(self) -> tuple[_Candidate, dict[str, float], int]:
        """The best candidate, its success by start and terrain, and the episodes of each."""
        field, config = list(self.candidates), self.config
        if config.candidates > 1 and all(c.episode != self.episodes for c in field):
            field.append(self._candidate())
        if len(field) == 1:
            return field[0], {}, 0
        field.sort(key=lambda c: -_mean(self._tuned(c, 0, config.playoff)))
        # The mean of few episodes flatters the first of many: the two best are compared on others.
        scores = [self._tuned(c, config.playoff, config.final) for c in field[:2]]
        best = max(range(2), key=lambda i: _mean(scores[i]))
        return field[best], scores[best], config.final

    def _tuned(self, candidate: _Candidate, first: int, episodes: int) -> dict[str, float]:
        """Success of a candidate in tuning episodes from the `first` on, by start and terrain."""
        network = network_from_arrays(self.config.inputs, candidate.arrays)
        found: dict[str, float] = {}
        for mix in self.config.starts:
            for kind, _ in self.config.kinds:
                wins = 0
                for i in range(first, first + episodes):
                    rng = episode_rng(Purpose.TUNE, self.seed, KINDS.index(kind), i)
                    choose = network_chooser(network, rng, self.config.testing, self.config.beta)
                    wins += play(kind, mix, self.config, choose, rng)[1]
                found[f"{mix.name}/{kind}"] = wins / episodes
        return found


def _mean(scores: Mapping[str, float]) -> float:
    return float(np.mean(list(scores.values())))


def play(
    kind: Kind, mix: StartMix, config: TrainingConfig, choose: Choose, rng: np.random.Generator
) -> tuple[float, bool]:
    """One episode without learning; its reward, and whether it succeeded."""
    episode = _begin(kind, mix, config, rng)
    steps = list(episode.play(choose))
    episode.close()
    return sum(step.reward for step in steps), steps[-1].verdict == "success"


def _begin(kind: Kind, mix: StartMix, config: TrainingConfig, rng: np.random.Generator) -> Episode:
    rules = dataclasses.replace(config.rules, guards=config.rules.guards and mix.guards)
    return Episode(draw(kind, distribution(mix.name), rng), rules, engine=config.engine)


def _nothing_follows(step: Step, ends: Ends) -> bool:
    """Whether the target of an action is its reward alone."""
    return ends != "none" and (step.verdict is not None or (ends == "limit" and step.over))


def _weighted(weights: list[float], rng: np.random.Generator) -> int:
    edges = np.cumsum(weights)
    return int(np.searchsorted(edges, rng.random() * edges[-1], side="right"))


def _learner(start: QNetwork, config: TrainingConfig) -> "DoubleDQN":
    try:
        with held():
            from colonysim.push.training.dqn import DoubleDQN
    except ImportError as error:
        raise MissingExtraError(f"training needs torch ({error}): {install_command('train')}") from error
    return DoubleDQN(start, config.learner)
