"""Named training configurations: the paper's, and the one that chains."""

from dataclasses import dataclass, replace
from typing import Literal

from colonysim.physics import EngineName
from colonysim.push.choosing import Testing
from colonysim.push.judging import PAPER_RULES, Rules
from colonysim.push.network import Inputs
from colonysim.push.task import Kind

__all__ = ["PRESETS", "READINGS", "Ends", "LearnerConfig", "StartMix", "Target", "TrainingConfig"]

Target = Literal["standard", "printed"]
Ends = Literal["verdict", "limit", "none"]


@dataclass(frozen=True, slots=True)
class LearnerConfig:
    """Parameters of Double DQN.

    Attributes:
        target: Form of the Double DQN target: `"standard"`, the target network's value at the online network's
            best control, or `"printed"`, the paper's, which has the two networks exchanged.
        loss: `"squared"` (paper Alg. 1) or `"huber"`.
        learning_rate: Adam's rate at the start.
        learning_rate_end: Adam's rate at the end of training; it falls linearly.
        gradient_clip: Largest norm of a gradient; None for no limit.
        target_every: M, updates between two copies of the online to the target network; None: soft.
        target_share: Share of the online network mixed into the target network at each update, when soft.
        average_share: Share of the online network mixed at each update into an average that is tested and kept in
            its place, which is steadier; None: the online network itself.
    """

    target: Target = "standard"
    loss: Literal["squared", "huber"] = "huber"
    learning_rate: float = 5e-4
    learning_rate_end: float = 2e-5
    gradient_clip: float | None = 10.0
    target_every: int | None = None
    target_share: float = 0.005
    average_share: float | None = 0.001


IMPROVED_LEARNER = LearnerConfig()
IMPROVED_RULES = Rules(ticks=15)


@dataclass(frozen=True, slots=True)
class StartMix:
    """A share of the episodes that begins in one of the distributions of `starts.json`.

    Attributes:
        name: The distribution.
        share: Weight of it.
        guards: Whether guards end these episodes, as they end a push in a colony; without them the paper's table does.
    """

    name: str
    share: float
    guards: bool


@dataclass(frozen=True, slots=True)
class TrainingConfig:
    """Everything that makes a trained network, but for the seed.

    Attributes:
        name: Name of the preset.
        engine: The rigid-body engine.
        inputs: What the network reads.
        hidden: Widths of the hidden layers.
        learner: Parameters of Double DQN.
        gamma: Discount of one action.
        steps: n of the n-step returns.
        ends: After which actions nothing is expected any more, so that the target is the reward alone: `"verdict"`,
            those that end in success or failure; `"limit"`, also the last one before the step limit; `"none"`: the
            target always adds the value of the next state, as paper Alg. 1 prints it.
        buffer: Capacity of the replay.
        batch: Transitions of one update (b).
        explore: First actions, chosen without the network (S).
        mirror: Whether each transition of a batch is seen in a mirror with a chance of one half (`mirror.py`).
        demonstrations: Share of those that the demonstrator chooses; the others are drawn uniformly.
        update_from: Transitions in the replay before the first update.
        update_every: Actions between two updates.
        beta: Boltzmann's beta.
        epsilon: Chance of a uniform action at the start.
        epsilon_decay: Epsilon's factor at each uniform action.
        epsilon_floor: Least epsilon.
        actions: Training actions in all; None for no limit.
        episodes: Training episodes in all, those of the exploration not counted; None for no limit.
        train_block: Training episodes between two tests.
        test_block: Episodes of a test.
        testing: How a test chooses.
        rules: Rules of the episodes.
        kinds: Weights of the terrains.
        starts: Where episodes begin.
        score_blocks: Tests that a network's score is averaged over.
        candidates: Networks with the best scores that a play-off on tuning seeds decides between, if more than one;
            the last one takes part too.
        playoff: Episodes per terrain and start of the play-off's first round.
        final: The same of its second round, between the two best of the first.
    """

    name: str
    engine: EngineName = "bullet"
    inputs: Inputs = "line"
    hidden: tuple[int, ...] = (200, 200, 200)
    learner: LearnerConfig = IMPROVED_LEARNER
    gamma: float = 0.991
    steps: int = 6
    ends: Ends = "verdict"
    buffer: int = 150_000
    batch: int = 128
    explore: int = 6_000
    mirror: bool = True
    demonstrations: float = 0.7
    update_from: int = 1_000
    update_every: int = 2
    beta: float = 12.0
    epsilon: float = 0.15
    epsilon_decay: float = 0.999
    epsilon_floor: float = 0.02
    actions: int | None = 180_000
    episodes: int | None = None
    train_block: int = 100
    test_block: int = 20
    testing: Testing = "greedy"
    rules: Rules = IMPROVED_RULES
    kinds: tuple[tuple[Kind, float], ...] = (("flat", 0.3), ("slope", 0.35), ("hole", 0.35))
    starts: tuple[StartMix, ...] = (
        StartMix("push_wide", 0.4, guards=False),
        StartMix("handover", 0.3, guards=True),
        StartMix("askew", 0.15, guards=True),
        StartMix("fine", 0.15, guards=True),
    )
    score_blocks: int = 3
    candidates: int = 5
    playoff: int = 16
    final: int = 40


PRESETS: dict[str, TrainingConfig] = {
    "paper": TrainingConfig(
        name="paper",
        inputs="state",
        learner=LearnerConfig(
            target="printed",
            loss="squared",
            learning_rate=3e-4,
            learning_rate_end=3e-4,
            gradient_clip=None,
            target_every=300,
            average_share=None,
        ),
        gamma=0.975,
        steps=1,
        buffer=10_000,
        explore=1_000,
        mirror=False,
        demonstrations=0.0,
        update_every=1,
        beta=8.0,
        epsilon=0.2,
        epsilon_decay=0.995,
        epsilon_floor=0.0,
        actions=None,
        episodes=400,
        train_block=20,
        testing="boltzmann",
        rules=PAPER_RULES,
        kinds=(("flat", 0.3), ("slope", 0.2), ("hole", 0.5)),
        starts=(StartMix("push", 1.0, guards=False),),
        score_blocks=1,
        candidates=1,
    ),
    "improved": TrainingConfig(name="improved"),
}
"""`paper` is the text verbatim (epsilon's values are not printed there); `improved` is what is shipped."""

_PAPER = PRESETS["paper"]
_STANDARD = replace(_PAPER, learner=replace(_PAPER.learner, target="standard"))
_BEHIND = (StartMix("coarse", 1.0, guards=False),)
_CLEAR = replace(
    _STANDARD, rules=replace(PAPER_RULES, check_every=3, hold_heading=True, success_bonus=5.0, failure_penalty=2.0)
)
READINGS: dict[str, TrainingConfig] = {
    **PRESETS,
    "no ends": replace(_PAPER, ends="none"),
    "clipped": replace(_PAPER, learner=replace(_PAPER.learner, loss="huber", gradient_clip=10.0)),
    "standard target": _STANDARD,
    "ends at the limit": replace(_STANDARD, ends="limit"),
    "updates from the start": replace(_STANDARD, update_from=1),
    "epsilon from 1": replace(_STANDARD, epsilon=1.0),
    "held heading": replace(_STANDARD, rules=replace(PAPER_RULES, hold_heading=True)),
    "tested within actions": replace(_STANDARD, rules=replace(PAPER_RULES, check_every=3)),
    "reward of the outcome": replace(_STANDARD, rules=replace(PAPER_RULES, success_bonus=5.0, failure_penalty=2.0)),
    "half actions": replace(_STANDARD, rules=replace(PAPER_RULES, ticks=25, check_every=25)),
    "robot behind": replace(_STANDARD, starts=_BEHIND),
    "clear": _CLEAR,
    "clear, robot behind": replace(_CLEAR, starts=_BEHIND),
}
"""Readings of paper Alg. 1: the presets, and the paper's with something changed that its text leaves open.

- `no ends` and `clipped` keep the printed target: as printed, with no end of an episode in it; with Huber's loss and
  clipped gradients.
- `standard target` has the two networks of the target the usual way round. Those from `ends at the limit` to
  `robot behind` differ from it in one more point.
- `clear` joins the standard target with a reward that knows the outcome, without the heading term where the direction
  to the goal flips, and tests the outcome within actions.
"""
