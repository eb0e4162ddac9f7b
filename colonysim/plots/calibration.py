"""How far the chance of a push, and of a whole way, can be trusted: what was foretold against what came."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from colonysim.errors import ColonysimError
from colonysim.files import found_at, read_json
from colonysim.plots.paper import AGENT, BOX, INK, QUIET
from colonysim.plots.sheet import SCREEN
from colonysim.trace.fields import MOST, is_a

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from colonysim.plots.sheet import Sheet

__all__ = ["calibration_figure"]

_LONGEST = 200
_SHARES = ("chance", "success", "success_low", "success_high")
_ABOUT = {"pushes": "single pushes", "ways": "whole ways, told before the first push"}


def calibration_figure(folder: Path, sheet: Sheet = SCREEN) -> Figure:
    """The calibration curves of a fit, with the number of pushes or ways in each bin.

    Args:
        folder: What `colonysim train way` wrote.
        sheet: What is drawn on.

    Raises:
        ColonysimError: The fit has not ended, or its card cannot be read.
    """
    card = folder / "way.json"
    if not os.path.lexists(card):
        raise ColonysimError(f"{folder}: its ways are not fitted yet, so there is nothing to draw")
    results = _results(card)
    rows, columns = sheet.beside(2)
    title = f"Calibration of the chance of a way · {results['split']}"
    figure = sheet.figure(3.8 * columns, (3.4 if sheet.narrow else 4.0) * rows, title)
    panels = figure.subplots(rows, columns)
    for axes, color, (part, about) in zip(panels, (BOX, AGENT), _ABOUT.items(), strict=True):
        _curve(axes, color, results[part], about)
    return figure


def _results(card: Path) -> dict[str, Any]:
    """What the card says of how well the chance was foretold, checked as far as it is drawn."""
    results = found_at(read_json(card), "results")
    if not is_a(found_at(results, "split"), str) or len(results["split"]) > _LONGEST:
        raise ColonysimError(f"{card}: results.split: expected a text")
    for part in _ABOUT:
        curve = found_at(results, f"{part}.curve")
        if not isinstance(curve, list):
            raise ColonysimError(f"{card}: results.{part}.curve: expected a list")
        shares = [(f"curve.{i}.{name}", found_at(point, name)) for i, point in enumerate(curve) for name in _SHARES]
        counts = [(f"curve.{i}.n", found_at(point, "n")) for i, point in enumerate(curve)]
        for name, value in [*shares, ("brier", found_at(results, f"{part}.brier"))]:
            if not is_a(value, float) or not 0 <= value <= 1:
                raise ColonysimError(f"{card}: results.{part}.{name}: expected a number, 0 to 1")
        for name, value in [*counts, ("n", found_at(results, f"{part}.n"))]:
            if not is_a(value, int) or not 0 <= value <= MOST:
                raise ColonysimError(f"{card}: results.{part}.{name}: expected a whole number, 0 or more")
    return dict(results)


def _curve(axes: Axes, color: str, judged: Mapping[str, Any], about: str) -> None:
    curve = judged["curve"]
    told, came = [part["chance"] for part in curve], [part["success"] for part in curve]
    axes.plot((0.0, 1.0), (0.0, 1.0), color=QUIET, linewidth=1.0)
    spread = (
        [max(part["success"] - part["success_low"], 0.0) for part in curve],
        [max(part["success_high"] - part["success"], 0.0) for part in curve],
    )
    axes.errorbar(told, came, yerr=spread, color=color, marker="o", markersize=4, linewidth=1.2, capsize=2)
    for part in curve:
        below = part["chance"] > 0.5
        axes.annotate(
            str(part["n"]), (part["chance"], part["success"]), xytext=(5 if not below else -5, 7 if not below else -12),
            textcoords="offset points", fontsize=7, color=INK, ha="left" if not below else "right",
        )  # fmt: skip
    axes.set_title(f"{about}\n{judged['n']}, Brier score {judged['brier']:.3f}", fontsize=9)
    axes.set_xlabel("chance that was foretold (mean of a bin)", fontsize=8)
    axes.set_ylabel("share that succeeded, Wilson 95 %", fontsize=8)
    axes.set_xlim(-0.04, 1.04)
    axes.set_ylim(-0.04, 1.04)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=8)
    axes.grid(color=QUIET, linewidth=0.4, alpha=0.6)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
