"""Learning curves of an ablation."""

import pytest

pytest.importorskip("matplotlib")

from colonysim.plots.learning import ablation_figure


def test_a_curve_is_the_mean_of_its_seeds_counted_from_the_first_test() -> None:
    seeds = [
        [[140, 900, 0.0, 1.0], [160, 1000, 0.5, 3.0]],
        [[100, 900, 0.0, 3.0], [120, 1000, 0.5, 5.0], [140, 1100, 1, 9]],
    ]
    figure = ablation_figure({"batch size": {"b = 64": seeds, "b = 256": []}}, "holes")
    (axes,) = figure.axes
    (line,) = axes.lines
    assert list(line.get_xdata()) == [0, 20]
    # Each test is averaged with those before it, then over the seeds.
    assert list(line.get_ydata()) == [2.0, 3.0]
    assert line.get_label() == "b = 64 (2 seeds)"
