"""An image on which polygons and circles are filled, by NumPy alone: it needs no display and no drawing library."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

__all__ = ["Canvas", "Colour", "Point", "colour_of"]

Colour: TypeAlias = tuple[int, int, int]
"""Red, green and blue, 0 to 255."""
Point: TypeAlias = tuple[float, float]
"""x to the right, y upwards, in the unit of what is drawn."""


def colour_of(code: str) -> Colour:
    """A colour as `#RRGGBB` gives it."""
    red, green, blue = bytes.fromhex(code.removeprefix("#"))
    return red, green, blue


class Canvas:
    """An image seen from above; what is drawn later covers what was drawn before.

    Args:
        centre: What lies in its middle.
        pixel: Side of a pixel, in the unit of what is drawn.
        width: Pixels.
        height: Pixels.
        bare: The colour of what nothing is drawn on.

    Attributes:
        image: Red, green and blue of each pixel, 8 bits each; shape (height, width, 3).
    """

    def __init__(self, centre: Point, pixel: float, width: int, height: int, bare: Colour = (255, 255, 255)) -> None:
        self.image = np.full((height, width, 3), bare, np.uint8)
        self._x = centre[0] + pixel * (np.arange(width) + 0.5 - width / 2)
        self._y = centre[1] - pixel * (np.arange(height) + 0.5 - height / 2)

    def fill(self, corners: Iterable[Point], colour: Colour) -> None:
        """Fills a convex polygon, given counterclockwise."""
        points = [*corners]
        rows, columns = self._around(points)
        x, y = self._x[None, columns], self._y[rows, None]
        inside = np.ones((y.size, x.size), bool)
        for (x0, y0), (x1, y1) in zip(points, points[1:] + points[:1], strict=True):
            inside &= (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) >= 0.0
        self.image[rows, columns][inside] = colour

    def line(self, one: Point, other: Point, width: float, colour: Colour) -> None:
        """Draws a straight line."""
        along = np.subtract(other, one)
        x, y = 0.5 * width * along / max(float(np.hypot(*along)), 1e-12)
        (x0, y0), (x1, y1) = one, other
        self.fill([(x0 + y, y0 - x), (x1 + y, y1 - x), (x1 - y, y1 + x), (x0 - y, y0 + x)], colour)

    def square(self, centre: Point, side: float, colour: Colour) -> None:
        """Fills a square with sides along x and y."""
        (x, y), half = centre, side / 2
        self.fill([(x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half)], colour)

    def ring(self, centre: Point, inner: float, outer: float, colour: Colour) -> None:
        """Fills what lies between two circles; a disc if the inner radius is negative."""
        (x, y), reach = centre, outer
        rows, columns = self._around([(x - reach, y - reach), (x + reach, y + reach)])
        away = np.hypot(self._x[None, columns] - x, self._y[rows, None] - y)
        self.image[rows, columns][(away >= inner) & (away <= outer)] = colour

    def disc(self, centre: Point, radius: float, colour: Colour) -> None:
        """Fills a circle."""
        self.ring(centre, -1.0, radius, colour)

    def halved(self) -> NDArray[np.uint8]:
        """The image at half its size: each pixel is the mean of four, so that edges are smooth."""
        height, width, _ = self.image.shape
        found = np.full((height // 2, width // 2, 3), 2, np.uint16)  # half of four, to round
        for row, column in ((0, 0), (0, 1), (1, 0), (1, 1)):
            found += self.image[row : height // 2 * 2 : 2, column : width // 2 * 2 : 2]
        return (found // 4).astype(np.uint8)

    def _around(self, points: list[Point]) -> tuple[slice, slice]:
        """The rows and columns of pixels that can lie among some points."""
        xs, ys = zip(*points, strict=True)
        left, right = np.searchsorted(self._x, (min(xs), max(xs))).tolist()
        top, bottom = np.searchsorted(-self._y, (-max(ys), -min(ys))).tolist()
        return slice(top, bottom + 1), slice(left, right + 1)
