"""Exponential, logarithm, softmax and sampling: accurate, and the same bits everywhere."""

from __future__ import annotations

import math
import random
from itertools import pairwise

import pytest

from colonysim.exact import exp, log
from colonysim.policies.choice import sample, softmax


def test_exp_is_as_good_as_the_c_library_s():
    rng = random.Random(1)
    for _ in range(20000):
        x = rng.uniform(-700, 700)
        assert exp(x) == pytest.approx(math.exp(x), rel=1e-15)
    assert exp(0.0) == 1.0
    assert exp(-800.0) == exp(-math.inf) == 0.0
    assert exp(710.0) == math.inf
    assert 0.0 < exp(-744.0) < 1e-322


def test_exp_never_falls_where_its_argument_rises():
    # Across the seams of the range reduction, at half-multiples of ln 2, and densely around 0.
    for n in range(-40, 41):
        seam = (n + 0.5) * math.log(2)
        xs = [seam + k * 1e-13 * max(1.0, abs(seam)) for k in range(-50, 51)]
        assert all(exp(a) <= exp(b) for a, b in pairwise(xs)), n
    assert all(exp(a) < exp(b) for a, b in pairwise(i / 1000 for i in range(-5000, 5001)))


def test_log_undoes_exp_and_refuses_what_is_not_positive():
    rng = random.Random(2)
    for _ in range(4000):
        x = 10 ** rng.uniform(-300, 300)
        assert log(x) == pytest.approx(math.log(x), rel=1e-14, abs=1e-15)
    for _ in range(2000):
        y = rng.uniform(0, 30)
        assert log(exp(-y)) == pytest.approx(-y, abs=1e-14 * max(1.0, y))
    assert log(1.0) == 0.0
    assert log(5e-324) == pytest.approx(math.log(5e-324))
    xs = [0.5 + i / 1000 for i in range(2000)]
    assert all(log(a) < log(b) for a, b in pairwise(xs))
    for bad in (0.0, -1.0, math.nan):
        with pytest.raises(ValueError):
            log(bad)


def test_known_bits():
    """A change of a single bit would be a change of every trace."""
    assert [exp(x).hex() for x in (1.0, -0.5, 10.1)] == KNOWN_EXP
    assert [log(x).hex() for x in (0.5, 0.9, 3.0)] == KNOWN_LOG


KNOWN_EXP = ["0x1.5bf0a8b14576ap+1", "0x1.368b2fc6f960ap-1", "0x1.7c5c09a68d572p+14"]
KNOWN_LOG = ["-0x1.62e42fefa39efp-1", "-0x1.af8e8210a415bp-4", "0x1.193ea7aad030bp+0"]


@pytest.mark.parametrize("beta", [0.0, 0.3, 1.0, 4.0, 1000.0])
def test_softmax_sums_to_one_and_keeps_the_order(beta):
    rng = random.Random(3)
    for _ in range(300):
        values = [rng.uniform(-50, 50) for _ in range(rng.randint(1, 8))]
        chances = softmax(values, beta)
        assert math.fsum(chances) == pytest.approx(1.0)
        assert all(0.0 <= p <= 1.0 for p in chances)
        ranked = sorted(range(len(values)), key=values.__getitem__)
        assert all(chances[i] <= chances[j] for i, j in pairwise(ranked))
        if beta == 0.0:
            assert chances == pytest.approx([1 / len(values)] * len(values))


def test_softmax_is_the_formula_and_stands_large_values():
    assert softmax([1.0, 2.0], 4.0)[1] == pytest.approx(1 / (1 + math.exp(-4.0)))
    assert softmax([1e308, -1e308, 1e308]) == [0.5, 0.0, 0.5]
    assert softmax([4811.0, 0.0], 4.0) == [1.0, 0.0]
    assert softmax([math.inf, 3.0]) == [1.0, 0.0]
    assert softmax([-1e9, -1e9]) == [0.5, 0.5]


def test_sample_follows_its_probabilities_with_one_number_a_draw():
    rng = random.Random(4)
    chances = [0.5, 0.0, 0.2, 0.3]
    counts = [0] * 4
    for _ in range(20000):
        counts[sample(chances, rng)] += 1
    assert counts[1] == 0
    for count, chance in zip(counts, chances, strict=True):
        # four standard deviations of a binomial with 20,000 draws (seed 4)
        assert abs(count - 20000 * chance) <= 4 * math.sqrt(20000 * chance * (1 - chance))
    one, other = random.Random(5), random.Random(5)
    sample(chances, one)
    other.random()
    assert one.random() == other.random()


def test_sample_copes_with_rounding_at_the_upper_end():
    class Last(random.Random):
        def random(self) -> float:
            return 1.0 - 2**-53

    assert sample([0.1] * 10, Last()) == 9
    assert sample([0.3, 0.3, 0.3999999999, 0.0], Last()) == 2
