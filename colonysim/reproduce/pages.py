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
    "performance": (
        "Performance",
        "the paper's tables of steps and success, on the node world and with rigid bodies",
        "How long an episode takes and how many of the robots reach the goal: the paper's table beside ours. A *step* "
        "is an edge of the map that a robot begins to drive or push along. An episode's *steps* are those of the "
        "robot with the most, or the limit (50 on easy and medium, 80 on hard) where not all reached the goal; its "
        "*success* is the share of robots that did. The paper's ± is the standard deviation over its episodes, our "
        "brackets hold the 95 % interval of the mean over seeds. A *seed* makes all chance of a run, and each run of "
        "many episodes keeps its marks from one episode to the next.",
    ),
    "fit": (
        "The unprinted parameters",
        "which values bring the paper's rules closest to its rows",
        "The paper names five parameters whose values it does not print: beta (how strictly agents follow the larger "
        "mark), epsilon (how often they do something else) and its decay, B_decay (by how much the mark of a box "
        "falls when somebody takes it), and what that mark starts from. Two rules are varied with them: `collision`, "
        "whether an agent keeps off nodes with another agent on them or beside them (`two_node`, as the paper prints "
        "it) or reserves the node that it goes to (`reservation`); and `box_credit`, whether a box gains as an agent "
        "steps onto the hole that it fills (`enter`) or off it (`leave`). Here we look for the values that bring the "
        "paper's rules nearest to its five rows, and for what no values explain.",
    ),
    "ablations": (
        "Ablations and asynchrony",
        "the five parameters; agents that act all at once or in their own time",
        "What changes if one parameter is set to other values and the rest stays; and whether it matters that agents "
        "act all at once (*synchronous*), or each as soon as it has finished what it did (*asynchronous*).",
    ),
    "pheromones": (
        "Pheromones and trajectories",
        "what the fields become and how the robots drive",
        "Four marks, called pheromones, guide an agent. *D* is larger the nearer a node is to the goal, *E* the more "
        "often a node was visited, *H* the nearer it is to an open hole, and *B* tells for each box how much it has "
        "been worth in each hole. *Official* is the paper's word for a node whose distance was found by driving and "
        "not by a straight line.",
    ),
    "push": (
        "The push",
        "Algorithm 1 in several readings, its ablations, one network against three",
        "How a network learns to push one box to the next node: on flat ground, up a slope, or into a hole. The "
        "paper's Algorithm 1 is Double DQN; b is the number of examples of one update, S the number of first actions "
        "that are drawn by lot, M the number of updates between two copies of the learning network to the one that "
        "its targets are taken from. *Success* is the share of pushes that end as they should, *reward* the sum of "
        "the rewards of a push.",
    ),
}
"""The pages that studies stand on: title, what is there in half a line, and what a newcomer has to know."""


def report(context: Context, studies: Mapping[str, Sequence[Block]], asked: str) -> list[Page]:
    """All pages, the first one first.

    Args:
        context: The reproduction, its studies done.
        studies: By page, what the studies on it have made.
        asked: The command's arguments.
    """
    there = {name: PAGES[name] for name in PAGES if name in studies}
    links = [f"- [{title}]({name}.md): {about}." for name, (title, about, _) in there.items()]
    links.append("- [Verdicts](verdicts.md): the rule, and every figure and claim with its verdict.")
    size = context.size
    run = (
        f": node world with seeds {size.first_seed}-{size.first_seed + size.seeds - 1}, {size.episodes} episodes a run"
        if any(trial.settings["backend"] == "nodeworld" for trial in context.evidence.trials)
        else ""
    )
    first: list[Block] = [
        Heading(1, "The paper, reproduced"),
        *summary(context),
        Heading(2, "Pages"),
        Text("\n".join(links)),
        Heading(2, "How it was made"),
        Text(
            f"{context.paper.source}, beside colonysim {__version__}. Made by `colonysim reproduce{asked}`{run}. "
            "The paper's images are not to be had; its captions and numbers stand in their place."
        ),
    ]
    if context.gaps:
        first += [Heading(2, "What is missing"), Text("\n".join(f"- {gap}" for gap in context.gaps))]
    pages = [Page("index", first)]
    pages += [Page(name, [Heading(1, title), Text(words), *studies[name]]) for name, (title, _, words) in there.items()]
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
