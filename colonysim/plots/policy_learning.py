"""The learning curve of a colony's policy: makespan and success of its tests."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.ticker import MaxNLocator

from colonysim.errors import ColonysimError
from colonysim.files import found_at, read_json
from colonysim.plots.paper import INK, pens, plain
from colonysim.plots.sheet import SCREEN
from colonysim.trace.fields import is_a

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path
    from typing import Any

    from matplotlib.figure import Figure

    from colonysim.plots.sheet import Sheet

__all__ = ["is_of_policy", "policy_curves_figure", "policy_learning_figure"]

_NUMBERS = ("decisions", "tested.success", "tested.seconds")
_LARGEST = 1e12


def is_of_policy(history: Any) -> bool:
    """Whether the content of a `history.json` is that of a policy's training."""
    return isinstance(history, list) and bool(history) and found_at(history[0], "phase") is not None


def policy_learning_figure(folder: Path, sheet: Sheet = SCREEN) -> Figure:
    """Makespan and success of the tests against the decisions that were learned from before them.

    Args:
        folder: What `colonysim train policy` wrote.
        sheet: What is drawn on.

    Raises:
        ColonysimError: There is no test yet, or the file cannot be read.
    """
    file = folder / "history.json"
    tests = []
    for i, each in enumerate(read_json(file)):
        if found_at(each, "tested") is None:
            continue
        numbers = [found_at(each, name) for name in _NUMBERS]
        for name, value in zip(_NUMBERS, numbers, strict=True):
            if not is_a(value, float) or not abs(value) <= _LARGEST:
                raise ColonysimError(f"{file}: {i}.{name}: expected a number, at most {_LARGEST:g}")
        tests.append(numbers)
    if not tests:
        raise ColonysimError(f"{folder}: no test of this training is complete, so there is nothing to draw yet")
    return policy_curves_figure({"test": tests}, sheet)


def policy_curves_figure(
    curves: Mapping[str, Sequence[Sequence[float]]], sheet: Sheet = SCREEN, rule: float | None = None
) -> Figure:
    """The curves of some trainings of a policy.

    Args:
        curves: By name the tests of a training: decisions before each, success, and makespan in simulated seconds.
        sheet: What is drawn on.
        rule: Makespan of the rule in such tests, simulated seconds, for a line to compare with.
    """
    figure = sheet.figure(7.0, 3.0, "Training of a colony's policy")
    left, right = figure.subplots(1, 2)
    for pen, (name, tests) in zip(pens(len(curves)), curves.items(), strict=True):
        decisions = [test[0] / 1000.0 for test in tests]
        left.plot(decisions, [test[2] for test in tests], color=pen.color, linewidth=1.2, label=name)
        right.plot(decisions, [test[1] for test in tests], color=pen.color, linewidth=1.2)
    if rule is not None:
        left.axhline(rule, color=INK, linestyle="dotted", linewidth=1.0, label="colony")
    plain(left, "thousand decisions learned from", "makespan of a test, s")
    plain(right, "thousand decisions learned from", "success of a test")
    for axes in (left, right):
        axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    sheet.legend(figure, left.get_legend_handles_labels()[0])
    return figure
