# cython: initializedcheck=False
"""Exponential and logarithm from additions and multiplications only.

The C library's and NumPy's versions differ in the last bit between processors. A last bit can turn a choice, and
with it the whole rest of a run; these give the same bits wherever floats follow IEEE 754.
"""

from __future__ import annotations

from array import array

__all__ = ["exp", "log"]

LOG2_E = 1.4426950408889634
# ln 2 in two parts: the first has trailing zero bits, so that its small multiples are exact.
LN2_HIGH = 0.6931471803691238
LN2_LOW = 1.9082149292705877e-10

# Taylor coefficients 1/n!, n = 2 .. 13; on |r| <= ln(2)/2 the rest is below half a unit in the last place.
C2, C3, C4, C5, C6, C7, C8, C9, C10, C11, C12, C13 = (
    1 / 2, 1 / 6, 1 / 24, 1 / 120, 1 / 720, 1 / 5040, 1 / 40320, 1 / 362880, 1 / 3628800, 1 / 39916800,
    1 / 479001600, 1 / 6227020800,
)  # fmt: skip

# Powers of 2, the smallest of them subnormal: a product with one of them rounds once.
DEEPEST = 1074
POWERS = array("d", [2.0**k for k in range(-DEEPEST, 1024)])


def exp(x: float) -> float:
    """The number e to the power of x; 0 below -745, infinity above 709."""
    if x < -745.0:
        return 0.0
    if x > 709.0:
        return float("inf")
    t = x * LOG2_E + 0.5
    k = int(t)
    if k > t:
        k -= 1
    r = x - k * LN2_HIGH - k * LN2_LOW
    tail = C8 + r * (C9 + r * (C10 + r * (C11 + r * (C12 + r * C13))))
    p = 1.0 + r * (1.0 + r * (C2 + r * (C3 + r * (C4 + r * (C5 + r * (C6 + r * (C7 + r * tail)))))))
    return p * POWERS[k + DEEPEST] if k >= -DEEPEST else 0.5 * p * POWERS[k + 1 + DEEPEST]


def log(x: float) -> float:
    """The natural logarithm of a positive x, by Halley's iteration on `exp`.

    Raises:
        ValueError: x is not positive.
    """
    if not x > 0.0:
        raise ValueError("log of a number that is not positive")
    y = 0.0
    while x > 2.0:
        x *= 0.5
        y += 1.0
    while x < 0.5:
        x *= 2.0
        y -= 1.0
    z = x - 1.0
    for _ in range(6):
        e = exp(z)
        z += 2.0 * (x - e) / (x + e)
    return z + y * LN2_HIGH + y * LN2_LOW
