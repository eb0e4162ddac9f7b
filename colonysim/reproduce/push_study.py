"""The push's part of the report."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

from colonysim.reproduce.document import Block, Heading, Table, Text
from colonysim.reproduce.judging import WITHIN, Figure, Reported, direction, level
from colonysim.reproduce.push import ALL_IN_ONE, INDIVIDUAL, PANELS, SETTINGS

if TYPE_CHECKING:
    from colonysim.reproduce.context import Context
    from colonysim.reproduce.judging import Expected
    from colonysim.reproduce.push import Trainings

__all__ = ["push_part"]


def push_part(context: Context) -> list[Block]:
    """The ablations of the push's training, and one network against three."""
    trainings = context.trainings
    if trainings is None:
        context.gaps.append("push: no stored trainings; `benchmarks/push_ablation.py run` makes them.")
        return [Text("There are no stored trainings.")]
    counts = {setting: len(trainings.of(setting)) for setting in SETTINGS}
    few = [f"`{setting}` ({count})" for setting, count in counts.items() if count < 3]
    blocks: list[Block] = [
        Text(
            f"Stored trainings of the preset `{trainings.base}`, {trainings.episodes} training episodes each. Rewards "
            "are those of the tests between the blocks of training; `benchmarks/push_ablation.py run` adds trainings."
        )
    ]
    if few:
        gap = f"fewer than three trainings of {', '.join(few)}; with one there is no interval, hence no verdict."
        context.gaps.append(f"push: {gap}")
        blocks.append(Text(f"**Missing:** {gap}"))
    panels = {
        title: {label: [row["tests"] for row in trainings.of(name).values()] for label, name in curves.items()}
        for title, curves in PANELS.items()
    }
    if any(seeds for curves in panels.values() for seeds in curves.values()):
        from colonysim.plots import save
        from colonysim.plots.learning import ablation_figure

        save(ablation_figure(panels, f"preset {trainings.base}"), context.images / "push-ablation.png", "png", 80)
        blocks += context.picture("push-ablation")
    rows = []
    for claim in context.paper.push_claims:
        one, other = trainings.claimed(claim)
        rows.append(_compared(context, claim.says, one, other, claim.expected, "reward"))
    columns = ["the paper claims", "first", "second", "difference [95 %]", "trainings", "verdict"]
    blocks += [Table(columns, rows), Heading(3, "One network or three"), _styles(context, trainings)]
    rows = []
    for style in context.paper.style_claims:
        one, other = trainings.styles(style)
        says = f"{style.says} ({style.measure})"
        rows.append(_compared(context, says, one, other, style.expected, style.measure))
    one, other = trainings.spent()
    says = "All-in-one needs fewer training episodes than the three individuals together."
    rows.append(_compared(context, says, one, other, "less", "episodes"))
    return [*blocks, Table(columns, rows)]


def _styles(context: Context, trainings: Trainings) -> Block:
    paper = context.paper.push_style
    rows = []
    for style, theirs in (("individual", paper.individual), ("all-in-one", paper.all_in_one)):
        for measure, terrain in product(("reward", "success"), INDIVIDUAL):
            mean, sd = getattr(theirs, measure)[terrain]
            setting = INDIVIDUAL[terrain] if style == "individual" else ALL_IN_ONE
            ours = Figure.of(list(trainings.pushed(setting, terrain, measure).values()), WITHIN.get(measure))
            verdict = level(ours, Reported(mean, sd, paper.pushes), measure)
            word = context.judge("push", f"{measure} on {terrain}, {style} (`{paper.place}`)", "trainings", verdict)
            shown, count = (ours.shown(2), ours.count) if ours else ("-", 0)
            rows.append([style, terrain, measure, f"{mean:g} ± {sd:g}", shown, str(count), word])
    columns = ["style", "terrain", "measure", f"the paper, {paper.pushes} pushes", "ours", "trainings", "verdict"]
    return Table(columns, rows)


def _compared(
    context: Context, says: str, one: list[float], other: list[float], expected: Expected, measure: str
) -> list[str]:
    verdict = direction(one, other, expected, WITHIN.get(measure))
    word = context.judge("push", says, "trainings", verdict)
    figures = [Figure.of(values, WITHIN.get(measure)) for values in (one, other)]
    sides = [figure.shown(2) if figure else "-" for figure in figures]
    difference = verdict.difference.shown(2, sign=True) if verdict.difference else "-"
    return [says, *sides, difference, str(len(one)), word]
