"""Figures of runs, sweeps and trainings, drawn from their directories alone.

`draw` draws a run, `draw_results` a sweep or several runs, `draw_training` a training. matplotlib is imported when
something is drawn.
"""

from __future__ import annotations

import os
import warnings
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Literal
from urllib.parse import quote

from colonysim.arguments import MAX_SEED, as_span, real, whole, wholes
from colonysim.errors import ColonysimError, ColonysimWarning, MissingExtraError, TraceError
from colonysim.files import replacing
from colonysim.installing import install_command
from colonysim.plots.sheet import SCREEN, EmptyFigureError, Style, sheet_of
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from matplotlib.figure import Figure

    from colonysim.plots.sheet import Sheet
    from colonysim.plots.shown import Figures
    from colonysim.scenario.groups import Group
    from colonysim.sweep.comparing import Difference
    from colonysim.trace.reader import Run

__all__ = [
    "KINDS", "MEASURES", "OF_AGENTS", "PUSH_KINDS", "RESULT_KINDS", "draw", "draw_results", "draw_training", "figures",
    "is_sweep", "is_training", "save",
]  # fmt: skip

FIELDS = ("D", "E", "H", "B")
"""The paper's pheromone fields."""
KINDS = (*FIELDS, "map", "trajectories", "episodes", "waiting", "workload", "fates")
"""What can be drawn of the run of a colony, besides fields of others."""
PUSH_KINDS = ("trajectories", "samples")
"""What can be drawn of a run of single pushes."""
RESULT_KINDS = ("means", "heatmap", "curves", "differences")
"""What can be drawn of a sweep or of several runs."""
MEASURES = ("success", "steps")
"""What these show."""
_Job = tuple[str, "Callable[[], Figure]"]
"""Name of a file, and what draws it."""
_WHOLE = ("episodes", "workload", "fates")
"""Those that are of the whole run, whichever episodes are asked for."""
OF_AGENTS = ("episodes", "waiting", "workload")
"""Those that can be drawn of each group of agents for itself."""
_METADATA: dict[str, dict[str, str | None]] = {
    "png": {"Software": ""}, "svg": {"Date": None}, "pdf": {"CreationDate": None},
}  # fmt: skip
"""File formats; without dates in the files the same run gives the same bytes."""
_DPI = (10.0, 2400.0)
_MOST_PANELS = 6
_MOST_BOXES = 6
_MOST_CHOSEN = 60
_MOST_INCHES = 200
"""Longest side of an image."""


def draw(
    run: Run,
    *,
    what: Sequence[str] | None = None,
    episodes: Sequence[int] | None = None,
    hole: int | None = None,
    box: int | None = None,
    by_group: bool = False,
    out: str | Path | None = None,
    kind: Literal["png", "svg", "pdf"] = "png",
    dpi: float | None = None,
    style: Style = "screen",
    width: str | float | None = None,
) -> list[Path]:
    """Draws a run and returns the images.

    What would be an empty figure is left out, and a `ColonysimWarning` says why.

    Args:
        run: The run.
        what: Any of `KINDS`, or another field of the run by its name; by default everything that the run has. Of a
            run of single pushes any of `PUSH_KINDS`.
        episodes: The panels of fields and trajectories; by default up to six, from the first to the last. The map
            and the waiting are those of the last of them. Of a run of single pushes those that are drawn; by default
            the first six of each terrain.
        hole: Node of the hole whose H (or another field with a value for each hole) is drawn; by default an image for
            each hole. Only with such a field.
        box: The box whose B (or another field of boxes) is drawn; by default an image for each of the first six. Only
            with such a field.
        by_group: Whether there is an image for each group of agents of what `OF_AGENTS` names.
        out: Where to put the images; by default `plots` in the run directory.
        kind: File format.
        dpi: Pixels an inch, 10 to 2,400; by default 130, in print 600.
        style: "screen", or "paper": as wide as a column, without a title (the caption says it), with thin lines, and
            letters in PDF and SVG as letters (type 42 in PDF).
        width: That of a figure for a paper: inches, or a text such as "3.4in", "86mm", "8.6cm" or "246pt" (points of
            TeX); by default 3.4 inches.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ColonysimError: The run has no such episode, hole, box or field, or no groups where they are asked for, there is
            nothing to draw, or the images cannot be written.
    """
    _need_matplotlib()
    sheet = sheet_of(style, width)
    dpi = _dpi(dpi, sheet)
    jobs = _asked(run, what, episodes, hole, box, by_group, sheet)
    if out is None:
        assert run.path is not None  # or there would be nothing to draw it from
        out = run.path / "plots"
    return _drawn(jobs, Path(out), kind, dpi, sheet, run.check_apart)


def draw_results(
    paths: str | Path | Sequence[str | Path],
    *,
    what: Sequence[str] | None = None,
    x: str | None = None,
    by: str | Sequence[str] | None = None,
    y: Literal["success", "steps"] | None = None,
    episodes: tuple[int, int] | None = None,
    out: str | Path | None = None,
    kind: Literal["png", "svg", "pdf"] = "png",
    dpi: float | None = None,
    style: Style = "screen",
    width: str | float | None = None,
) -> list[Path]:
    """Draws what came of a sweep, of a run's futures or of several runs, and returns the images.

    Trials that have not succeeded are left out, and so is what would be an empty figure; a `ColonysimWarning` says
    so. Intervals are of 95 % over runs (bootstrap from 8 on, Student's t for fewer); of one run there is none.

    Args:
        paths: Directories of sweeps and runs, one or several.
        what: Any of `RESULT_KINDS`; by default all for which there is something to draw. "means": success and steps
            along a parameter; "heatmap": by two parameters that are numbers; "curves": by episode; "differences":
            between settings, paired by seed as `colonysim.sweep.comparing.compare` does.
        x: The column along the axis (of "differences" the one that is compared, without `by`); by default the number
            with the most values, else what varies.
        by: The column or columns that are told apart by lines (of "differences" the first is compared); by default
            all others that vary. What is in neither is averaged over.
        y: The measure; by default both.
        episodes: First and last episode that count; None for all.
        out: Where to put the images; by default `plots` in the sweep's directory, of several in the working directory.
        kind: File format.
        dpi: As for `draw`.
        style: As for `draw`.
        width: As for `draw`.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ColonysimError: A path holds no results, there is no such column, there is nothing to draw, or the images
            cannot be written.
    """
    _need_matplotlib()
    sheet = sheet_of(style, width)
    dpi = _dpi(dpi, sheet)
    words = RESULT_KINDS if what is None else _words(what)
    for wrong in (word for word in words if word not in RESULT_KINDS):
        raise ColonysimError(f"cannot draw {wrong!r} of a sweep or several runs; {nearest(wrong, RESULT_KINDS)}")
    if y is not None and y not in MEASURES:
        raise ColonysimError(f"no measure {y!r}; {nearest(str(y), MEASURES)}")
    if episodes is not None:
        episodes = as_span("episodes", episodes)
    folders = [Path(each) for each in ([paths] if isinstance(paths, (str, Path)) else paths)]
    folders = list({each.absolute(): each for each in folders}.values())  # the same twice is no second run
    jobs = _result_jobs(folders, words, x, (by,) if isinstance(by, str) else by, y, episodes, sheet)
    from colonysim.sweep.tables import check_apart

    def apart(path: Path) -> None:
        for folder in folders:
            check_apart(folder, path)

    if out is None:
        out = folders[0] / "plots" if len(folders) == 1 and is_sweep(folders[0]) else Path("plots")
    return _drawn(jobs, Path(out), kind, dpi, sheet, apart)


def _drawn(
    jobs: Sequence[_Job], out: Path, kind: str, dpi: float, sheet: Sheet, check: Callable[[Path], None]
) -> list[Path]:
    """Draws and writes what is not empty; tells of what is.

    Raises:
        ColonysimError: There is nothing to draw at all.
    """
    images: list[Path] = []
    with sheet.drawing():
        for name, figure in _made(jobs):
            path = out / f"{name}.{kind}"
            check(path)
            save(sheet.finish(figure), path, kind, dpi)
            images.append(path)
    return images


def _made(jobs: Sequence[_Job]) -> Iterator[tuple[str, Figure]]:
    """Each figure that is not empty, with its name; at the end tells of those that are.

    Raises:
        EmptyFigureError: All are.
    """
    empty: dict[str, list[str]] = {}
    for name, make in jobs:
        try:
            figure = make()
        except EmptyFigureError as reason:
            empty.setdefault(str(reason), []).append(name)
            continue
        yield name, figure
    told = "; ".join(f"{', '.join(names)}: {reason}" for reason, names in empty.items())
    if sum(map(len, empty.values())) == len(jobs):
        raise EmptyFigureError(f"nothing to draw: {told}")
    if told:
        warnings.warn(f"left out: {told}", ColonysimWarning, stacklevel=4)


def _result_jobs(
    folders: Sequence[Path], words: Sequence[str], x: str | None, by: Sequence[str] | None, y: str | None,
    episodes: tuple[int, int] | None, sheet: Sheet,
) -> list[_Job]:  # fmt: skip
    """File name and drawing function of each image of a sweep or several runs."""
    from colonysim.plots.arrangement import arranged, short
    from colonysim.plots.differences import differences_figure
    from colonysim.plots.progress import progress_figure
    from colonysim.plots.settings import heatmap_figure, means_figure
    from colonysim.sweep.played import read_source
    from colonysim.trace.manifest import is_run, read_manifest

    for folder in folders:
        if is_run(folder) and "evaluation" in read_manifest(folder):
            raise ColonysimError(f"{folder}: a run of single pushes, which is drawn by itself")
    sources = [read_source(folder) for folder in folders]
    for source in sources:
        if source.shortfall:
            warnings.warn(f"{source.path}: {source.shortfall}", ColonysimWarning, stacklevel=3)
    played = [each for source in sources for each in source.played if each.means(episodes)]
    if not played:
        raise ColonysimError("nothing to draw yet: no run or trial has finished these episodes")
    arrangement = arranged(played, x, by)
    if arrangement.averaged:
        warnings.warn(f"averaged over: {', '.join(arrangement.averaged)}", ColonysimWarning, stacklevel=3)
    measures = MEASURES if y is None else (y,)
    about = [" and ".join(measures).capitalize(), *(short(str(folder), 40) for folder in folders[:3])]
    about += [f"and {len(folders) - 3} more"] * (len(folders) > 3)
    about += [] if episodes is None else [f"episodes {episodes[0]}-{episodes[1]}"]
    title = " · ".join(about)
    makers = {"means": means_figure, "heatmap": heatmap_figure, "curves": progress_figure}
    jobs: list[_Job] = []
    for word in words:
        if word == "differences":
            jobs.append((word, lambda: differences_figure(
                _differences(folders, arrangement.by, arrangement.x, episodes), measures, sheet, title
            )))  # fmt: skip
        else:
            jobs.append((word, partial(makers[word], played, arrangement, measures, episodes, sheet, title)))
    return jobs


def _differences(
    folders: Sequence[Path], by: Sequence[str], x: str | None, episodes: tuple[int, int] | None
) -> list[Difference]:
    """The differences that the first of the lines' columns makes, else that along the axis.

    Raises:
        EmptyFigureError: There is none of them, or nothing to compare.
    """
    from colonysim.sweep.comparing import compare

    column = next(iter((*by, *([x] if x else []))), None)
    if column is None:
        raise EmptyFigureError("the runs differ in nothing but their seeds")
    try:
        return compare(folders, by=column, episodes=episodes)
    except ColonysimError as reason:  # the files were read before: what is left is that no two can be compared
        raise EmptyFigureError(str(reason)) from reason


def _dpi(dpi: float | None, sheet: Sheet) -> float:
    return (600.0 if sheet.width else 130.0) if dpi is None else real("dpi", dpi, *_DPI)


def figures(
    run: Run,
    what: str | Sequence[str] | None = None,
    *,
    episodes: int | Sequence[int] | None = None,
    hole: int | None = None,
    box: int | None = None,
    by_group: bool = False,
) -> Figures:
    """The same figures, not written anywhere.

    Args:
        run: The run.
        what: As for `draw`.
        episodes: As for `draw`; a number stands for the one episode.
        hole: As for `draw`.
        box: As for `draw`.
        by_group: As for `draw`.

    Returns:
        matplotlib figures, whose labels say what they show; a notebook shows them one below the other.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ColonysimError: The run has no such episode, hole, box or field, or there is nothing to draw.
    """
    _need_matplotlib()
    from colonysim.plots.shown import Figures

    jobs = _asked(run, what, [episodes] if isinstance(episodes, int) else episodes, hole, box, by_group, SCREEN)
    made = []
    with SCREEN.drawing():
        for name, figure in _made(jobs):
            figure.set_label(name)
            made.append(figure)
    return Figures(made)


def _asked(
    run: Run, what: Sequence[str] | None, episodes: Sequence[int] | None, hole: int | None, box: int | None,
    by_group: bool, sheet: Sheet,
) -> list[_Job]:  # fmt: skip
    """File name and drawing function of each image that is asked for."""
    what = None if what is None else _words(what)
    if episodes is not None:
        episodes = wholes("episodes", episodes)
    if run.path is None:
        raise ColonysimError("this run kept no trace, so there is nothing to draw it from")
    if "evaluation" in run.manifest:
        if hole is not None or box is not None or by_group:
            raise ColonysimError("a run of single pushes has neither hole, box nor group to choose: it is no colony's")
        return _push_jobs(run, PUSH_KINDS if what is None else what, episodes, sheet)
    if episodes is not None and what is not None and set(what) <= set(_WHOLE):
        raise ColonysimError(f"episodes: {', '.join(what)} show the whole run; leave the choice out")
    run.check_places("events", "frames", "poses")
    return _jobs(run, what, _episodes(run, episodes), hole, box, episodes is not None, by_group, sheet)


def _words(what: Sequence[str]) -> tuple[str, ...]:
    words = (what,) if isinstance(what, str) else tuple(what)
    if not words:
        raise ColonysimError("what: expected at least one kind of image")
    return words


def is_sweep(folder: Path) -> bool:
    """Whether a folder is one that `colonysim sweep`, `tune` or `fork` wrote to."""
    return any(os.path.lexists(folder / name) for name in ("trials.parquet", "journal.jsonl"))


def is_training(folder: Path) -> bool:
    """Whether a folder is one that `colonysim train push` or `colonysim train way` wrote to."""
    return os.path.lexists(folder / "history.json") or _is_fit(folder)


def _is_fit(folder: Path) -> bool:
    return os.path.lexists(folder / "ways.jsonl")


def draw_training(
    folder: str | Path,
    *,
    out: str | Path | None = None,
    kind: Literal["png", "svg", "pdf"] = "png",
    dpi: float | None = None,
    style: Style = "screen",
    width: str | float | None = None,
) -> list[Path]:
    """Draws the learning curve of a training, also of one under way, or the calibration of a fit.

    Args:
        folder: What `colonysim train push` or `colonysim train way` wrote.
        out: Where to put the image; by default `plots` in the folder.
        kind: File format.
        dpi: As for `draw`.
        style: As for `draw`.
        width: As for `draw`.

    Returns:
        The image.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ColonysimError: There is nothing to draw, or the image cannot be written.
    """
    _need_matplotlib()
    sheet = sheet_of(style, width)
    from colonysim.plots.calibration import calibration_figure
    from colonysim.plots.learning import learning_figure

    folder = Path(folder)
    name, make = ("calibration", calibration_figure) if _is_fit(folder) else ("learning", learning_figure)
    jobs: list[_Job] = [(name, partial(make, folder, sheet))]
    return _drawn(jobs, folder / "plots" if out is None else Path(out), kind, _dpi(dpi, sheet), sheet, lambda _: None)


def _need_matplotlib() -> None:
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise MissingExtraError(
            f"drawing needs matplotlib, which is not installed: {install_command('plot')}"
        ) from None


def _jobs(
    run: Run, what: Sequence[str] | None, episodes: Sequence[int], hole: int | None, box: int | None, chosen: bool,
    by_group: bool, sheet: Sheet,
) -> list[_Job]:  # fmt: skip
    """File name and drawing function of each image; every mistake is found before the first is drawn."""
    from colonysim.plots.fates import fates_figure
    from colonysim.plots.fields import box_figure, hole_figure, node_figure
    from colonysim.plots.maps import map_figure
    from colonysim.plots.places import Places
    from colonysim.plots.results import results_figure
    from colonysim.plots.trajectories import trajectories_figure
    from colonysim.plots.waiting import waiting_figure
    from colonysim.plots.workload import workload_figure

    scenario = run.scenario
    holes = [scenario.topology.ids[each.node] for each in scenario.holes]
    if hole is not None and whole("hole", hole, 0, MAX_SEED) not in holes:
        raise ColonysimError(f"no hole at node {hole}; {nearest(str(hole), map(str, holes))}")
    if box is not None and whole("box", box, 0) >= len(scenario.boxes):
        there = f"the boxes are 0 to {len(scenario.boxes) - 1}" if scenario.boxes else "the run has none"
        raise ColonysimError(f"no box {box}; {there}")
    fields = _fields(run)
    for given, key in ((hole, "hole"), (box, "box")):
        if given is not None and what is not None and not any(fields.get(word) == key for word in what):
            raise ColonysimError(f"{key} {given}: only with a field that has a value for each {key}, and none is drawn")
    others = [word for word in KINDS if word not in FIELDS]
    missing = {number: run.missing("frames", number) for number in episodes}
    framed = [number for number in episodes if chosen or not missing[number]]
    if what is None:
        what = [*(fields if framed else ()), *(word for word in others if word not in fields)]
    known = {*fields, *others}
    groups: Sequence[tuple[Group | None, str]] = [(None, "")]
    if by_group:
        groups = _groups(run, what)
    jobs: list[_Job] = []
    places = Places(run)
    for word in what:
        if word not in known:
            raise ColonysimError(f"cannot draw {word!r}; {nearest(word, sorted(known))}")
        if word == "map":
            jobs.append(("map", lambda: map_figure(run, episodes[-1], sheet)))
        elif word == "trajectories":
            jobs.append(("trajectories", lambda: trajectories_figure(run, episodes, sheet)))
        elif word == "fates":
            jobs.append(("fates", lambda: fates_figure(run, sheet)))
        elif word == "episodes":
            jobs += [(f"episodes{end}", partial(results_figure, run, group, sheet)) for group, end in groups]
        elif word == "workload":
            jobs += [(f"workload{end}", partial(workload_figure, run, group, sheet)) for group, end in groups]
        elif word == "waiting":
            jobs += [
                (f"waiting{end}", partial(waiting_figure, run, episodes[-1], group, sheet)) for group, end in groups
            ]  # fmt: skip
        elif lacking := next((missing[number] for number in framed or episodes if missing[number]), ""):
            raise TraceError(f"{run.path}: {lacking}")
        elif fields[word] == "hole":
            for node in holes if hole is None else [hole]:
                make = partial(hole_figure, run, word, node, framed, sheet, places)
                jobs.append((f"{quote(word, safe='')}-hole{node}", make))
        elif fields[word] == "box":
            for number in range(len(scenario.boxes))[:_MOST_BOXES] if box is None else [box]:
                make = partial(box_figure, run, word, number, framed, sheet, places)
                jobs.append((f"{quote(word, safe='')}-box{number}", make))
        else:
            jobs.append((quote(word, safe=""), partial(node_figure, run, word, framed, sheet, places)))
    return jobs


def _groups(run: Run, what: Sequence[str]) -> list[tuple[Group | None, str]]:
    """The groups of a run's agents, and what the names of their images end with."""
    if not run.scenario.groups:
        raise ColonysimError(f"by group: {run.path} has no groups of agents")
    if not set(what) & set(OF_AGENTS):
        raise ColonysimError(f"by group: {', '.join(what)} are not of agents, expected some of {', '.join(OF_AGENTS)}")
    return [(group, f"-{quote(group.name, safe='')}") for group in run.scenario.groups]


def _fields(run: Run) -> dict[str, Literal["node", "hole", "box"]]:
    """The pheromone fields of a run, ours first, and what a value of each belongs to; by its rows and its manifest."""
    import pyarrow.compute as pc

    keyed, there = {"H"}, {*run.manifest.get("fields", {})}
    for frames in () if run.missing("frames") else run.batches("frames", ("episode", "field", "key")):
        keyed.update(frames.filter(pc.greater_equal(frames["key"], 0))["field"].unique().to_pylist())
        there.update(frames["field"].unique().to_pylist())
    order = [*(name for name in FIELDS if name in there), *sorted(there.difference(FIELDS))]
    return {name: "box" if run.by_box(name) else "hole" if name in keyed else "node" for name in order}


def _push_jobs(run: Run, what: Sequence[str], episodes: Sequence[int] | None, sheet: Sheet) -> list[_Job]:
    """The same for a run of single pushes."""
    from colonysim.plots.pushes import chosen_pushes, overlaid_figure, sample_figure

    chosen = chosen_pushes(run, episodes)
    jobs: list[_Job] = []
    for word in what:
        if word not in PUSH_KINDS:
            raise ColonysimError(f"cannot draw {word!r} of single pushes; {nearest(word, PUSH_KINDS)}")
        if word == "trajectories":
            jobs.append(("trajectories", lambda: overlaid_figure(run, chosen, sheet)))
        else:
            for kind, numbers in chosen.items():
                jobs.append((f"samples-{kind}", partial(sample_figure, run, kind, numbers, sheet)))
    return jobs


def _episodes(run: Run, wanted: Sequence[int] | None) -> list[int]:
    there = [result.episode for result in run.episodes]
    if not there:
        raise ColonysimError(f"{run.path}: no episode of this run is complete, so there is nothing to draw yet")
    if wanted is None:
        steps = [1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000]
        early = [number for number in steps if number in there and number != there[-1]]
        return [*early[: _MOST_PANELS - 1], there[-1]]
    for number in wanted:
        if number not in there:
            raise ColonysimError(f"no episode {number} in this run; it has {there[0]} to {there[-1]}")
    if len(wanted) > _MOST_CHOSEN:
        raise ColonysimError(f"{len(wanted)} episodes are more than one image holds; choose at most {_MOST_CHOSEN}")
    return list(wanted)


def save(figure: Figure, path: Path, kind: str, dpi: float = 130) -> None:
    """Writes a figure in one step.

    Raises:
        ColonysimError: It cannot be written.
    """
    metadata = _METADATA.get(kind)
    if metadata is None:
        raise ColonysimError(f"no format {kind!r}; {nearest(str(kind), _METADATA)}")
    if max(figure.get_size_inches()) > _MOST_INCHES:
        raise ColonysimError(f"{path}: would be more than {_MOST_INCHES} inches large; choose fewer episodes")
    import matplotlib

    # Ids in SVG are hashes with a salt, by default another one each time.
    with replacing(path) as temporary, matplotlib.rc_context({"svg.hashsalt": "colonysim"}):
        figure.savefig(temporary, format=kind, dpi=dpi, metadata=metadata)
