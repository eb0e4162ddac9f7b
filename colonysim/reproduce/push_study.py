"""The push's part of the report."""

from __future__ import annotations

from itertools import product
from statistics import fmean
from typing import TYPE_CHECKING

from colonysim.reproduce.context import Judged
from colonysim.reproduce.document import Block, Heading, Picture, Table, Text
from colonysim.reproduce.judging import WITHIN, Figure, Reported, direction, level
from colonysim.reproduce.push import ALL_IN_ONE, ASKED, INDIVIDUAL, LETTER, PANELS, TRIAL

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from typing import Any

    from colonysim.reproduce.context import Context
    from colonysim.reproduce.judging import Expected, Verdict
    from colonysim.reproduce.push import Trainings

__all__ = ["push_part"]

_DIVERGED = 100.0
"""A loss above this means that values have diverged: a return is seldom above 15."""
_CURVES = 4
"""Most curves of a panel."""
_MEANS = {
    LETTER: "the letter of the text; its target takes the two networks the other way round than Double DQN does",
    "standard target": "the letter, but with the two networks of the target the usual way round",
    "clear": (
        "the same as `standard target`, with 5 more of reward for a success and 2 less for a failure, without the turn "
        "of the heading in the reward where the direction to the goal flips, and with actions that end as soon as the "
        "push has succeeded or failed"
    ),
    "improved": "what ships: more inputs, longer returns, demonstrations, mirror images and other starts besides",
}
"""What the readings are, in words."""


def push_part(context: Context) -> list[Block]:
    """The readings of Algorithm 1; of those that were repeated the figures, and the ablations where there are any."""
    trained = context.trainings
    if not trained:
        context.gaps.append("push: no stored trainings; `benchmarks/push_ablation.py run` makes them.")
        return [Text("There are no stored trainings.")]
    blocks: list[Block] = [
        Text(
            f"Stored trainings of {trained[0].episodes} training episodes each, those of the first S actions not "
            "counted. `benchmarks/push_ablation.py run` adds trainings. A reading is a configuration of Algorithm 1, "
            "for its text leaves some things open; all that were thought of stand in `READINGS` of "
            "`colonysim/push/training/presets.py`. Here there are:"
        ),
        Text("\n".join(f"- `{base}`: {_MEANS.get(base, 'see there')}." for base in _bases(trained))),
        *_readings(context, trained),
    ]
    for one in [one for one in trained if one.repeated] or trained[:1]:
        if one.ablated:
            blocks += [Heading(3, f"Claims, with the reading {one.label}"), *_claims(context, one)]
        else:
            blocks += [Heading(3, f"All-in-One, with the reading {one.label}"), _styles(context, one, [ALL_IN_ONE])]
    return blocks


def _bases(trained: Iterable[Trainings]) -> list[str]:
    return list(dict.fromkeys(one.base for one in trained))


def _readings(context: Context, trained: Iterable[Trainings]) -> list[Block]:
    """Each reading on all terrains: its curve, when it was best, and how well its best and its last network push."""
    paper = context.paper.push_style
    theirs = [f"{paper.all_in_one.success[terrain][0]:g}" for terrain in INDIVIDUAL]
    counts = ["1", str(paper.pushes), str(paper.all_in_one.training)]
    rows = [["the paper, All-in-One", "V-REP", *counts, "-", *theirs, "-", "-", "-", ""]]
    curves: dict[str, list[Any]] = {}
    reached: list[str] = []
    for one in trained:
        setting = one.all_terrains()
        there = one.of(setting)
        if not there:
            continue
        curves[f"{one.base}, {one.engine}"] = [row.tests for row in there.values()]
        peak = f"{fmean(row.peak_episode for row in there.values()):.0f}"
        best, last = ([one.success(terrain, last=last) for terrain in INDIVIDUAL] for last in (False, True))
        words = []
        for terrain, figure in zip(INDIVIDUAL, best, strict=True):
            mean, sd = paper.all_in_one.success[terrain]
            words.append(level(figure, Reported(mean, sd, paper.pushes), "success").word)
        shown = [figure.shown(2) if figure else "-" for figure in (*best, *last)]
        said = ", ".join(words) if len(there) > 1 else "one seed"
        if len(there) > 1 and {*words} <= {"agrees", "better"}:
            reached.append(one.label)
        pushes = "/".join(str(count) for count in sorted({row.pushes for row in there.values()}))
        losses = [max(row.losses) for row in there.values() if row.losses]
        largest = f"{max(losses):,.1f}" if losses else "-"
        rows.append([f"`{one.base}`", one.engine, str(len(there)), pushes, peak, largest, *shown, said])
    columns = ["reading", "engine", "seeds", "pushes a terrain", "training episodes at the peak", "largest loss",
               "best network: flat", "slope", "hole", "last network: flat", "slope", "hole",
               "the best beside the paper's: flat, slope, hole"]  # fmt: skip
    blocks: list[Block] = [
        Text(
            "Readings on all terrains at once (All-in-One): mean success over the training seeds, with its 95 % "
            "interval where there are several. Best is the network with the most success in its last 60 test "
            f"episodes. Trainings with seeds from {TRIAL} on are trials by which it was decided what to repeat; they "
            "count only for a setting of a reading that has no others. The largest loss is that of a block of 20 "
            "episodes, the mean of its updates: a return is seldom above 15, so that a loss far above 100 means "
            "that the values have diverged."
        ),
        Table(columns, rows),
        Text(
            f"Of the readings trained with several seeds, {' and '.join(reached) or 'none'} is shown to reach the "
            "paper's success on all three terrains."
        ),
    ]
    if curves:
        from colonysim.plots import save
        from colonysim.plots.learning import ablation_figure

        names = list(curves)
        panels = {
            f"readings {first + 1}-{min(first + _CURVES, len(names))}": {
                n: curves[n] for n in names[first : first + _CURVES]
            }
            for first in range(0, len(names), _CURVES)
        }
        save(
            ablation_figure(panels, "readings of Algorithm 1", "success"),
            context.pages / "push-readings.png",
            "png",
            80,
        )
        blocks.append(
            Picture("push-readings.png", "Success of the tests by training episodes, mean of eight tests of 20")
        )
    return blocks


def _claims(context: Context, trained: Trainings) -> list[Block]:
    counts = {setting: len(trained.of(setting)) for setting in ASKED}
    few = [f"`{setting}` ({count})" for setting, count in counts.items() if count < 2]
    blocks: list[Block] = []
    if few:
        gap = f"fewer than two trainings of {', '.join(few)}, hence no intervals and no verdicts."
        context.gaps.append(f"push, {trained.label}: {gap}")
        blocks.append(Text(f"**Missing:** {gap}"))
    panels = {
        title: {label: [row.tests for row in trained.of(name).values()] for label, name in curves.items()}
        for title, curves in PANELS.items()
    }
    if any(seeds for curves in panels.values() for seeds in curves.values()):
        from colonysim.plots import save
        from colonysim.plots.learning import ablation_figure

        name = f"push-ablation-{trained.base}-{trained.engine}".replace(" ", "-").replace(",", "")
        save(
            ablation_figure(panels, f"{trained.base}, {trained.engine}, holes"),
            context.pages / f"{name}.png",
            "png",
            80,
        )
        caption = context.paper.figures["push-ablation"]
        blocks += [
            Picture(f"{name}.png", "Reward of the tests by training episodes, mean of eight tests of 20"),
            Text(f"*The paper, `{caption.place}`:* {caption.says}"),
        ]
    blocks.append(
        Text(
            "Trainings on holes alone. The paper's *end* is the last third of the tests, its *initial* performance the "
            "first third, *faster* and *slower* mean more or less reward over all tests; *first* and *second* are the "
            "two settings in the order in which the claim names the better one first. The reward of tests, in the "
            "image and the next table, is the one that the reading itself trains with, "
            "which for `clear` holds its 5 more for a success and 2 less for a failure; that of the pushes further "
            "down is the paper's (Eq. 8) for every reading."
        )
    )
    rows = []
    for claim in context.paper.push_claims:
        one, other = trained.claimed(claim)
        rows.append(_compared(context, trained, claim.says, one, other, claim.expected, "reward"))
    columns = ["the paper claims", "first", "second", "difference [95 %]", "trainings", "verdict"]
    styles = _styles(context, trained, ["individual", ALL_IN_ONE])
    blocks += [Table(columns, rows), Text("One network for all terrains, or one for each:"), styles]
    rows = []
    for style in context.paper.style_claims:
        one, other = trained.styles(style)
        says = f"{style.says} ({style.measure})"
        rows.append(_compared(context, trained, says, one, other, style.expected, style.measure))
    one, other = trained.spent()
    says = "All-in-one needs fewer training episodes than the three individuals together."
    rows.append(_compared(context, trained, says, one, other, "less", "episodes"))
    return [*blocks, Table(columns, rows)]


def _settings(trained: Trainings) -> Mapping[str, Any]:
    return {"base": trained.base, "engine": trained.engine, "letter": trained.base == LETTER}


def _styles(context: Context, trained: Trainings, styles: Iterable[str]) -> Block:
    paper = context.paper.push_style
    rows = []
    for style in styles:
        theirs = paper.all_in_one if style == ALL_IN_ONE else paper.individual
        for measure, terrain in product(("reward", "success"), INDIVIDUAL):
            mean, sd = getattr(theirs, measure)[terrain]
            setting = ALL_IN_ONE if style == ALL_IN_ONE else INDIVIDUAL[terrain]
            ours = Figure.of(list(trained.pushed(setting, terrain, measure).values()), WITHIN.get(measure))
            verdict = level(ours, Reported(mean, sd, paper.pushes), measure)
            about = f"{measure} on {terrain} ({style}) (`{paper.place}`)"
            judged = Judged("push", about, trained.label, verdict, _settings(trained), why=_why(trained, verdict))
            word = context.judge(judged)
            shown, count = (ours.shown(2), ours.count) if ours else ("-", 0)
            rows.append([style, terrain, measure, f"{mean:g} ± {sd:g}", shown, str(count), word])
    columns = ["style", "terrain", "measure", f"the paper, {paper.pushes} pushes", "ours", "trainings", "verdict"]
    return Table(columns, rows)


def _why(trained: Trainings, verdict: Verdict) -> str:
    """Why networks of the letter are worse, if what they have learned says so."""
    largest = max((loss for row in trained.rows for loss in row.losses), default=0.0)
    if trained.base != LETTER or verdict.word != "disagrees" or largest < _DIVERGED:
        return ""
    return (
        "To the letter the values of actions diverge: the target that the paper prints takes the two networks the "
        f"other way round than Double DQN does, and the loss reaches {largest:,.0f} on {trained.engine}, which no "
        "return can explain."
    )


def _compared(
    context: Context,
    trained: Trainings,
    says: str,
    one: list[float],
    other: list[float],
    expected: Expected,
    measure: str,
) -> list[str]:
    verdict = direction(one, other, expected, WITHIN.get(measure))
    judged = Judged("push", says, trained.label, verdict, _settings(trained))
    figures = [Figure.of(values, WITHIN.get(measure)) for values in (one, other)]
    sides = [figure.shown(2) if figure else "-" for figure in figures]
    return [says, *sides, judged.difference, str(len(one)), context.judge(judged)]
