"""Learning curves of an ablation."""

import pytest

pytest.importorskip("matplotlib")

from colonysim.plots.learning import ablation_figure


def test_a_curve_is_the_mean_of_its_seeds() -> None:
    seeds = [
        [[20 + 20 * i, 900, 0.0, reward] for i, reward in enumerate((1.0, 3.0, 3.0, 5.0, 5.0, 5.0))],
        [[20 + 20 * i, 900, 0.0, reward] for i, reward in enumerate((3.0, 5.0, 5.0, 7.0, 7.0, 7.0, 9.0))],
    ]
    figure = ablation_figure({"batch size": {"b = 64": seeds, "b = 256": []}}, "holes")
    (axes,) = figure.axes
    (line,) = axes.lines
    assert list(line.get_xdata()) == [20, 40, 60, 80, 100, 120]
    # Each test is averaged with the one before it (a third of six or seven tests), then over the seeds.
    assert list(line.get_ydata()) == [2.0, 3.0, 4.0, 5.0, 6.0, 6.0]
    assert line.get_label() == "b = 64 (2 seeds)"
