"""Polygons and circles on an image, drawn by NumPy alone."""

from __future__ import annotations

import numpy as np
import pytest

from colonysim.canvas import Canvas, colour_of

RED = (255, 0, 0)


def reds(canvas: Canvas) -> list[list[int]]:
    """Row and column of each red pixel."""
    return np.argwhere((canvas.image == RED).all(axis=2)).tolist()


def test_x_is_to_the_right_and_y_upwards() -> None:
    canvas = Canvas((0.0, 0.0), 1.0, 4, 2)
    canvas.square((1.5, 0.5), 1.0, RED)
    assert reds(canvas) == [[0, 3]]
    canvas.square((-1.5, -0.5), 1.0, RED)
    assert reds(canvas) == [[0, 3], [1, 0]]


@pytest.mark.parametrize("centre", [(0.0, 0.0), (3.0, -4.0), (-7.0, 6.0), (40.0, 0.0)])
def test_shapes_cover_as_much_as_they_should_and_may_lie_beyond_the_image(centre: tuple[float, float]) -> None:
    pixel, half = 0.05, 5.0
    x, y = np.meshgrid((np.arange(200) + 0.5) * pixel - half, half - (np.arange(200) + 0.5) * pixel)
    away, (cx, cy) = np.hypot(x - centre[0], y - centre[1]), centre
    for draw, inside in (
        (lambda canvas: canvas.disc(centre, 2.0, RED), away <= 2.0),
        (lambda canvas: canvas.ring(centre, 1.0, 2.0, RED), (away >= 1.0) & (away <= 2.0)),
        (lambda canvas: canvas.square(centre, 3.0, RED), (abs(x - cx) <= 1.5) & (abs(y - cy) <= 1.5)),
        (lambda canvas: canvas.line((cx - 2, cy), (cx + 2, cy), 0.5, RED), (abs(x - cx) <= 2) & (abs(y - cy) <= 0.25)),
        (lambda canvas: canvas.fill([(cx, cy), (cx + 2, cy), (cx, cy + 2)], RED),
         (x >= cx) & (y >= cy) & (x - cx + y - cy <= 2)),
    ):  # fmt: skip
        canvas = Canvas((0.0, 0.0), pixel, 200, 200)
        draw(canvas)
        assert abs(len(reds(canvas)) - int(inside.sum())) <= 0.02 * inside.sum() + 1


def test_half_the_size_has_smooth_edges() -> None:
    canvas = Canvas((0.0, 0.0), 1.0, 4, 2, bare=(0, 0, 0))
    canvas.square((-1.5, 0.5), 1.0, (200, 100, 3))
    assert canvas.halved().tolist() == [[[50, 25, 1], [0, 0, 0]]]


def test_colours() -> None:
    assert colour_of("#0072B2") == (0, 114, 178)
