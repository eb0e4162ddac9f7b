"""What of the paper holds, in half a page: sentences made from the verdicts."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import product
from statistics import fmean
from typing import TYPE_CHECKING, Any

from colonysim.physics import ENGINES
from colonysim.reproduce.document import Block, Heading, Table, Text
from colonysim.reproduce.judging import WITHIN, WORDS, Figure
from colonysim.reproduce.push import INDIVIDUAL, LETTER

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.reproduce.context import Context, Judged

__all__ = ["summary"]

_QUOTED = 2
"""Claims that hold and are quoted; of more it is said how many. Those that do not hold are all quoted."""


@dataclass(frozen=True)
class Topic:
    """A subject of the first page.

    Attributes:
        says: What it is.
        studies: The studies whose verdicts count.
        settings: What the judged settings have to be.
        named: Whether its figures and claims are named one by one; of others only their number is told.
    """

    says: str
    studies: tuple[str, ...]
    settings: Mapping[str, Any]
    named: bool = False

    def of(self, judged: Sequence[Judged]) -> list[Judged]:
        """The verdicts that it is about."""
        return [
            each for each in judged if each.study in self.studies and self.settings.items() <= each.settings.items()
        ]


_RULES = ("ablation-sanity", "ablation-easy", "asynchrony", "hole-edge-case")
_FIELDS = ("pheromones-sanity", "pheromones-easy", "pheromones-medium", "pheromones-hard")
_PHYSICS = ("performance-physics",)
TOPICS = (
    Topic(
        "The paper's rules with a learned push (`rl`, `forest`), rigid bodies", _PHYSICS,
        {"policy": "paper", "backend.push": "rl", "backend.feasibility": "forest"}, named=True,
    ),
    Topic("Its rules with the push `staged`, rigid bodies", _PHYSICS, {"policy": "paper", "backend.push": "staged"}),
    Topic("Its rules on the node world", ("performance-nodeworld",), {"policy": "paper"}),
    Topic(
        "Its rules on the node world, fitted to these very figures", ("fit",),
        {"policy": "paper", "backend": "nodeworld"}, named=True,
    ),
    *(
        Topic(f"The fitted rules with the learned push, on {engine}", ("fit",), {"policy": "paper", "backend": engine})
        for engine in ENGINES
    ),
    Topic("What it says of parameters, asynchrony and marks", _RULES + _FIELDS, {"policy": "paper"}, named=True),
    Topic("Training the push by Algorithm 1 to the letter", ("push",), {"letter": True}, named=True),
    Topic("Training the push by Algorithm 1 in a reading that differs", ("push",), {"letter": False}, named=True),
    Topic("Our rules `colony` with rigid bodies", _PHYSICS, {"policy": "colony"}),
    Topic("Our rules `colony` on the node world", ("performance-nodeworld",), {"policy": "colony"}),
    Topic("What the paper says of parameters and so on, under `colony`", _RULES + _FIELDS, {"policy": "colony"}),
)  # fmt: skip
_WORDS = (
    "The paper lets robots push boxes into holes until all of them can cross to a goal. They do not talk: each leaves "
    "marks on the nodes of the map (*pheromones*), reads those near by, and decides by them where to go and which box "
    "to push. A network that has learned by reinforcement (*Algorithm 1*) does the pushing."
)
_NAMES = (
    "`paper` is the paper's rules with their contradictions repaired, `colony` the ones that we recommend. `rl` is the "
    "learned push from wherever the robot is, `staged` the same after a scripted approach; both use the network that "
    "comes with this package, which was trained longer and otherwise than by the paper's Algorithm 1. Bullet and "
    "MuJoCo simulate rigid bodies; on the node world robots step from node to node and every push succeeds. `r20-4`, "
    "`r5-4` and `r5-6` are the map hard with robots that see 20, 5 and 5 units far, and with four, four and six of "
    "them."
)


def summary(context: Context) -> list[Block]:
    """What holds, what does not, and why; then the paper's five rows beside ours, and what is open."""
    judged = context.judged
    told = [(topic, found) for topic in TOPICS if (found := topic.of(judged))]
    blocks: list[Block] = [Text(_WORDS), Text(_overall(judged))]
    parts = (
        ("What holds: as in the paper, or better", ("agrees", "better"), _QUOTED),
        ("What does not: ours less the paper's in brackets, one for each engine", ("disagrees",), len(judged)),
    )
    for title, words, quoted in parts:
        lines = [
            f"**{topic.says}:** {_named(these, found, quoted)}."
            for topic, found in told
            if topic.named and (these := [each for each in found if each.verdict.word in words])
        ]
        blocks += _part(title, lines)
    named = [each for topic, found in told if topic.named for each in found if each.verdict.word == "disagrees"]
    blocks += _part("Why, as far as we know", list(dict.fromkeys(each.why for each in named if each.why)))
    blocks += _part("Learning to push", [_learning(context)] if context.trainings else [])
    blocks += [Heading(2, "By subject"), _counts(told)] if told else []
    return [*blocks, *_rows(context), *_part("What is open", _open(judged))]


def _part(title: str, lines: Sequence[str]) -> list[Block]:
    return [Heading(2, title), Text("\n".join(f"- {line}" for line in lines))] if lines else []


def _overall(judged: Sequence[Judged]) -> str:
    words = Counter(each.verdict.word for each in judged)
    return (
        f"We set {_count(len(judged), 'figure or claim', 'figures and claims')} of the paper beside runs of our own: "
        f"{words['agrees']} agree, in {words['better']} ours is better, {words['disagrees']} differ, "
        f"{words['undecided']} are undecided, which means that our runs are too few to tell them from chance. "
        "A figure counts once for each engine, push and set of rules that is set beside it, and *better* is whatever "
        "takes shown fewer steps, more success or more reward than the paper's. [The rule](verdicts.md) says what "
        "exactly these words mean."
    )


def _counts(told: Sequence[tuple[Topic, Sequence[Judged]]]) -> Block:
    rows = []
    for topic, found in told:
        words = Counter(each.verdict.word for each in found)
        rows.append([topic.says, str(len(found)), *(str(words[word]) for word in WORDS)])
    return Table(["subject", "comparisons", *WORDS], rows)


def _open(judged: Sequence[Judged]) -> list[str]:
    return [
        f"{_subject(each)} ({each.with_what}): {each.verdict.wanting}."
        for each in judged
        if each.verdict.word == "undecided"
    ]


def _subject(each: Judged) -> str:
    figure, _, _ = each.about.partition(" (`")
    return figure if figure != each.about else f"“{each.about.rstrip('.')}”"


def _named(these: Sequence[Judged], of: Sequence[Judged], quoted: int) -> str:
    """What some verdicts are about: figures by measure, claims one by one.

    Args:
        these: The verdicts.
        of: All verdicts of their topic: where others came out otherwise, it is told how many did not.
        quoted: Claims that are quoted; of more it is said how many.
    """
    figures: dict[str, list[str]] = {}
    claims: list[str] = []
    for about in dict.fromkeys(each.about for each in these):
        same = [each for each in these if each.about == about]
        every = sum(each.about == about for each in of)
        notes = [f"{len(same)} of {every}"] if len(same) < every else []
        subject = _subject(same[0])
        if subject.startswith("“"):
            claims.append(subject + "".join(f" ({note})" for note in notes))
            continue
        amounts = [f"{each.verdict.difference.mean:+.{each.digits}f}" for each in same if each.verdict.difference]
        notes += [" and ".join(dict.fromkeys(amounts))] if same[0].verdict.word == "disagrees" else []
        measure, _, place = subject.partition(" on ")
        figures.setdefault(measure, []).append(place + (f" ({': '.join(notes)})" if notes else ""))
    parts = [f"{measure} on {', '.join(places)}" for measure, places in figures.items()]
    rest = len(claims) - quoted
    parts += [*claims[:quoted], *([f"and {_count(rest, 'more claim')}"] if rest > 0 else [])]
    return "; ".join(parts)


def _learning(context: Context) -> str:
    """How well the networks of the letter of Algorithm 1 push, and those of the reading that comes nearest."""
    paper = context.paper.push_style
    theirs = [paper.all_in_one.success[terrain][0] for terrain in INDIVIDUAL]
    pushed = [
        (one, found)
        for one in context.trainings
        if len(found := [figure for terrain in INDIVIDUAL if (figure := one.success(terrain))]) == len(INDIVIDUAL)
    ]
    others = [(one, found) for one, found in pushed if one.base != LETTER]
    most = max((found[0].count for _, found in others), default=0)
    nearest = min(
        (each for each in others if each[1][0].count == most),
        key=lambda each: fmean(abs(ours.mean - their) for ours, their in zip(each[1], theirs, strict=True)),
        default=None,
    )
    told = []
    for one, found in [*(each for each in pushed if each[0].base == LETTER), *([nearest] if nearest else [])]:
        last = [figure.shown(2) for terrain in INDIVIDUAL if (figure := one.success(terrain, last=True))]
        peak = fmean(row.peak_episode for row in one.of(one.all_terrains()).values())
        told.append(
            f"{'to the letter' if one.base == LETTER else f'by the reading `{one.base}`'} on {one.engine} "
            f"{', '.join(figure.shown(2) for figure in found)} ({_count(found[0].count, 'training')}, the best after "
            f"{peak:.0f} episodes on average; the last networks {', '.join(last) or '-'})"
        )
    return (
        "How many pushes succeed on flat ground, up a slope and into a hole, by the best network of a training on all "
        f"three: in the paper {', '.join(f'{their:.2f}' for their in theirs)} after {paper.all_in_one.training} "
        f"training episodes; here of trainings of {context.trainings[0].episodes} episodes "
        f"{'; '.join(told) or '- (none was trained on all)'}. [The push](push.md) says what the readings are."
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
    return [
        Heading(2, "The paper's five rows"),
        Text(_NAMES),
        Text(about),
        Table(["map", "the paper", *(label for label, _ in there)], rows),
    ]
