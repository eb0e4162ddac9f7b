"""The pages of the report: a first one that says what holds, one for the verdicts, and those of the studies."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from colonysim import __version__
from colonysim.reproduce.document import Block, Heading, Page, Table, Text
from colonysim.reproduce.judging import RULE, WORDS
from colonysim.reproduce.summary import summary

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.reproduce.context import Context

__all__ = ["PAGES", "report"]

PAGES = {
    "performance": ("Performance", "the paper's tables of steps and success, on the node world and with rigid bodies"),
    "fit": (
        "The unprinted parameters",
        "which values bring the paper's rules closest to its rows",
    ),
    "ablations": (
        "Ablations and asynchrony",
        "the five parameters; agents that act all at once or in their own time",
    ),
    "pheromones": ("Pheromones and trajectories", "what the fields become and how the robots drive"),
    "push": ("The push", "Algorithm 1 in several readings, its ablations, one network against three"),
}
"""The pages that studies stand on: title, and what is there."""


def report(context: Context, studies: Mapping[str, Sequence[Block]], asked: str) -> list[Page]:
    """All pages, the first one first.

    Args:
        context: The reproduction, its studies done.
        studies: By page, what the studies on it have made.
        asked: The command's arguments.
    """
    there = {name: PAGES[name] for name in PAGES if name in studies}
    links = [f"- [{title}]({name}.md): {about}." for name, (title, about) in there.items()]
    links.append("- [Verdicts](verdicts.md): the rule, and every figure and claim with its verdict.")
    size = context.size
    first: list[Block] = [
        Heading(1, "The paper, reproduced"),
        *summary(context),
        Heading(2, "Pages"),
        Text("\n".join(links)),
        Heading(2, "How it was made"),
        Text(
            f"{context.paper.source}, beside colonysim {__version__}. Made by `colonysim reproduce{asked}`: node "
            f"world with seeds {size.first_seed}-{size.first_seed + size.seeds - 1}, {size.episodes} episodes a run. "
            "`paper` is the paper's own rules with their contradictions repaired, `colony` the recommended ones. "
            "The paper's images are not to be had; its captions and numbers stand in their place."
        ),
    ]
    if context.gaps:
        first += [Heading(2, "What is missing"), Text("\n".join(f"- {gap}" for gap in context.gaps))]
    pages = [Page("index", first)]
    pages += [Page(name, [Heading(1, title), *studies[name]]) for name, (title, _) in there.items()]
    return [*pages, Page("verdicts", _verdicts(context))]


def _verdicts(context: Context) -> list[Block]:
    counts = Counter(each.verdict.word for each in context.judged)
    words = ", ".join(f"{counts[word]} *{word}*" for word in WORDS)
    blocks: list[Block] = [
        Heading(1, "Verdicts"),
        Heading(2, "The rule"),
        *[Text(part) for part in RULE.strip().split("\n\n")],
        Heading(2, "At a glance"),
        Text(f"Of {len(context.judged)} comparisons: {words}."),
    ]
    rows = [
        [each.about, each.study, each.with_what, each.difference, each.verdict.word, each.verdict.wanting]
        for each in context.judged
    ]
    columns = ["about", "study", "with", "difference or share [95 %]", "verdict", "what it would take"]
    return [*blocks, Table(columns, rows)] if rows else blocks
