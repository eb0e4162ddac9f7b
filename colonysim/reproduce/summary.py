"""What of the paper holds, in half a page: sentences made from the verdicts."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import product
from statistics import fmean
from typing import TYPE_CHECKING, Any

from colonysim.physics import ENGINES
from colonysim.reproduce.document import Block, Table, Text
from colonysim.reproduce.judging import WITHIN, Figure
from colonysim.reproduce.push import INDIVIDUAL

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from colonysim.reproduce.context import Context, Judged

__all__ = ["summary"]

_NAMED = 4
"""Comparisons that a sentence names one by one; of more it says how many."""


@dataclass(frozen=True)
class Topic:
    """What a sentence is about.

    Attributes:
        says: Its subject.
        studies: The studies whose verdicts count.
        settings: What the judged settings have to be.
    """

    says: str
    studies: tuple[str, ...]
    settings: Mapping[str, Any]

    def of(self, judged: Sequence[Judged]) -> list[Judged]:
        """The verdicts that it is about."""
        return [
            each for each in judged if each.study in self.studies and self.settings.items() <= each.settings.items()
        ]


_RULES = ("ablation-sanity", "ablation-easy", "asynchrony", "hole-edge-case")
_FIELDS = ("pheromones-sanity", "pheromones-easy", "pheromones-medium", "pheromones-hard")
TOPICS = (
    Topic(
        "The paper's own system with rigid bodies (its rules, a learned push, its classifier)",
        ("performance-physics",),
        {"policy": "paper", "backend.push": "rl", "backend.feasibility": "forest"},
    ),
    Topic("Its rules on the node world, where every push succeeds", ("performance-nodeworld",), {"policy": "paper"}),
    Topic("Its five rows on the node world at the parameters that fit them best", ("fit",), {"policy": "paper"}),
    Topic(
        "What it says of parameters, asynchrony and pheromones, under its rules", _RULES + _FIELDS, {"policy": "paper"}
    ),
    Topic("The learning of its push, Algorithm 1 to the letter", ("push",), {"base": "paper"}),
    Topic("The recommended rules `colony` with rigid bodies", ("performance-physics",), {"policy": "colony"}),
    Topic("The recommended rules `colony` on the node world", ("performance-nodeworld",), {"policy": "colony"}),
)  # fmt: skip


def summary(context: Context) -> list[Block]:
    """What holds, what does not, and why; then the paper's five rows beside ours."""
    judged = context.judged
    blocks: list[Block] = [Text(_overall(judged))]
    lines = [_sentence(topic.says, found) for topic in TOPICS if (found := topic.of(judged))]
    lines += [_readings(context)] if context.trainings else []
    if lines:
        blocks.append(Text("\n".join(f"- {line}" for line in lines)))
    return [*blocks, *_rows(context)]


def _overall(judged: Sequence[Judged]) -> str:
    words = Counter(each.verdict.word for each in judged)
    holds = words["agrees"] + words["better"]
    return (
        f"We compared {_count(len(judged), 'figure or claim', 'figures and claims')} of the paper with runs of our "
        f"own: {holds} as the paper says or better, {words['disagrees']} otherwise, {words['undecided']} that the "
        "runs there are cannot tell apart from chance. [The rule](verdicts.md) says what these words mean. By "
        "subject:"
    )


def _sentence(says: str, found: Sequence[Judged]) -> str:
    words: Counter[str] = Counter(each.verdict.word for each in found)
    verbs = {"agrees": ("agrees", "agree"), "better": ("is better", "are better")}
    holds = [f"{words[word]} {verbs[word][words[word] > 1]}" for word in verbs if words[word]]
    none = "none is decided" if words["undecided"] == len(found) else "none holds"
    parts = [f"**{says}:** of {_count(len(found), 'comparison')}, {' and '.join(holds) if holds else none}."]
    wrong = [each for each in found if each.verdict.word == "disagrees"]
    if wrong:
        parts.append(f"{len(wrong)} {'does' if len(wrong) == 1 else 'do'} not: {_named(wrong, _with_difference)}.")
        reasons = list(dict.fromkeys(each.why for each in wrong if each.why))
        if reasons:
            parts.append(f"Why, as far as we know: {' '.join(reasons)}")
    if words["undecided"]:
        parts.append(f"Undecided: {words['undecided']}.")
    return " ".join(parts)


def _named(found: Sequence[Judged], told: Callable[[Judged], str]) -> str:
    names = list(dict.fromkeys(told(each) for each in found))
    rest = len(names) - _NAMED
    return "; ".join(names[:_NAMED]) + (f"; and {rest} more" if rest > 0 else "")


def _with_difference(each: Judged) -> str:
    difference = each.verdict.difference
    about = each.about.split(" (`")[0].rstrip(".")
    return f"{about} ({difference.mean:+.{each.digits}f})" if difference else about


def _readings(context: Context) -> str:
    """How well the networks of each reading of Algorithm 1 push."""
    paper = context.paper.push_style
    told = []
    for one in context.trainings:
        setting = one.all_terrains()
        found = [one.pushed(setting, terrain, "success") for terrain in INDIVIDUAL]
        if all(found):
            means = ", ".join(f"{fmean(values.values()):.2f}" for values in found)
            told.append(f"`{one.base}` on {one.engine} {means} ({_count(len(one.of(setting)), 'seed')})")
    theirs = ", ".join(f"{paper.all_in_one.success[terrain][0]:.2f}" for terrain in INDIVIDUAL)
    return (
        "**Readings of Algorithm 1:** success of the best network of a training on all terrains, on flat ground, up "
        f"a slope and into a hole; the paper reports {theirs} after {paper.all_in_one.training} training episodes. "
        f"Here after {context.trainings[0].episodes}: {'; '.join(told) or 'none was trained on all terrains'}. [The "
        "push](push.md) says what the readings are."
    )


def _count(number: int, one: str, many: str = "") -> str:
    return f"{number} {one if number == 1 else many or f'{one}s'}"


def _rows(context: Context) -> list[Block]:
    """The paper's five rows, and ours with its system and with the recommended one."""
    sides: list[tuple[str, dict[str, Any]]] = []
    for engine, (policy, push, estimate) in product(ENGINES, (("paper", "rl", "forest"), ("colony", "staged", "way"))):
        where = {"policy": policy, "backend": engine, "backend.push": push, "backend.feasibility": estimate}
        sides.append((f"`{policy}`, `{push}`, {engine}", where))
    sides += [(f"`{policy}`, node world", {"policy": policy, "backend": "nodeworld"}) for policy in ("paper", "colony")]
    there = [side for side in sides if context.evidence.matching({**side[1], "mode": "asynchronous"}).trials]
    if not there:
        return []
    rows = []
    for row in context.paper.performance:
        cells = []
        for _, where in there:
            settings = {"scenario": row.map, "variant": row.variant, "mode": "asynchronous", **where}
            found = context.evidence.matching(settings)
            steps, success = (
                Figure.of(list(found.by_seed(measure).values()), WITHIN.get(measure))
                for measure in ("steps", "success")
            )
            cells.append(f"{steps.shown(1)}; {success.shown(2)}; {steps.count}" if steps and success else "-")
        theirs = f"{row.steps[0]:.1f} ± {row.steps[1]:.1f}; {row.success[0]:.2f} ± {row.success[1]:.2f}"
        rows.append([row.label, theirs, *cells])
    about = (
        "Steps; share of agents at the goal; seeds, each mean with its 95 % interval over seeds, all episodes counted:"
    )
    return [Text(about), Table(["map", "the paper", *(label for label, _ in there)], rows)]
