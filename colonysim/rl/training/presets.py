"""Parameters of the training of a colony's policy, and the named sets of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal

from pydantic import Field

__all__ = ["PRESETS", "ImitationConfig", "PPOConfig", "PolicyConfig"]

Count = Annotated[int, Field(ge=1)]
Whole = Annotated[int, Field(ge=0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]


@dataclass(frozen=True, slots=True)
class ImitationConfig:
    """Behaviour cloning of the rule: which decisions are gathered, and how they are learned.

    Attributes:
        runs: Runs of the rule whose decisions are gathered, in turn on the places of the training.
        epochs: Passes over these decisions.
        batch: Decisions of a gradient step.
        learning_rate: Of Adam, at the beginning; it falls linearly to nothing.
        held_out: Share of the runs whose decisions are not learned from, but compared with.
    """

    runs: Count = 300
    epochs: Whole = 8
    batch: Count = 256
    learning_rate: Positive = 1e-3
    held_out: Share = 0.1


@dataclass(frozen=True, slots=True)
class PPOConfig:
    """Proximal policy optimisation with one network for all agents.

    Attributes:
        iterations: How often runs are gathered and learned from.
        runs: Runs of an iteration, played side by side.
        epochs: Passes over the decisions of an iteration.
        batch: Decisions of a gradient step.
        learning_rate: Of Adam, for the policy and the critic, at the beginning; it falls linearly to nothing.
        clip: How far the ratio of the chances of an action may move from 1.
        discount: What is worth a reward one travelled edge's time later; rewards are discounted by time, not by step.
        trace_decay: Lambda of the generalised advantage, for each decision.
        entropy: Weight of the policy's entropy, at the beginning; it falls linearly to nothing.
        gradient_clip: Largest norm of a gradient.
        critic: What the critic reads: what the agent is told ("local", IPPO), or besides a summary of the whole state
            ("central", MAPPO).
        critic_first: Iterations in which the critic alone learns, since it starts from nothing and the policy does not.
        own_time: Weight of the agent's own time until it is at the goal, beside the team's.
        failure: What it costs an agent to end its episode elsewhere than at the goal, in travelled edges.
    """

    iterations: Whole = 160
    runs: Count = 24
    epochs: Count = 4
    batch: Count = 512
    learning_rate: Positive = 5e-4
    clip: Positive = 0.2
    discount: Share = 0.99
    trace_decay: Share = 0.95
    entropy: NotNegative = 0.01
    gradient_clip: Positive = 0.5
    critic: Literal["local", "central"] = "central"
    critic_first: Whole = 3
    own_time: NotNegative = 1.0
    failure: NotNegative = 40.0


@dataclass(frozen=True, slots=True)
class PolicyConfig:
    """The training of a colony's policy.

    Attributes:
        name: Of the preset.
        places: How many places it is trained on.
        episodes: Episodes of a run; marks last from one to the next.
        neighbours: Rows of an observation for neighbours: the policy fits places whose nodes have no more.
        boxes: Rows for boxes.
        holes: Rows for holes.
        hidden: Widths of the hidden layers, for each neighbour.
        mirrored: Whether each run is seen turned or mirrored at random, so that no direction is a special one.
        test_every: Iterations between two tests.
        test_places: Places of a test; none of them is trained on.
        imitation: The imitation.
        ppo: The learning after that.
    """

    name: str
    places: Count = 60
    episodes: Count = 3
    neighbours: Count = 8
    boxes: Whole = 4
    holes: Whole = 4
    hidden: tuple[Count, ...] = (48, 48)
    mirrored: bool = True
    test_every: Count = 10
    test_places: Count = 18
    imitation: ImitationConfig = field(default_factory=ImitationConfig)
    ppo: PPOConfig = field(default_factory=PPOConfig)


PRESETS = {
    "small": PolicyConfig("small"),
    "tiny": PolicyConfig(
        "tiny", places=3, episodes=1, hidden=(8, 8), test_every=2, test_places=3,
        imitation=ImitationConfig(runs=6, epochs=2), ppo=PPOConfig(iterations=4, runs=3, epochs=1, critic_first=1),
    ),
}  # fmt: skip
"""`small`: what the shipped policy was trained with. `tiny`: to see in seconds that everything works."""
