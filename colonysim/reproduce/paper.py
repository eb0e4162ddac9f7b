"""What the paper reports and claims, as it stands in `paper.yaml`."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any, Literal

import yaml
from pydantic import BaseModel, ConfigDict, Field

from colonysim.reproduce.judging import Expected, Reported

__all__ = ["Caption", "Claim", "Paper", "PushClaim", "Row", "StyleClaim", "Told", "the_paper"]

Told = Literal["steps", "success"]
"""What the paper's rows tell of a colony."""


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Row(_Part):
    """A row of a performance table."""

    map: str
    variant: str | None = None
    place: str
    steps: tuple[float, float]
    success: tuple[float, float]
    episodes: int

    def reported(self, measure: Told) -> Reported:
        """One of its figures."""
        return Reported(*(self.steps if measure == "steps" else self.success), self.episodes)

    @property
    def label(self) -> str:
        """Map and variant."""
        return f"{self.map} {self.variant}" if self.variant else self.map


class Claim(_Part):
    """A claim about the colony: the trials `where` with the settings `of`, against those with the settings `than`."""

    name: str
    study: str
    place: str
    says: str
    where: dict[str, Any]
    of: dict[str, Any]
    than: dict[str, Any]
    measure: Told
    expected: Expected
    late: bool = False
    why: dict[str, str] = {}
    """Why it may disagree, by policy."""


class PushClaim(_Part):
    """A claim about trainings: the reward of the tests of one setting against another's."""

    says: str
    of: str
    than: str
    part: Literal["start", "end", "all"]
    expected: Expected


class StyleClaim(_Part):
    """A claim about one network for all terrains against one for each."""

    says: str
    terrain: Literal["flat", "slope", "hole"]
    measure: Literal["reward", "success"]
    expected: Expected


class _Style(_Part):
    reward: dict[str, tuple[float, float]]
    success: dict[str, tuple[float, float]]
    training: int


class _Styles(_Part):
    place: str
    pushes: int
    individual: _Style
    all_in_one: _Style = Field(alias="all-in-one")


class Caption(_Part):
    """What the paper says of a figure."""

    place: str
    says: str


class Paper(_Part):
    """All of it."""

    source: str
    performance: tuple[Row, ...]
    reasons: dict[str, dict[str, dict[str, dict[str, str]]]]
    """Why a row may come out otherwise: by place, policy, measure and side."""
    push_style: _Styles
    claims: tuple[Claim, ...]
    push_claims: tuple[PushClaim, ...]
    style_claims: tuple[StyleClaim, ...]
    figures: dict[str, Caption]


@cache
def the_paper() -> Paper:
    """Reads it from the package's data."""
    text = (files("colonysim.reproduce") / "paper.yaml").read_text(encoding="utf-8")
    return Paper.model_validate(yaml.safe_load(text))
