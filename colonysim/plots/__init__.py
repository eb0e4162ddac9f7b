"""Figures of a run, drawn from its directory alone. matplotlib is imported when something is drawn."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Literal
from urllib.parse import quote

from colonysim.arguments import MAX_SEED, real, whole, wholes
from colonysim.errors import ColonysimError, MissingExtraError, TraceError
from colonysim.files import replacing
from colonysim.installing import install_command
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from contextlib import AbstractContextManager

    from matplotlib.figure import Figure

    from colonysim.plots.shown import Figures
    from colonysim.scenario.groups import Group
    from colonysim.trace.reader import Run

__all__ = ["KINDS", "OF_AGENTS", "PUSH_KINDS", "draw", "draw_training", "figures", "is_training", "save"]

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
    dpi: float = 130,
) -> list[Path]:
    """Draws a run and returns the images.

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
        dpi: Pixels an inch, 10 to 2,400.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ColonysimError: The run has no such episode, hole, box or field, or no groups where they are asked for, or the
            images cannot be written.
    """
    _need_matplotlib()
    dpi = real("dpi", dpi, *_DPI)
    jobs = _asked(run, what, episodes, hole, box, by_group)
    if out is None:
        assert run.path is not None  # or there would be nothing to draw it from
        out = run.path / "plots"

    images = []
    with _as_words():
        for name, make in jobs:
            path = Path(out) / f"{name}.{kind}"
            run.check_apart(path)
            save(make(), path, kind, dpi)
            images.append(path)
    return images


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
        ColonysimError: The run has no such episode, hole, box or field.
    """
    _need_matplotlib()
    from colonysim.plots.shown import Figures

    jobs = _asked(run, what, [episodes] if isinstance(episodes, int) else episodes, hole, box, by_group)
    made = []
    with _as_words():
        for name, make in jobs:
            figure = make()
            figure.set_label(name)
            made.append(figure)
    return Figures(made)


def _asked(
    run: Run, what: Sequence[str] | None, episodes: Sequence[int] | None, hole: int | None, box: int | None,
    by_group: bool,
) -> list[tuple[str, Callable[[], Figure]]]:
    """File name and drawing function of each image that is asked for."""
    what = None if what is None else _words(what)
    if episodes is not None:
        episodes = wholes("episodes", episodes)
    if run.path is None:
        raise ColonysimError("this run kept no trace, so there is nothing to draw it from")
    if "evaluation" in run.manifest:
        if hole is not None or box is not None or by_group:
            raise ColonysimError("a run of single pushes has neither hole, box nor group to choose: it is no colony's")
        return _push_jobs(run, PUSH_KINDS if what is None else what, episodes)
    if episodes is not None and what is not None and set(what) <= set(_WHOLE):
        raise ColonysimError(f"episodes: {', '.join(what)} show the whole run; leave the choice out")
    run.check_places("events", "frames", "poses")
    return _jobs(run, what, _episodes(run, episodes), hole, box, episodes is not None, by_group)


def _as_words() -> AbstractContextManager[None]:
    """Within this a name with two dollar signs is a name, no formula."""
    import matplotlib

    found: AbstractContextManager[None] = matplotlib.rc_context({"text.parse_math": False})
    return found


def _words(what: Sequence[str]) -> tuple[str, ...]:
    words = (what,) if isinstance(what, str) else tuple(what)
    if not words:
        raise ColonysimError("what: expected at least one kind of image")
    return words


def is_training(folder: Path) -> bool:
    """Whether a folder is one that `colonysim train push` or `colonysim train way` wrote to."""
    return os.path.lexists(folder / "history.json") or _is_fit(folder)


def _is_fit(folder: Path) -> bool:
    return os.path.lexists(folder / "ways.jsonl")


def draw_training(
    folder: str | Path, *, out: str | Path | None = None, kind: Literal["png", "svg", "pdf"] = "png"
) -> list[Path]:
    """Draws the learning curve of a training, also of one under way, or the calibration of a fit.

    Args:
        folder: What `colonysim train push` or `colonysim train way` wrote.
        out: Where to put the image; by default `plots` in the folder.
        kind: File format.

    Returns:
        The image.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ColonysimError: There is nothing to draw, or the image cannot be written.
    """
    _need_matplotlib()
    from colonysim.plots.calibration import calibration_figure
    from colonysim.plots.learning import learning_figure

    folder = Path(folder)
    name, make = ("calibration", calibration_figure) if _is_fit(folder) else ("learning", learning_figure)
    path = (folder / "plots" if out is None else Path(out)) / f"{name}.{kind}"
    with _as_words():
        save(make(folder), path, kind)
    return [path]


def _need_matplotlib() -> None:
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise MissingExtraError(
            f"drawing needs matplotlib, which is not installed: {install_command('plot')}"
        ) from None


def _jobs(
    run: Run, what: Sequence[str] | None, episodes: Sequence[int], hole: int | None, box: int | None, chosen: bool,
    by_group: bool,
) -> list[tuple[str, Callable[[], Figure]]]:
    """File name and drawing function of each image; every mistake is found before the first is drawn."""
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
    jobs: list[tuple[str, Callable[[], Figure]]] = []
    for word in what:
        if word not in known:
            raise ColonysimError(f"cannot draw {word!r}; {nearest(word, sorted(known))}")
        if word == "map":
            jobs.append(("map", lambda: map_figure(run, episodes[-1])))
        elif word == "trajectories":
            jobs.append(("trajectories", lambda: trajectories_figure(run, episodes)))
        elif word == "fates":
            jobs.append(("fates", lambda: fates_figure(run)))
        elif word == "episodes":
            jobs += [(f"episodes{end}", partial(results_figure, run, group)) for group, end in groups]
        elif word == "workload":
            jobs += [(f"workload{end}", partial(workload_figure, run, group)) for group, end in groups]
        elif word == "waiting":
            jobs += [(f"waiting{end}", partial(waiting_figure, run, episodes[-1], group)) for group, end in groups]
        elif lacking := next((missing[number] for number in framed or episodes if missing[number]), ""):
            raise TraceError(f"{run.path}: {lacking}")
        elif fields[word] == "hole":
            for node in holes if hole is None else [hole]:
                make = partial(hole_figure, run, word, node, framed)
                jobs.append((f"{quote(word, safe='')}-hole{node}", make))
        elif fields[word] == "box":
            for number in range(len(scenario.boxes))[:_MOST_BOXES] if box is None else [box]:
                jobs.append((f"{quote(word, safe='')}-box{number}", partial(box_figure, run, word, number, framed)))
        else:
            jobs.append((quote(word, safe=""), partial(node_figure, run, word, framed)))
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


def _push_jobs(run: Run, what: Sequence[str], episodes: Sequence[int] | None) -> list[tuple[str, Callable[[], Figure]]]:
    """The same for a run of single pushes."""
    from colonysim.plots.pushes import chosen_pushes, overlaid_figure, sample_figure

    chosen = chosen_pushes(run, episodes)
    jobs: list[tuple[str, Callable[[], Figure]]] = []
    for word in what:
        if word not in PUSH_KINDS:
            raise ColonysimError(f"cannot draw {word!r} of single pushes; {nearest(word, PUSH_KINDS)}")
        if word == "trajectories":
            jobs.append(("trajectories", lambda: overlaid_figure(run, chosen)))
        else:
            for kind, numbers in chosen.items():
                jobs.append((f"samples-{kind}", lambda kind=kind, numbers=numbers: sample_figure(run, kind, numbers)))  # type: ignore[misc]
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
    with replacing(path) as temporary:
        figure.savefig(temporary, format=kind, dpi=dpi, metadata=metadata)
