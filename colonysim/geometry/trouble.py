"""What is wrong with a place, with the lengths in it: they are told in metres, whatever they were worked out in."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from colonysim.errors import ScenarioError
    from colonysim.scenario.scenario import Scenario

__all__ = ["Trouble"]


class Trouble(Exception):  # noqa: N818 - most are returned, and compared, before one of them is raised
    """Why a place cannot be built, or robots cannot use it.

    Args:
        path: The field it is about, such as "edges.3".
        words: What is wrong, with a `{}` or `{:.2f}` in the place of each length.
        lengths: The lengths, in units of the robot.
        away: How far apart two things are, in the same units; 0 if it is not about that.
        needed: A distance that would be enough; 0 if the words say what was expected, or it is not about that.
    """

    def __init__(self, path: str, words: str, *lengths: float, away: float = 0.0, needed: float = 0.0) -> None:
        super().__init__(path, words, *lengths)
        self.path, self.words, self.lengths = path, words, lengths
        self.away, self.needed = away, needed

    def fault(self, scenario: Scenario, unit: float) -> ScenarioError:
        """The error that says so to whoever wrote the scenario.

        Args:
            scenario: The scenario.
            unit: Metres in a unit of the robot.
        """
        return scenario.fault(self.path, self.words.format(*(unit * length for length in self.lengths)))
