"""What a study has to work with, and where its verdicts go."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from colonysim.reproduce.document import Picture, Table, Text
from colonysim.reproduce.judging import WITHIN, Figure, Verdict, direction

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path
    from typing import Any

    from colonysim.reproduce.document import Block
    from colonysim.reproduce.evidence import Evidence
    from colonysim.reproduce.paper import Paper
    from colonysim.reproduce.plans import Size
    from colonysim.reproduce.push import Trainings

__all__ = ["Context", "Judged"]

IMAGES = "reproduction"


@dataclass(frozen=True)
class Judged:
    """A verdict with what it is about."""

    study: str
    about: str
    with_what: str
    verdict: Verdict
    digits: int = 2


@dataclass
class Context:
    """A reproduction under way.

    Attributes:
        out: Its directory.
        size: How much is run.
        paper: What the paper reports.
        evidence: The trials.
        trainings: Stored trainings of the push, if there are any.
        stored_in: For each engine whose runs were not made here, the name of the file that they come from.
        judged: All verdicts so far.
        gaps: What could not be shown, and why.
    """

    out: Path
    size: Size
    paper: Paper
    evidence: Evidence
    trainings: Trainings | None
    stored_in: Mapping[str, str]
    judged: list[Judged] = field(default_factory=list)
    gaps: list[str] = field(default_factory=list)

    @property
    def runs(self) -> Path:
        """Where recorded runs are."""
        return self.out / "runs"

    @property
    def images(self) -> Path:
        """Where images are."""
        return self.out / IMAGES

    def picture(self, name: str) -> list[Block]:
        """An image beside what the paper says of its own."""
        caption = self.paper.figures[name]
        return [
            Picture(f"{IMAGES}/{name}.png", name.replace("-", " ")),
            Text(f"*The paper, `{caption.place}`:* {caption.says}"),
        ]

    def judge(self, study: str, about: str, with_what: str, verdict: Verdict, digits: int = 2) -> str:
        """Keeps a verdict; returns it as a table's cell."""
        self.judged.append(Judged(study, about, with_what, verdict, digits))
        return verdict.word

    def claims(self, study: str, groups: Sequence[tuple[str, Mapping[str, Any]]], late: tuple[int, int]) -> list[Block]:
        """The table of the claims that a study tests, under each of some groups of settings (label, settings)."""
        rows = []
        for claim in (claim for claim in self.paper.claims if claim.study == study):
            span, digits = late if claim.late else None, 1 if claim.measure == "steps" else 3
            for label, more in groups:
                where = {**claim.where, **more}
                one, other = self.evidence.pairs({**where, **claim.of}, {**where, **claim.than}, claim.measure, span)
                verdict = direction(one, other, claim.expected, WITHIN.get(claim.measure))
                sides = [_shown(values, claim.measure, digits) for values in (one, other)]
                word = self.judge(study, claim.says, label, verdict, digits)
                difference = verdict.difference.shown(digits, sign=True) if verdict.difference else "-"
                what = f"{claim.measure}{f', episodes {late[0]}-{late[1]}' if claim.late else ''}"
                tested = f"{what}: {_settings(claim.of)} against {_settings(claim.than)}"
                says = f"{claim.says} (`{claim.place}`)"
                why = claim.why.get(str(more["policy"]), "") if word == "disagrees" else ""
                rows.append([
                    says, label, tested, *sides, difference, str(len(one)), f"{word}: {why}" if why else word,
                ])  # fmt: skip
        columns = ["the paper claims", "rules", "tested", "first", "second", "difference [95 %]", "seeds", "verdict"]
        return [Table(columns, rows)] if rows else []


def _settings(settings: Mapping[str, Any]) -> str:
    return ", ".join(f"`{name.removeprefix('policy.')}` {value}" for name, value in settings.items())


def _shown(values: Sequence[float], measure: str, digits: int) -> str:
    figure = Figure.of(values, WITHIN.get(measure))
    return figure.shown(digits) if figure else "-"
