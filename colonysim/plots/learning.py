"""The learning curve of a training: success and reward of its tests."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from colonysim.errors import ColonysimError
from colonysim.files import found_at, read_json
from colonysim.plots.paper import AGENT, BOX, INK, QUIET
from colonysim.plots.results import WINDOW, running_interval
from colonysim.plots.sheet import SCREEN
from colonysim.trace.fields import is_a

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from matplotlib.axes import Axes

    from colonysim.plots.sheet import Sheet

__all__ = ["ablation_figure", "learning_figure"]

_SMOOTHED = 8
"""Tests that a curve of an ablation is averaged over (of 20 episodes: the paper's 150), at most a third of them."""
_LARGEST, _LONGEST = 1e12, 100
"""Of a number that is drawn, and characters of a text."""
_SETTINGS = ("#E69F00", "#009E73", "#56B4E9", "#CC79A7")
"""Colours of the curves of a panel."""
_MEASURES = {"reward": 3, "success": 2}
_TERRAINS = {"flat": "#E69F00", "slope": "#009E73", "hole": "#3A3A3A"}


def learning_figure(folder: Path, sheet: Sheet = SCREEN) -> Figure:
    """Success and reward of the tests against the episodes of training before them.

    Args:
        folder: What `colonysim train push` wrote: `history.json` and, once it has ended, the card of the network.
        sheet: What is drawn on.

    Raises:
        ColonysimError: There is no test yet, or a file cannot be read.
    """
    history = _history(folder / "history.json")
    if not history:
        raise ColonysimError(f"{folder}: no test of this training is complete, so there is nothing to draw yet")
    card = _card(folder / "push.json") if os.path.lexists(folder / "push.json") else {}
    episodes = [test["episodes"] for test in history]
    figure = sheet.figure(7.0, 5.4, f"Training of the push · {_about(card)}")
    above, below = figure.subplots(2, 1, sharex=True)
    _curve(above, episodes, [test["success"] for test in history], BOX, (0.0, 1.0))
    for kind, color in _TERRAINS.items():
        there = [test for test in history if kind in test["by_kind"]]
        if there:
            means = [mean for mean, _, _ in running_interval([test["by_kind"][kind] for test in there])]
            above.plot([test["episodes"] for test in there], means, color=color, linewidth=0.9, label=f"mean on {kind}")
    _curve(below, episodes, [test["reward"] for test in history], AGENT, None)
    above.set_ylim(-0.02, 1.02)
    above.set_ylabel("success of a test", fontsize=8)
    below.set_ylabel("reward of a test", fontsize=8)
    below.set_xlabel("training episodes", fontsize=8)
    below.xaxis.set_major_locator(MaxNLocator(integer=True))
    if card:
        for axes in (above, below):
            axes.axvline(
                card["how"]["peak_episode"], color=INK, linewidth=0.8, linestyle="dotted", label="network that was kept"
            )
    sheet.legend(figure, above.get_legend_handles_labels()[0])
    return figure


def ablation_figure(
    panels: Mapping[str, Mapping[str, Sequence[Sequence[Sequence[float]]]]], about: str, measure: str = "reward"
) -> Figure:
    """Reward or success of the tests by training episodes, one panel a parameter and one curve a value of it.

    Args:
        panels: Title, then label of a value, then for each training seed its tests: episodes, actions, success, reward.
            Episodes of the exploration do not count. At most four values a panel.
        about: What was trained, for the title.
        measure: "reward" or "success".
    """
    figure = Figure(figsize=(max(5.0, 3.6 * len(panels)), 3.9), layout="constrained")
    figure.suptitle(f"Training the push · {about}", fontsize=11, color=INK)
    row = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for axes, (title, curves) in zip(row, panels.items(), strict=True):
        for color, (label, seeds) in zip(_SETTINGS, curves.items(), strict=False):
            if not seeds:
                continue
            smooth = [_smooth([test[_MEASURES[measure]] for test in tests]) for tests in seeds]
            by_test = list(zip(*smooth, strict=False))
            episodes = [test[0] for test in seeds[0][: len(by_test)]]
            axes.fill_between(episodes, [min(v) for v in by_test], [max(v) for v in by_test], color=color, alpha=0.2)
            means = [sum(v) / len(v) for v in by_test]
            trained = f"{len(seeds)} seed{'s' * (len(seeds) > 1)}"
            axes.plot(episodes, means, color=color, linewidth=1.6, label=f"{label} ({trained})")
        axes.set_title(title, fontsize=9)
        axes.set_xlabel("training episodes after the exploration", fontsize=8)
        _tidy(axes)
        # Below the axes, where no curve is.
        axes.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2, frameon=False)
    row[0].set_ylabel(f"{measure} of the tests\n(mean, least to largest of the seeds)", fontsize=8)
    return figure


def _smooth(values: list[float]) -> list[float]:
    window = min(_SMOOTHED, max(1, len(values) // 3))
    parts = [values[max(0, i + 1 - window) : i + 1] for i in range(len(values))]
    return [sum(part) / len(part) for part in parts]


def _tidy(axes: Axes) -> None:
    axes.tick_params(labelsize=8)
    axes.grid(color=QUIET, linewidth=0.4, alpha=0.6)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _curve(
    axes: Axes, episodes: list[int], values: list[float], color: str, limits: tuple[float, float] | None
) -> None:
    means, lows, highs = zip(*running_interval(values), strict=True)
    count = min(WINDOW, len(values))
    if limits is not None:
        lows = tuple(max(low, limits[0]) for low in lows)
        highs = tuple(min(high, limits[1]) for high in highs)
    axes.fill_between(
        episodes, lows, highs, color=color, alpha=0.2, linewidth=0, label=f"its 95 % interval (t, n = {count})"
    )
    axes.plot(episodes, means, color=color, linewidth=1.6, label=f"mean of {count} tests")
    axes.plot(episodes, values, ".", color=INK, markersize=4, label="test")
    _tidy(axes)


def _about(card: dict[str, Any]) -> str:
    if not card:
        return "under way, or stopped"
    how = card["how"]
    return f"{how['config']['name']} · seed {how['seed']} · {how['config']['test_block']} episodes a test"


def _history(file: Path) -> list[dict[str, Any]]:
    """The tests of a training: `episodes` before each, `success`, `reward`, and the success `by_kind` of terrain."""
    tests = read_json(file)
    if not isinstance(tests, list):
        raise ColonysimError(f"{file}: expected a list of tests")
    for i, test in enumerate(tests):
        numbers = {name: found_at(test, name) for name in ("episodes", "success", "reward")}
        by_kind = found_at(test, "by_kind")
        if isinstance(by_kind, dict):
            numbers |= {f"by_kind.{name}": value for name, value in by_kind.items()}
        for name, value in numbers.items():
            if not is_a(value, float) or not abs(value) <= _LARGEST:
                raise ColonysimError(f"{file}: {i}.{name[:60]}: expected a number, at most {_LARGEST:g}")
        if not isinstance(by_kind, dict):
            raise ColonysimError(f"{file}: {i}.by_kind: expected a number for each terrain")
    return tests


def _card(file: Path) -> dict[str, Any]:
    card = read_json(file)
    for where, kind in (("how.peak_episode", float), ("how.seed", int), ("how.config.name", str),
                        ("how.config.test_block", int)):  # fmt: skip
        value = found_at(card, where)
        if not is_a(value, kind) or len(str(value)) > _LONGEST:
            raise ColonysimError(f"{file}: {where}: is missing or of another kind, expected that of a trained network")
    return dict(card)
