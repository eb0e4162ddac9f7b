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

PAGES = "reproduction"


@dataclass(frozen=True)
class Judged:
    """A verdict with what it is about.

    Attributes:
        study: The study.
        about: The figure or claim.
        with_what: Rules and executor, or reading, in words.
        verdict: The verdict.
        settings: What was judged, by name: policy, backend and its options, or the reading of a training.
        digits: Of the difference when it is shown.
        why: Why it may have come out so.
    """

    study: str
    about: str
    with_what: str
    verdict: Verdict
    settings: Mapping[str, Any]
    digits: int = 2
    why: str = ""

    @property
    def difference(self) -> str:
        """The difference as text."""
        found = self.verdict.difference
        return found.shown(self.digits, sign=True) if found else "-"


@dataclass
class Context:
    """A reproduction under way.

    Attributes:
        out: Its directory.
        size: How much is run.
        paper: What the paper reports.
        evidence: The trials.
        trainings: Stored trainings of the push, by reading and engine.
        stored_in: For each engine whose runs were not made here, the name of the file that they come from.
        judged: All verdicts so far.
        gaps: What could not be shown, and why.
    """

    out: Path
    size: Size
    paper: Paper
    evidence: Evidence
    trainings: Sequence[Trainings]
    stored_in: Mapping[str, str]
    judged: list[Judged] = field(default_factory=list)
    gaps: list[str] = field(default_factory=list)

    @property
    def runs(self) -> Path:
        """Where recorded runs are."""
        return self.out / "runs"

    @property
    def pages(self) -> Path:
        """Where the pages and their images are."""
        return self.out / PAGES

    def picture(self, name: str) -> list[Block]:
        """An image beside what the paper says of its own."""
        caption = self.paper.figures[name]
        return [
            Picture(f"{name}.png", name.replace("-", " ")),
            Text(f"*The paper, `{caption.place}`:* {caption.says}"),
        ]

    def judge(self, judged: Judged) -> str:
        """Keeps a verdict, unless there is nothing that could be compared; returns it as a table's cell."""
        verdict = judged.verdict
        if verdict.difference is None:
            return "no runs"
        self.judged.append(judged)
        if verdict.word == "undecided":
            return f"{verdict.word}: {verdict.wanting}"
        return f"{verdict.word}: {judged.why}" if judged.why else verdict.word

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
                why = claim.why.get(str(more["policy"]), "") if verdict.word == "disagrees" else ""
                judged = Judged(study, claim.says, label, verdict, more, digits, why)
                what = f"{claim.measure}{f', episodes {late[0]}-{late[1]}' if claim.late else ''}"
                tested = f"{what}: {_settings(claim.of)} against {_settings(claim.than)}"
                says = f"{claim.says} (`{claim.place}`)"
                rows.append([says, label, tested, *sides, judged.difference, str(len(one)), self.judge(judged)])
        columns = ["the paper claims", "rules", "tested", "first", "second", "difference [95 %]", "seeds", "verdict"]
        return [Table(columns, rows)] if rows else []


def _settings(settings: Mapping[str, Any]) -> str:
    return ", ".join(f"`{name.removeprefix('policy.')}` {value}" for name, value in settings.items())


def _shown(values: Sequence[float], measure: str, digits: int) -> str:
    figure = Figure.of(values, WITHIN.get(measure))
    return figure.shown(digits) if figure else "-"
