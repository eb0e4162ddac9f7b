"""Figures of sweeps, of a run's futures and of several runs."""

from __future__ import annotations

import warnings
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from colonysim.arguments import as_span
from colonysim.errors import ColonysimError, ColonysimWarning
from colonysim.plots.images import Job, dpi_of, drawn, need_matplotlib, words_of
from colonysim.plots.sheet import EmptyFigureError, Style, sheet_of
from colonysim.suggest import nearest

if TYPE_CHECKING:
    from collections.abc import Sequence

    from colonysim.plots.sheet import Sheet
    from colonysim.sweep.comparing import Difference

__all__ = ["DRAWN_MEASURES", "RESULT_KINDS", "draw_results"]

RESULT_KINDS = ("means", "heatmap", "curves", "differences")
"""What can be drawn of a sweep or of several runs."""
DRAWN_MEASURES = ("success", "steps")
"""What these show."""


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
    need_matplotlib()
    from colonysim.sweep.tables import check_apart, is_sweep

    sheet = sheet_of(style, width)
    dpi = dpi_of(dpi, sheet)
    words = RESULT_KINDS if what is None else words_of(what)
    if unknown := [word for word in words if word not in RESULT_KINDS]:
        hint = nearest(unknown[0], RESULT_KINDS)
        raise ColonysimError(f"cannot draw {unknown[0]!r} of a sweep or several runs; {hint}")
    if y is not None and y not in DRAWN_MEASURES:
        raise ColonysimError(f"no measure {y!r}; {nearest(str(y), DRAWN_MEASURES)}")
    if episodes is not None:
        episodes = as_span("episodes", episodes)
    folders = [Path(each) for each in ([paths] if isinstance(paths, (str, Path)) else paths)]
    folders = list({each.absolute(): each for each in folders}.values())  # the same twice is no second run
    jobs = _result_jobs(folders, words, x, (by,) if isinstance(by, str) else by, y, episodes, sheet)
    def apart(path: Path) -> None:
        for folder in folders:
            check_apart(folder, path)

    if out is None:
        out = folders[0] / "plots" if len(folders) == 1 and is_sweep(folders[0]) else Path("plots")
    return drawn(jobs, Path(out), kind, dpi, sheet, apart)


def _result_jobs(
    folders: Sequence[Path], words: Sequence[str], x: str | None, by: Sequence[str] | None, y: str | None,
    episodes: tuple[int, int] | None, sheet: Sheet,
) -> list[Job]:  # fmt: skip
    """File name and drawing function of each image of a sweep or several runs."""
    from colonysim.plots.arrangement import arranged, short
    from colonysim.plots.by_episode import by_episode_figure
    from colonysim.plots.by_setting import heatmap_figure, means_figure
    from colonysim.plots.differences import differences_figure
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
    measures = DRAWN_MEASURES if y is None else (y,)
    about = [" and ".join(measures).capitalize(), *(short(str(folder), 40) for folder in folders[:3])]
    about += [f"and {len(folders) - 3} more"] * (len(folders) > 3)
    about += [] if episodes is None else [f"episodes {episodes[0]}-{episodes[1]}"]
    title = " · ".join(about)
    makers = {"means": means_figure, "heatmap": heatmap_figure, "curves": by_episode_figure}
    jobs: list[Job] = []
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
