"""Named random streams: every stream depends on the run's seed and its own name, on nothing else."""

from __future__ import annotations

import hashlib
import random
from dataclasses import dataclass

from colonysim.draws import Draws

__all__ = ["Streams"]


class _Generator(random.Random):
    """`random.Random`, without the dictionary that each instance of that keeps for a single attribute: 330 bytes."""

    __slots__ = ("gauss_next",)


@dataclass(frozen=True, slots=True)
class Streams:
    """The random streams of a run, or of a part of it.

    A stream is derived from the seed and its path of names, not from the order in which streams are
    made, so that an agent more, a plot or a worker changes no other stream.

    Example:
        >>> streams = Streams(seed=1)
        >>> streams.generator("agent/3").random() == Streams(seed=1).generator("agent/3").random()
        True
    """

    seed: int
    path: str = ""

    def within(self, name: str) -> Streams:
        """The streams below `name`, for example those of one episode."""
        return Streams(self.seed, f"{self.path}{name}/")

    def derive(self, name: str) -> int:
        """A 64-bit seed for the stream called `name`; for libraries that seed themselves."""
        digest = hashlib.sha256(f"{self.seed}:{self.path}{name}".encode()).digest()
        return int.from_bytes(digest[:8], "big")

    def generator(self, name: str) -> random.Random:
        """A fresh generator for the stream called `name`.

        `random.Random` (Mersenne Twister) gives the same numbers on every machine and version.
        """
        return _Generator(self.derive(name))

    def draws(self, name: str, count: int) -> Draws:
        """Fresh streams called `name` for each of `count`, of uniform numbers only; one more changes no other."""
        return Draws(self.derive(name), count)
