"""The faults of a colony: what a scenario says of what goes wrong."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from colonysim.scenario.format import FaultsSection

__all__ = ["Faults", "faults_of"]


@dataclass(frozen=True, slots=True)
class Faults:
    """How often what goes wrong, and a seed for it.

    Attributes:
        seed: Together with the run's seed it makes the random streams of the faults.
        move_fails: Chance that a move fails: its time passes, and nothing has moved.
        box_missed: Chance, at each look, that an agent does not see a box within R.
        node_misplaced: Standard deviation, along x and along y, of where nodes seem to lie at each look, graph units.
        mark_lost: Chance that an agent that is to leave marks of a field leaves none.
        mark_noise: Relative standard deviation of a field's value as an agent reads it, one error for each look.
        stop_every: Mean simulated seconds from the end of an agent's stop to its next one; 0 for no stops.
        stop_seconds: How long each stop is, simulated seconds.
    """

    seed: int = 0
    move_fails: float = 0.0
    box_missed: float = 0.0
    node_misplaced: float = 0.0
    mark_lost: float = 0.0
    mark_noise: float = 0.0
    stop_every: float = 0.0
    stop_seconds: float = 0.0

    @property
    def of_sensors(self) -> bool:
        """Whether what agents see or read may be wrong."""
        return self.box_missed > 0.0 or self.node_misplaced > 0.0 or self.mark_noise > 0.0

    @property
    def of_acts(self) -> bool:
        """Whether what agents do may go wrong."""
        return self.move_fails > 0.0 or self.mark_lost > 0.0 or self.stop_every > 0.0


def faults_of(section: FaultsSection | None) -> Faults | None:
    """The faults that a scenario's file speaks of; None if nothing ever goes wrong."""
    if section is None:
        return None
    stops = section.stops
    found = Faults(
        section.seed, float(section.move_fails), float(section.box_missed), float(section.node_misplaced),
        float(section.mark_lost), float(section.mark_noise), float(stops.every) if stops else 0.0,
        float(stops.seconds) if stops else 0.0,
    )  # fmt: skip
    return found if found.of_sensors or found.of_acts else None
