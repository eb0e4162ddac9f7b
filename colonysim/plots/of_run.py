"""Figures of one run, drawn from its directory alone."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Literal
from urllib.parse import quote

from colonysim.arguments import MAX_SEED, whole, wholes
from colonysim.errors import ColonysimError, TraceError
from colonysim.plots.images import Job, dpi_of, drawn, need_matplotlib, not_empty, words_of
from colonysim.plots.sheet import SCREEN, Style, sheet_of
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.plots.sheet import Sheet
    from colonysim.plots.shown import Figures
    from colonysim.scenario.groups import Group
    from colonysim.trace.reader import Run

__all__ = ["FIELDS", "KINDS", "OF_AGENTS", "PUSH_KINDS", "draw", "figures"]

FIELDS = ("D", "E", "H", "B")
"""The paper's pheromone fields."""
KINDS = (*FIELDS, "map", "trajectories", "episodes", "waiting", "workload", "fates")
"""What can be drawn of the run of a colony, besides fields of others."""
PUSH_KINDS = ("trajectories", "samples")
"""What can be drawn of a run of single pushes."""
_WHOLE = ("episodes", "workload", "fates")
"""Those that are of the whole run, whichever episodes are asked for."""
OF_AGENTS = ("episodes", "waiting", "workload")
"""Those that can be drawn of each group of agents for itself."""
_MOST_PANELS = 6
_MOST_BOXES = 6
_MOST_CHOSEN = 60


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
    need_matplotlib()
    sheet = sheet_of(style, width)
    dpi = dpi_of(dpi, sheet)
    jobs = _asked(run, what, episodes, hole, box, by_group, sheet)
    if out is None:
        assert run.path is not None  # or there would be nothing to draw it from
        out = run.path / "plots"
    return drawn(jobs, Path(out), kind, dpi, sheet, run.check_apart)


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
    need_matplotlib()
    from colonysim.plots.shown import Figures

    jobs = _asked(run, what, [episodes] if isinstance(episodes, int) else episodes, hole, box, by_group, SCREEN)
    made = []
    with SCREEN.drawing():
        for name, figure in not_empty(jobs):
            figure.set_label(name)
            made.append(figure)
    return Figures(made)


def _asked(
    run: Run, what: Sequence[str] | None, episodes: Sequence[int] | None, hole: int | None, box: int | None,
    by_group: bool, sheet: Sheet,
) -> list[Job]:  # fmt: skip
    """File name and drawing function of each image that is asked for."""
    what = None if what is None else words_of(what)
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


def _jobs(
    run: Run, what: Sequence[str] | None, episodes: Sequence[int], hole: int | None, box: int | None, chosen: bool,
    by_group: bool, sheet: Sheet,
) -> list[Job]:  # fmt: skip
    """File name and drawing function of each image; every mistake is found before the first is drawn."""
    from colonysim.plots.ends import EpisodeEnds
    from colonysim.plots.fates import fates_figure
    from colonysim.plots.fields import box_figure, hole_figure, node_figure
    from colonysim.plots.maps import map_figure
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
    jobs: list[Job] = []
    ends = EpisodeEnds(run)
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
            jobs += [(f"episodes{suffix}", partial(results_figure, run, group, sheet)) for group, suffix in groups]
        elif word == "workload":
            jobs += [(f"workload{suffix}", partial(workload_figure, run, group, sheet)) for group, suffix in groups]
        elif word == "waiting":
            jobs += [
                (f"waiting{suffix}", partial(waiting_figure, run, episodes[-1], group, sheet))
                for group, suffix in groups
            ]  # fmt: skip
        elif lacking := next((missing[number] for number in framed or episodes if missing[number]), ""):
            raise TraceError(f"{run.path}: {lacking}")
        elif fields[word] == "hole":
            for node in holes if hole is None else [hole]:
                make = partial(hole_figure, run, word, node, framed, sheet, ends)
                jobs.append((f"{quote(word, safe='')}-hole{node}", make))
        elif fields[word] == "box":
            for number in range(len(scenario.boxes))[:_MOST_BOXES] if box is None else [box]:
                make = partial(box_figure, run, word, number, framed, sheet, ends)
                jobs.append((f"{quote(word, safe='')}-box{number}", make))
        else:
            jobs.append((quote(word, safe=""), partial(node_figure, run, word, framed, sheet, ends)))
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


def _push_jobs(run: Run, what: Sequence[str], episodes: Sequence[int] | None, sheet: Sheet) -> list[Job]:
    """The same for a run of single pushes."""
    from colonysim.plots.pushes import chosen_pushes, overlaid_figure, sample_figure

    chosen = chosen_pushes(run, episodes)
    jobs: list[Job] = []
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
