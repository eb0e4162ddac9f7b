"""Which values of the parameters that the paper does not print bring its rules closest to its five rows.

Points of the space of parameters are drawn once (Sobol), under each of a few readings, and run on the node world with
the paper's rules. The distance of a point to the paper's rows says how well it explains them. The best point of each
reading is then run with seeds that nothing was chosen by, beside the preset.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from itertools import product
from math import sqrt
from random import Random
from statistics import fmean, stdev
from typing import TYPE_CHECKING, Any

from colonysim.arguments import MAX_SEED
from colonysim.physics import ENGINES
from colonysim.reproduce.context import Judged
from colonysim.reproduce.document import Block, Heading, Picture, Table, Text
from colonysim.reproduce.judging import COARSE, WITHIN, Figure, level
from colonysim.reproduce.plans import ALTERNATIVES, FITTED, FITTED_READINGS, FULL, PRESET_POINT, Size, fit_held_out

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from colonysim.reproduce.context import Context
    from colonysim.reproduce.evidence import Evidence
    from colonysim.reproduce.paper import Paper, Row, Told

__all__ = ["Point", "distance", "driven_part", "fit_part", "held_out", "points"]

_STUDY = "fit"
_NAMES = (*FITTED, *FITTED_READINGS)
_RESAMPLES = 400
_MEASURES: tuple[Told, ...] = ("steps", "success")
_DIGITS: dict[Told, int] = {"steps": 1, "success": 3}


@dataclass(frozen=True)
class Point:
    """Values of the parameters, and what came of them.

    Attributes:
        parameters: By path.
        runs: By label of the paper's row and seed, the episodes.
    """

    parameters: Mapping[str, Any]
    runs: Mapping[str, Mapping[int, Sequence[Mapping[str, Any]]]]

    @property
    def reading(self) -> tuple[Any, ...]:
        """The readings it is under."""
        return tuple(self.parameters[name] for name in FITTED_READINGS if name in self.parameters)

    def episodes(self, row: Row, seeds: Sequence[int]) -> list[Mapping[str, Any]]:
        """The episodes of some seeds beside a row."""
        return [episode for seed in seeds for episode in self.runs[row.label][seed]]

    def seeds(self) -> list[int]:
        """The seeds that were run beside every row."""
        return sorted(set.intersection(*(set(found) for found in self.runs.values())))


def points(
    evidence: Evidence,
    paper: Paper,
    first: int,
    count: int,
    names: Sequence[str] = _NAMES,
    backend: str = "nodeworld",
    more: Mapping[str, Any] | None = None,
) -> list[Point]:
    """The points, set by these parameters alone, of which all rows were run with seeds `first` and the next ones.

    `more` holds further settings that the runs must have, the backend's options.
    """
    where = {"mode": "asynchronous", "policy": "paper", "backend": backend, **(more or {})}
    rows = {(row.map, row.variant): row.label for row in paper.performance}
    found: dict[tuple[Any, ...], dict[str, dict[int, Any]]] = defaultdict(lambda: defaultdict(dict))
    for trial in evidence.trials:
        if set(trial.parameters) == set(names) and first <= trial.seed < first + count:
            label = rows.get((trial.settings["scenario"], trial.settings["variant"]))
            if label is None or any(trial.settings.get(name) != value for name, value in where.items()):
                continue
            found[tuple(trial.parameters[name] for name in names)][label][trial.seed] = trial.episodes
    made = [Point(dict(zip(names, values, strict=True)), runs) for values, runs in found.items()]
    return [point for point in made if len(point.runs) == len(rows) and point.seeds()]


def distance(paper: Paper, point: Point, seeds: Sequence[int]) -> float:
    """How far a point is from the paper's five rows: 1 means as far as the rule of the verdicts calls coarse.

    The root of the mean square, over the rows, of the differences of the mean and of the standard deviation over
    episodes, of steps in units of a quarter of the paper's mean and of success in units of .1.
    """
    squares = []
    for row in paper.performance:
        episodes = point.episodes(row, seeds)
        for measure in _MEASURES:
            values = [float(episode[measure]) for episode in episodes]
            theirs, unit = row.reported(measure), _unit(row, measure)
            squares += [((fmean(values) - theirs.mean) / unit) ** 2, ((stdev(values) - theirs.sd) / unit) ** 2]
    return sqrt(fmean(squares))


def _unit(row: Row, measure: Told) -> float:
    """What is coarse beside a figure of the paper: a quarter of its steps, .1 of success."""
    return COARSE[measure] * (row.steps[0] if measure == "steps" else 1.0)


def _off(row: Row, measure: Told, point: Point) -> float:
    """Ours less the paper's mean, in those units."""
    values = [float(episode[measure]) for episode in point.episodes(row, point.seeds())]
    return (fmean(values) - row.reported(measure).mean) / _unit(row, measure)


def _interval(paper: Paper, point: Point) -> Figure:
    """The distance of a point with its 95 % interval, by resampling its seeds."""
    seeds, dice = point.seeds(), Random(0)
    found = distance(paper, point, seeds)
    if len(seeds) < 2:
        return Figure(found, None, None, len(seeds))
    drawn = sorted(distance(paper, point, dice.choices(seeds, k=len(seeds))) for _ in range(_RESAMPLES))
    return Figure(found, drawn[int(0.025 * _RESAMPLES)], drawn[int(0.975 * _RESAMPLES) - 1], len(seeds))


def _best(paper: Paper, found: Iterable[Point]) -> list[tuple[float, Point]]:
    """The best point of each reading, the best of all first."""
    best: dict[tuple[Any, ...], tuple[float, Point]] = {}
    for point in found:
        far = distance(paper, point, point.seeds())
        if point.reading not in best or far < best[point.reading][0]:
            best[point.reading] = (far, point)
    return sorted(best.values(), key=lambda each: each[0])


def held_out(size: Size, evidence: Evidence, paper: Paper) -> list[dict[str, Any]]:
    """The trials with fresh seeds: of the best point of each reading, and of the preset."""
    found = points(evidence, paper, size.first_seed, size.fit_seeds)
    chosen = [point.parameters for _, point in _best(paper, found)]
    return [fit_held_out(size, parameters) for parameters in [*chosen, PRESET_POINT] if chosen]


def fit_part(context: Context) -> list[Block]:
    """The fit: where it is best, how sure that is, and what is left unexplained there."""
    paper, size = context.paper, context.size
    tried = points(context.evidence, paper, size.first_seed, size.fit_seeds)
    if not tried:
        context.gaps.append(f"{_STUDY}: no run has succeeded.")
        return [Text("No run has succeeded.")]
    best = _best(paper, tried)
    fresh = {_key(p): p for p in points(context.evidence, paper, size.held_out_first, size.held_out_seeds)}
    preset = fresh.get(_key_of(PRESET_POINT))
    blocks: list[Block] = [
        Text(
            f"{len(tried)} points on the node world, with the rules `paper` but for the parameters below, seeds "
            f"{_span(size.first_seed, size.fit_seeds)}, {FULL.physics_episodes} episodes a run on each of the five "
            "rows. The distance of a point is the root of the mean square of its differences to the five rows: of "
            "mean and standard deviation over episodes, of steps in units of a quarter of the paper's mean, of "
            "success in units of .1. The best point of each reading was then run, beside the preset, with the seeds "
            f"{_span(size.held_out_first, size.held_out_seeds)}, by which nothing was chosen; their intervals are by "
            "resampling those seeds."
        ),
        _choices(paper, best, fresh, preset),
        Text(
            "Each other reading of the text alone, the rest as in the preset `paper`, seeds of the fit. The two "
            "that come nearest by themselves are part of the fit:"
        ),
        _alone(context),
        *_region(context, tried, best),
    ]
    chosen = fresh.get(_key(best[0][1]))
    if chosen is not None and preset is not None:
        readings = ", ".join(
            f"`{_short(name)}` {chosen.parameters[name]} (the preset: {PRESET_POINT[name]})" for name in FITTED_READINGS
        )
        blocks += [
            Heading(3, "The five rows at the best point, fresh seeds"),
            Text(
                f"The best point is under the readings {readings}. It was chosen by these very figures: that it comes "
                "near them says that the rules can explain them, not that the paper used these values."
            ),
            _rows(context, chosen, preset),
        ]
    return [*blocks, *driven_part(context, best[0][1])]


def driven_part(context: Context, best: Point) -> list[Block]:
    """The best point with rigid bodies, as `benchmarks/physics_tables.py run --set` does it; other points are gaps."""
    rows = []
    for engine in ENGINES:
        system = {"backend.push": "rl", "backend.feasibility": "forest"}
        there = points(context.evidence, context.paper, 0, MAX_SEED, backend=engine, more=system)
        same = [point for point in there if _key(point) == _key(best)]
        kept = sum(len(runs) for point in same for runs in point.runs.values())
        set_at_all = sum(
            bool(trial.parameters) for trial in context.evidence.trials if trial.settings["backend"] == engine
        )
        if left := set_at_all - kept:
            context.gaps.append(
                f"{_STUDY}: {left} of {set_at_all} stored runs on {engine} with parameters set are not of the paper's "
                "push and estimate (`rl`, `forest`) at the best point on all five maps; left out."
            )
        for point in same:
            values, settings = ", ".join(_values(point.parameters)), {"policy": "paper", "backend": engine}
            for row in context.paper.performance:
                cells = []
                for measure in _MEASURES:
                    by_seed = [fmean(float(e[measure]) for e in runs) for runs in point.runs[row.label].values()]
                    ours, digits = Figure.of(by_seed, WITHIN.get(measure)), _DIGITS[measure]
                    verdict = level(ours, row.reported(measure), measure)
                    about = f"{measure} on {row.label} (`{row.place}`)"
                    judged = Judged(_STUDY, about, f"`paper`, fitted, {engine}", verdict, settings, digits)
                    cells += [ours.shown(digits) if ours else "-", context.judge(judged)]
                far = f"{distance(context.paper, point, point.seeds()):.2f}"
                rows.append([values, engine, row.label, str(len(point.runs[row.label])), *cells, far])
    if not rows:
        return []
    columns = ["point", "engine", "map", "seeds", "steps", "verdict", "success", "verdict", "distance of all rows"]
    return [
        Heading(3, "With rigid bodies"),
        Text(
            "The paper's push and estimate (`rl`, `forest`) at the best point, 20 episodes a run; nothing was "
            "chosen by these runs. The distance is of the seeds that all five rows have:"
        ),
        Table(columns, rows),
    ]


def _choices(
    paper: Paper, best: Sequence[tuple[float, Point]], fresh: Mapping[tuple[Any, ...], Point], preset: Point | None
) -> Block:
    rows = []
    for far, point in best:
        again = fresh.get(_key(point))
        rows.append([*_values(point.parameters), f"{far:.2f}", _interval(paper, again).shown(2) if again else "-"])
    if preset is not None:
        rows.append([*_values(PRESET_POINT), "the preset", _interval(paper, preset).shown(2)])
    return Table([*map(_short, _NAMES), "distance, seeds of the fit", "distance, fresh seeds [95 %]"], rows)


def _alone(context: Context) -> Block:
    paper, size = context.paper, context.size
    found = []
    for name, value in [("policy.beta", PRESET_POINT["policy.beta"]), *ALTERNATIVES.items()]:
        there = points(context.evidence, paper, size.first_seed, size.fit_seeds, [name])
        what = "the preset" if name == "policy.beta" else f"`{_short(name)}` {value}"
        found += [(distance(paper, point, point.seeds()), what) for point in there if point.parameters[name] == value]
    return Table(["reading", "distance"], [[what, f"{far:.2f}"] for far, what in sorted(found)])


def _region(context: Context, tried: Sequence[Point], best: Sequence[tuple[float, Point]]) -> list[Block]:
    """Which values do as well as the best within what the seeds of the fit can tell apart."""
    from colonysim.plots import save
    from colonysim.plots.profiles import profiles_figure

    paper, (least, point) = context.paper, best[0]
    limit = _interval(paper, point).high or least
    far = [(distance(paper, each, each.seeds()), each) for each in tried]
    near = [each for value, each in far if value <= limit]
    curves: dict[str, list[tuple[Mapping[str, float], float]]] = defaultdict(list)
    for value, each in far:
        curves[", ".join(str(part) for part in each.reading)].append(
            ({_short(name): float(each.parameters[name]) for name in FITTED}, value)
        )
    figure = profiles_figure(curves, [_short(name) for name in FITTED], "distance to the paper's five rows", limit)
    save(figure, context.pages / "fit.png", "png", 80)
    rows = [
        [_short(name), f"{low:g} to {high:g}", f"{min(values):.2f} to {max(values):.2f}"]
        for name, (low, high) in FITTED.items()
        if (values := [each.parameters[name] for each in near])
    ]
    for name, options in FITTED_READINGS.items():
        there = [str(option) for option in options if any(each.parameters[name] == option for each in near)]
        rows.append([_short(name), ", ".join(map(str, options)), ", ".join(there)])
    return [
        Picture(
            "fit.png", "Distance of every point by each parameter; the line is the upper end of the best one's interval"
        ),
        Text(
            f"{len(near)} of {len(tried)} points lie within the interval of the best one's distance, by the "
            f"seeds of the fit up to {limit:.2f}:"
        ),
        Table(["parameter", "tried", "of those points"], rows),
        *_explained(paper, tried),
    ]


def _explained(paper: Paper, tried: Sequence[Point]) -> list[Block]:
    """Which figures of the paper points come close to, under each reading, and how many figures one does at once."""
    figures = list(product(paper.performance, _MEASURES))
    offs: dict[tuple[Any, ...], list[list[float]]] = {
        reading: [] for reading in sorted({point.reading for point in tried})
    }
    for point in tried:
        offs[point.reading].append([_off(row, measure, point) for row, measure in figures])
    rows = []
    for number, (row, measure) in enumerate(figures):
        reported, unit, digits = row.reported(measure), _unit(row, measure), _DIGITS[measure]
        cells = []
        for found in offs.values():
            values = [each[number] for each in found]
            low, high = (f"{reported.mean + off * unit:.{digits}f}" for off in (min(values), max(values)))
            cells.append(f"{low} to {high}; {sum(map(_is_close, values))} of {len(values)}")
        rows.append([row.label, measure, f"{reported.mean:g}", *cells])
    most = max(sum(map(_is_close, each)) for found in offs.values() for each in found)
    return [
        Text(
            "Which figures can be explained at all? For each reading, from the least to the largest mean of its "
            "points, and how many of them are close: within a quarter of the paper's steps or .1 of its success. No "
            f"more than {most} of the {len(figures)} figures are close at one and the same point."
        ),
        Table(["map", "measure", "the paper", *(", ".join(map(str, reading)) for reading in offs)], rows),
    ]


def _is_close(off: float) -> bool:
    return abs(off) <= 1.0


def _rows(context: Context, chosen: Point, preset: Point) -> Block:
    rows = []
    for row in context.paper.performance:
        for measure in _MEASURES:
            reported, digits = row.reported(measure), _DIGITS[measure]
            cells = [f"{reported.mean:g} ± {reported.sd:g}"]
            for point in (preset, chosen):
                values = [float(e[measure]) for e in point.episodes(row, point.seeds())]
                by_seed = [fmean(float(e[measure]) for e in point.runs[row.label][seed]) for seed in point.seeds()]
                ours = Figure.of(by_seed, WITHIN.get(measure))
                cells.append(f"{ours.shown(digits) if ours else '-'}, sd {stdev(values):.{digits}f}")
            verdict = level(ours, reported, measure)
            about = f"{measure} on {row.label} (`{row.place}`)"
            settings = {"policy": "paper", "backend": "nodeworld"}
            why = context.paper.reasons["nodeworld"]["paper"][measure].get(verdict.side or "", "")
            cells.append(context.judge(Judged(_STUDY, about, "`paper`, fitted", verdict, settings, digits, why)))
            rows.append([row.label, measure, *cells])
    return Table(["map", "measure", "the paper", "the preset", "the best point", "verdict at the best point"], rows)


def _values(parameters: Mapping[str, Any]) -> list[str]:
    return [f"{value:.2f}" if isinstance(value, float) else str(value) for value in map(parameters.get, _NAMES)]


def _key(point: Point) -> tuple[Any, ...]:
    return _key_of(point.parameters)


def _key_of(parameters: Mapping[str, Any]) -> tuple[Any, ...]:
    return tuple(parameters[name] for name in _NAMES)


def _short(name: str) -> str:
    return name.removeprefix("policy.")


def _span(first: int, count: int) -> str:
    return f"{first}-{first + count - 1}" if count > 1 else str(first)
