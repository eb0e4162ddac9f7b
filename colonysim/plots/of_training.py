"""Figures of trainings and fits, also of those under way."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import Literal

from colonysim.files import read_json
from colonysim.plots.images import Job, dpi_of, drawn, need_matplotlib
from colonysim.plots.sheet import Style, sheet_of

__all__ = ["draw_training", "is_training"]


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
        folder: What `colonysim train push`, `train policy` or `train way` wrote.
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
    need_matplotlib()
    sheet = sheet_of(style, width)
    from colonysim.plots.calibration import calibration_figure
    from colonysim.plots.learning import learning_figure
    from colonysim.plots.policy_learning import is_of_policy, policy_learning_figure

    folder = Path(folder)
    name, make = ("calibration", calibration_figure) if _is_fit(folder) else ("learning", learning_figure)
    if name == "learning" and is_of_policy(read_json(folder / "history.json")):
        make = policy_learning_figure
    jobs: list[Job] = [(name, partial(make, folder, sheet))]
    return drawn(jobs, folder / "plots" if out is None else Path(out), kind, dpi_of(dpi, sheet), sheet, lambda _: None)


def is_training(folder: Path) -> bool:
    """Whether a folder is one that `colonysim train push`, `train policy` or `train way` wrote to."""
    return os.path.lexists(folder / "history.json") or _is_fit(folder)


def _is_fit(folder: Path) -> bool:
    return os.path.lexists(folder / "ways.jsonl")
