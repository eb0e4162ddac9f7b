"""Figures of a run, drawn from its directory alone. matplotlib is imported when something is drawn."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from colonysim.arguments import MAX_SEED, real, whole, wholes
from colonysim.errors import ColonysimError, MissingExtraError
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from matplotlib.figure import Figure

    from colonysim.trace.reader import Run

__all__ = ["KINDS", "PUSH_KINDS", "draw", "draw_training", "is_training", "save"]

KINDS = ("D", "E", "H", "B", "map", "trajectories", "episodes", "waiting", "workload", "fates")
"""What can be drawn of the run of a colony."""
PUSH_KINDS = ("trajectories", "samples")
"""What can be drawn of a run of single pushes."""
_WHOLE = ("episodes", "workload", "fates")
"""Those that are of the whole run, whichever episodes are asked for."""
_METADATA: dict[str, dict[str, str | None]] = {
    "png": {"Software": ""}, "svg": {"Date": None}, "pdf": {"CreationDate": None},
}  # fmt: skip
"""File formats; without dates in the files the same run gives the same bytes."""
_DPI = (10.0, 2400.0)
_MOST_PANELS = 6
_MOST_BOXES = 6


def draw(
    run: Run,
    *,
    what: Sequence[str] | None = None,
    episodes: Sequence[int] | None = None,
    hole: int | None = None,
    box: int | None = None,
    out: str | Path | None = None,
    kind: Literal["png", "svg", "pdf"] = "png",
    dpi: float = 130,
) -> list[Path]:
    """Draws a run and returns the images.

    Args:
        run: The run.
        what: Any of `KINDS` (by default all), or another field of the run by its name; of a run of single
            pushes any of `PUSH_KINDS`.
        episodes: The panels of fields and trajectories; by default up to six, from the first to the last. The map
            and the waiting are those of the last of them. Of a run of single pushes those that are drawn; by default
            the first six of each terrain.
        hole: Node of the hole whose H is drawn; by default an image for each hole. Only with H.
        box: The box whose B is drawn; by default an image for each of the first six. Only with B.
        out: Where to put the images; by default `plots` in the run directory.
        kind: File format.
        dpi: Pixels an inch, 10 to 2,400.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ColonysimError: The run has no such episode, hole, box or field, or the images cannot be written.
    """
    _need_matplotlib()
    dpi = real("dpi", dpi, *_DPI)
    what = None if what is None else _words(what)
    if episodes is not None:
        episodes = wholes("episodes", episodes)
    if "evaluation" in run.manifest:
        if hole is not None or box is not None:
            raise ColonysimError("a run of single pushes has no pheromones, hence neither hole nor box to choose")
        jobs = _push_jobs(run, PUSH_KINDS if what is None else what, episodes)
    else:
        if episodes is not None and what is not None and set(what) <= set(_WHOLE):
            raise ColonysimError(f"episodes: {', '.join(what)} show the whole run; leave the choice out")
        jobs = _jobs(run, KINDS if what is None else what, _episodes(run, episodes), hole, box)
    if out is None:
        if run.path is None:
            raise ColonysimError("this run kept no trace, so there is nothing to draw it from")
        out = run.path / "plots"
    images = []
    for name, make in jobs:
        path = Path(out) / f"{name}.{kind}"
        save(make(), path, kind, dpi)
        images.append(path)
    return images


def _words(what: Sequence[str]) -> tuple[str, ...]:
    words = (what,) if isinstance(what, str) else tuple(what)
    if not words:
        raise ColonysimError("what: expected at least one kind of image")
    return words


def is_training(folder: Path) -> bool:
    """Whether a folder is one that `colonysim train push` or `colonysim train way` wrote to."""
    return (folder / "history.json").is_file() or _is_fit(folder)


def _is_fit(folder: Path) -> bool:
    return (folder / "ways.jsonl").is_file()


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
    save(make(folder), path, kind)
    return [path]


def _need_matplotlib() -> None:
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        raise MissingExtraError(
            "drawing needs matplotlib, which is not installed: pip install 'colonysim[plot]'"
        ) from None


def _jobs(
    run: Run, what: Sequence[str], episodes: Sequence[int], hole: int | None, box: int | None
) -> list[tuple[str, Callable[[], Figure]]]:
    """File name and drawing function of each image; every mistake is found before the first is drawn."""
    from colonysim.plots.fates import fates_figure
    from colonysim.plots.fields import box_figure, hole_figure, node_figure
    from colonysim.plots.maps import map_figure
    from colonysim.plots.results import results_figure
    from colonysim.plots.trajectories import trajectories_figure
    from colonysim.plots.waiting import waiting_figure
    from colonysim.plots.workload import workload_figure

    if what is not None:
        for name, given, needed in (("hole", hole, "H"), ("box", box, "B")):
            if given is not None and needed not in what:
                raise ColonysimError(f"{name}: only with {needed}, which is not drawn")
    scenario = run.scenario
    holes = [scenario.topology.ids[each.node] for each in scenario.holes]
    if hole is not None and whole("hole", hole, 0, MAX_SEED) not in holes:
        raise ColonysimError(f"no hole at node {hole}; {nearest(str(hole), map(str, holes))}")
    if box is not None and whole("box", box, 0) >= len(scenario.boxes):
        there = f"the boxes are 0 to {len(scenario.boxes) - 1}" if scenario.boxes else "the run has none"
        raise ColonysimError(f"no box {box}; {there}")
    known = {*KINDS, *run.table("frames")["field"].unique().to_pylist()}
    of_run = dict(zip(_WHOLE, (results_figure, workload_figure, fates_figure), strict=True))
    jobs: list[tuple[str, Callable[[], Figure]]] = []
    for word in what:
        if word not in known:
            raise ColonysimError(f"cannot draw {word!r}; {nearest(word, sorted(known))}")
        if word == "map":
            jobs.append(("map", lambda: map_figure(run, episodes[-1])))
        elif word == "trajectories":
            jobs.append(("trajectories", lambda: trajectories_figure(run, episodes)))
        elif word == "waiting":
            jobs.append(("waiting", lambda: waiting_figure(run, episodes[-1])))
        elif word in of_run:
            jobs.append((word, lambda make=of_run[word]: make(run)))  # type: ignore[misc]
        elif word == "H":
            for node in holes if hole is None else [hole]:
                jobs.append((f"H-hole{node}", lambda node=node: hole_figure(run, node, episodes)))  # type: ignore[misc]
        elif word == "B":
            for number in range(len(scenario.boxes))[:_MOST_BOXES] if box is None else [box]:
                jobs.append((f"B-box{number}", lambda number=number: box_figure(run, number, episodes)))  # type: ignore[misc]
        else:
            jobs.append((word, lambda word=word: node_figure(run, word, episodes)))  # type: ignore[misc]
    return jobs


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
    return list(wanted)


def save(figure: Figure, path: Path, kind: str, dpi: float = 130) -> None:
    """Writes a figure in one step.

    Raises:
        ColonysimError: It cannot be written.
    """
    temporary = path.with_name(f".{path.name}.tmp")
    metadata = _METADATA.get(kind)
    if metadata is None:
        raise ColonysimError(f"no format {kind!r}; {nearest(str(kind), _METADATA)}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        figure.savefig(temporary, format=kind, dpi=dpi, metadata=metadata)
        temporary.replace(path)
    except OSError as error:
        raise ColonysimError(f"{path}: cannot be written: {error.strerror or error}") from error
