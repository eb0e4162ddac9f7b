from __future__ import annotations

import pytest

from colonysim.intervals import of_mean, wilson


@pytest.mark.parametrize(
    ("wins", "trials", "low", "high"),
    [(0, 10, 0.0, 0.2775), (10, 10, 0.7225, 1.0), (190, 200, 0.9104, 0.9726), (50, 100, 0.4038, 0.5962), (0, 0, 0, 1)],
)
def test_wilson_intervals(wins: int, trials: int, low: float, high: float) -> None:
    assert wilson(wins, trials) == pytest.approx((low, high), abs=1e-4)


def test_an_interval_of_a_mean_is_cut_off_where_its_values_end() -> None:
    values = [1.0, 0.5, 1.0]
    wide = of_mean(values)
    assert wide is not None and wide[0] > 0.0 and wide[1] > 1.0
    assert of_mean(values, within=(0.0, 1.0)) == (wide[0], 1.0)
    low, high = of_mean([-1.0, 0.5], within=(-1.0, 1.0)) or (0.0, 0.0)
    assert (low, high) == (-1.0, 1.0)
    assert of_mean([0.5], within=(0.0, 1.0)) is None
