"""Where the fields of a scenario stand, so that a message can point at the right line."""

from __future__ import annotations

import difflib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from colonysim.errors import ScenarioError

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = ["Places", "nearest_word"]


@dataclass(frozen=True, slots=True)
class Places:
    """Positions of the fields of one scenario.

    Attributes:
        source: Where it came from: a path or a name.
        positions: Line and column (from 1) of each field, by dotted path; empty if there is no file.
        overrides: For each field set from outside the file, how that was said ("--set policy.beta=2").
    """

    source: str
    positions: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    overrides: Mapping[str, str] = field(default_factory=dict)

    def fault(self, path: str, message: str) -> ScenarioError:
        """An error that says where `path` stands, or what stands nearest above it."""
        place = path
        while place and place not in self.positions and place not in self.overrides:
            place = place.rpartition(".")[0]
        if place in self.overrides:
            override = self.overrides[place]
            return ScenarioError(f"{override}: {message}" if place == path else f"{override}: {path}: {message}")
        at = self.source
        if self.positions:
            line, column = self.positions.get(place, (1, 1))
            at = f"{at}:{line}:{column}"
        return ScenarioError(f"{at}: {path}: {message}" if path else f"{at}: {message}")


def nearest_word(word: str, words: Iterable[str]) -> str:
    """The clause "; did you mean 'x'?" for the word most like `word`, or nothing if none is like it."""
    known = {name.lower(): name for name in words}
    found = difflib.get_close_matches(word.lower(), known, n=1, cutoff=0.55)
    if not found:
        found = [name for name in known if word and (name.startswith(word.lower()) or word.lower() in name)][:1]
    return f"; did you mean '{known[found[0]]}'?" if found else ""
