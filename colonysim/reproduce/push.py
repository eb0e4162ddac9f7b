"""The push's part of the paper: ablations, styles of training and readings of Algorithm 1, from stored trainings."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import fmean
from typing import TYPE_CHECKING

from colonysim.reproduce.judging import WITHIN, Figure
from colonysim.reproduce.stored import ALL_IN_ONE, OWN, StoredTraining, stored_rows

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from colonysim.push.task import Kind
    from colonysim.reproduce.paper import PushClaim, StyleClaim

__all__ = ["ALL_IN_ONE", "ASKED", "INDIVIDUAL", "LETTER", "PANELS", "TRIAL", "Trainings"]

PANELS = {
    "batch size b": {"b = 64": "batch 64", "b = 128": "base", "b = 256": "batch 256"},
    "exploration steps S": {"S = 1000": "base", "S = 3000": "explore 3000", "S = 5000": "explore 5000"},
    "target update M": {"M = 300": "base", "M = 600": "target 600", "M = 1200": "target 1200"},
}
"""Panels of the figure and what their curves are called; `base` is b = 128, S = 1000, M = 300, on holes."""
INDIVIDUAL: dict[Kind, str] = {"flat": "individual flat", "slope": "individual slope", "hole": "base"}
ASKED = tuple(
    dict.fromkeys([*(name for panel in PANELS.values() for name in panel.values()), *INDIVIDUAL.values(), ALL_IN_ONE])
)
"""The settings that the paper's claims are about."""
TRIAL = 100
"""Trainings with seeds from here on decide which readings are repeated, and count only where there are no others."""
LETTER = "paper"
"""The reading that is the paper's letter."""


@dataclass(frozen=True)
class Trainings:
    """Trainings of one reading on one engine and of one length, as `benchmarks/push_ablation.py` stores them.

    Attributes:
        base: The reading of Algorithm 1.
        engine: The rigid-body engine.
        episodes: Training episodes of each, exploration not counted.
        rows: The trainings.
    """

    base: str
    engine: str
    episodes: int
    rows: tuple[StoredTraining, ...]

    @classmethod
    def read(cls, path: Path) -> tuple[list[Trainings], list[str]]:
        """The trainings of a file, those of the paper's letter first, then by how many there are.

        Returns:
            The trainings by reading and engine, and what of the file was left out and why, a text for each reason.

        Raises:
            ColonysimError: The file cannot be read, or is none of these.
        """
        rows, gaps = stored_rows(path, StoredTraining)
        groups: dict[tuple[str, str], list[StoredTraining]] = {}
        for row in rows:
            groups.setdefault((row.base, row.engine), []).append(row)
        found = [cls(base, engine, rows[0].episodes, tuple(group)) for (base, engine), group in groups.items()]
        return sorted(found, key=lambda trained: (trained.base != LETTER, -len(trained.rows), trained.label)), gaps

    @property
    def label(self) -> str:
        """Reading and engine, in words."""
        return f"`{self.base}`, {self.engine}"

    @property
    def repeated(self) -> bool:
        """Whether some setting was trained with several seeds, so that there are intervals."""
        return any(len(self.of(setting)) > 1 for setting in ASKED)

    @property
    def ablated(self) -> bool:
        """Whether there are trainings with other settings than All-in-One, as most of the paper's claims need."""
        return any(self.of(setting) for setting in ASKED if setting != ALL_IN_ONE)

    def of(self, setting: str) -> dict[int, StoredTraining]:
        """The trainings of a setting by seed: those of seeds below `TRIAL`, or, if there are none, the trial ones."""
        found = {row.seed: row for row in self.rows if row.setting == setting}
        return {seed: row for seed, row in found.items() if seed < TRIAL} or found

    def rewards(self, setting: str, part: str) -> dict[int, float]:
        """Mean reward of the tests of each seed: of their first third ("start"), the last ("end"), or "all"."""
        found = {}
        for seed, row in self.of(setting).items():
            values = [test[3] for test in row.tests]
            third = max(1, len(values) // 3)
            found[seed] = fmean({"start": values[:third], "end": values[-third:], "all": values}[part])
        return found

    def pushed(self, setting: str, terrain: Kind, measure: str, *, last: bool = False) -> dict[int, float]:
        """Success or mean reward of the pushes after each training on a terrain, with its best or its last network."""
        column = 0 if measure == "success" else 1
        found = {seed: row.pushed_last if last else row.pushed for seed, row in self.of(setting).items()}
        return {seed: pushed[terrain][column] for seed, pushed in found.items() if terrain in pushed}

    def all_terrains(self) -> str:
        """The setting that was trained on all terrains: the paper's All-in-One, else the reading's own."""
        return ALL_IN_ONE if self.of(ALL_IN_ONE) or not self.of(OWN) else OWN

    def success(self, terrain: Kind, *, last: bool = False) -> Figure | None:
        """Success on a terrain of the best or the last networks of the trainings on all terrains; None of none."""
        found = self.pushed(self.all_terrains(), terrain, "success", last=last)
        return Figure.of(list(found.values()), WITHIN["success"])

    def claimed(self, claim: PushClaim) -> tuple[list[float], list[float]]:
        """The two sides of a claim, for the seeds that both have."""
        return _pairs(self.rewards(claim.of, claim.part), self.rewards(claim.than, claim.part))

    def styles(self, claim: StyleClaim) -> tuple[list[float], list[float]]:
        """All-in-one and individual, for the seeds that both have."""
        one = self.pushed(ALL_IN_ONE, claim.terrain, claim.measure)
        return _pairs(one, self.pushed(INDIVIDUAL[claim.terrain], claim.terrain, claim.measure))

    def spent(self) -> tuple[list[float], list[float]]:
        """Training episodes until the network that was kept: all-in-one, and the three individuals together."""
        peaks = [{seed: row.peak_episode for seed, row in self.of(name).items()} for name in INDIVIDUAL.values()]
        together = {seed: sum(p[seed] for p in peaks) for seed in peaks[0] if all(seed in p for p in peaks)}
        return _pairs({seed: row.peak_episode for seed, row in self.of(ALL_IN_ONE).items()}, together)


def _pairs(one: Mapping[int, float], other: Mapping[int, float]) -> tuple[list[float], list[float]]:
    both = sorted(one.keys() & other.keys())
    return [one[seed] for seed in both], [other[seed] for seed in both]
