"""The studies: each makes a part of the report from what its trials, runs or trainings have found."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

from colonysim.intervals import wilson
from colonysim.physics import ENGINES
from colonysim.push.executors import EXECUTORS
from colonysim.reproduce.context import Judged
from colonysim.reproduce.document import Block, Picture, Table, Text
from colonysim.reproduce.facts import FACTS
from colonysim.reproduce.judging import WITHIN, Figure, level, share
from colonysim.reproduce.plans import ABLATED, MAPS, NEAR, PRESETS
from colonysim.reproduce.recorded import DRAWINGS, RUNS, drawn, recorded

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from colonysim.reproduce.context import Context
    from colonysim.reproduce.evidence import Evidence

__all__ = ["ablation_part", "asynchrony_part", "drawings_part", "nodeworld_part", "physics_part"]

DIGITS = {"steps": 1, "success": 3, "sim_seconds": 1}
_BOTH = [(f"`{preset}`", {"policy": preset}) for preset in PRESETS]


def _cell(evidence: Evidence, measure: Any, span: tuple[int, int] | None = None) -> str:
    figure = Figure.of(list(evidence.by_seed(measure, span).values()), WITHIN.get(measure))
    return figure.shown(DIGITS[measure]) if figure else "-"


def _label(name: str, variant: str | None) -> str:
    return f"{name} {variant}" if variant else name


@dataclass(frozen=True)
class Group:
    """Runs that are set beside the paper's rows.

    Attributes:
        label: What they are, in a word or two.
        settings: What they have in common, the backend among it.
        cells: What they are, in the table's first columns.
    """

    label: str
    settings: Mapping[str, Any]
    cells: tuple[str, ...]


def _performance(
    context: Context, study: str, kind: str, columns: Sequence[str], groups: Sequence[Group], late: tuple[int, int]
) -> list[Block]:
    """The paper's rows beside ours, each judged in steps and success, and why they come out otherwise.

    Args:
        context: The reproduction.
        study: Its name.
        kind: Under which name the paper's reasons stand: "nodeworld" or "physics".
        columns: What the cells of a group are called.
        groups: What is set beside the paper.
        late: First and last episode after the pheromones have settled.
    """
    rows: list[list[str]] = []
    reasons: dict[str, None] = {}
    for row, group in product(context.paper.performance, groups):
        where = {"scenario": row.map, "variant": row.variant, "mode": "asynchronous", **group.settings}
        found = context.evidence.matching(where)
        if not found.trials:
            context.gaps.append(f"{study}: no run of {row.label} with {group.label}.")
            continue
        cells, words = [], []
        for measure in ("steps", "success"):
            reported = row.reported(measure)
            ours = Figure.of(list(found.by_seed(measure).values()), WITHIN.get(measure))
            verdict = level(ours, reported, measure)
            policy, digits = str(group.settings["policy"]), DIGITS[measure]
            why = context.paper.reasons[kind][policy][measure].get(verdict.side or "", "")
            about = f"{measure} on {row.label} (`{row.place}`)"
            cell = context.judge(Judged(study, about, group.label, verdict, group.settings, digits, why))
            words.append(f"{verdict.word} ({verdict.side})" if verdict.side else cell)
            if why:
                reasons[f"- `{policy}`, {measure} {verdict.side}: {why}"] = None
            cells += [f"{reported.mean:g} ± {reported.sd:g}", ours.shown(digits) if ours else "-"]
        # A trial that two studies have asked for is there twice.
        by_seed = {trial.seed: trial for trial in found.trials}
        wanted = context.size.physics_seeds if kind == "physics" else context.size.seeds
        if len(by_seed) < wanted:
            context.gaps.append(f"{study}: {row.label} with {group.label} has {len(by_seed)} of {wanted} seeds.")
        every = [episode for trial in by_seed.values() for episode in trial.episodes]
        played = [episode for episode in every if late[0] <= episode["episode"] <= late[1]]
        there = sum(episode["success"] == 1.0 for episode in played)
        low, high = wilson(there, len(played))
        all_there = f"{there} of {len(played)} [{low:.3f}, {high:.3f}]" if played else "-"
        late_steps = _cell(found, "steps", late)
        stuck = f"{sum(episode['ended'] == 'deadlock' for episode in every)} of {len(every)}"
        rows.append([row.label, *group.cells, str(len(by_seed)), *cells, stuck, late_steps, all_there, *words])
    span = f"episodes {late[0]}-{late[1]}"
    names = ["map", *columns, "seeds", "steps: the paper", "ours", "success: the paper", "ours",
             "episodes that ended in a deadlock", f"steps, {span}",
             f"{span} with all agents there [Wilson 95 %]", "verdict: steps", "verdict: success"]  # fmt: skip
    why_so = [Text("Why, as far as we know:"), Text("\n".join(reasons))] if reasons else []
    return [Table(names, rows), *why_so]


def nodeworld_part(context: Context) -> list[Block]:
    """The performance tables, on the node world."""
    study = "performance-nodeworld"
    late = context.size.late()
    groups = [Group(label, {**settings, "backend": "nodeworld"}, (label,)) for label, settings in _BOTH]
    return [
        Text(
            f"Node world, agents in their own time, {context.size.episodes} episodes a run, seeds {_seeds(context)}. "
            "All episodes count against the paper's figures, which are those of its physics; of which episodes, and "
            "of how many, it does not say. What is to be had once the pheromones have settled stands beside them."
        ),
        *_performance(context, study, "nodeworld", ["rules"], groups, late),
        *context.claims(study, [(group.label, group.settings) for group in groups], late),
    ]


_DRIVEN = ("policy", "backend.push", "backend.feasibility", "backend")
"""What tells runs in physics apart: rules, executor, estimate, engine."""
_PAPERS = ("paper", "rl", "forest")
"""Rules, executor and estimate of the paper's own system."""


def physics_part(context: Context) -> list[Block]:
    """The performance tables with rigid bodies."""
    study = "performance-physics"
    driven = [trial for trial in context.evidence.trials if trial.settings["backend"] in ENGINES]
    trials = [trial for trial in driven if not trial.parameters]
    if not trials:
        context.gaps.append(f"{study}: no run has succeeded.")
        return [Text("No run has succeeded.")]
    kinds = {tuple(str(trial.settings[name]) for name in _DRIVEN) for trial in trials}
    groups = [
        Group(_driven(kind), dict(zip(_DRIVEN, kind, strict=True)), tuple(f"`{word}`" for word in kind))
        for kind in sorted(kinds, key=lambda kind: (PRESETS.index(kind[0]), EXECUTORS.index(kind[1]), kind[2:]))
    ]
    if all(kind[:3] != _PAPERS for kind in kinds):
        context.gaps.append(f"{study}: no run of the paper's own system, {', '.join(f'`{word}`' for word in _PAPERS)}.")
    # Stored runs may be longer than those that would be run here.
    length = max(len(trial.episodes) for trial in trials)
    late = length // 2 + 1, length
    sources = [
        f"Runs on `{engine}`: seeds {_row(seeds)}, "
        + (f"stored in `{context.stored_in[engine]}`." if engine in context.stored_in else "run here.")
        for engine in ENGINES
        if (seeds := sorted({trial.seed for trial in trials if trial.settings["backend"] == engine}))
    ]
    claimed = [(group.label, group.settings) for group in groups if group.settings["backend.push"] != "scripted"]
    return [
        Text(
            f"Rigid bodies, {length} episodes a run. *Rules* says how agents choose, *push* who moves a box: `rl`, the "
            "learned network from wherever it expects to succeed, as in the paper; `staged`, the same network after a "
            "scripted approach; `scripted`, no learning. *Estimate* says what foresees whether a push will succeed: "
            "`forest` is the paper's classifier, `way` tells the chance that a box comes all along its way, and "
            "`geometry` asks only whether there is room. The paper's own system is `paper`, `rl`, `forest`, here with "
            "the network that comes with this package, which was trained longer and otherwise than by the paper's "
            "Algorithm 1. Where five seeds left a verdict open, some rows were run with more."
        ),
        Text("\n".join(f"- {source}" for source in sources)),
        *_performance(context, study, "physics", ["rules", "push", "estimate", "engine"], groups, late),
        *context.claims(study, claimed, late),
    ]


def _driven(kind: tuple[str, ...]) -> str:
    policy, push, estimate, engine = kind
    return f"`{policy}`, `{push}`, `{estimate}`, {engine}"


def ablation_part(context: Context, name: str) -> list[Block]:
    """One parameter at a time on a map: curves, table and claims."""
    study = f"ablation-{name}"
    blocks: list[Block] = [
        Text(
            f"Node world, all agents at once as in the paper's, {context.size.episodes} episodes a run, seeds "
            f"{_seeds(context)}{_nearer(context, name)}. The paper prints no values but R = 3 and 5 of sanity; ours "
            "lie around those of the presets."
        )
    ]
    for preset in PRESETS:
        where = {"scenario": name, "backend": "nodeworld", "mode": "synchronous", "policy": preset}
        panels = {
            _parameter(parameter): {
                f"{value:g}": [
                    [float(e["steps"]) for e in trial.episodes]
                    for trial in context.evidence.matching({**where, parameter: value}).trials
                ]
                for value in values
            }
            for parameter, values in ABLATED[name].items()
        }
        panels = {title: {label: seeds for label, seeds in curves.items() if seeds} for title, curves in panels.items()}
        if all(panels.values()):
            blocks += _curves(context, f"{study}-{preset}", panels, f"{name}, {preset}")
    rows = []
    for parameter, values in ABLATED[name].items():
        for value in values:
            cells = []
            for preset in PRESETS:
                where = {"scenario": name, "backend": "nodeworld", "mode": "synchronous", "policy": preset}
                found = context.evidence.matching({**where, parameter: value})
                cells += [_cell(found, "steps"), _cell(found, "steps", context.size.late())]
            rows.append([_parameter(parameter), f"{value:g}", *cells])
    span = "{}-{}".format(*context.size.late())
    columns = [f"`{preset}`: {what}" for preset in PRESETS for what in ("steps, all episodes", f"steps, {span}")]
    return [*blocks, Table(["parameter", "value", *columns], rows), *context.claims(study, _BOTH, context.size.late())]


def _nearer(context: Context, name: str) -> str:
    size, more = context.size, [_parameter(parameter) for place, parameter in NEAR if place == name]
    if not more or size.near_seeds <= size.seeds:
        return ""
    last = size.first_seed + size.near_seeds - 1
    return f" ({', '.join(more)}: to {last}, for what it shows lies near the limit of the negligible)"


def _parameter(name: str) -> str:
    words = {"epsilon": "initial epsilon", "epsilon_decay": "decay of epsilon", "box_decay": "B_decay"}
    short = name.removeprefix("policy.")
    return words.get(short, "R" if short == "detection_radius" else short)


def _curves(context: Context, name: str, panels: dict[str, Any], title: str) -> list[Block]:
    from colonysim.plots import save
    from colonysim.plots.curves import curves_figure

    path = context.pages / f"{name}.png"
    save(curves_figure(panels, title, "steps, mean of 10 episodes"), path, "png", 80)
    shows = f"Steps by episode, {title}: moving average of 10 episodes, mean over seeds with its 95 % interval"
    return [Picture(path.name, shows)]


def drawings_part(context: Context, study: str, names: Sequence[str]) -> list[Block]:
    """Pheromones and trajectories beside the paper's captions, and what the paper says happens, asked of many runs."""
    blocks: list[Block] = []
    for name in names:
        drawn(name, context.size, context.runs, context.pages)
        what = RUNS[DRAWINGS[name].run].on(context.size.engine)
        acting = "in their own time" if what.mode == "asynchronous" else "all at once"
        backend = "node world" if what.backend == "nodeworld" else what.backend
        place = f"{_label(what.scenario, what.variant)}, `{what.policy}`, {backend}"
        blocks += context.picture(name)
        blocks.append(Text(f"Ours: {place}, agents {acting}, seed {context.size.first_seed}."))
    rows = []
    seeds = range(context.size.first_seed, context.size.first_seed + context.size.drawn)
    for fact in (fact for fact in FACTS if fact.study == study):
        for preset in PRESETS:
            what = RUNS[fact.run].under(preset)
            there = sum(fact.holds(recorded(what, context.size, context.runs, seed)) for seed in seeds)
            judged = Judged(study, fact.says, f"`{preset}`", share(there, len(seeds)), {"policy": preset})
            low, high = wilson(there, len(seeds))
            counted, word = f"{there} of {len(seeds)} [{low:.2f}, {high:.2f}]", context.judge(judged)
            rows.append([f"{fact.says} (`{fact.place}`)", fact.asked, f"`{preset}`", counted, word])
    columns = ["the paper says", "asked", "rules", "runs in which it is so [Wilson 95 %]", "verdict"]
    return [*blocks, Table(columns, rows)] if rows else blocks


def asynchrony_part(context: Context) -> list[Block]:
    """Acting at once against acting in one's own time."""
    places: list[tuple[str, str | None, dict[str, Any]]] = [(*place, {}) for place in MAPS]
    rules = ("two_node", "reservation")
    places += [(name, None, {"policy.collision": rule}) for name in ("deadlock", "junction") for rule in rules]
    rows = []
    for (name, variant, more), preset in product(places, PRESETS):
        where = {"scenario": name, "variant": variant, "backend": "nodeworld", "policy": preset, **more}
        one = context.evidence.matching({**where, "mode": "asynchronous"})
        other = context.evidence.matching({**where, "mode": "synchronous"})
        label = f"{_label(name, variant)}{f', {next(iter(more.values()))}' if more else ''}"
        cells = [_cell(one, "success"), _cell(other, "success")]
        for measure in ("steps", "sim_seconds"):
            left, right = (e.by_seed(measure, only_at_goal=True) for e in (one, other))
            both = sorted(left.keys() & right.keys())
            difference = Figure.of([left[seed] - right[seed] for seed in both])
            shown = [Figure.of(list(side.values())) for side in (left, right)]
            cells += [f.shown(1) if f else "-" for f in shown] + [difference.shown(1, True) if difference else "-"]
        rows.append([label, f"`{preset}`", *cells])
    columns = ["map", "rules", "success: own time", "at once", "steps: own time", "at once", "difference [95 %]",
               "makespan: own time", "at once", "difference [95 %]"]  # fmt: skip
    return [
        Text(
            "The same policies and seeds, agents acting in their own time (asynchronous) or all at once "
            "(synchronous). Steps and makespan (simulated seconds until the last agent is at the goal; an edge takes "
            "about a second per unit) are of the episodes in which all agents reached the goal, differences are paired "
            "by seed. At once, every tick is a step and lasts as long as its longest move. `deadlock` and `junction` "
            f"are our own: on them two carriers, or three agents, can block each other; seeds {_seeds(context)}."
        ),
        Table(columns, rows),
        *context.claims("asynchrony", _BOTH, context.size.late()),
    ]


def _seeds(context: Context) -> str:
    first = context.size.first_seed
    return f"{first}-{first + context.size.seeds - 1}"


def _row(seeds: Sequence[int]) -> str:
    whole = list(seeds) == list(range(seeds[0], seeds[-1] + 1))
    return f"{seeds[0]}-{seeds[-1]}" if whole and len(seeds) > 1 else ", ".join(map(str, seeds))
