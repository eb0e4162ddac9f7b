"""Seeds of training, testing, tuning and judging: apart from one another whatever numbers are given."""

from enum import IntEnum

import numpy as np

__all__ = ["Purpose", "episode_rng"]


class Purpose(IntEnum):
    """What randomness is for; it is part of every seed, so that the same number never means the same draw.

    `JUDGE` is for figures that are quoted; nothing is ever chosen by looking at them.
    """

    LEARNER = 0
    TRAIN = 1
    TEST = 2
    TUNE = 3
    JUDGE = 4
    CLASSIFIER = 5
    WAYS = 6


def episode_rng(purpose: Purpose, seed: int, *index: int) -> np.random.Generator:
    """The stream of one episode (or of the learner itself), independent of all others."""
    return np.random.default_rng([int(purpose), seed, *index])
