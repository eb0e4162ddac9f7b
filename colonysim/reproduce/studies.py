"""The studies: each makes a part of the report from what its trials, runs or trainings have found."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any

from colonysim.intervals import wilson
from colonysim.physics import ENGINES
from colonysim.reproduce.document import Block, Picture, Table, Text
from colonysim.reproduce.facts import FACTS
from colonysim.reproduce.judging import WITHIN, Figure, Verdict, level, share
from colonysim.reproduce.plans import ABLATED, MAPS, PRESETS
from colonysim.reproduce.recorded import DRAWINGS, RUNS, drawn, recorded

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.reproduce.context import Context
    from colonysim.reproduce.evidence import Evidence, Measured

__all__ = ["ablation_part", "asynchrony_part", "drawings_part", "nodeworld_part", "physics_part"]

DIGITS = {"steps": 1, "success": 3, "sim_seconds": 1}
_BOTH = [(f"`{preset}`", {"policy": preset}) for preset in PRESETS]


def _cell(evidence: Evidence, measure: Any, span: tuple[int, int] | None = None) -> str:
    figure = Figure.of(list(evidence.by_seed(measure, span).values()), WITHIN.get(measure))
    return figure.shown(DIGITS[measure]) if figure else "-"


def _label(name: str, variant: str | None) -> str:
    return f"{name} {variant}" if variant else name


def _performance(
    context: Context, study: str, kind: str, groups: Sequence[tuple[str, dict[str, Any]]], late: tuple[int, int]
) -> Block:
    """The paper's rows beside ours, each judged in steps and success.

    Args:
        context: The reproduction.
        study: Its name.
        kind: Under which name the paper's reasons stand: "nodeworld" or "physics".
        groups: Label and settings, the backend among them, of what is set beside the paper.
        late: First and last episode after the pheromones have settled.
    """
    rows = []
    for row, (label, more) in product(context.paper.performance, groups):
        where = {"scenario": row.map, "variant": row.variant, "mode": "asynchronous", **more}
        found = context.evidence.matching(where)
        if not found.trials:
            context.gaps.append(f"{study}: no run of {row.label} with {label}.")
            continue
        cells, words = [], []
        for measure in ("steps", "success"):
            reported = row.reported(measure)
            ours = Figure.of(list(found.by_seed(measure).values()), WITHIN.get(measure))
            verdict = level(ours, reported, measure)
            digits = DIGITS[measure]
            word = context.judge(study, f"{measure} on {row.label} (`{row.place}`)", label, verdict, digits)
            reason = context.paper.reasons[kind][measure].get(verdict.side or "", "")
            words.append(f"{word} ({verdict.side}): {reason}" if reason else word)
            cells += [f"{reported.mean:g} ± {reported.sd:g}", ours.shown(digits) if ours else "-"]
        played = [e for trial in found.trials for e in trial.episodes if late[0] <= e["episode"] <= late[1]]
        there = sum(episode["success"] == 1.0 for episode in played)
        low, high = wilson(there, len(played))
        all_there = f"{there} of {len(played)} [{low:.3f}, {high:.3f}]" if played else "-"
        rows.append([
            row.label, label, str(len(found.trials)), *cells, _cell(found, "steps", late), all_there, *words,
        ])  # fmt: skip
    span = f"{late[0]}-{late[1]}"
    return Table(
        ["map", "rules", "seeds", "steps: the paper", "ours", "success: the paper", "ours", f"steps, episodes {span}",
         f"episodes {span} with all agents there [Wilson 95 %]", "steps", "success"],
        rows,
    )  # fmt: skip


def nodeworld_part(context: Context) -> list[Block]:
    """The performance tables without physics, under both presets."""
    study, size = "performance-nodeworld", context.size
    groups = [(label, {**more, "backend": "nodeworld"}) for label, more in _BOTH]
    return [
        Text(
            f"Node world, agents in their own time, {size.episodes} episodes a run, seeds {_seeds(context)}. All "
            "episodes count against the paper's figures, which are those of its physics; of which episodes, and "
            "of how many, it does not say. What is to be had once the pheromones have settled stands beside them."
        ),
        _performance(context, study, "nodeworld", groups, size.late()),
        *context.claims(study, _BOTH, size.late()),
    ]


def physics_part(context: Context) -> list[Block]:
    """The performance tables with rigid bodies, on one engine or on several."""
    study = "performance-physics"
    found = {engine: context.evidence.matching({"backend": engine}).trials for engine in ENGINES}
    blocks: list[Block] = [
        block for engine, trials in found.items() if trials for block in _driven(context, study, engine, trials)
    ]
    if not blocks:
        context.gaps.append(f"{study}: no run has succeeded.")
        return [Text("No run has succeeded.")]
    return blocks


def _driven(context: Context, study: str, engine: str, trials: Sequence[Measured]) -> list[Block]:
    """What was found on one engine."""
    pushes = sorted({str(trial.settings["backend.push"]) for trial in trials})
    groups = [
        (f"`colony`, `{push}`, {engine}", {"policy": "colony", "backend": engine, "backend.push": push})
        for push in pushes
    ]
    seeds = sorted({trial.seed for trial in trials})
    stored = context.stored_in.get(engine)
    source = f"stored in `{stored}`" if stored else "run here"
    # Stored runs may be longer than those that would be run here.
    length = max(len(trial.episodes) for trial in trials)
    late = length // 2 + 1, length
    claimed = [group for group in groups if "staged" in group[0]]
    return [
        Text(
            f"Rigid bodies on the engine `{engine}`, rules of `colony`, seeds {_row(seeds)}, {length} episodes a run, "
            f"{source}. `staged`, `rl` and `scripted` say who pushes."
        ),
        _performance(context, study, "physics", groups, late),
        *context.claims(study, claimed, late),
    ]


def ablation_part(context: Context, name: str) -> list[Block]:
    """One parameter at a time on a map: curves, table and claims."""
    study = f"ablation-{name}"
    blocks: list[Block] = [
        Text(
            f"Node world, all agents at once as in the paper's, {context.size.episodes} episodes a run, seeds "
            f"{_seeds(context)}. The paper prints no values but R = 3 and 5 of sanity; ours lie around "
            "those of the presets."
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


def _parameter(name: str) -> str:
    words = {"epsilon": "initial epsilon", "epsilon_decay": "decay of epsilon", "box_decay": "B_decay"}
    short = name.removeprefix("policy.")
    return words.get(short, "R" if short == "detection_radius" else short)


def _curves(context: Context, name: str, panels: dict[str, Any], title: str) -> list[Block]:
    from colonysim.plots import save
    from colonysim.plots.curves import curves_figure

    path = context.images / f"{name}.png"
    save(curves_figure(panels, title, "steps, mean of 10 episodes"), path, "png", 80)
    shows = f"Steps by episode, {title}: moving average of 10 episodes, mean over seeds with its 95 % interval"
    return [Picture(f"{path.parent.name}/{path.name}", shows)]


def drawings_part(context: Context, study: str, names: Sequence[str]) -> list[Block]:
    """Pheromones and trajectories beside the paper's captions, and what the paper says happens, asked of many runs."""
    blocks: list[Block] = []
    for name in names:
        drawn(name, context.size, context.runs, context.images)
        what = RUNS[DRAWINGS[name].run].on(context.size.engine)
        acting = "in their own time" if what.mode == "asynchronous" else "all at once"
        place = f"{_label(what.scenario, what.variant)}, `{what.policy}`, {what.backend}"
        blocks += context.picture(name)
        blocks.append(Text(f"Ours: {place}, agents {acting}, seed {context.size.first_seed}."))
    rows = []
    seeds = range(context.size.first_seed, context.size.first_seed + context.size.drawn)
    for fact in (fact for fact in FACTS if fact.study == study):
        for preset in PRESETS:
            what = RUNS[fact.run].under(preset)
            there = sum(fact.holds(recorded(what, context.size, context.runs, seed)) for seed in seeds)
            low, high = wilson(there, len(seeds))
            verdict = Verdict(share(low, high), Figure(there / len(seeds), low, high, len(seeds)))
            word = context.judge(study, fact.says, f"`{preset}`", verdict)
            counted = f"{there} of {len(seeds)} [{low:.2f}, {high:.2f}]"
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
