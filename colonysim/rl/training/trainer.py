"""Training a colony's policy: imitation of the rule, then PPO, with tests on other places; the best network is kept."""

from __future__ import annotations

import dataclasses
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from colonysim import __version__
from colonysim.arguments import as_seed, whole
from colonysim.errors import ColonysimError, MissingExtraError
from colonysim.installing import install_command
from colonysim.learning.cards import MOST_BYTES
from colonysim.learning.checkpoints import carry_out, fitting, read_checkpoint, write_checkpoint
from colonysim.learning.seeds import Purpose, episode_rng
from colonysim.rl.models import save_policy
from colonysim.rl.training.games import MARKS, Game, play
from colonysim.rl.training.places import place
from colonysim.rl.training.presets import PRESETS, PolicyConfig
from colonysim.signals import held
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from colonysim.rl.training.games import Episode
    from colonysim.rl.training.imitation import Lessons

__all__ = ["Progress", "Tested", "TrainedPolicy", "train_policy"]

CHOICE = "sampled"
"""PPO improves a policy that draws its actions; without memory, always doing what is likeliest may lead in circles."""
SCORED = 3
"""A network is judged by its last tests, so many."""
_RUNS = 4
"""Runs at each place of the test that a card tells of."""


@dataclass(frozen=True, slots=True)
class Tested:
    """How well a network did on places that it was not trained on.

    Attributes:
        success: Mean share of agents at the goal.
        seconds: Mean simulated seconds until all were there; a failed episode counts with its time limit.
    """

    success: float
    seconds: float


@dataclass(frozen=True, slots=True)
class Progress:
    """Where a training stands, after a pass of the imitation or an iteration of PPO.

    Attributes:
        phase: "imitation" or "ppo".
        round: Passes or iterations of this phase so far.
        decisions: Decisions that were learned from so far, those of the imitation once.
        share: Share of the training done, 0 to 1.
        played: How the runs of an iteration went, the policy drawing its actions.
        tested: How the test after it went, if there was one.
        told: `loss` and `agreement` (share of held-out decisions of the rule that are the network's most likely ones)
            of imitation; `entropy`, `critic` and `moved` of PPO.
    """

    phase: str
    round: int
    decisions: int
    share: float
    played: Tested | None
    tested: Tested | None
    told: dict[str, float]


@dataclass(frozen=True, slots=True)
class TrainedPolicy:
    """A finished training.

    Attributes:
        card: Path of the best network's card.
        imitated: Path of the card of the network as it was after the imitation.
        last: Path of the card of the network as it was at the end.
        best_round: Iteration of PPO after which it was best, 0 for the imitation alone.
        history: Every round.
    """

    card: Path
    imitated: Path
    last: Path
    best_round: int
    history: tuple[Progress, ...]


def train_policy(
    config: PolicyConfig | str,
    out_dir: str | Path,
    seed: int = 0,
    *,
    resume: bool = False,
    name: str = "policy",
    on_progress: Callable[[Progress], None] | None = None,
    stop_after_rounds: int | None = None,
) -> TrainedPolicy | None:
    """Trains a policy that `run --policy learned` runs; writes networks with their cards, history and a checkpoint.

    The best network is `<name>.npz`, that of the imitation `<name>-imitated.npz`, that of the end `<name>-last.npz`.

    Args:
        config: A configuration, or the name of a preset.
        out_dir: Where to write; created.
        seed: Makes the training: the same seed gives the same network on the same machine.
        resume: Goes on from the checkpoint in `out_dir`, if there is one; the result is that of an unbroken training.
        name: Name of the model.
        on_progress: Called after each round.
        stop_after_rounds: Leave after this many rounds, as an interruption would.

    Returns:
        The trained policy, or None when it was left early.

    Raises:
        MissingExtraError: PyTorch is not installed.
        ColonysimError: There is no such preset, or another process is training in `out_dir`.
        ModelError: The checkpoint belongs to another configuration or seed, or a file cannot be written there; found
            before anything is trained.
    """
    if isinstance(config, str):
        if config not in PRESETS:
            raise ColonysimError(f"no preset {config!r}; {nearest(config, PRESETS)}")
        config = PRESETS[config]
    if stop_after_rounds is not None:
        stop_after_rounds = whole("stop_after_rounds", stop_after_rounds, 0)
    folder, seed = Path(out_dir), as_seed(seed)
    return carry_out(
        lambda: _Run(config, folder, seed), folder, (name, f"{name}-imitated", f"{name}-last"), resume=resume,
        stop_after=stop_after_rounds, on_progress=on_progress,
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Note:
    """What a checkpoint holds beside its arrays."""

    config: dict[str, Any]
    seed: int
    cpu_seconds: float
    best_round: int
    imitated: bool
    history: tuple[Progress, ...]


class _Run:
    """The state of one training between two rounds. Runs begin and end within a round: no colony has to be kept."""

    def __init__(self, config: PolicyConfig, folder: Path, seed: int) -> None:
        try:
            with held():
                from colonysim.rl.training.ppo import Learner
        except ImportError as error:
            raise MissingExtraError(f"training needs torch ({error}): {install_command('train')}") from error
        self.config, self.folder, self.seed = config, folder, seed
        self.places = [place(Purpose.TRAIN, number) for number in range(config.places)]
        self.test_places = [place(Purpose.TUNE, number) for number in range(config.test_places)]
        self.options = Game(self.places[0], 0, config).turns.observer.options
        self.learner = Learner(self.options, config, seed)
        self.kept: dict[str, dict[str, NDArray[Any]]] = {}
        self.best_round, self.history = 0, list[Progress]()
        self._lessons: tuple[Lessons, Lessons] | None = None
        self.spent, self._began = 0.0, time.process_time()

    @property
    def _rounds(self) -> int:
        return self.config.imitation.epochs + self.config.ppo.iterations

    @property
    def finished(self) -> bool:
        return len(self.history) >= self._rounds

    def go_on(self) -> None:
        """A pass of the imitation, or an iteration of PPO; a test, if it is time for one."""
        epochs = self.config.imitation.epochs
        self.history.append(self._imitate() if len(self.history) < epochs else self._improve())
        if len(self.history) == epochs:
            self.kept["imitated"] = self.kept["best"] = self._weights()
        elif self.history[-1].tested is not None:
            now = self.history[-1].round
            if self._score(now) <= self._score(self.best_round):
                self.kept["best"], self.best_round = self._weights(), now

    def _imitate(self) -> Progress:
        from colonysim.rl.training.imitation import gather

        done, epochs = len(self.history), self.config.imitation.epochs
        if self._lessons is None:
            self._lessons = gather(self.places, self.config, self.seed)
        lessons, held_out = self._lessons
        rng = episode_rng(Purpose.LEARNER, self.seed, done)
        loss = self.learner.imitate(lessons, 1.0 - done / epochs, rng)
        told = {"loss": loss, "agreement": self.learner.agreement(held_out)}
        last = done + 1 == epochs
        if last:
            self._lessons = None
            self.learner.forget()
        return Progress(
            "imitation", done + 1, len(lessons), (done + 1) / self._rounds, None, self.test() if last else None, told
        )

    def _improve(self) -> Progress:
        config, ppo = self.config, self.config.ppo
        done = len(self.history) - config.imitation.epochs
        rng = episode_rng(Purpose.LEARNER, self.seed, len(self.history))
        symmetries = self.learner.symmetries
        games = []
        for number in range(ppo.runs):
            # Places take turns, so that each is played as often as any other.
            where = self.places[(done * ppo.runs + number) % len(self.places)]
            way = symmetries[int(rng.integers(len(symmetries)))] if config.mirrored else None
            games.append(Game(where, int(rng.integers(2**31)), config, way))
        play(games, lambda asked: self.learner.decide(asked, rng))
        batch = self.learner.batch([path for game in games for path in game.paths])
        told = self.learner.learn(batch, 1.0 - done / ppo.iterations, done < ppo.critic_first, rng)
        before = self.history[-1].decisions if self.history else 0
        due = (done + 1) % config.test_every == 0 or done + 1 == ppo.iterations
        return Progress(
            "ppo", done + 1, before + len(batch.action), (len(self.history) + 1) / self._rounds,
            _tested([episode for game in games for episode in game.episodes]), self.test() if due else None, told,
        )  # fmt: skip

    def test(self, first: int = 0, runs: int = 1) -> Tested:
        """Plays the network as it is on the places of the tests.

        Args:
            first: Number of the first run at each place; runs of another number are other ones.
            runs: Runs at each place.
        """
        games = [
            Game(where, int(episode_rng(Purpose.TUNE, self.seed, first + run, number).integers(2**31)), self.config)
            for run in range(runs)
            for number, where in enumerate(self.test_places)
        ]
        rng = episode_rng(Purpose.TUNE, self.seed, first)
        play(games, lambda asked: self.learner.decide(asked, rng))
        return _tested([episode for game in games for episode in game.episodes])

    def _score(self, until: int) -> float:
        """Mean seconds of the last `SCORED` tests up to an iteration; infinite before there are so many."""
        tests = [each.tested.seconds for each in self.history if each.phase == "ppo" and each.tested is not None
                 and each.round <= until][-SCORED:]  # fmt: skip
        return float(np.mean(tests)) if len(tests) == SCORED else float("inf")

    def _weights(self) -> dict[str, NDArray[Any]]:
        return {key: array for key, array in self.learner.dump().items() if key.startswith("weights_")}

    def save(self) -> None:
        """Writes the checkpoint; a training that goes on from it ends as if it had never stopped."""
        arrays = self.learner.dump()
        for kept, weights in self.kept.items():
            arrays |= {f"{kept}_{key}": array for key, array in weights.items()}
        note = {
            "config": dataclasses.asdict(self.config), "seed": self.seed, "cpu_seconds": self._cpu_seconds(),
            "best_round": self.best_round, "imitated": bool(self.kept),
            "history": [dataclasses.asdict(each) for each in self.history],
        }  # fmt: skip
        write_checkpoint(self.folder, arrays, note)

    def _cpu_seconds(self) -> float:
        return self.spent + time.process_time() - self._began

    def restore(self) -> None:
        """Goes on from the checkpoint, if there is one."""
        found = read_checkpoint(self.folder, _Note, self.config, self.seed, 4 * MOST_BYTES)
        if found is None:
            return
        arrays, note = found
        with fitting(self.folder):
            self.learner.restore(arrays)
            for kept in ("imitated", "best") if note.imitated else ():
                prefix = f"{kept}_"
                self.kept[kept] = {key: arrays[prefix + key] for key in self._weights()}
        self.spent, self.best_round, self.history = note.cpu_seconds, note.best_round, list(note.history)

    def finish(self, name: str) -> TrainedPolicy:
        """Writes the best network, that of the imitation and that of the end."""
        self.kept.setdefault("best", self._weights())
        self.kept.setdefault("imitated", self.kept["best"])
        last = self._write(f"{name}-last", self._weights(), None)
        imitated = self._write(f"{name}-imitated", self.kept["imitated"], 0)
        card = self._write(name, self.kept["best"], self.best_round)
        return TrainedPolicy(card, imitated, last, self.best_round, tuple(self.history))

    def _write(self, name: str, weights: Mapping[str, NDArray[Any]], best_round: int | None) -> Path:
        """Writes a network with its card; the card's path."""
        from colonysim.rl.training.network import layers_of

        self.learner.restore(weights)
        about = {
            "version": __version__, "seed": self.seed, "decisions": self.history[-1].decisions if self.history else 0,
            "round": self.config.ppo.iterations if best_round is None else best_round,
            "cpu_seconds": round(self._cpu_seconds()), "config": dataclasses.asdict(self.config),
            # On other runs than those by which the network was chosen.
            "test": dataclasses.asdict(self.test(1, _RUNS)),
            "test_episodes": len(self.test_places) * _RUNS * self.config.episodes,
        }  # fmt: skip
        layers = layers_of(self.learner.policy)
        return save_policy(self.folder / f"{name}.npz", layers, self.options, choice=CHOICE, marks=MARKS, about=about)


def _tested(episodes: Sequence[Episode]) -> Tested:
    """What episodes come to."""
    return Tested(
        float(np.mean([each.success for each in episodes])), float(np.mean([each.seconds for each in episodes]))
    )
